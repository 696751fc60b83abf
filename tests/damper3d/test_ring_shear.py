"""Finite elements of a body pressed on a wall and shifted along it; the lying toroid by them."""

import math

import numpy as np
import pytest
from skfem import Basis, ElementTriP1, ElementVector

from damper3d.studies.single_contact.particles import ring_shear
from damper3d.studies.single_contact.particles.axisymmetric_fe import (
    half_disc,
    stiffness,
    tube,
    wall,
    yielding,
)
from damper3d.studies.single_contact.particles.ring_contact import (
    press,
    quarter,
    shear,
    stick_stiffness,
    tilt,
    yields,
)
from damper3d.studies.single_contact.particles.smooth_body import Elastic
from damper3d.studies.single_contact.particles.steel_shapes import TUBE
from granulab.contact.mindlin_deresiewicz import loading_force
from granulab.contact.reduced import reduced_shear_modulus

STEEL = Elastic(206e9, 0.3)  # thesis, Table 5.1


def test_rigid_motions_strain_nothing():
    """A lift is m = 0 with w = 1, a shift along x m = 1 with u = 1, v = -1, a rotation about y
    m = 1 with u = z, v = -z, w = -r: linear elements hold all of them, to rounding."""
    mesh = half_disc(0.3, 0.3)
    mesh = type(mesh)(mesh.p + np.array([[2.6], [0.0]]), mesh.t)
    basis = Basis(mesh, ElementVector(ElementTriP1(), 3))
    r, z = mesh.p
    one, none = np.ones_like(r), np.zeros_like(r)
    for m, motion in ((0, (none, none, one)), (1, (one, -one, none)), (1, (z, -z, -r))):
        matrix = stiffness(STEEL, m).assemble(basis)
        moved = np.zeros(matrix.shape[0])
        moved[basis.nodal_dofs] = motion
        assert np.abs(matrix @ moved).max() < 1e-12 * abs(matrix).max() * r.max()


def test_tube_sheared_along_its_line():
    """A straight half cylinder, held in its middle plane and drawn along its lowest line by q with
    Hertz's distribution over a half width c, moves there by q/(pi G) (ln(4 b/c) + 1/2): an
    antiplane point load Q on the rim of a free disc gives -(Q/(pi G)) ln(distance), and its image,
    the same load backwards at the top, holds the middle. Here the first harmonic of a ring of
    a = 1000 b, which curves by b/a. Elements of 0.02, 0.01 and 0.005 b give 2.0e-3, 0.6e-3 and
    0.3e-3 less."""
    b, c = 1e-3, 0.08e-3
    body = tube(STEEL, 1e3 * b, b, finest=0.01, reach=1.3 * c / b)
    x = body.places[0] - 1e3 * b
    edges = np.clip(np.concatenate([[-c], (x[1:] + x[:-1]) / 2, [c]]), -c, c) / c
    share = np.diff(edges * np.sqrt(1 - edges**2) + np.arcsin(edges)) / math.pi
    assert share.sum() == pytest.approx(1.0)
    moved = yielding(body, 1)[1][:, 1] @ (share * 1e3 * b)  # 1 N/m
    closed = (math.log(4 * b / c) + 0.5) / (math.pi * STEEL.shear)
    assert np.interp(0.0, x, moved) == pytest.approx(closed, rel=1e-3)


# A sphere that is held in its equator is not Hertz's half-space beyond a distance of about its
# radius: what that lacks goes with a/R. Elements move the edge of what sticks by a part of one.
FRICTION, RADIUS, CIRCLE = 0.4, 10e-3, 0.00625  # mu, R, and sqrt(d/R), the circle over the radius


@pytest.fixture(scope="module")
def sphere():
    body = tube(STEEL, 0.0, RADIUS, finest=CIRCLE / 20, reach=1.3 * CIRCLE)
    bodies = body, wall(STEEL, body.places[0])
    contact = press(bodies, CIRCLE**2 * RADIUS)
    return bodies, contact, yields(bodies, contact, 3)


def test_sphere_by_finite_elements_is_hertz_s(sphere):
    """(4/3) E* sqrt(R) d^1.5 (eq. 5.7). Circles of 0.05, 0.025, 0.0125 and 0.00625 R gave 1.0178,
    1.0110, 1.0079 and 1.0065 of it with ten elements in them: 1.005 by the wall's end (1.3/300)
    and 0.25 a/R besides."""
    _, contact, _ = sphere
    hertz = 4 / 3 * STEEL.reduced * math.sqrt(RADIUS) * (CIRCLE**2 * RADIUS) ** 1.5
    assert contact.force == pytest.approx(hertz, rel=1.3 / 300 + 0.3 * CIRCLE)
    circle = (0.75 * RADIUS * contact.force / STEEL.reduced) ** (1 / 3)
    assert contact.width == pytest.approx(circle, rel=1 / 20)  # an element


def test_sphere_by_finite_elements_is_mindlin_s(sphere):
    """8 G* a before any slip (eq. 5.15), to half an element of a; the curve of partial slip
    1 - (1 - 2 T/3)^1.5 to as much of mu N. Mindlin's slip is along x alone, which is not quite
    against the tractions where nu is not 0: more harmonics, which know it, change 1e-3."""
    bodies, contact, own = sphere
    here = quarter(contact, FRICTION, own[:1])
    circle = (0.75 * RADIUS * contact.force / STEEL.reduced) ** (1 / 3)
    mindlin = 8 * reduced_shear_modulus(*STEEL, *STEEL) * circle
    found, limit = stick_stiffness(here), FRICTION * contact.force
    assert found == pytest.approx(mindlin, rel=1 / 40)
    across = np.linspace(0.0, 2.0 * limit / found, 21)[1:]
    forces = shear(here, across)
    assert np.abs(forces - loading_force(found, limit, across)).max() < limit / 40
    assert np.abs(shear(quarter(contact, FRICTION, own), across) - forces).max() < 1e-3 * limit
    assert tilt(bodies, contact, FRICTION) < 1e-3  # bodies alike do not couple (Johnson, sec. 7.4)


def test_toroid_between_stick_and_slip():
    """Coulomb: never above mu N, which it comes to within the slip of the last point; the first
    step is the stiffness that sticks where nothing slides yet, and later ones are softer."""
    bodies, contact = ring_shear.toroid_on_wall(STEEL, 18.4e-6, elements=4)
    here = quarter(contact, FRICTION, yields(bodies, contact, 2))
    stiff, limit = stick_stiffness(here), FRICTION * contact.force
    across = np.linspace(0.0, 2.0 * limit / stiff, 41)
    forces = np.append(0.0, shear(here, across[1:]))
    slopes = np.diff(forces) / np.diff(across) / stiff
    assert slopes[0] == pytest.approx(1.0, abs=0.02)  # its two outermost points slide at once
    assert np.all(np.diff(slopes) < 1e-3)
    assert forces.max() <= limit * (1 + 1e-9)
    assert forces[-1] == pytest.approx(limit, rel=1e-3)


@pytest.mark.validation  # half a minute of finite elements
def test_lying_toroid_of_sub_spheres_in_shear():
    """Fig. 5.10b, coarsely. With half as many elements and directions as the study its finite
    elements change by 1 %. One contact is its own 8 G* a whatever the number of sub-spheres, and
    n of them share F: kt goes with n (F/n)^(1/3). Where the sum has the smooth toroid's normal
    force and overlap, it is half as stiff again in shear: a point has 2 (1 - nu)/(2 - nu) of its
    dF/dd (Mindlin 1949), 1.5 F/d, and F of a ring is nearly straight."""
    found = ring_shear.compute(ring_shear.Mesh(elements=4, harmonics=2)).numbers
    largest, small = (name[: -len(", finite elements")] for name in found if "finite" in name)
    for name, stiff in ((largest, 5.13e8), (small, 4.55e8)):
        fe = found[f"{name}, finite elements"]
        assert fe["stiffness_n_m"] == pytest.approx(stiff, rel=0.01)
        assert fe["stiffness_with_half_the_elements_n_m"] == pytest.approx(stiff, rel=0.01)
        assert fe["normal_force_over_closed_form"] == pytest.approx(1.0, abs=0.01)
        sums = {n: found[f"{name}, {n}"]["sum_stiffness_over_smooth"] for n in (10, 20, 50, 100)}
        for n in (20, 50, 100):
            assert sums[n] / sums[10] == pytest.approx((n / 10) ** (2 / 3), rel=1e-3)
    shear_modulus = reduced_shear_modulus(*STEEL, *STEEL)
    force = found[f"{small}, finite elements"]["normal_force_n"] / 50
    one = 8 * shear_modulus * (0.75 * force * TUBE / STEEL.reduced) ** (1 / 3)
    ratio = 50 * one / found[f"{small}, finite elements"]["stiffness_n_m"]
    assert found[f"{small}, 50"]["sum_stiffness_over_smooth"] == pytest.approx(ratio, rel=1e-3)
    assert ratio == pytest.approx(1.55, abs=0.02)
