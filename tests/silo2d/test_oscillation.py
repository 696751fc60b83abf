"""A particle between two walls: every stiffness, damping, arm and inertia sets a rate.

Pressed into both walls and nudged, it oscillates as x'' + gamma x' + omega0^2 x = 0, across the
walls on its normal springs, along them and in its spin on the tangential ones.
"""

import math

import numpy as np
import pytest
from analytic import damped
from numpy.testing import assert_allclose
from scenes import DISC_CONTACTS, WOOD, block, disc, inertia, mass, squeezed

from silo2d.engine import state

DEEP = 1e-4  # overlap with both walls [m]
BLOCK, BLOCK_HALF_HEIGHT = block(20e-3, 10e-3), 5e-3  # [m]
RADIUS = 5e-3  # of the disc [m]
# (position, velocity half a step back, velocity now) of each direction.
ACROSS = (state.Y, state.VY, state.UY)
ALONG = (state.X, state.VX, state.UX)
SPINNING = (state.ANGLE, state.OMEGA, state.UOMEGA)


def pushing(law):
    """Across the walls: two pairs at each. Shape, half its height, direction, omega0^2, gamma."""
    m = mass(squeezed(BLOCK, BLOCK_HALF_HEIGHT, DEEP, law, 1.0))
    return BLOCK, BLOCK_HALF_HEIGHT, ACROSS, 4 * law.kn / m, 4 * law.gamma_n


def sliding(law):
    """Along the walls."""
    m = mass(squeezed(BLOCK, BLOCK_HALF_HEIGHT, DEEP, law, 1.0))
    return BLOCK, BLOCK_HALF_HEIGHT, ALONG, 4 * law.kt / m, 4 * law.gamma_t


def spinning(law):
    """A disc on the spot: forces act at the middle of the overlap, a = r - d/2 from its centre."""
    simulation = squeezed(disc(RADIUS), RADIUS, DEEP, law, 1.0)
    arms = 2 * DISC_CONTACTS * (RADIUS - DEEP / 2) ** 2 / inertia(simulation)
    rate = mass(simulation) * law.gamma_t * arms
    return disc(RADIUS), RADIUS, SPINNING, law.kt * arms, rate


def oscillate(mode, law, steps_per_turn, turns=3):
    """(simulated, exact) displacements in parts of the amplitude, step by step, and omega0 dt.

    The first step stretches a tangential spring by the velocity half a step back: the motion
    starts one step after it passed its middle.
    """
    shape, half_height, (at, half_back, now), omega_squared, gamma = mode(law)
    omega0 = math.sqrt(omega_squared)
    step = 2 * math.pi / omega0 / steps_per_turn
    amplitude = 1e-3 * DEEP / (1.0 if at != state.ANGLE else RADIUS)
    t = step * np.arange(1, turns * steps_per_turn + 1)
    x, v = damped(omega0, gamma, t)
    exact = omega0 * x

    simulation = squeezed(shape, half_height, DEEP, law, step)
    row = simulation.rows[0]
    middle = row[at]
    row[at] += amplitude * exact[0]
    row[half_back], row[now] = amplitude * exact[0] / step, amplitude * omega0 * v[0]
    simulated = np.empty_like(exact)
    for n in range(len(t)):
        simulated[n] = (row[at] - middle) / amplitude
        simulation.run(1)
    return simulated, exact, omega0 * step


@pytest.mark.parametrize("mode", [pushing, sliding, spinning])
@pytest.mark.parametrize(
    "law",
    [
        WOOD._replace(gamma_n=0.0, gamma_t=0.0),
        WOOD,
        WOOD._replace(gamma_n=500.0, gamma_t=1500.0),
        WOOD._replace(kn=3e6, kt=4e6, gamma_n=100.0, gamma_t=5000.0),
    ],
)
def test_oscillation_between_walls(mode, law):
    """exp(-b t) sin(w t)/w with four pairs (six for the disc) and a wall's reduced mass, the
    particle's own. Tolerance: the leapfrog's frequency is (omega dt)^2/24 too high, which makes a
    phase of 0.8 (omega dt)^2 in three turns; amplitude and decay are as far off. One percent of
    a constant would shift the phase by 200 times as much."""
    simulated, exact, omega_dt = oscillate(mode, law, steps_per_turn=300)
    assert_allclose(simulated, exact, rtol=0, atol=2 * omega_dt**2)


@pytest.mark.parametrize("mode", [pushing, sliding, spinning])
def test_observed_order_of_convergence(mode):
    """The leapfrog is of second order, and with the velocity extrapolated to now the dashpots
    are as well: half the step, a quarter of the error. Tolerance: 0.1 of the slope."""
    law = WOOD._replace(gamma_n=3000.0, gamma_t=1000.0)
    errors, sizes = [], []
    for steps_per_turn in (50, 100, 200, 400):
        simulated, exact, omega_dt = oscillate(mode, law, steps_per_turn)
        errors.append(np.abs(simulated - exact).max())
        sizes.append(omega_dt)
    slope, _ = np.polyfit(np.log(sizes), np.log(errors), 1)
    assert slope == pytest.approx(2.0, abs=0.1), f"observed order {slope:.3f}"
