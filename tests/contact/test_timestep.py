"""The stability limit: its formula, modes of known configurations, and the engine at the limit."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import WOOD, block, disc, inertia, launch, mass, position, squeezed

from granulab.contact.timestep import highest_rate, rayleigh_time_step, stable_time_step

STANDING, LYING = block(10e-3, 20e-3), block(20e-3, 10e-3)  # rock slower than they push or slide
DEEP = 1e-4  # overlap with both walls [m]
NUDGE, GROWN = 1e-12, 1e-7  # [m]; both so small that neither wall is left


def excursion(time_step, law, direction, shape, half_height):
    """How far [m or rad] a nudged particle between walls strays, until it has grown or settled."""
    simulation = squeezed(shape, half_height, DEEP, law, time_step)
    launch(simulation, **{("vx", "vy", "spin")[direction]: NUDGE / time_step})
    start = position(simulation)[direction]
    most = 0.0
    for _ in range(2000):
        simulation.run(1)
        most = max(most, abs(position(simulation)[direction] - start))
        if most > GROWN:
            break
    return most


def assert_limit(limit, *scene):
    """Within 1 %. Above the limit the nudge grows by at least some 1 % a step, 1e8 in 2000;
    below it oscillates, undamped with an amplitude of NUDGE/sqrt(4 - (omega dt)^2)."""
    assert excursion(0.99 * limit, *scene) < 10 * NUDGE
    assert excursion(1.01 * limit, *scene) > GROWN


@pytest.mark.parametrize("gamma", [0.0, 6085.0, 3e4, 1e5])
def test_limit_of_pushing(gamma):
    """A block between two walls, two pairs at each: omega^2 = 4 kn/m, damping rate 4 gamma_n."""
    law = WOOD._replace(gamma_n=gamma)
    m = mass(squeezed(STANDING, 10e-3, DEEP, law, 1e-9))
    assert_limit(stable_time_step(4 * law.kn / m, 4 * gamma), law, 1, STANDING, 10e-3)


@pytest.mark.parametrize("gamma", [0.0, 3e4])
def test_limit_of_sliding(gamma):
    """The same along the walls, with kt large enough to be the faster spring, and friction that
    holds: omega^2 = 4 kt/m, damping rate 4 gamma_t."""
    law = WOOD._replace(kt=10 * WOOD.kn, mu=1e6, gamma_n=0.0, gamma_t=gamma)
    m = mass(squeezed(LYING, 5e-3, DEEP, law, 1e-9))
    assert_limit(stable_time_step(4 * law.kt / m, 4 * gamma), law, 0, LYING, 5e-3)


@pytest.mark.parametrize("gamma", [0.0, 3e4])
def test_limit_of_rotation(gamma):
    """A disc between two walls: 2 DISC_CONTACTS = 6 springs at the arm a = r - d/2 from its
    centre, omega^2 = 6 kt a^2/I, damping rate 6 m gamma_t a^2/I."""
    r = 5e-3
    law = WOOD._replace(kt=WOOD.kn, mu=1e6, gamma_n=0.0, gamma_t=gamma)
    simulation = squeezed(disc(r), r, DEEP, law, 1e-9)
    per_inertia = 6 * (r - DEEP / 2) ** 2 / inertia(simulation)
    limit = stable_time_step(law.kt * per_inertia, mass(simulation) * gamma * per_inertia)
    assert_limit(limit, law, 2, disc(r), r)


@given(omega=st.floats(1e-3, 1e7), gamma=st.floats(0.0, 1e7))
def test_stable_time_step_solves_its_equation(omega, gamma):
    """(omega dt)^2 + 4 gamma dt = 4. Tolerance: rounding."""
    dt = stable_time_step(omega**2, gamma)
    assert (omega * dt) ** 2 + 4 * gamma * dt == pytest.approx(4.0, rel=1e-13)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_highest_rate_of_a_chain(n):
    """n equal masses and n + 1 springs between two walls: omega^2 = (4 k/m) sin^2(n pi/(2 n + 2))
    (any textbook). Tolerance: rounding of the eigenvalue."""
    k, m = 1e7, 5e-3
    jacobian = np.eye(n + 1, n) - np.eye(n + 1, n, k=-1)
    rate = highest_rate(jacobian, np.full(n + 1, k), np.full(n, 1 / m))
    assert rate == pytest.approx(4 * k / m * math.sin(n * math.pi / (2 * n + 2)) ** 2, rel=1e-12)


def test_highest_rate_of_two_masses_on_one_spring():
    """omega^2 = k/m with the reduced mass; the free mode has rate 0."""
    rate = highest_rate(np.array([[1.0, -1.0]]), np.array([1e7]), np.array([1 / 2e-3, 1 / 6e-3]))
    assert rate == pytest.approx(1e7 / (2e-3 * 6e-3 / 8e-3), rel=1e-13)


@pytest.mark.parametrize(("radius", "published"), [(2.5e-3, 8.33e-6), (1.5e-3, 5.0e-6)])
def test_rayleigh_step_of_acrylic_spheres(radius, published):
    """Granular-damper thesis, eq. 3.31 with Table 6.2 (its Table 6.1 prints 8.4e-6 s)."""
    step = rayleigh_time_step(radius, 1190.0, 3.3e9, 0.37)
    assert step == pytest.approx(published, rel=1e-3)
