"""Triangulated surfaces: of balls and what is stretched from them, and of what is turned."""

from functools import cache
from typing import NamedTuple

import numpy as np


class Surface(NamedTuple):
    """Triangles whose corners go anticlockwise when seen from outside."""

    vertices: np.ndarray  # (n, 3) [m]
    triangles: np.ndarray  # (m, 3) rows of vertices

    @property
    def corners(self) -> np.ndarray:
        """The corners of each triangle, (m, 3, 3) [m]."""
        return self.vertices[self.triangles]

    def scaled(self, factor: float) -> "Surface":
        """The surface, larger by a factor."""
        return Surface(factor * self.vertices, self.triangles)


@cache
def unit_ball(splits: int = 4) -> Surface:
    """The ball of radius one: an icosahedron whose triangles are split into four, `splits` times.

    20 x 4^splits triangles of nearly one size, with their corners on the ball.
    """
    vertices, triangles = _icosahedron()
    for _ in range(splits):
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        unique, which = np.unique(edges, axis=0, return_inverse=True)
        ab, bc, ca = (which.reshape(-1, 3) + len(vertices)).T
        a, b, c = triangles.T
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = np.concatenate([np.stack(part, axis=1) for part in parts])
        vertices = np.concatenate([vertices, vertices[unique].mean(axis=1)])
    return Surface(vertices / np.linalg.norm(vertices, axis=1)[:, None], triangles)


def _icosahedron() -> tuple[np.ndarray, np.ndarray]:
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    corners = [(s, t * golden, 0.0) for s in (-1.0, 1.0) for t in (-1.0, 1.0)]
    vertices = np.array([np.roll(corner, k) for k in range(3) for corner in corners])
    apart = np.linalg.norm(vertices[:, None] - vertices, axis=2)
    near = np.isclose(apart, 2.0)
    faces = [
        (i, j, k)
        for i in range(12) for j in range(i + 1, 12) for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]  # fmt: skip
    triangles = np.array(faces)
    inwards = np.linalg.det(vertices[triangles]) < 0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return vertices, triangles


def tube(radius: float, distance: float, around: int = 96, across: int = 32) -> Surface:
    """A circular toroid round the z axis: a tube of a radius [m], at a distance from it [m]."""
    phi = np.arange(around) * (2.0 * np.pi / around)
    theta = np.arange(across) * (2.0 * np.pi / across)
    out = distance + radius * np.cos(theta)
    height = np.broadcast_to(radius * np.sin(theta), (around, across))
    vertices = np.stack([np.outer(np.cos(phi), out), np.outer(np.sin(phi), out), height], axis=2)
    i, j = (part.ravel() for part in np.indices((around, across)))
    corner = [((i + p) % around) * across + (j + q) % across for p in (0, 1) for q in (0, 1)]
    triangles = np.concatenate(
        [
            np.stack([corner[0], corner[2], corner[3]], 1),
            np.stack([corner[0], corner[3], corner[1]], 1),
        ]
    )
    return Surface(vertices.reshape(-1, 3), triangles)
