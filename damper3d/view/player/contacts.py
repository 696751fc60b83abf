"""Pairs of bodies that touch in the frames of a run: forces, normals, and stress in spheres."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damper3d.view.player.walls import to_wall
from damper3d.view.scene import Scene
from granulab.campaign.output.page.player import Touching
from granulab.campaign.runs.ragged import Tables

Floats = NDArray[np.float64]


class Pairs(NamedTuple):
    """Pairs that touch in a frame, walls numbered after the n particles.

    bodies    (c, 2), ascending
    force     (c, 3) on the second, of all contacts of the two [N]
    normal    (c, 3) unit vector to the second: to its centre, or to the nearest point of a wall
    distance  (c,) of the first's centre from there [m]
    """

    frame: int
    bodies: NDArray[np.int64]
    force: Floats
    normal: Floats
    distance: Floats


def pairs_of(scene: Scene, contacts: Tables, position: Floats) -> list[Pairs]:
    """The pairs of each frame with contacts; position (F, n, 3) [m] of centres in the enclosure."""
    frame_of = {int(sample): frame for frame, sample in enumerate(scene.frame_sample)}
    found = []
    for k, sample in enumerate(contacts.frame):
        if (frame := frame_of.get(int(sample))) is not None:
            found.append(_pairs(scene, contacts.at(k), frame, position[frame]))
    return found


def _pairs(scene: Scene, kept: dict[str, np.ndarray], frame: int, position: Floats) -> Pairs:
    rows = np.column_stack([kept["body_1"], kept["body_2"]]).astype(np.int64)
    forces = np.column_stack([kept[f"force_{axis}"] for axis in "xyz"]).astype(float)
    turned = rows[:, 0] > rows[:, 1]
    rows[turned], forces[turned] = rows[turned][:, ::-1], -forces[turned]
    bodies, which = np.unique(rows, axis=0, return_inverse=True)
    bodies, force = bodies.reshape(-1, 2), np.zeros((len(bodies), 3))
    np.add.at(force, which.ravel(), forces)
    n = len(position)
    away = position[np.minimum(bodies[:, 1], n - 1)] - position[bodies[:, 0]]
    for row in np.flatnonzero(bodies[:, 1] >= n):
        first, second = bodies[row]
        away[row] = to_wall(scene.enclosure, int(second) - n, position[first])
    distance = np.linalg.norm(away, axis=1)
    return Pairs(frame, bodies, force, away / np.maximum(distance, 1e-300)[:, None], distance)


def touching(scene: Scene, pairs: Pairs) -> Touching:
    """The pairs as a page has them; pulls are not known where the normals of contacts are not."""
    at_wall = pairs.bodies[:, 1] >= len(scene.radius)
    pulls = (pairs.force * pairs.normal).sum(axis=1) < 0.0
    if scene.of_many_spheres:
        pulls = np.zeros(len(pulls), bool)
    branch = pairs.distance[at_wall, None] * pairs.normal[at_wall]
    size = np.linalg.norm(pairs.force, axis=1)
    return Touching(pairs.frame, pairs.bodies, size, pulls, branch)


def pressure(scene: Scene, pairs: Pairs) -> Floats:
    """A third of the trace of the mean stress in each sphere (n,) [Pa]; pressure is positive.

    sigma = -(1/V) sum_c f_c (x) b_c

    as silo2d.measures.basics.contacts.particle_stress has it. The branch b of a sphere is its
    radius along the normal, half the overlap left out; only the force along it counts here.
    """
    n, radius = len(scene.radius), scene.radius
    pressing = (pairs.force * pairs.normal).sum(axis=1)
    virial = np.zeros(n)
    for column in pairs.bodies.T:
        of = column < n
        np.add.at(virial, column[of], radius[column[of]] * pressing[of])
    return virial / (4.0 * np.pi * radius**3)
