"""Disorder: contact parameters that differ from pair to pair, drawn as they were measured.

The measured distributions (means and standard deviations in the materials file) stand for pairs of
bodies. A quantity of mean m and standard deviation s is normal, cut symmetrically at CUT of its own
standard deviations; the normal it is cut from is a little wider (SPREADING), so that what is left
has the mean m and the standard deviation s exactly. Nothing is drawn beyond m (1 +- 2.62 s/m).

- Friction: the Coulomb coefficient.
- Stiffness: kn. kt/kn is held: Table 1 of the wood-silo paper measures that ratio along one
  interface, and its scatter there is not one from pair to pair. gamma_n/sqrt(kn) is held too, so
  that stiffness by itself leaves the restitution as it is.
- Restitution: gamma_n goes with the damping ratio that one contact needs for the e that is drawn,
  over the ratio for the mean e. The printed gamma_n does not follow from the measured e (errata of
  section 3.3.3): it is scaled, not replaced.
"""

import math
from typing import NamedTuple

import numpy as np

from granulab.contact.laws import LinearLaw
from granulab.contact.material import Measured, Pair
from granulab.contact.restitution import ContactEnd, damping_for_restitution
from granulab.errors import InputError
from silo2d.case.settings import Settings
from silo2d.engine.pair_law import LEVELS, DrawnLaw, Law, PairConstants, draw_pairs

CUT = 2.5  # standard deviations of the normal distribution that is cut
# Standard deviation of a standard normal cut at +-CUT: 1 - 2 c phi(c)/(2 Phi(c) - 1) is its square.
_DENSITY = math.exp(-(CUT**2) / 2) / math.sqrt(2 * math.pi)
_LEFT = math.sqrt(1 - 2 * CUT * _DENSITY / math.erf(CUT / math.sqrt(2)))
SPREADING = 1 / _LEFT
FARTHEST = CUT * SPREADING  # of any value from its mean, in standard deviations
QUANTITIES = ("friction", "stiffness", "restitution")  # in the order of the rows of a DrawnLaw
_TAG = 0x6469736F72646572  # keeps these draws apart from others of the same seed


class Spread(NamedTuple):
    """Relative standard deviations of one class of pairs, 0 where all are alike."""

    friction: float
    stiffness: float
    restitution: float
    mean_restitution: float  # what restitution is drawn about [-]; 1 where it is not drawn


def spreads(
    settings: Settings, pairs: tuple[Pair, Pair], laws: tuple[LinearLaw, LinearLaw], where: str
) -> tuple[Spread, Spread] | None:
    """Spreads that the case draws, between particles and at walls; None without disorder.

    Raises InputError where a standard deviation is missing, or so large that values beyond their
    physical range would be drawn.
    """
    if settings.disorder.per == "none":
        for key in QUANTITIES:
            if not isinstance(getattr(settings.disorder, key), bool):
                raise InputError(
                    f"{where}: [disorder] {key}: drawn of nothing; give per = 'particle' or "
                    "'pair' too, or leave it out"
                )
        return None
    first, second = (_spread(settings, *both, where) for both in zip(pairs, laws, strict=True))
    return first, second


def _spread(settings: Settings, pair: Pair, law: LinearLaw, where: str) -> Spread:
    assert pair.linear is not None
    assert pair.linear.kn is not None  # of a whole pair
    file = f"{settings.particles.materials}: [pair.{pair.first}-{pair.second}]"
    wanted, e = settings.disorder, pair.restitution
    friction = _relative(wanted.friction, pair.friction, "friction", file, where)
    stiffness = _relative(wanted.stiffness, pair.linear.kn, "kn", file, where, "stiffness")
    if wanted.restitution is False:
        return Spread(friction, stiffness, 0.0, 1.0)
    if e is None or law.gamma_n == 0:
        lacks = f"{file} restitution is missing" if e is None else f"{where}: gamma_n = 0"
        raise InputError(f"{lacks}; give it, or write [disorder] restitution = false")
    restitution = _relative(wanted.restitution, e, "restitution", file, where)
    if restitution and e.value * (1 + FARTHEST * restitution) >= 1:
        raise InputError(
            f"{where}: [disorder] restitution: up to {e.value * (1 + FARTHEST * restitution):.3g} "
            f"would be drawn about {e.value:g}; it must stay below 1: give a standard deviation of "
            f"less than {math.floor(1000 * (1 / e.value - 1) / FARTHEST) / 10:g} %"
        )
    return Spread(friction, stiffness, restitution, e.value if restitution else 1.0)


def _relative(
    wanted: bool | float, known: Measured, name: str, file: str, where: str, key: str | None = None
) -> float:
    """A relative standard deviation: none, the one given, or the measured one."""
    key = key or name
    if wanted is False:
        return 0.0
    if wanted is True:
        if known.spread is None:
            raise InputError(
                f"{file} {name} has no sigma; give one, or [disorder] {key} = '10 %' or false"
            )
        if known.value == 0:
            return 0.0
        wanted = known.spread / known.value
    if wanted * FARTHEST >= 1:
        raise InputError(
            f"{where}: [disorder] {key}: a standard deviation of {100 * wanted:.3g} % would draw "
            f"values down to zero; at most {math.floor(1000 / FARTHEST) / 10:g} %"
        )
    return wanted


def stiffest(
    laws: tuple[LinearLaw, LinearLaw], found: tuple[Spread, Spread] | None, end: ContactEnd
) -> tuple[LinearLaw, LinearLaw]:
    """The stiffest and most damped laws that pairs can draw: they set the stable time step."""
    if found is None:
        return laws
    return _stiffest(laws[0], found[0], end), _stiffest(laws[1], found[1], end)


def _stiffest(law: LinearLaw, spread: Spread, end: ContactEnd) -> LinearLaw:
    stiffer = 1 + FARTHEST * spread.stiffness
    lowest = spread.mean_restitution * (1 - FARTHEST * spread.restitution)
    gamma_n = law.gamma_n * math.sqrt(stiffer) * _damping(lowest, spread, end)
    return law._replace(kn=law.kn * stiffer, kt=law.kt * stiffer, gamma_n=gamma_n)


def _damping(restitution: float, spread: Spread, end: ContactEnd) -> float:
    """Damping ratio for a restitution over that for the mean one."""
    if not spread.restitution:
        return 1.0
    needed, usual = (
        damping_for_restitution(e, 1.0, 1.0, end=end)
        for e in (restitution, spread.mean_restitution)
    )
    return needed / usual


def drawn_laws(
    laws: tuple[LinearLaw, LinearLaw],
    found: tuple[Spread, Spread],
    settings: Settings,
    n_particles: int,
) -> tuple[DrawnLaw, DrawnLaw]:
    """The laws of a world whose pairs differ; the seed of the run decides what they draw."""
    seed, end = settings.run.seed, settings.law.contact_end
    key = np.random.SeedSequence([seed, _TAG]).generate_state(len(QUANTITIES), np.uint64)
    score = scores(seed, n_particles if settings.disorder.per == "particle" else 0)
    none = PairConstants(*np.zeros((len(PairConstants._fields), 0)))  # sized with the lists
    first, second = (
        DrawnLaw(law, _quantiles(law, spread, end), score, key, none, none)
        for law, spread in zip(laws, found, strict=True)
    )
    return first, second


def scores(seed: int, n_particles: int) -> np.ndarray:
    """Standard normal scores (3, n_particles) of the particles: friction, stiffness, restitution.

    A particle's scores depend on the seed and on its number, not on how many others there are.
    """
    return np.array(
        [np.random.default_rng([seed, _TAG, q]).standard_normal(n_particles) for q in range(3)]
    )


def _quantiles(law: LinearLaw, spread: Spread, end: ContactEnd) -> np.ndarray:
    """Friction, kn and damping ratio at LEVELS equally likely levels, (3, LEVELS)."""
    levels = cut_normal()
    restitution = spread.mean_restitution * (1 + spread.restitution * levels)
    return np.array(
        [
            law.mu * (1 + spread.friction * levels),
            law.kn * (1 + spread.stiffness * levels),
            [_damping(e, spread, end) for e in restitution.tolist()],
        ]
    )


def cut_normal() -> np.ndarray:
    """LEVELS equally likely values, ascending, of the cut normal of mean 0 and deviation 1."""
    from scipy.special import ndtr, ndtri

    low = ndtr(-CUT)
    middles = (np.arange(LEVELS) + 0.5) / LEVELS
    return SPREADING * ndtri(low + (1 - 2 * low) * middles)


def with_friction(law: Law, mu: float) -> Law:
    """The same law with one friction for all its pairs; a law without friction as it is."""
    if not isinstance(law, DrawnLaw):
        return law._replace(mu=mu) if "mu" in law._fields else law
    quantiles = law.quantiles.copy()
    quantiles[0] = mu
    return law._replace(quantiles=quantiles, mean=law.mean._replace(mu=mu))


def pair_constants(
    law: DrawnLaw, first: np.ndarray, second: np.ndarray, n_particles: int
) -> np.ndarray:
    """Constants that pairs of bodies draw: kn, kt [N/m], mu [-], gamma_n [1/s], (n, 4).

    first, second (n,): numbers of the bodies in either order, the walls' after the particles'; the
    law is that of their class.
    """
    pairs = np.sort(np.column_stack([first, second]).astype(np.int64), axis=1)
    constants = np.empty((len(pairs), 4))
    draw_pairs(law, pairs, n_particles, constants)
    return constants
