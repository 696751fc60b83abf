"""The damper's engine and the single-contact kernel give one result for one impact."""

import math

import numpy as np
import pytest

from damper3d.engine.enclosures import box
from damper3d.engine.motions import sine
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world
from damper3d.studies.single_contact.spheres.impact import Impact, run
from granulab.contact import load_table

ALUMINA = load_table("alumina").material("alumina")
SIZE = 0.2  # of the box [m]


def in_engine(impact, steps_per_contact):
    """(velocities, spins, the kernel's outcome) after an impact in a still box without gravity;
    the sphere touches after a tenth of a step, and parts long before the end."""
    alone = run(impact, steps_per_contact)
    dt = alone.time_step_s
    fall = impact.speed * math.cos(impact.angle) * 0.1 * dt
    r, c = impact.radius, 0.5 * SIZE
    places = [[0.0, 0.0, r + fall]] if not impact.sphere else [[0, 0, c + r + fall], [0, 0, c - r]]
    arriving = impact.speed * np.array([math.sin(impact.angle), 0.0, -math.cos(impact.angle)])
    world = build_world(
        np.array(places, float), np.full(len(places), r), density=ALUMINA.density.value,
        enclosure=box(SIZE, SIZE, SIZE), pair_law=impact.law, wall_law=impact.law,
        shaker=sine(0.0, 40.0, 9.81), direction=np.array([0.0, 0, 1]), gravity=np.zeros(3),
        time_step=dt,
    )  # fmt: skip
    simulation = Simulation(world)
    share = np.array([[1.0]] if not impact.sphere else [[0.5], [-0.5]])
    spin = np.zeros((len(places), 3))
    spin[0, 1] = impact.spin
    simulation.set_velocity(share * arriving, spin)
    simulation.step(alone.steps + 50)
    frame = simulation.frame()
    return frame["v"], frame["spin"], alone


@pytest.mark.parametrize("sphere", [False, True], ids=["wall", "pair"])
@pytest.mark.parametrize("tangential", ["displacement", "force"])
def test_engine_and_kernel_agree(tangential, sphere):
    """Oblique, with spin, slip and both dashpots. Tolerance: the engine meets the contact a tenth
    of a step later, and starts with no history: 1/steps of the change of velocity."""
    steps = 1000
    impact = Impact(ALUMINA, ALUMINA, sphere=sphere, angle=math.radians(25.0), spin=200.0,
                    restitution=0.86, friction=0.3, tangential=tangential)  # fmt: skip
    v, spin, alone = in_engine(impact, steps)
    apart = v[0] - v[1] if sphere else v[0]
    v_n, v_t = 3.9 * math.cos(impact.angle), 3.9 * math.sin(impact.angle)
    speed = np.hypot(apart[0], apart[2])
    expected = np.hypot(alone.normal_restitution * v_n, alone.tangential_restitution * v_t)
    assert speed == pytest.approx(expected, rel=2 / steps)
    assert spin[0, 1] == pytest.approx(alone.spin_rad_s, rel=2 / steps)
    assert np.abs(v[:, 1]).max() < 1e-12
