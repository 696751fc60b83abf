"""Meshes of cubes and boxes, and the file that holds one."""

from pathlib import Path

import numpy as np

CUBE = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], float)
CUBE_FACES: list[tuple[int, ...]] = [
    (0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)
]  # fmt: skip


def write_obj(path: Path, vertices: np.ndarray, faces: list[tuple[int, ...]]) -> Path:
    """A Wavefront file; counts from 1."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(vertices).tolist()]
    lines += ["f " + " ".join(f"{k + 1}/1/1" for k in face) for face in faces]
    path.write_text("\n".join(["# made", *lines]), encoding="utf-8")
    return path


def cuboid(sides: tuple[float, float, float]) -> np.ndarray:
    """Triangles of a box."""
    fans = [(f[0], f[k], f[k + 1]) for f in CUBE_FACES for k in (1, 2)]
    return (CUBE * sides)[np.array(fans)]


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """By Rodrigues' formula."""
    cross = np.cross(np.eye(3), axis / np.linalg.norm(axis))
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
