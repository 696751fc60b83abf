"""A dropped enclosure with particles in it: how high it rebounds.

In the frame that falls freely with box and bed both are at rest before the impact, and nothing has
weight. The floor gives the box, at once, a velocity of (1 + e0) v against the bed that rests on its
bottom; what is then left is the bed's work on a free box. Against the floor the box has risen by

    y(t) = x(t) - v t - g t^2/2,        x(0) = 0, x'(0) = (1 + e0) v

until y is zero again. e0 is the restitution of the empty box. The free box is a host on a spring
so soft that it bears 1e-8 of its weight in a flight.
"""

import math

import numpy as np

from damper3d.case.case import GRAVITY, DamperCase
from damper3d.case.host.host import Drive, host_of
from damper3d.case.host.modes import Modes
from damper3d.run.fill import fill, resting
from granulab.campaign.runs.protocol import Stop
from granulab.errors import Stopped

_SLOW = 1e-3  # [rad/s] of the spring
_SAMPLE = 1e-4  # [s] between two looks at the box


def rebound(
    case: DamperCase, ratio: float, restitution: float, drop: float, stop: Stop = lambda: False
) -> float:
    """Height of the first rebound of an upright enclosure over that from which it fell [-].

    The bed of the case settles in it; its motion is not used. ratio: the bed's mass over the
    enclosure's; restitution: e0; drop [m]. Raises what filling raises, SimulationError, and
    Stopped where `stop` says so.
    """

    def stop_if_requested(*_progress: object) -> None:
        if stop():
            raise Stopped("the same command drops it again, from its seed")

    poured, step = fill(case, stop_if_requested), case.steps.free
    sim = resting(case, poured.state["position"][:, :3])
    sim.restore(poured.state)
    speed = math.sqrt(2 * GRAVITY * drop)
    modes = Modes.single(case.mass / ratio, _SLOW, 0.0)
    drive = Drive(_SLOW, start_velocity=(1 + restitution) * speed)
    sim.begin_phase(shaker=host_of(modes, drive, step, 0.0), gravity=np.zeros(4), time_step=step)
    sim.steps_per_sample = math.ceil(_SAMPLE / step)
    highest = 0.0
    while True:  # the empty box is back after 2 e0 v/g
        rows = sim.run(10)
        stop_if_requested()
        t = rows["time"]
        y = rows["displacement"] - speed * t - 0.5 * GRAVITY * t**2
        down = np.flatnonzero(y < 0)
        highest = max(highest, float(y[: down[0] if down.size else None].max(initial=0.0)))
        if down.size:
            return highest / drop
