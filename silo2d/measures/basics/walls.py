"""The walls: their sides and directions, and the pressure and shear of the particles on each.

Tractions are of the plane [N/m]: divide by the prisms' length for pascals.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from silo2d.measures.basics.coarse_graining import Floats
from silo2d.measures.basics.contacts import Moment
from silo2d.measures.basics.particles import outlet_centre, particle_size
from silo2d.view.scene import Scene

STRETCH = 2.5  # typical particle sizes that a stretch of wall is long, at least


def sides(scene: Scene) -> NDArray[np.int64]:
    """-1 for walls left of the outlet's middle, 1 for those right of it, 0 for the door (w,)."""
    middles = scene.trajectory.static["wall_segments"].mean(axis=1)[:, 0]
    side = np.where(middles < outlet_centre(scene), -1, 1)
    side[-1] = 0
    return side


def outwards(segments: Floats) -> Floats:
    """Unit vectors (w, 2) out of the silo: the inside is on the left of each wall (w, 2, 2)."""
    along = segments[:, 1] - segments[:, 0]
    return np.column_stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)[:, None]


@dataclass(frozen=True, eq=False)
class Tractions:
    """Tractions on one wall, by stretches of even length; means over moments.

    name       of the wall
    height     of the middles of its stretches (b,) [m]
    normal     pressure outwards (b,) [N/m]
    shear      traction down the wall (b,) [N/m]
    length     of a stretch [m]
    """

    name: str
    height: Floats
    normal: Floats
    shear: Floats
    length: float


def tractions(moments: list[Moment]) -> list[Tractions]:
    """Means over moments of what particles do to each wall but the door."""
    scene = moments[0].scene
    segments = scene.walls
    stretch = STRETCH * particle_size(scene)
    found = []
    for k, (start, end) in enumerate(segments):
        length = float(np.hypot(*(end - start)))
        n = max(int(length / stretch), 1)
        out, down = outwards(segments)[k], _down(scene, start, end)
        sums = np.zeros((2, n))
        for moment in moments:
            here = moment.bodies[:, 1] == scene.n_particles + k
            along = (moment.point[here] - start) @ (end - start) / length**2
            which = np.clip((along * n).astype(int), 0, n - 1)
            for row, direction in enumerate((out, down)):
                np.add.at(sums[row], which, moment.force[here] @ direction)
        middles = start[1] + (np.arange(n) + 0.5) / n * (end[1] - start[1])
        normal, shear = sums / len(moments) / (length / n)
        found.append(Tractions(scene.wall_names[k], middles, normal, shear, length / n))
    return found


def _down(scene: Scene, start: Floats, end: Floats) -> Floats:
    """Unit vector down a wall; on a level floor towards the outlet."""
    along = (end - start) / np.hypot(*(end - start))
    (left, _), (right, _) = scene.trajectory.attributes["lips"]
    falls = -along[1] or along[0] * np.sign((left + right) / 2 - start[0])
    return along if falls > 0 else -along
