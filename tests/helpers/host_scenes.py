"""One ball in an enclosure on a host, without gravity: a world for closed forms."""

import math

import numpy as np
from damper_scenes import acrylic

from damper3d.case.host import Drive, Modes, host_of
from damper3d.engine.enclosures import cylinder
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world

UP, RADIUS = np.array([0.0, 0.0, 1.0]), 5e-3


def on_host(
    modes: Modes, drive: Drive, *, mass: float, gap: float, dt: float, restitution: float = 0.6,
    steps_per_sample: int = 1, off: float = 0.0,
) -> Simulation:  # fmt: skip
    """A ball of a mass in the middle of a cylinder that it has a gap in, or off it; SI."""
    law = acrylic(restitution, 0.0, dashpot=False)
    density = mass / (4 / 3 * math.pi * RADIUS**3)
    world = build_world(
        np.array([[0.0, 0.0, RADIUS + gap / 2 + off]]), np.array([RADIUS]), density=density,
        enclosure=cylinder(0.05, 2 * RADIUS + gap), pair_law=law, wall_law=law,
        shaker=host_of(modes, drive, dt, 0.0), direction=UP, gravity=np.zeros(3), time_step=dt,
    )  # fmt: skip
    sim = Simulation(world, steps_per_sample)
    start = float(sim.sample()["displacement"][0])
    sim.world.spheres.position[:1, 2] += start
    return sim
