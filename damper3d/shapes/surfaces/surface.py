"""Triangulated surfaces: spheres, what is stretched from them, and surfaces of revolution."""

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
def unit_sphere(splits: int = 4) -> Surface:
    """The sphere of radius one: an icosahedron whose triangles are split into four, `splits` times.

    20 x 4^splits triangles of nearly one size, with their corners on the sphere.
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
    theta = np.arange(across) * (2.0 * np.pi / across)
    profile = np.stack([distance + radius * np.cos(theta), radius * np.sin(theta)], axis=1)
    vertices = _rings(profile, around)
    j = np.arange(across)
    return Surface(vertices, _bands(around, across, j, (j + 1) % across))


def revolved(profile: np.ndarray, around: int) -> Surface:
    """Surface of revolution round the z axis of a line from pole to pole.

    profile (k, 2) [m]: distance from the axis and height, upwards; the two ends are on the axis.
    """
    inner = profile[1:-1]
    n = len(inner)
    vertices = _rings(inner, around)
    j = np.arange(n - 1)
    i = np.arange(around)
    after = (i + 1) % around
    south, north = np.full(around, len(vertices)), np.full(around, len(vertices) + 1)
    caps = [
        np.stack([south, after * n, i * n], 1),
        np.stack([north, i * n + n - 1, after * n + n - 1], 1),
    ]
    poles = [[0.0, 0.0, profile[0, 1]], [0.0, 0.0, profile[-1, 1]]]
    triangles = np.concatenate([_bands(around, n, j, j + 1), *caps])
    return Surface(np.concatenate([vertices, poles]), triangles)


def _rings(profile: np.ndarray, around: int) -> np.ndarray:
    """The points of a profile (k, 2), rotated round z by equal angles: (around * k, 3)."""
    phi = np.arange(around) * (2.0 * np.pi / around)
    x, y = np.outer(np.cos(phi), profile[:, 0]), np.outer(np.sin(phi), profile[:, 0])
    return np.stack([x, y, np.broadcast_to(profile[:, 1], x.shape)], axis=2).reshape(-1, 3)


def _bands(around: int, k: int, here: np.ndarray, following: np.ndarray) -> np.ndarray:
    """Triangles between two points of a profile of k, all round."""
    i = np.repeat(np.arange(around), len(here))
    after = (i + 1) % around
    here, following = np.tile(here, around), np.tile(following, around)
    a, b, c, d = i * k + here, after * k + here, after * k + following, i * k + following
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def normals_and_areas(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Outward unit normals (m, 3) and areas (m,) [m2] of triangles (m, 3, 3) [m]."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(cross, axis=1)
    return cross / size[:, None], 0.5 * size


def area_of(corners: np.ndarray) -> float:
    """Area of triangles (m, 3, 3) together [m2]."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(0.5 * np.linalg.norm(cross, axis=1).sum())
