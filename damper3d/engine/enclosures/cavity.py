"""A cavity of any shape between triangles, which need not be convex.

A sphere touches it where the distance from its centre, along the surface, has a minimum that is
less than its radius: at the foot of the perpendicular on a face, on an edge at which the void bends
round the solid, or at a corner. So in a concave edge it has two contacts, with the two faces; on a
convex one it has one; and over a seam between triangles of one plane the foot goes from one to the
next. See damper3d.engine.enclosures.places for what is counted as one place.

Each of these features (faces, then convex edges, then their corners) is a few half-spaces, in which
the centre must lie for the minimum to be there:

    face      within its three sides
    edge      between its two ends, and beyond it as seen from either of its faces
    corner    beyond it as seen from each of its edges
"""

from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from damper3d.engine.enclosures.polyhedron import Flat

# [rad] Faces that turn by less are one plane: STL has single numbers, whose rounding (6e-8 of the
# size) turns a triangle whose height is a hundredth of it by some 1e-5.
FLAT = 3e-5
PLACES = 16  # at which one sphere may touch the cavity at once and keep its springs
_REACH = 1.25  # over the radius: farther features are not looked for


class Triangles(NamedTuple):
    """Features of a triangulated wall, and cells that name those near by; see the module."""

    n_faces: int
    n_edges: int
    origin: np.ndarray  # (n, 3) a point of the feature [m]
    along: np.ndarray  # (n, 3) inward normal of a face, direction of an edge, nothing of a corner
    first: np.ndarray  # (n + 1,) where its half-spaces begin
    half: np.ndarray  # (h, 4) m, c: the centre x has m . x >= c; sides or ends come first [m]
    slack: float  # by which the foot may leave a face [m]
    reach: float  # features farther from a point may be missing in its cell [m]
    cell: float  # size of a cell [m]
    low: np.ndarray  # (3,) corner of the cells [m]
    shape: np.ndarray  # (3,) int64 cells each way
    start: np.ndarray  # (n_cells + 1,) int64
    member: np.ndarray  # (start[-1],) int32 features of the cells
    held: np.ndarray  # (m, PLACES) int32 features that histories are kept of, sphere by sphere; -1
    number: np.ndarray  # (PLACES,) int64 listed contacts that act, while they are found
    distance: np.ndarray  # (PLACES,) [m] of these
    normal: np.ndarray  # (PLACES, 3) of these


@dataclass(frozen=True, eq=False)
class Cavity(Flat):
    """A closed cavity between triangles that face outwards, (n, 3) [m] and rows of it (m, 3).

    It is moved so that the box around it stands about the axis, with its lowest point at z = 0.
    """

    shape = "cavity"
    file: str = field(metadata={"unit": "text"})
    unit: str = field(metadata={"unit": "text"})
    points: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)), metadata={"unit": "made"})
    triangles: np.ndarray = field(
        default_factory=lambda: np.zeros((0, 3), np.int64), metadata={"unit": "made"}
    )

    def __post_init__(self) -> None:
        """Move it to its place."""
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        shift = np.array([*(-0.5 * (low + high))[:2], -low[2]])
        object.__setattr__(self, "points", self.points + shift)

    @classmethod
    def units(cls) -> dict[str, str]:
        """Return the keys of [enclosure] that it takes; both are texts."""
        return {"file": "text", "unit": "text"}

    @property
    def planes(self) -> np.ndarray:
        """No flat walls, (0, 4): all is one wall."""
        return np.zeros((0, 4))

    @property
    def wall_names(self) -> list[str]:
        """The one wall."""
        return ["cavity"]

    @property
    def keys(self) -> dict[str, object]:
        """As a case in a run folder has it."""
        return {"file": "enclosure-cavity.obj", "unit": "m"}  # see damper3d.case.parts.cavity_copy

    @property
    def identity(self) -> list[Any]:
        """Shape and triangles, by which a packing is named."""
        return [self.shape, self.points, self.triangles]

    @property
    def words(self) -> str:
        """Its triangles and the box around it, in words."""
        return (
            f"cavity of {len(self.triangles)} triangles, within {self.width:g} m (x) by "
            f"{self.depth:g} m (y), {self.height:g} m high"
        )

    @cached_property
    def _polygons(self) -> list[tuple[str, np.ndarray]]:
        return [("cavity", corners) for corners in self.points[self.triangles]]

    @property
    def polygons(self) -> list[tuple[str, np.ndarray]]:
        """Its triangles; see Enclosure.polygons."""
        return self._polygons

    @cached_property
    def corners(self) -> np.ndarray:
        """All corners of the triangles (n, 3) [m], each once."""
        return self.points

    @cached_property
    def _features(self) -> tuple[np.ndarray, ...]:
        return features(self.points, self.triangles)

    @property
    def surface(self) -> Triangles:
        """The features for spheres that are small against it."""
        return self.surface_for(0.05 * max(self.width, self.depth, self.height))

    def surface_for(self, radius: float) -> Triangles:
        """Numbers of the wall, for spheres of a radius up to this [m]."""
        return in_cells(self, _REACH * radius)

    def through(self, along: np.ndarray) -> tuple[float, float]:
        """Extent from its widest place, against and with the unit vector `along` [m].

        To the nearest triangle either way.
        """
        start = self.middle
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        across = np.cross(b - a, c - a)
        rate = across @ along
        with np.errstate(divide="ignore", invalid="ignore"):
            way = np.einsum("mx,mx->m", a - start, across) / rate
            foot = start + way[:, None] * along
            sides = [np.cross(q - p, foot - p) for p, q in ((a, b), (b, c), (c, a))]
            hit = np.all([np.einsum("mx,mx->m", s, across) >= 0.0 for s in sides], axis=0)
        hit &= rate != 0.0
        ends = way[hit]
        return float(ends[ends < 0.0].max()), float(ends[ends > 0.0].min())

    @cached_property
    def _narrowest(self) -> tuple[float, np.ndarray]:
        """Largest clearance of points of a grid in it [m], and the point (3,)."""
        sizes = np.array([self.width, self.depth, self.height])
        step = float(np.cbrt(sizes.prod() / _LOOKS))
        axes = [np.arange(0.5 * step, size, step) for size in sizes]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        points -= (0.5 * sizes[0], 0.5 * sizes[1], 0.0)
        away = self.clearance(points)
        best = int(np.argmax(away))
        for _ in range(20):  # closer and closer about the best
            step *= 0.7
            near = points[best] + step * np.stack(
                np.meshgrid(*[(-0.5, 0.0, 0.5)] * 3, indexing="ij"), axis=-1
            ).reshape(-1, 3)
            found = self.clearance(near)
            points, away, best = near, found, int(np.argmax(found))
        return float(away[best]), points[best]

    @property
    def middle(self) -> np.ndarray:
        """The place (3,) that is farthest from the triangles [m]."""
        return self._narrowest[1]

    @property
    def narrowest(self) -> float:
        """Diameter of the largest sphere that fits in [m], found on a grid."""
        return 2.0 * self._narrowest[0]

    @property
    def narrowest_place(self) -> str:
        """Place of the centre of that sphere, in words."""
        x, y, z = 1e3 * self._narrowest[1]
        return f"for a sphere near ({x:.3g}, {y:.3g}, {z:.3g}) mm, where it is widest"

    def clearance(self, points: np.ndarray) -> np.ndarray:
        """Distance (n,) [m] of points (n, 3) from the triangles; -inf where they are outside."""
        from damper3d.engine.enclosures.places import clearances

        corners = self.points[self.triangles]
        return clearances(corners, np.asarray(points, float))


_LOOKS = 4000  # points at which the widest place of a cavity is looked for first


def nearest_triangle(surface, wall, x, y, z):
    """Distance of a point in the void from the triangles, and what belongs to it; at most `reach`.

    See damper3d.engine.enclosures.register for what the geometry of a curved wall returns.
    """
    least = surface.reach
    nx, ny, nz = 0.0, 0.0, 1.0
    i = min(max(int((x - surface.low[0]) / surface.cell), 0), surface.shape[0] - 1)
    j = min(max(int((y - surface.low[1]) / surface.cell), 0), surface.shape[1] - 1)
    k = min(max(int((z - surface.low[2]) / surface.cell), 0), surface.shape[2] - 1)
    cell = (i * surface.shape[1] + j) * surface.shape[2] + k
    for m in range(surface.start[cell], surface.start[cell + 1]):
        f = surface.member[m]
        inside = True
        for h in range(surface.first[f], surface.first[f + 1]):
            row = surface.half[h]
            inside = inside and row[0] * x + row[1] * y + row[2] * z - row[3] >= -surface.slack
        if not inside:
            continue
        ax, ay, az = surface.origin[f, 0] - x, surface.origin[f, 1] - y, surface.origin[f, 2] - z
        tx, ty, tz = surface.along[f, 0], surface.along[f, 1], surface.along[f, 2]
        part = ax * tx + ay * ty + az * tz
        if f < surface.n_faces:
            if 0.0 <= -part < least:
                least = -part
                nx, ny, nz = -tx, -ty, -tz
            continue
        ax, ay, az = ax - part * tx, ay - part * ty, az - part * tz
        distance = np.sqrt(ax * ax + ay * ay + az * az)
        if distance < least:
            least = distance
            far = max(distance, 1e-300)
            nx, ny, nz = ax / far, ay / far, az / far
    return least, (nx, ny, nz), np.inf


@lru_cache(maxsize=8)
def in_cells(cavity: Cavity, reach: float) -> Triangles:
    """The features of a cavity in cells of half a reach [m], each with all that is as near."""
    n_faces, n_edges, origin, along, first, half, low, high = cavity._features
    size = 0.5 * reach
    corner = cavity.points.min(axis=0)
    shape = np.maximum(np.ceil(np.ptp(cavity.points, axis=0) / size).astype(np.int64), 1)
    begin = np.clip(((low - reach - corner) // size).astype(np.int64), 0, shape - 1)
    end = np.clip(((high + reach - corner) // size).astype(np.int64), 0, shape - 1) + 1
    across = end - begin
    count = across.prod(axis=1)
    feature = np.repeat(np.arange(len(count)), count)
    local = np.arange(len(feature)) - np.repeat(np.cumsum(count) - count, count)
    i, rest = np.divmod(local, (across[:, 1] * across[:, 2])[feature])
    j, k = np.divmod(rest, across[feature, 2])
    i, j, k = i + begin[feature, 0], j + begin[feature, 1], k + begin[feature, 2]
    cell = (i * shape[1] + j) * shape[2] + k
    order = np.argsort(cell, kind="stable")
    start = np.searchsorted(cell[order], np.arange(shape.prod() + 1))
    return Triangles(
        n_faces=n_faces, n_edges=n_edges, origin=origin, along=along, first=first, half=half,
        slack=FLAT * reach, reach=reach, cell=size, low=corner, shape=shape,
        start=start.astype(np.int64), member=feature[order].astype(np.int32),
        held=np.full((0, PLACES), -1, np.int32), number=np.zeros(PLACES, np.int64),
        distance=np.zeros(PLACES), normal=np.zeros((PLACES, 3)),
    )  # fmt: skip


def features(points: np.ndarray, triangles: np.ndarray) -> tuple[Any, ...]:
    """Features of closed triangles: numbers of faces and edges; origin, along, first and half, see
    Triangles; and the box around each (n, 3) and (n, 3) [m].
    """
    corners = points[triangles]
    sides = np.roll(corners, -1, axis=1) - corners  # (m, 3, 3)
    across = np.cross(sides[:, 0], sides[:, 1])
    inward = -across / np.linalg.norm(across, axis=1)[:, None]
    into = np.cross(sides, inward[:, None])  # from each side into its face
    into /= np.linalg.norm(into, axis=2)[:, :, None]
    origin, along = [corners[:, 0]], [inward]
    halves = [_row(into, corners).reshape(len(triangles), 3, 4)]
    first, second, one, two = _edges(triangles)
    # Convex as seen from the solid: the second face leaves the plane of the first away from the
    # void.
    away = np.einsum("ex,ex->e", inward[one[:, 0]], into[two[:, 0], two[:, 1]])
    convex = away < -FLAT
    first, second, one, two = first[convex], second[convex], one[convex], two[convex]
    start, end = points[first], points[second]
    length = np.linalg.norm(end - start, axis=1)
    line = (end - start) / length[:, None]
    rows = [line, -line, -into[one[:, 0], one[:, 1]], -into[two[:, 0], two[:, 1]]]
    at = [start, end, start, start]
    halves.append(np.stack([_row(r, a) for r, a in zip(rows, at, strict=True)], axis=1))
    origin.append(start)
    along.append(line)
    tips, beyond = _tips(points, triangles, np.concatenate([first, second]))
    origin.append(points[tips])
    along.append(np.zeros((len(tips), 3)))
    low = [corners.min(axis=1), np.minimum(start, end), points[tips]]
    high = [corners.max(axis=1), np.maximum(start, end), points[tips]]
    counts = [np.full(len(triangles), 3), np.full(len(first), 4), [len(b) for b in beyond]]
    return (
        len(triangles), len(first), np.concatenate(origin), np.concatenate(along),
        np.concatenate([[0], np.cumsum(np.concatenate(counts))]).astype(np.int64),
        np.concatenate([*(h.reshape(-1, 4) for h in halves), *beyond]),
        np.concatenate(low), np.concatenate(high),
    )  # fmt: skip


def _row(normal: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Half-spaces (..., 4) of normals and points (..., 3)."""
    return np.concatenate([normal, (normal * point).sum(axis=-1, keepdims=True)], axis=-1)


def _edges(triangles: np.ndarray) -> tuple[np.ndarray, ...]:
    """Ends (e,) and (e,) of each edge; its two faces, each with the number of its side (e, 2)."""
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    ordered = np.sort(ends, axis=1)
    order = np.lexsort((ordered[:, 1], ordered[:, 0]))
    one, two = order[0::2], order[1::2]  # closed: each edge stands there twice
    sides = [np.stack(np.divmod(which, 3), axis=1) for which in (one, two)]
    return ordered[one, 0], ordered[one, 1], *sides


def _tips(
    points: np.ndarray, triangles: np.ndarray, ends: np.ndarray
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Corners (t,) at which convex edges end; half-spaces (k, 4) beyond all edges of each."""
    tips = np.unique(ends)
    pairs = np.unique(
        np.concatenate([triangles[:, [a, b]] for a in range(3) for b in range(3) if a != b]), axis=0
    )
    begin = np.searchsorted(pairs[:, 0], tips)
    end = np.searchsorted(pairs[:, 0], tips, side="right")
    beyond = []
    for tip, a, b in zip(tips, begin, end, strict=True):
        way = points[tip] - points[pairs[a:b, 1]]
        way /= np.linalg.norm(way, axis=1)[:, None]
        beyond.append(_row(way, np.broadcast_to(points[tip], way.shape)))
    return tips, beyond
