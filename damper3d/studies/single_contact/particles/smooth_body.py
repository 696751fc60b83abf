"""A smooth elastic body pressed on a flat wall: closed forms for a point and a ring of contact.

K. L. Johnson, Contact Mechanics, 1985, is "Johnson". Overlaps are between points far from the
contact, as those of Hertz's law of spheres.
"""

import math
from typing import NamedTuple

import numpy as np

from granulab.contact.reduced import reduced_modulus, shear_modulus

_ROUND = 1e-6  # radii that differ by less than this share are equal: the integrals lose digits


class Elastic(NamedTuple):
    """The material of both body and wall."""

    modulus: float  # E [Pa]
    poisson: float  # nu [-]

    @property
    def reduced(self) -> float:
        """Reduced modulus of body and wall, eq. 5.6 with its erratum [Pa]."""
        return float(reduced_modulus(self.modulus, self.poisson, self.modulus, self.poisson))

    @property
    def shear(self) -> float:
        """G = E/(2 (1 + nu)) [Pa]."""
        return float(shear_modulus(self.modulus, self.poisson))


class Ellipse(NamedTuple):
    """The contact of a body with two principal radii: it stays alike as the force grows."""

    flat: float  # 1 - (q/p)^2 of its half axes p >= q [-]
    half_axis: float  # p of a force of 1 N; it grows with the cube root of the force [m/N^(1/3)]
    hertz: float  # F/d^1.5 of the force F at the overlap d [N/m^1.5]


def ellipse(material: Elastic, radius: float, other: float) -> Ellipse:
    """The contact of a body with the principal radii [m] at its lowest point with a flat wall.

    With e^2 = 1 - (q/p)^2, the elliptic integrals K and E of it, and E* the reduced modulus,
    R_1 >= R_2 follow from R_1/R_2 = ((p/q)^2 E - K)/(K - E), p^3 = (3 F/(pi E*)) R_1 (K - E)/e^2
    and d = 3 F K/(2 pi p E*) (Johnson, eqs 4.24-4.32). Equal radii give (4/3) E* sqrt(R).
    """
    from scipy.optimize import brentq
    from scipy.special import ellipe, ellipk

    long, across = max(radius, other), min(radius, other)
    reduced = material.reduced
    if long - across < _ROUND * across:
        return Ellipse(
            0.0, (0.75 * across / reduced) ** (1 / 3), 4 / 3 * reduced * math.sqrt(across)
        )

    def excess(m: float) -> float:
        return (ellipe(m) / (1 - m) - ellipk(m)) / (ellipk(m) - ellipe(m)) - long / across

    m = brentq(excess, 1e-8, 1 - 1e-12)
    p = (3 * long / (math.pi * reduced) * (ellipk(m) - ellipe(m)) / m) ** (1 / 3)
    return Ellipse(m, p, (3 * ellipk(m) / (2 * math.pi * reduced * p)) ** -1.5)


def tangential_stiffness(material: Elastic, contact: Ellipse, force: float, along: bool) -> float:
    """Tangential stiffness of a contact under a normal force [N] before any of it slides [N/m].

    along: the long axis of the ellipse, else across it. A traction Q/(2 pi p q)
    (1 - x^2/p^2 - y^2/q^2)^(-1/2) moves all of the ellipse alike; Cerruti's solution (Johnson,
    eq. 3.91a) summed at its middle is, with t the angle from the long axis,

        u = Q/(8 pi p q G) int_0^2pi ((1 - nu) + nu cos^2 t) (cos^2 t/p^2 + sin^2 t/q^2)^(-1/2) dt

    of each body, sin^2 in place of the first cos^2 across (Mindlin 1949; for a circle
    u = (2 - nu) Q/(8 G p), as in eq. 5.14). In elliptic integrals it is what is coded.
    """
    from scipy.special import ellipe, ellipk

    m, nu, p = contact.flat, material.poisson, contact.half_axis * force ** (1 / 3)
    k, e = float(ellipk(m)), float(ellipe(m))
    cosine = (k - e) / m if m > 0.0 else math.pi / 4
    share = cosine if along else k - cosine
    return math.pi * material.shear * p / ((1 - nu) * k + nu * share)


def ring(
    material: Elastic, distance: float, tube: float, width: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Force [N] and overlap [m] of a circular toroid that lies on a flat wall.

    distance: a, of the tube's middle from the axis; tube: its radius b; width: half widths c > 0 of
    the ring of contact [m], much smaller than b. A line load q = pi E* c^2/(4 b) (Johnson, eq.
    4.45) on the circumference F = 2 pi a q gives way in three parts:

    - wall: the load on a ring of a half-space, spread over its width as Hertz has it, sinks by
      (2 q (1 - nu^2)/(pi E)) (ln(16 a/c) + 1/2): the near field is that of a line, and the integral
      of 1/distance round the circle, 2 ln(8 a/s) at a small distance s, ends its logarithm;
    - tube: (q (1 - nu^2)/(pi E)) (2 ln(4 b/c) - 1) from the contact to the middle, as of a cylinder
      held at the top as at the bottom (Johnson, eq. 5.57 ff.);
    - ring: in a cylinder that cannot lengthen this wakes the axial force nu int(s_x + s_z) dA =
      -2 nu q b; a ring is free to widen, loses it by the strain 2 nu q/(pi E b), and the tube gets
      thinner by nu times that: b 2 nu^2 q/(pi E b) more from the contact to the middle.

    The curvature of the ring is left out of the second part. Finite elements of a toroid of
    a = 2.6 b on a rigid wall agree with tube and ring to 0.1 % at c = 0.06 b (tests).
    """
    e, nu = material.modulus, material.poisson
    plane = (1 - nu**2) / (math.pi * e)
    load = math.pi * material.reduced * width**2 / (4 * tube)
    wall = 2 * plane * (np.log(16 * distance / width) + 0.5)
    section = plane * (2 * np.log(4 * tube / width) - 1)
    widening = 2 * nu**2 / (math.pi * e)
    return 2 * math.pi * distance * load, load * (wall + section + widening)


def ring_width(material: Elastic, distance: float, tube: float, overlap: np.ndarray) -> np.ndarray:
    """The half width [m] of the ring of contact of `ring` at overlaps (n,) >= 0 [m]."""
    width, _, overlaps = _ring_table(material, distance, tube)
    return np.interp(overlap, overlaps, width)


def ring_force(material: Elastic, distance: float, tube: float, overlap: np.ndarray) -> np.ndarray:
    """The force [N] of `ring` at overlaps (n,) >= 0 [m]."""
    _, forces, overlaps = _ring_table(material, distance, tube)
    return np.interp(overlap, overlaps, forces)


def _ring_table(material: Elastic, distance: float, tube: float) -> list[np.ndarray]:
    """Half widths [m], forces [N] and overlaps [m] of `ring`, from nothing on."""
    width = np.geomspace(1e-5, 0.5, 400) * tube
    return [np.append(0.0, one) for one in (width, *ring(material, distance, tube, width))]
