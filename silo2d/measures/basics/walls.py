"""The walls: their sides and directions, and the pressure and shear of the particles on each.

Tractions are of the plane [N/m]: divide by the prisms' length for pascals.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from silo2d.measures.basics.coarse_graining import Floats
from silo2d.measures.basics.contacts import Moment
from silo2d.measures.basics.particles import outlet_centre
from silo2d.view.scene import Scene

STRETCH = 2.5  # typical particle sizes that a stretch of wall is long, at least


def sides(scene: Scene) -> NDArray[np.int64]:
    """-1 for walls left of the outlet's middle, 1 for those right of it (w,).

    0 for doors and the sides of inserts.
    """
    segments = scene.trajectory.static["wall_segments"]
    return sides_of(segments, scene.wall_names, outlet_centre(scene))


def sides_of(segments: Floats, names: Sequence[str], centre: float) -> NDArray[np.int64]:
    """The same of walls (w, 2, 2) with names about an outlet whose middle is at x = centre."""
    side = np.where(segments.mean(axis=1)[:, 0] < centre, -1, 1)
    side[[name.startswith(("door", "insert")) for name in names]] = 0
    return side


def outwards(segments: Floats) -> Floats:
    """Unit vectors (w, 2) out of the silo: the inside is on the left of each wall (w, 2, 2)."""
    along = segments[:, 1] - segments[:, 0]
    return np.column_stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)[:, None]


@dataclass(frozen=True, eq=False)
class Samples:
    """Contacts of particles with walls at m moments; SI.

    time      (m,) since the opening, negative before it; of a filling since its beginning
    moment    (n,) index of the moment of each contact
    wall      (n,) index of its wall
    point     (n, 2) where the force acts
    force     (n, 2) on the wall
    """

    time: Floats
    moment: NDArray[np.int64]
    wall: NDArray[np.int64]
    point: Floats
    force: Floats

    def between(self, first: float, last: float) -> "Samples":
        """The moments of a window of time [s]."""
        chosen = (self.time >= first) & (self.time <= last)
        number, here = np.cumsum(chosen) - 1, chosen[self.moment]
        return Samples(self.time[chosen], number[self.moment[here]], self.wall[here],
                       self.point[here], self.force[here])  # fmt: skip


def samples_of(moments: list[Moment]) -> Samples:
    """Contacts of moments that are at walls."""
    at = [m.at_wall for m in moments]
    return Samples(
        np.array([m.time for m in moments]),
        np.repeat(np.arange(len(moments)), [here.sum() for here in at]),
        np.concatenate(
            [m.bodies[h, 1] - m.scene.n_particles for m, h in zip(moments, at, strict=True)]
        ),
        np.concatenate([m.point[h] for m, h in zip(moments, at, strict=True)]),
        np.concatenate([m.force[h] for m, h in zip(moments, at, strict=True)]),
    )


@dataclass(frozen=True, eq=False)
class Tractions:
    """Tractions on one wall, by stretches of even length; (m, b) at moments, (b,) their means.

    name       of the wall
    height     of the middles of its stretches (b,) [m]
    normal     pressure outwards (..., b) [N/m]
    shear      traction down the wall (..., b) [N/m]
    length     of a stretch [m]
    """

    name: str
    height: Floats
    normal: Floats
    shear: Floats
    length: float


def on_walls(scene: Scene, samples: Samples, stretch: float | None = None) -> list[Tractions]:
    """Tractions on each wall but the door.

    stretch: least length [m], STRETCH typical sizes unless given. A force counts where its point
    is; over all stretches the forces of a wall add up exactly.
    """
    segments, stretch = scene.walls, stretch or STRETCH * scene.particle_size
    found = []
    for k, (start, end) in enumerate(segments):
        length = float(np.hypot(*(end - start)))
        n = max(int(length / stretch), 1)
        out, down = outwards(segments)[k], _down(scene, start, end)
        here = samples.wall == k
        along = (samples.point[here] - start) @ (end - start) / length**2
        which = np.clip((along * n).astype(int), 0, n - 1)
        sums = np.zeros((2, len(samples.time), n))
        for row, direction in enumerate((out, down)):
            np.add.at(sums[row], (samples.moment[here], which), samples.force[here] @ direction)
        middles = start[1] + (np.arange(n) + 0.5) / n * (end[1] - start[1])
        normal, shear = sums / (length / n)
        found.append(Tractions(scene.wall_names[k], middles, normal, shear, length / n))
    return found


def tractions(moments: list[Moment]) -> list[Tractions]:
    """Means over moments of what particles do to each wall but the door."""
    return [
        replace(one, normal=one.normal.mean(axis=0), shear=one.shear.mean(axis=0))
        for one in on_walls(moments[0].scene, samples_of(moments))
    ]


def _down(scene: Scene, start: Floats, end: Floats) -> Floats:
    """Unit vector down a wall; on a level floor towards the outlet."""
    along = (end - start) / np.hypot(*(end - start))
    (left, _), (right, _) = scene.trajectory.attributes["lips"]
    falls = -along[1] or along[0] * np.sign((left + right) / 2 - start[0])
    return along if falls > 0 else -along
