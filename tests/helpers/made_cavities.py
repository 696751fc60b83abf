"""Triangulated cavities: boxes with a floor in many triangles, prisms, boxes with a ridge."""

from pathlib import Path

import numpy as np

from damper3d.engine.enclosures import Cavity


def cavity_of(corners: np.ndarray) -> Cavity:
    """The cavity between triangles (m, 3, 3) [m] that face outwards."""
    points, which = np.unique(np.round(corners.reshape(-1, 3), 12), axis=0, return_inverse=True)
    return Cavity("made.stl", "m", points, which.reshape(-1, 3))


def box_of(width: float, height: float, across: int = 1, jitter: float = 0.0) -> np.ndarray:
    """A box (m, 3, 3) [m] whose floor is across^2 squares in two triangles each.

    jitter: how far the floor's inner corners are moved within it, over the size of a square.
    """
    rng = np.random.default_rng(3)
    edge = np.linspace(-0.5 * width, 0.5 * width, across + 1)
    floor = np.stack(np.meshgrid(edge, edge, [0.0], indexing="ij"), axis=-1)[:, :, 0]
    way = jitter * width / across * rng.uniform(-0.5, 0.5, (across + 1, across + 1, 2))
    floor[1:-1, 1:-1, :2] += way[1:-1, 1:-1]
    a, b, c, d = floor[:-1, :-1], floor[1:, :-1], floor[1:, 1:], floor[:-1, 1:]
    parts = [np.stack(corners, axis=2).reshape(-1, 3, 3) for corners in ((a, c, b), (a, d, c))]
    rim = np.concatenate([floor[:-1, 0], floor[-1, :-1], floor[:0:-1, -1], floor[0, :0:-1]])
    return np.concatenate([*parts, *_around(rim, height, np.zeros(3))])


def prism_of(rim: np.ndarray, height: float, apex: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """A prism (m, 3, 3) [m] over a polygon (n, 3), anticlockwise from above; the apex sees all."""
    middle = np.array([*apex, 0.0])
    after = np.roll(rim, -1, axis=0)
    fan = np.stack([np.broadcast_to(middle, rim.shape), after, rim], axis=1)
    return np.concatenate([fan, *_around(rim, height, middle)])


def _around(rim: np.ndarray, height: float, apex: np.ndarray) -> list[np.ndarray]:
    """Sides and lid over a rim (n, 3), anticlockwise from above; the apex (3,) sees all of it."""
    up = np.array([0.0, 0.0, height])
    after = np.roll(rim, -1, axis=0)
    lid = np.stack([np.broadcast_to(apex, rim.shape), rim, after], axis=1) + up
    return [
        np.stack([rim, after, after + up], axis=1), np.stack([rim, after + up, rim + up], axis=1),
        lid,
    ]  # fmt: skip


def round_rim(diameter: float, n: int) -> np.ndarray:
    """A regular polygon (n, 3) with the area of a circle, so that a prism has its volume."""
    angle = 2 * np.pi * np.arange(n) / n
    radius = 0.5 * diameter * np.sqrt(2 * np.pi / (n * np.sin(2 * np.pi / n)))
    return radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)


def ell(size: float, width: float) -> np.ndarray:
    """The rim (6, 3) of an L, for an apex within `width` of the origin; first its reflex corner."""
    xy = [(width, width), (width, size), (0, size), (0, 0), (size, 0), (size, width)]
    return np.array([(x, y, 0.0) for x, y in xy])


def write_stl(path: Path, corners: np.ndarray) -> Path:
    """Write triangles (m, 3, 3) as binary STL, in single numbers."""
    import trimesh

    mesh = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3),
                           process=False)  # fmt: skip
    path.write_bytes(mesh.export(file_type="stl"))
    return path
