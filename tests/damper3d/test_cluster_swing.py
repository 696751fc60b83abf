"""The ball that oscillates as fast on its contacts as a cluster: closed forms, and invariance."""

import dataclasses

import numpy as np
import pytest
from cluster_beds import about, particle, rotation

from damper3d.case.oscillation import DEEPEST, equivalent_sphere_radius
from damper3d.shapes.multisphere import MultiSphere, sphere
from damper3d.shapes.surfaces.surface import Surface

RADIUS = 2e-3
SPRINGS = 1.16  # kt/kn of acrylic


def made_of(offsets, radii) -> MultiSphere:
    """A ball's body that touches with these spheres; lengths over its radius."""
    return dataclasses.replace(
        sphere(RADIUS), offsets=RADIUS * np.asarray(offsets, float),
        radii=RADIUS * np.asarray(radii, float), arrangement="any",
    )  # fmt: skip


def test_a_sphere_is_its_own_equivalent():
    """And is so by the sum over spheres too, where another is hidden inside it."""
    assert equivalent_sphere_radius(sphere(RADIUS), SPRINGS) == RADIUS
    hidden = made_of([[0, 0, 0], [0.1, 0, 0]], [1.0, 0.2])
    assert equivalent_sphere_radius(hidden, SPRINGS) == pytest.approx(RADIUS, rel=1e-12)


@pytest.mark.parametrize("n", [2, 7, 51])
def test_equal_contacts_at_one_position(n):
    """n h^2.5 = h0^2.5 and k = n h^(1/2) ~ n^(4/5): the step, as 1/sqrt(k), goes with n^(-2/5)."""
    together = made_of(np.zeros((n, 3)), np.ones(n))
    assert equivalent_sphere_radius(together, SPRINGS) == pytest.approx(n**-0.4 * RADIUS, rel=1e-9)


@pytest.mark.parametrize("size", [0.1, 0.5])
def test_a_small_sphere_of_a_whole_particle_touches_for_longer(size):
    """On a body that does not turn, T ~ (m^2/R)^(1/5) (thesis, eq. 5.10): R^(-1/5), not R."""
    tip = made_of([[0, 0, 0]], [size])
    still = dataclasses.replace(tip, inertia=1e9 * tip.inertia, arrangement="any",
                                offsets=np.array([[0.0, 0.0, 1e-30]]))  # fmt: skip
    full = dataclasses.replace(still, radii=np.array([RADIUS]))
    ratio = equivalent_sphere_radius(still, SPRINGS) / equivalent_sphere_radius(full, SPRINGS)
    assert ratio == pytest.approx(size**-0.2, rel=1e-9)


def test_it_grows_with_the_particle_and_does_not_depend_on_its_orientation():
    """A length; and of no direction: what is left is that of the directions that are looked at."""
    cluster = particle("prolate:3")
    first = equivalent_sphere_radius(cluster, SPRINGS)
    assert equivalent_sphere_radius(cluster.scaled(3.0), SPRINGS) == pytest.approx(
        3 * first, rel=1e-9
    )
    turn = rotation(about([0.0, 0.0, 1.0], np.pi / 2))  # changes the moments of x and y
    turned = dataclasses.replace(
        cluster, offsets=cluster.offsets @ turn.T, inertia=cluster.inertia[[1, 0, 2]],
        surface=Surface(cluster.surface.vertices @ turn.T, cluster.surface.triangles),
    )  # fmt: skip
    assert equivalent_sphere_radius(turned, SPRINGS) == pytest.approx(first, rel=0.01)


def test_the_number_of_spheres_sets_it_and_not_the_smallest():
    """The tip of a/b = 3 is 2.5 times as sharp as that of 1.5, and swings as slowly; with four
    times as many spheres as many more touch at once, and the step is shorter."""
    blunt, sharp = (equivalent_sphere_radius(particle(f"prolate:{r}"), SPRINGS) for r in (1.5, 3))
    assert 0.8 < sharp / blunt < 1.25
    dense = equivalent_sphere_radius(particle("prolate:3", sub_spheres=201), SPRINGS)
    assert 4**-0.4 < dense / sharp < 0.8  # at most all of them act at once
    assert DEEPEST < 0.1  # for which Hertz's law is
