"""The enclosure in a picture: what of the run's space is shown, and where its walls stand."""

import numpy as np
from numpy.typing import NDArray

from damper3d.view.pictures.scene import Scene
from damper3d.view.pictures.spheres import Window

Array = NDArray[np.float64]

_AROUND = 0.04  # of the enclosure's size, left free around it


def corners(scene: Scene) -> Array:
    """Least and largest right and up (2, 2) [m] of the enclosure in its own frame."""
    width, depth, height = scene.size
    ends = np.array([[-width / 2, -depth / 2, 0.0], [width / 2, depth / 2, height]])
    across = scene.view.project(ends)[:, :2]
    return np.stack([across.min(axis=0), across.max(axis=0)])


def window(scene: Scene, scale: float) -> Window:
    """What holds the enclosure wherever it goes, at a scale [px/m]."""
    low, high = corners(scene)
    reach = scene.trajectory["displacement"]
    moved = np.stack([scene.view.project(u * scene.direction) for u in (reach.min(), reach.max())])
    margin = _AROUND * max(high - low)
    left, bottom = low + moved[:, :2].min(axis=0) - margin
    right, top = high + moved[:, :2].max(axis=0) + margin
    return Window(float(left), float(right), float(bottom), float(top), scale)


def cut(scene: Scene, frame: int) -> tuple[Array, NDArray[np.bool_]]:
    """Centres (n, 3) [m] as drawn, in the lab, and which are: the half that is nearer is away."""
    view = scene.view
    inside = view.project(scene.particles(frame).position)
    middle = view.project(np.array([0.0, 0.0, scene.enclosure.height / 2]))[2]
    return inside + view.project(scene.shift(frame)), inside[:, 2] <= middle


def spheres_drawn(scene: Scene, frame: int) -> tuple[Array, Array, NDArray[np.int64]]:
    """The spheres of the particles that are drawn.

    Centres (m, 3) [m] as seen, in the lab, radii (m,) [m], and the particles' numbers (m,).
    """
    centre, kept = cut(scene, frame)
    arm, radius, whose = scene.spheres(frame)
    stays = kept[whose]
    return (centre[whose] + scene.view.project(arm))[stays], radius[stays], whose[stays]
