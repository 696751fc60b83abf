"""Damping from a measured restitution, with the uncertainty of all that goes into it.

Linear contact (wood-silo paper, eqs 3.8 to 3.10): gamma = 2 b sqrt(kn/(n m)) for n contacts in
parallel of stiffness kn each, m the reduced mass: m1/2 for two equal bodies (eq. 3.9; the appendix
has m1), m1 against a wall (eq. 3.10). Hertz contact with Tsuji's dashpot: the same b by itself.
b(e) stands in granulab/contact/restitution.py for both ends of a contact.

Uncertainties are carried to first order (GUM, JCGM 100:2008, eq. 10):

    s_b = s_e/|de/db|,    (s_gamma/gamma)^2 = (s_b/b)^2 + (s_kn/kn)^2/4 + (s_m/m)^2/4

A quantity without a sigma counts as exact; where none has one, neither has the result.
"""

import math

from granulab.contact.material import Measured
from granulab.contact.restitution import (
    ContactEnd,
    damping_for_restitution,
    ratio_of_restitution,
    restitution_of_ratio,
    slope_of_restitution,
)


def reduced_mass_of(first: Measured, second: Measured | None = None) -> Measured:
    """m1 m2/(m1 + m2) [kg] of two bodies whose masses were measured each; of a wall, m1.

    For two bodies of one measured mass, halve it: then their errors are one.
    """
    if second is None:
        return first
    total = first.value + second.value
    mass = first.value * second.value / total
    slopes = (second.value / total) ** 2, (first.value / total) ** 2
    return Measured(mass, _root_sum(zip(slopes, (first.sigma, second.sigma), strict=True)))


def damping_ratio(restitution: Measured, end: ContactEnd = "overlap") -> Measured:
    """The b [-] of a linear contact (eqs 5.29, 5.30), or a Hertz one, that gives a restitution."""
    ratio = ratio_of_restitution(restitution.value, end)
    slope = 1 / slope_of_restitution(ratio, end)
    return Measured(ratio, _root_sum([(slope, restitution.sigma)]))


def tsuji_damping_ratio(restitution: Measured, end: ContactEnd = "overlap") -> Measured:
    """The thesis's zeta [-] of a Hertz contact, eq. 5.31: (sqrt(5)/2) b."""
    ratio, factor = damping_ratio(restitution, end), math.sqrt(5) / 2
    return Measured(factor * ratio.value, _root_sum([(factor, ratio.sigma)]))


def linear_damping(
    restitution: Measured,
    kn: Measured,
    mass: Measured,
    *,
    end: ContactEnd = "overlap",
    contacts: int = 1,
) -> Measured:
    """The gamma_n [1/s] of each of n contacts in parallel that together give a restitution.

    kn [N/m] of each, mass the reduced mass [kg]. Raises ValueError for a restitution outside
    (0, 1].
    """
    gamma = damping_for_restitution(restitution.value, kn.value, mass.value, end=end,
                                    contacts=contacts)  # fmt: skip
    ratio = damping_ratio(restitution, end)
    per_ratio = 2 * math.sqrt(kn.value / (contacts * mass.value))
    terms = [
        (per_ratio, ratio.sigma),
        (gamma / (2 * kn.value), kn.sigma),
        (gamma / (2 * mass.value), mass.sigma),
    ]
    return Measured(gamma, _root_sum(terms))


def in_parallel(
    restitution: Measured, contacts: int, *, of: int = 1, end: ContactEnd = "overlap"
) -> Measured:
    """The restitution [-] through `contacts` equal contacts, where `of` such contacts have one.

    Damping adds as the stiffness does, and so b grows with the root of the number; mass and
    stiffness drop out.
    """
    ratio, root = damping_ratio(restitution, end), math.sqrt(contacts / of)
    several = root * ratio.value
    slope = root * slope_of_restitution(several, end)
    return Measured(restitution_of_ratio(several, end), _root_sum([(slope, ratio.sigma)]))


def _root_sum(terms) -> float | None:
    """Root of the sum of squares of slope times sigma; None where no sigma is known."""
    known = [slope * sigma for slope, sigma in terms if sigma is not None]
    return math.hypot(*known) if known else None
