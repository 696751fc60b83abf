"""Line contact of two prisms: kn and kt in closed form from E and nu, and back.

A rounded corner touches a flat face, or two discs each other, along their length: plane strain.
The contact is of half-width a = sqrt(4 P R/(pi E*)) under the load P per length, R its reduced
radius (K. L. Johnson, Contact Mechanics, 1985, eq. 4.43). Displacements of a half-plane grow with
the logarithm of the distance: the approach is that of a depth d, which must be named. Flamant's
line loads (ib., ch. 2), summed over the traction of the contact, give for each body, with
c = (1 - nu^2)/(pi E), the displacement between the contact and the depth

    pressed: Hertz pressure                   P c (2 ln(2 d/a) - nu/(1 - nu))
    sheared: Q/(pi sqrt(a^2 - x^2)), no slip  Q c (2 ln(2 d/a) + 1/(1 - nu))

Both bodies in series make kn = F/overlap, a secant that rises with ln F, and kt. Of two like bodies
kt/kn = w/(w + (1 + nu)/(1 - nu)) with w = 2 ln(2 d/a) - nu/(1 - nu): near 1, as a line yields along
the surface by the same logarithm as across it, and not the 2 (1 - nu)/(2 - nu) that Mindlin found
for spheres. Back from kn: w exp(-w) = e^(nu/(1 - nu)) F R/(kn d^2), which is Lambert's function.

a is taken as small against R and d, and the coupling of pressure and shear between unlike bodies
(Dundurs) is left out. A corner that is pushed across its bisector bends, which a half-plane does
not: finite elements of a right-angled one on a face have a kt/kn 15 % lower.
"""

import math
from typing import NamedTuple

from granulab.contact.reduced import reduced_modulus
from granulab.errors import InputError

Elastic = tuple[float, float]  # Young's modulus [Pa] and Poisson's ratio
_LARGEST_POISSON = 0.5
_ROUNDING = 1e-12  # of a kt/kn that is that of nu = 0 or 0.5


class LineContact(NamedTuple):
    """Geometry and load of a line contact."""

    length: float  # of the line [m]
    radius: float  # reduced: of the corner on a flat face [m]
    depth: float  # below the contact, to which each body gives way [m]
    force: float  # at which the secant is taken [N]


def half_width(line: LineContact, first: Elastic, second: Elastic) -> float:
    """Half-width of the contact [m] under the force."""
    load = line.force / line.length
    return math.sqrt(4 * load * line.radius / (math.pi * reduced_modulus(*first, *second)))


def line_stiffness(line: LineContact, first: Elastic, second: Elastic) -> tuple[float, float]:
    """Secant kn and kt [N/m] of a line contact of two bodies.

    Raises InputError, one line, where the contact would be wider than its corner is round.
    """
    a = half_width(line, first, second)
    if not a <= line.radius:
        raise InputError(
            f"youngs_modulus is too low for a line contact: at {line.force:.3g} N its "
            f"half-width of {a:.3g} m exceeds the radius of {line.radius:.3g} m; give a higher "
            "one, or kn and kt"
        )
    across = along = 0.0
    log = 2 * math.log(2 * line.depth / a)
    for modulus, nu in (first, second):
        compliance = (1 - nu**2) / (math.pi * modulus * line.length)
        across += compliance * (log - nu / (1 - nu))
        along += compliance * (log + 1 / (1 - nu))
    return 1 / across, 1 / along


def ratio_limits(line: LineContact, kn: float) -> tuple[float, float]:
    """The least and the largest kt/kn [-] of two like bodies: of nu = 0.5 and of nu = 0.

    kn [N/m]. Raises InputError where a contact so soft is none of a line.
    """
    return _ratio(line, kn, _LARGEST_POISSON), _ratio(line, kn, 0.0)


def solid_of_stiffness(line: LineContact, kn: float, kt: float) -> Elastic:
    """Young's modulus [Pa] and Poisson's ratio, 0 to 0.5, of two like bodies of a kn and kt [N/m].

    There is one such solid at most. Raises InputError, one line, where there is none: kt/kn lies
    outside ratio_limits, or the contact is too soft for a line.
    """
    from scipy.optimize import brentq

    least, most = ratio_limits(line, kn)
    wanted = kt / kn
    if not least * (1 - _ROUNDING) <= wanted <= most * (1 + _ROUNDING):
        raise InputError(
            f"kt/kn = {wanted:.3g}: no elastic solid has it in a line contact; a Poisson's ratio "
            f"of 0.5 to 0 gives {least:.3f} to {most:.3f}"
        )
    wanted = min(max(wanted, least), most)
    nu = brentq(lambda nu: _ratio(line, kn, nu) - wanted, 0.0, _LARGEST_POISSON, xtol=1e-14)
    return modulus_of_stiffness(line, kn, nu), nu


def modulus_of_stiffness(line: LineContact, kn: float, nu: float) -> float:
    """Young's modulus [Pa] of two like bodies of a kn [N/m] and a Poisson's ratio.

    Raises InputError where a contact so soft is none of a line.
    """
    reduced = kn * _logarithm(line, kn, nu) / (math.pi * line.length)
    return 2 * (1 - nu**2) * reduced


def _ratio(line: LineContact, kn: float, nu: float) -> float:
    w = _logarithm(line, kn, nu)
    return w / (w + (1 + nu) / (1 - nu))


def _logarithm(line: LineContact, kn: float, nu: float) -> float:
    """2 ln(2 d/a) - nu/(1 - nu) of two like bodies of a kn [N/m]: the larger root of w exp(-w)."""
    from scipy.special import lambertw

    part = math.exp(nu / (1 - nu)) * line.force * line.radius / (kn * line.depth**2)
    w = -float(lambertw(-part, -1).real) if part < math.exp(-1) else 0.0
    if not 4 * line.force <= kn * w * line.radius:  # a <= R, with a^2 = 4 F R/(kn w)
        raise InputError(
            f"kn = {kn:.3g} N/m is too soft for a line contact: at {line.force:.3g} N its "
            f"half-width exceeds the radius of {line.radius:.3g} m; give a stiffer one"
        )
    return w
