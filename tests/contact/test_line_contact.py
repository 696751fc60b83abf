"""Line contact of prisms: closed forms against integrals and finite elements, and the way back."""

import math

import numpy as np
import pytest
from corner_fe import displacements, square_on_its_corner, square_on_its_face
from hypothesis import given
from hypothesis import strategies as st
from line_contacts import hertz_half_width, hertz_pressure
from refusals import assert_refuses
from scipy.integrate import quad

from granulab.contact.prisms.line import (
    LineContact,
    half_width,
    line_stiffness,
    modulus_of_stiffness,
    ratio_limits,
    solid_of_stiffness,
)

RIGID = (math.inf, 0.0)
ACRYLIC = (3.3e9, 0.37)
CORNER = LineContact(length=0.12, radius=1e-3, depth=8e-3, force=10.0)


def test_the_half_width_is_hertzs():
    modulus = ACRYLIC[0] / (2 * (1 - ACRYLIC[1] ** 2))
    expected = hertz_half_width(CORNER.force / CORNER.length, CORNER.radius, modulus)
    assert half_width(CORNER, ACRYLIC, ACRYLIC) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.37, 0.499])
def test_the_approach_is_the_strain_below_hertzs_pressure_integrated_to_the_depth(nu):
    """Stresses on the axis from Flamant's line loads, summed; then Hooke's law in plane strain.

    Against a rigid body, so that one alone gives way. Tolerance: the first hundredth of a, where
    the strain is taken as that at the surface; the closed form leaves out (a/d)^2, less than 1e-6.
    """
    modulus, load, a = 3.3e9, CORNER.force / CORNER.length, half_width(CORNER, (3.3e9, nu), RIGID)
    assert a / CORNER.depth < 1e-3
    angle, weights = np.polynomial.legendre.leggauss(400)
    angle, weights = 0.5 * math.pi * angle, 0.5 * math.pi * weights
    s = a * np.sin(angle)
    loads = hertz_pressure(s, load, a) * a * np.cos(angle) * weights
    assert loads.sum() == pytest.approx(load, rel=1e-10)

    def strain(z):
        r4 = (s**2 + z**2) ** 2
        down = (2 * loads * z**3 / (math.pi * r4)).sum()
        aside = (2 * loads * z * s**2 / (math.pi * r4)).sum()
        return ((1 - nu**2) * down - nu * (1 + nu) * aside) / modulus

    def over_log(t):
        return strain(math.exp(t)) * math.exp(t)

    # Over the logarithm of the depth, from a hundredth of a on; above it, all is at the pressure of
    # the middle.
    first = 1e-2 * a
    top = first * ((1 - nu**2) - nu * (1 + nu)) / modulus * 2 * load / (math.pi * a)
    rest, _ = quad(over_log, math.log(first), math.log(CORNER.depth), limit=400, epsrel=1e-9)
    kn, _ = line_stiffness(CORNER, (modulus, nu), RIGID)
    assert CORNER.force / kn == pytest.approx(top + rest, rel=1e-4)


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.37, 0.499])
def test_the_shear_is_the_displacement_of_the_complex_potentials(nu):
    """Muskhelishvili's potentials of tangential line loads on a half-plane, summed over a contact.

    Traction Q/(pi sqrt(a^2 - s^2)): s = a sin(t), t even. Tolerance: terms of order (a/d)^2.
    """
    modulus, a = 3.3e9, half_width(CORNER, (3.3e9, nu), RIGID)
    shear, kappa = modulus / (2 * (1 + nu)), 3 - 4 * nu

    def displacement(point, s):
        phi, slope = -np.log(point - s) / (2 * np.pi), -1 / (2 * np.pi * (point - s))
        psi = (np.log(point - s) + s / (point - s)) / (2 * np.pi)
        moved = kappa * phi - point * np.conj(slope) - np.conj(psi)
        return moved.real / (2 * shear)

    def mean(point):
        value, _ = quad(lambda t: displacement(point, a * math.sin(t)), 0, math.pi / 2)
        mirrored, _ = quad(lambda t: displacement(point, -a * math.sin(t)), 0, math.pi / 2)
        return (value + mirrored) / math.pi

    moved = mean(0.0 + 0.0j) - mean(-1j * CORNER.depth)
    _, kt = line_stiffness(CORNER, (modulus, nu), RIGID)
    assert CORNER.length / kt == pytest.approx(moved, rel=1e-5)


def test_finite_elements_of_a_corner_on_a_face():
    """A square of 14 mm with a corner of 1 mm, and another that it stands on; acrylic's half-width.

    Hertz's load by itself moves half of P c less than its middle; in shear it moves half of Q c
    more than a contact that sticks, as the mean of -2 ln|x - s| over both is 1/2 above that of the
    latter, 2 ln(2/a). The depth of the centre is right for a face within 2 %; a right-angled corner
    gives way by 7 % more, as its flanks narrow the body. Sheared across its bisector it bends:
    kt/kn of the two is 15 % lower than the closed form's, as the commands say.
    """
    nu, a = ACRYLIC[1], 7.6e-6
    unit = (1 - nu**2) / math.pi
    faces = displacements(square_on_its_face(14e-3), a, nu)
    corners = displacements(square_on_its_corner(14e-3, 1e-3), a, nu)
    pressed = [body[0] + 0.5 * unit for body in (faces, corners)]
    sheared = [body[1] - 0.5 * unit for body in (faces, corners)]
    depth = math.sqrt(faces[2] / math.pi)
    # The load that has this half-width against a rigid body, at E = 1 Pa and 1 m of length.
    load = math.pi * a**2 / (1 - nu**2) / (4 * 1e-3)
    kn, kt = line_stiffness(LineContact(1.0, 1e-3, depth, load), (1.0, nu), RIGID)
    assert pressed == pytest.approx([1 / kn, 1.06 / kn], rel=0.02)
    assert sum(pressed) / sum(sheared) / (kt / kn) == pytest.approx(0.85, abs=0.01)


@pytest.mark.parametrize(("nu", "share"), [(0.0, 0.03), (0.37, 0.075), (0.499, 0.11)])
def test_a_disc_between_two_plates_gives_way_a_little_more_than_a_half_plane(nu, share):
    """P c (2 ln(4 R/a) - 1) to its centre (Johnson, ch. 5).

    To the half-plane's, the load on the far side adds 2 ln 2, and the uniform tension P/(pi R) that
    frees the rim takes 1 - nu/(1 - nu). Here a = 10 um, R = 6 mm.
    """
    disc = CORNER._replace(radius=6e-3, depth=6e-3)
    log = 2 * math.log(2 * disc.depth / half_width(disc, (3.3e9, nu), RIGID))
    between_plates = (1 - nu**2) / (math.pi * 3.3e9 * disc.length) * (log + 2 * math.log(2) - 1)
    kn, _ = line_stiffness(disc, (3.3e9, nu), RIGID)
    assert kn * between_plates - 1 == pytest.approx(share, abs=0.005)


def test_stiffness_is_that_of_the_length_and_grows_with_the_logarithm_of_the_load():
    """Twice as long under twice the load: twice as stiff. Each factor of the load adds as much."""
    longer = CORNER._replace(length=2 * CORNER.length, force=2 * CORNER.force)
    one, two = (line_stiffness(line, ACRYLIC, ACRYLIC) for line in (CORNER, longer))
    assert two == pytest.approx((2 * one[0], 2 * one[1]), rel=1e-14)
    yielding = [
        1 / line_stiffness(CORNER._replace(force=force), ACRYLIC, ACRYLIC)[0]
        for force in (1.0, 10.0, 100.0)
    ]
    steps = np.diff(yielding)
    assert steps[0] == pytest.approx(steps[1], rel=1e-9)
    assert steps[0] < 0


def test_unlike_bodies_are_in_series():
    """A rigid one adds nothing; of two like ones each has half of the approach at the same a."""
    soft = (3.3e8, 0.37)
    kn, kt = line_stiffness(CORNER, ACRYLIC, soft)
    assert (kn, kt) == pytest.approx(line_stiffness(CORNER, soft, ACRYLIC), rel=1e-14)
    assert line_stiffness(CORNER, soft, soft)[0] < kn < line_stiffness(CORNER, ACRYLIC, ACRYLIC)[0]
    alone = line_stiffness(CORNER, ACRYLIC, RIGID)[0]
    same_a = CORNER._replace(radius=CORNER.radius / 2)
    assert line_stiffness(same_a, ACRYLIC, ACRYLIC)[0] == pytest.approx(alone / 2, rel=1e-12)


def test_a_higher_poissons_ratio_yields_more_to_shear():
    """kt/kn = w/(w + (1 + nu)/(1 - nu)): w/(w + 1) at nu = 0, w/(w + 3) at 0.5; never above 1."""
    ratios = [
        kt / kn for kn, kt in (line_stiffness(CORNER, *2 * [(3.3e9, nu)]) for nu in (0, 0.2, 0.49))
    ]
    assert 1 > ratios[0] > ratios[1] > ratios[2] > 0.8
    kn, kt = line_stiffness(CORNER, (3.3e9, 0.0), (3.3e9, 0.0))
    a = half_width(CORNER, (3.3e9, 0.0), (3.3e9, 0.0))
    w = 2 * math.log(2 * CORNER.depth / a)
    assert kt / kn == pytest.approx(w / (w + 1), rel=1e-12)
    assert ratio_limits(CORNER, kn)[1] == pytest.approx(w / (w + 1), rel=1e-12)


lines = st.builds(
    LineContact,
    length=st.floats(1e-3, 1.0),
    radius=st.floats(1e-4, 5e-3),
    depth=st.floats(5e-3, 0.1),
    force=st.floats(1e-3, 100.0),
)


@given(lines, st.floats(1e9, 1e12), st.floats(0.0, 0.499))
def test_there_and_back(line, modulus, nu):
    """E, nu to kn, kt to E, nu. kt/kn changes by a fifth at most while nu does by a half."""
    if half_width(line, (modulus, nu), (modulus, nu)) > 0.2 * line.radius:
        return
    kn, kt = line_stiffness(line, (modulus, nu), (modulus, nu))
    found = solid_of_stiffness(line, kn, kt)
    assert found[1] == pytest.approx(nu, abs=1e-9)
    assert found[0] == pytest.approx(modulus, rel=1e-8)
    assert modulus_of_stiffness(line, kn, nu) == pytest.approx(modulus, rel=1e-9)


@pytest.mark.parametrize(
    ("kn", "kt", "words"),
    [
        (
            1e7,
            6.5e5,
            ["kt/kn = 0.065", "no elastic solid", "0.5 to 0", "to 0.9"],
        ),  # wood, as printed
        (1e7, 2.8e6, ["kt/kn = 0.28"]),
        (1e7, 0.0, ["kt/kn = 0:"]),
        (1e7, 1e7, ["kt/kn = 1:"]),
        (1e7, 2e7, ["kt/kn = 2:"]),
        (1.0, 0.9, ["kn = 1 N/m is too soft", "exceeds the radius of 0.001 m", "stiffer"]),
        (3e3, 2.5e3, ["kn = 3e+03 N/m is too soft", "at 10 N its half-width", "stiffer"]),
    ],
)
def test_stiffness_that_no_solid_has(kn, kt, words):
    assert_refuses(words, solid_of_stiffness, CORNER, kn, kt)


@pytest.mark.parametrize("modulus", [1e5, 1.0, 1e-300])
def test_a_contact_wider_than_its_corner_is_none_of_a_line(modulus):
    words = [
        "youngs_modulus is too low",
        "half-width",
        "exceeds the radius of 0.001 m",
        "or kn and kt",
    ]
    assert_refuses(words, line_stiffness, CORNER, (modulus, 0.3), (modulus, 0.3))
