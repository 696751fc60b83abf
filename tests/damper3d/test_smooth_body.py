"""Closed forms of smooth bodies on a flat wall, which the studies of sub-spheres compare with."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipkm1

from damper3d.studies.single_contact.particles.axisymmetric_fe import tube
from damper3d.studies.single_contact.particles.ring_contact import press
from damper3d.studies.single_contact.particles.smooth_body import (
    Elastic,
    ellipse,
    ring,
    ring_force,
    ring_width,
    tangential_stiffness,
)
from granulab.contact.reduced import reduced_shear_modulus

STEEL = Elastic(206e9, 0.3)  # thesis, Table 5.1


def test_ellipse_of_contact_of_a_round_body_is_hertz_s_circle():
    """F = (4/3) E* sqrt(R) d^1.5 and p^3 = 3 F R/(4 E*) (Johnson 1985, eqs 4.22, 4.23), also where
    the radii differ by 1e-4, beyond which the closed form is not used: to first order the
    constant is that of the mean curvature."""
    round_one, nearly = ellipse(STEEL, 2e-3, 2e-3), ellipse(STEEL, 2.0002e-3, 2e-3)
    assert round_one.hertz == pytest.approx(4 / 3 * STEEL.reduced * math.sqrt(2e-3), rel=1e-12)
    assert round_one.half_axis**3 == pytest.approx(0.75 * 2e-3 / STEEL.reduced, rel=1e-12)
    assert nearly.hertz == pytest.approx(round_one.hertz * (1 + 0.25e-4), rel=1e-6)
    assert nearly.half_axis == pytest.approx(round_one.half_axis, rel=1e-4)


def test_ellipse_of_contact_obeys_the_potential_of_its_pressure():
    """Pressure p0 sqrt(1 - x^2/p^2 - y^2/q^2) sinks by d - x^2/(2 R1) - y^2/(2 R2) if d = p0 q K/E*
    and so on (Johnson, eqs 3.37, 4.24); here by its surface integral at three points, in polar
    coordinates about them, in which 1/distance drops out. To the tolerance of the quadrature."""
    long, across, force = 12e-3, 3e-3, 50.0
    contact = ellipse(STEEL, across, long)
    p = contact.half_axis * force ** (1 / 3)
    q = p * math.sqrt(1 - contact.flat)
    peak = 3 * force / (2 * math.pi * p * q)

    def sinks(x, y):
        def ray(t):
            a = (math.cos(t) / p) ** 2 + (math.sin(t) / q) ** 2
            b = x * math.cos(t) / p**2 + y * math.sin(t) / q**2
            c = 1 - (x / p) ** 2 - (y / q) ** 2  # under the root: c - 2 b r - a r^2, to its zero
            half = b**2 + a * c
            return 0.5 * (half / a**1.5 * (math.pi / 2 - math.asin(b / math.sqrt(half)))
                          - b * math.sqrt(c) / a)  # fmt: skip

        return peak / (math.pi * STEEL.reduced) * quad(ray, 0, 2 * math.pi)[0]

    overlap = (force / contact.hertz) ** (2 / 3)
    assert sinks(0, 0) == pytest.approx(overlap, rel=1e-8)
    for x, y in ((0.5 * p, 0.0), (0.0, 0.6 * q), (0.4 * p, 0.3 * q)):
        left = overlap - x**2 / (2 * long) - y**2 / (2 * across)
        assert sinks(x, y) == pytest.approx(left, rel=1e-8)


def test_tangential_stiffness_of_an_ellipse_is_cerruti_s_sum():
    """The sum in the docstring by quadrature; a circle has kt = 8 G* a with eq. 5.14's G*."""
    contact, force = ellipse(STEEL, 12e-3, 3e-3), 50.0
    p = contact.half_axis * force ** (1 / 3)
    q, nu = p * math.sqrt(1 - contact.flat), STEEL.poisson
    for along, part in ((True, math.cos), (False, math.sin)):
        total = quad(
            lambda t, part=part: (1 - nu + nu * part(t) ** 2)
            / math.sqrt((math.cos(t) / p) ** 2 + (math.sin(t) / q) ** 2), 0, 2 * math.pi,
        )[0]  # fmt: skip
        yields = 2 * total / (8 * math.pi * p * q * STEEL.shear)
        found = tangential_stiffness(STEEL, contact, force, along)
        assert found == pytest.approx(1 / yields, rel=1e-8)
    circle = ellipse(STEEL, 3e-3, 3e-3)
    reduced = reduced_shear_modulus(*STEEL, *STEEL)
    for along in (True, False):
        found = tangential_stiffness(STEEL, circle, force, along)
        assert found == pytest.approx(8 * reduced * circle.half_axis * force ** (1 / 3), rel=1e-9)


A, B = 3e-3, 1.15e-3  # the thesis's toroid, Fig. 5.9


def test_toroid_on_a_rigid_wall_against_finite_elements():
    """Without the wall's part: pi E c^2/(4 b (1 - nu^2)) on each length, the tube's and the ring's
    give. Meshes that grow by 0.2, 0.1 and 0.05 of the distance give 1.0020, 0.9999 and 0.9993 of
    it, so it holds to 0.1 %, and this mesh to 0.2 %. Without the widening it would be 2.6 % off."""
    width = 0.06 * B
    line = math.pi * STEEL.modulus / (1 - STEEL.poisson**2) * width**2 / (4 * B)
    plane = (1 - STEEL.poisson**2) / (math.pi * STEEL.modulus)
    widening = 2 * STEEL.poisson**2 / (math.pi * STEEL.modulus)
    overlap = line * (plane * (2 * math.log(4 * B / width) - 1) + widening)
    found = press((tube(STEEL, A, B, finest=0.0075, reach=0.09),), overlap)
    assert found.force == pytest.approx(2 * math.pi * A * line, rel=2e-3)
    # The closed form on an elastic wall: half of the load for the same width, and the wall's part.
    force, together = ring(STEEL, A, B, np.array([width]))
    assert force[0] == pytest.approx(math.pi * A * line, rel=1e-12)
    wall = line / 2 * 2 * plane * (math.log(16 * A / width) + 0.5)
    assert together[0] == pytest.approx(overlap / 2 + wall, rel=1e-12)


def test_load_on_a_ring_of_a_half_space():
    """A ring of the radius s with a line load q sinks the surface at the radius r by
    (1 - nu^2)/(pi E) times 4 q s K(m)/(r + s), m = 4 r s/(r + s)^2 (a potential of the circle);
    summed over the width of the contact: ln(16 a/c) + 1/2, to the order of (c/a)^2 ln(a/c), and
    the parabola s^2/c^2 of a Hertz contact less."""
    width = 0.02 * A

    def sinks(r):
        def part(s):
            load = 2 / (math.pi * width) * math.sqrt(1 - ((s - A) / width) ** 2)
            return load * 4 * s * ellipkm1(((r - s) / (r + s)) ** 2) / (r + s)

        return quad(part, A - width, A + width, points=[r], epsabs=1e-9, limit=200)[0]

    middle = 2 * (math.log(16 * A / width) + 0.5)
    assert sinks(A) == pytest.approx(middle, rel=1e-4)
    beside = [sinks(A + side * 0.5 * width) for side in (-1, 1)]
    assert np.mean(beside) == pytest.approx(middle - 2 * 0.25, rel=1e-4)


def test_force_of_a_ring_at_an_overlap():
    """The table of `ring` read backwards, to the steps of its logarithmic widths."""
    width = np.array([0.003, 0.04]) * B
    forces, overlaps = ring(STEEL, A, B, width)
    assert ring_width(STEEL, A, B, overlaps) == pytest.approx(width, rel=1e-4)
    assert ring_force(STEEL, A, B, np.append(0.0, overlaps)) == pytest.approx(
        np.append(0.0, forces), rel=1e-4
    )
