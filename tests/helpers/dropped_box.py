"""A cylinder with grains that is dropped: the box as a host that nothing holds.

In the frame that falls freely with box and bed both are at rest before the impact, and nothing has
weight. The floor gives the box, at once, a velocity of (1 + e0) v against the bed that rests on its
bottom; what is then left is the bed's work on a free box. Against the floor the box has risen by

    y(t) = x(t) - v t - g t^2/2,        x(0) = 0, x'(0) = (1 + e0) v

until y is zero again. e0 is the restitution of the empty box.
"""

import math

import numpy as np
from damper_scenes import DENSITY, GRAVITY, RADIUS, acrylic, poured

from damper3d.case.host.host import Drive, host_of
from damper3d.case.host.modes import Modes
from damper3d.engine.enclosures import Enclosure
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world

SPHERE = DENSITY * 4 / 3 * math.pi * RADIUS**3  # [kg]
_SLOW = 1e-3  # rad/s of the host's spring: 1e-8 of the weight that it replaces in a flight
_STEP, _EVERY = 2e-6, 50  # [s], steps a sample


def rebound(
    enclosure: Enclosure, n: int, ratio: float, restitution: float, drop: float, seed: int = 1
) -> float:
    """Height of the first rebound of a box over that from which it fell [-].

    n spheres of 5 mm settle in it; ratio: their mass over the box's; restitution: e0; drop in m.
    """
    speed = math.sqrt(2 * GRAVITY * drop)
    modes = Modes.single(n * SPHERE / ratio, _SLOW, 0.0)
    drive = Drive(_SLOW, start_velocity=(1 + restitution) * speed)
    law = acrylic()
    sim = Simulation(
        build_world(
            poured(n, enclosure, seed), np.full(n, RADIUS), density=DENSITY, enclosure=enclosure,
            pair_law=law, wall_law=law, shaker=host_of(modes, drive, _STEP, 0.0),
            direction=np.array([0.0, 0.0, 1.0]), gravity=np.zeros(3), time_step=_STEP,
        ),
        _EVERY,
    )  # fmt: skip
    highest = 0.0
    while True:  # the empty box is back after 2 e0 v/g
        rows = sim.run(10)
        t = rows["time"]
        y = rows["displacement"] - speed * t - 0.5 * GRAVITY * t**2
        down = np.flatnonzero(y < 0)
        highest = max(highest, float(y[: down[0] if down.size else None].max(initial=0.0)))
        if down.size:
            return highest / drop


def one_body(ratio: float, restitution: float) -> float:
    """The same of a bed that at once moves with the box: ((e0 - r)/(1 + r))^2, 0 from r = e0 on."""
    return (max(restitution - ratio, 0.0) / (1 + ratio)) ** 2
