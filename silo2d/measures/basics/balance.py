"""Weight and what bears it: base, hopper and friction at the walls, and what accelerates.

In a window of frames the vertical momentum of the particles changes by the impulse of all forces,

    sum of forces of the walls, upwards = weight + (change of momentum)/time

The forces are means over every step (frames hold them), the weight is the mean over the window, and
a particle that is taken out counts until the last frame that has it. What is left over is the
error of this balance: of forces that such particles still pass on, and of the frames' single
precision. Before the opening the same holds of the last looks at the settling; at the end nothing
moves, and the forces are the weight.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from silo2d.measures.basics.contacts import GRAVITY
from silo2d.measures.basics.walls import Samples
from silo2d.view.scene import Scene

PARTS = "walls", "hopper", "floor", "inserts", "door"
_VERTICAL = 1e-6  # run over length of a wall that counts as vertical, at most; likewise level


class Balance(NamedTuple):
    """Vertical forces [N], upwards on the particles, and their weight."""

    weight: float
    walls: float  # friction at the vertical walls
    hopper: float  # inclined walls
    floor: float  # level walls
    inserts: float  # whichever way their sides are inclined
    door: float
    inertia: float  # mass times acceleration, downwards

    @property
    def closure(self) -> float | None:
        """Part of the weight that the balance lacks (negative) or has too much."""
        borne = sum(getattr(self, part) for part in PARTS) + self.inertia
        return borne / self.weight - 1.0 if self.weight else None

    def numbers(self) -> dict[str, float | None]:
        """For JSON: forces [N], shares of the weight, and the closure."""
        forces = {f"{name}_n": value for name, value in self._asdict().items()}
        shares = {
            f"{name}_share": getattr(self, name) / self.weight if self.weight else None
            for name in (*PARTS, "inertia")
        }
        return {**forces, **shares, "closure": self.closure}


def part_of_wall(scene: Scene) -> list[str]:
    """Part of the silo that each wall belongs to: one of PARTS."""
    segments = scene.trajectory.static["wall_segments"]
    run, rise = np.abs(segments[:, 1] - segments[:, 0]).T
    length = np.hypot(run, rise)
    parts = np.where(run <= _VERTICAL * length, "walls", "hopper")
    parts = np.where(rise <= _VERTICAL * length, "floor", parts)
    own = np.where(scene.of_insert, "inserts", parts[: len(scene.walls)])
    return own.tolist() + ["door"] * scene.n_doors


def _balance(scene: Scene, weight: float, upwards: NDArray, inertia: float) -> Balance:
    """Balance of a weight and the forces of the walls (w,), upwards [N]."""
    parts = np.array(part_of_wall(scene))
    borne = {part: float(upwards[parts == part].sum()) for part in PARTS}
    return Balance(weight=weight, inertia=inertia, **borne)


def weight_at(scene: Scene, frame: int) -> float:
    """Weight of the particles that are simulated at a frame [N]."""
    return float(GRAVITY * scene.trajectory.static["mass"][scene.trajectory["inside"][frame]].sum())


def balance_of_samples(scene: Scene, samples: Samples, frame: int) -> Balance:
    """Balance of moments at rest, by the forces of their contacts; frame: with the particles."""
    n_walls = len(scene.trajectory.static["wall_segments"])
    down = np.bincount(samples.wall, -samples.force[:, 1], minlength=n_walls) / len(samples.time)
    return _balance(scene, weight_at(scene, frame), down, 0.0)


def balance_at_rest(scene: Scene, settling: Mapping[str, NDArray] | None) -> Balance:
    """Balance just before the opening: of the last looks at the settling, with their momentum.

    settling: columns of that table; without it the forces of the first frame, of a millisecond.
    """
    weight = weight_at(scene, 0)
    if settling is None or len(settling["time"]) < 2:
        forces = scene.trajectory["wall_force"][0]
        return _balance(scene, weight, -forces[:, 1], 0.0)
    steps, momentum = np.diff(settling["time"]), settling["momentum"]
    span = float(steps.sum())
    upwards = -(steps @ settling["force"][1:, :, 1]) / span
    return _balance(scene, weight, upwards, float(momentum[0] - momentum[-1]) / span)


def balance_between(scene: Scene, first: float, last: float) -> Balance | None:
    """Balance in a window of time [s], over its whole frames; None of fewer than two."""
    frames = np.flatnonzero((scene.time >= first) & (scene.time <= last))
    if len(frames) < 2:
        return None
    start, end = int(frames[0]), int(frames[-1])
    steps = np.diff(scene.time[start : end + 1])
    span = float(steps.sum())
    force = scene.trajectory["wall_force"][start + 1 : end + 1, :, 1]
    upwards = -(steps @ force) / span
    inside = scene.trajectory["inside"][start : end + 1]
    mass, vy = scene.trajectory.static["mass"], scene.trajectory["vy"][start : end + 1]
    # Steps through which a particle is in the simulation from beginning to end, and what it gains.
    through = inside[:-1] & inside[1:]
    weight = GRAVITY * float(steps @ (through @ mass)) / span
    gained = float((through * np.diff(vy.astype(float), axis=0)).sum(axis=0) @ mass) / span
    return _balance(scene, weight, upwards, -gained)
