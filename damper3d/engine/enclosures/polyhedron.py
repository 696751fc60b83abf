"""Closed convex polyhedra: any, by its corners or its faces, and the regular hexagonal prism."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from damper3d.engine.enclosures.enclosure import Enclosure

_SAME = 1e-9  # of the polyhedron's size: corners and planes nearer than this are one
_FLAT = 1e-9  # inradius over the size, below which there is no void


class Flat(Enclosure):
    """A void between flat faces, whose polygons are known; the faces need not be convex together.

    The corners of a polygon go anticlockwise when seen from outside.
    """

    @property
    def corners(self) -> np.ndarray:
        """All corners of the polygons (n, 3) [m], shared ones several times."""
        return np.concatenate([points for _, points in self.polygons])

    @property
    def width(self) -> float:
        """Size along x [m]."""
        return float(np.ptp(self.corners[:, 0]))

    @property
    def depth(self) -> float:
        """Size along y [m]."""
        return float(np.ptp(self.corners[:, 1]))

    @property
    def height(self) -> float:
        """Size along z [m]."""
        return float(np.ptp(self.corners[:, 2]))

    @property
    def volume(self) -> float:
        """Volume of the void [m3]."""
        return self.volume_below(np.array([0.0, 0.0, 1.0]), math.inf)

    def lowest(self, up: np.ndarray) -> float:
        """Least of up . x in the enclosure [m]; up (3,) is a unit vector."""
        return float((self.corners @ up).min())

    def volume_below(self, up: np.ndarray, level: float) -> float:
        """Volume of the void where up . x < level [m3], by Gauss's theorem.

        A third of the flux of x - o through its surface, with o on the level: there the face that
        closes the part below adds nothing. What is left are the faces, cut at the level.
        """
        level = min(level, float((self.corners @ up).max()))
        origin, flux = level * np.asarray(up, float), 0.0
        for _, points in self.polygons:
            part = _below(points, up, level)
            if len(part) > 2:
                across = np.cross(part[1:-1] - part[0], part[2:] - part[0]).sum(axis=0)
                flux += 0.5 * float((part[0] - origin) @ across)
        return flux / 3.0


def _below(points: np.ndarray, up: np.ndarray, level: float) -> np.ndarray:
    """The part of a convex polygon (p, 3) where up . x < level (Sutherland and Hodgman 1974)."""
    over = points @ up - level
    if (over <= 0.0).all():
        return points
    kept = []
    for a, b, p, q in zip(over, np.roll(over, -1), points, np.roll(points, -1, 0), strict=True):
        if a <= 0.0:
            kept.append(p)
        if (a < 0.0 < b) or (b < 0.0 < a):
            kept.append(p + a / (a - b) * (q - p))
    return np.array(kept)


class Convex(Flat):
    """A convex void between flat faces, each of which is a wall."""

    @property
    def middle(self) -> np.ndarray:
        """The mean of its corners (3,) [m], which is inside."""
        return self.corners.mean(axis=0)

    @property
    def narrowest(self) -> float:
        """Diameter of the largest sphere that fits in [m]."""
        return 2.0 * inscribed(self.planes)[1]

    @property
    def narrowest_place(self) -> str:
        """The faces that hold that sphere, in words."""
        held = inscribed(self.planes)[2]
        return f"between {', '.join(n for n, k in zip(self.wall_names, held, strict=True) if k)}"


@dataclass(frozen=True)
class HexagonalPrism(Convex):
    """A closed regular hexagonal prism, two of whose sides are normal to x; inner sizes [m]."""

    shape = "hexagonal_prism"
    across_flats: float  # distance of opposite sides
    height: float = 0.04

    @property
    def planes(self) -> np.ndarray:
        """Walls (8, 4): inward unit normal and offset [m]; bottom and top first."""
        angle = np.pi / 3.0 * np.arange(6)
        sides = [-np.cos(angle), -np.sin(angle), 0.0 * angle, 0.0 * angle - 0.5 * self.across_flats]
        ends = (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, -1.0, -self.height)
        return np.array([*ends, *np.transpose(sides)])

    @property
    def wall_names(self) -> list[str]:
        """As the rows of `planes`."""
        return ["bottom", "top", *(f"side{k}" for k in range(1, 7))]

    @property
    def polygons(self) -> list[tuple[str, np.ndarray]]:
        """The walls, each one polygon; see Enclosure.polygons."""
        angle = np.pi / 3.0 * (np.arange(6) - 0.5)
        around = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
        low = self.across_flats / math.sqrt(3.0) * around
        high = low + np.array([0.0, 0.0, self.height])
        sides = np.stack([low, np.roll(low, -1, axis=0), np.roll(high, -1, axis=0), high], axis=1)
        return list(zip(self.wall_names, [low[::-1], high, *sides], strict=True))

    @property
    def words(self) -> str:
        """Shape and sizes in words."""
        return f"hexagonal prism, {self.across_flats:g} m across flats, {self.height:g} m high"


@dataclass(frozen=True)
class Polyhedron(Convex):
    """Any closed convex polyhedron, by its corners or by its faces.

    It is moved so that the box around it stands about the axis, with its lowest point at z = 0.
    """

    shape = "polyhedron"
    vertices: tuple[tuple[float, ...], ...] | None = field(default=None)
    faces: tuple[tuple[float, ...], ...] | None = field(default=None)

    @classmethod
    def units(cls) -> dict[str, str]:
        """Return the keys of [enclosure] that it takes: lists, and the unit that they are in."""
        return {"vertices": "list", "faces": "list", "unit": "text"}

    def __post_init__(self) -> None:
        """Refuse, by ValueError, what is no convex polyhedron."""
        if (self.vertices is None) == (self.faces is None):
            raise ValueError("a polyhedron has either vertices or faces; give one of them")
        _ = self._made

    @cached_property
    def _made(self) -> tuple[np.ndarray, list[np.ndarray]]:
        """Planes (n, 4), inward, and the polygon of each, about the axis."""
        if self.vertices is not None:
            planes, points = _hull(np.array(self.vertices, float))
        else:
            assert self.faces is not None
            planes = _inward(np.array(self.faces, float))
            points = _corners(planes)
        low, high = points.min(axis=0), points.max(axis=0)
        shift = np.array([*(-0.5 * (low + high))[:2], -low[2]])
        size, points = float((high - low).max()), points + shift
        planes[:, 3] += planes[:, :3] @ shift
        if self.vertices is not None:  # whose faces have no order of their own: from below upwards
            key = np.round(planes[:, 2], 9), np.round(np.arctan2(-planes[:, 1], -planes[:, 0]), 9)
            planes = planes[np.lexsort((key[1], -key[0]))]
        polygons = [_polygon(plane, points, size) for plane in planes]
        idle = [k for k, polygon in enumerate(polygons, 1) if len(polygon) < 3]
        if idle:
            raise ValueError(
                f"faces: number {idle[0]} does not bound the void, which the others close without "
                "it; take it out, or look at its distance"
            )
        return planes, polygons

    @property
    def identity(self) -> list[object]:
        """Shape and planes, by which a packing is named."""
        return [self.shape, self.planes]

    @property
    def planes(self) -> np.ndarray:
        """Walls (n, 4): inward unit normal and offset [m]."""
        return self._made[0].copy()

    @property
    def wall_names(self) -> list[str]:
        """By the number of the face, as given; of vertices from below upwards."""
        return [f"face{k}" for k in range(1, len(self._made[0]) + 1)]

    @property
    def polygons(self) -> list[tuple[str, np.ndarray]]:
        """The walls, each one polygon; see Enclosure.polygons."""
        return list(zip(self.wall_names, self._made[1], strict=True))

    @property
    def keys(self) -> dict[str, object]:
        """Its corners or faces as lists [m]."""
        given = {"vertices": self.vertices, "faces": self.faces}
        return {
            **{name: [list(row) for row in rows] for name, rows in given.items() if rows},
            "unit": "m",
        }

    @property
    def words(self) -> str:
        """Number of its faces, and the box around it, in words."""
        return (
            f"convex polyhedron of {len(self._made[0])} faces, within {self.width:g} m (x) by "
            f"{self.depth:g} m (y), {self.height:g} m high"
        )


def inscribed(planes: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Centre (3,) and radius [m] of the largest sphere between inward planes (n, 4).

    Third, which planes hold it (n,). A linear program: the radius is at most the distance from
    every plane, and those hold it without which it would be larger. Negative: there is no void;
    infinite: it is open.
    """
    from scipy.optimize import linprog

    size = float(np.abs(planes[:, 3]).max()) or 1.0
    rows = np.column_stack([-planes[:, :3], np.ones(len(planes))])
    bounds = [(None, None)] * 3 + [(None, 1e3)]
    found = linprog([0.0, 0.0, 0.0, -1.0], A_ub=rows, b_ub=-planes[:, 3] / size, bounds=bounds)
    if found.x is None or found.x[3] >= 1e3:
        return np.zeros(3), math.inf, np.zeros(len(planes), bool)
    held = np.abs(found.ineqlin.marginals) > _SAME
    return size * found.x[:3], size * float(found.x[3]), held


def _inward(faces: np.ndarray) -> np.ndarray:
    """Planes (n, 4) from outward normals of any length, and distances from the origin (n, 4)."""
    length = np.linalg.norm(faces[:, :3], axis=1)
    if not (length > 0.0).all():
        k = int(np.flatnonzero(~(length > 0.0))[0]) + 1
        raise ValueError(f"faces: number {k} has no direction; write such as [0, 0, 1, 20]")
    return np.column_stack([-faces[:, :3] / length[:, None], -faces[:, 3]])


def _corners(planes: np.ndarray) -> np.ndarray:
    """Corners (m, 3) of the void between inward planes (n, 4) [m]."""
    from scipy.spatial import HalfspaceIntersection, QhullError

    centre, radius, _ = inscribed(planes)
    size = float(np.abs(planes[:, 3]).max())
    if radius <= _FLAT * size:
        raise ValueError("faces: they leave no void between them; look at normals and distances")
    # It is bounded where no direction leads away from all planes: a positive sum of the normals is
    # zero, and they span the space.
    if math.isinf(radius) or not _closed(planes[:, :3]):
        raise ValueError(
            "faces: they do not close, the void is open; add the faces that are missing"
        )
    try:
        halves = np.column_stack([-planes[:, :3], planes[:, 3]])
        return HalfspaceIntersection(halves, centre).intersections
    except QhullError:
        raise ValueError(
            "faces: the void between them cannot be calculated; look for faces that nearly coincide"
        ) from None


def _closed(normals: np.ndarray) -> bool:
    """True where normals (n, 3) balance with weights of at least one, and span the space."""
    from scipy.optimize import linprog

    if np.linalg.matrix_rank(normals, tol=1e-9) < 3:
        return False
    n = len(normals)
    found = linprog(np.ones(n), A_eq=normals.T, b_eq=np.zeros(3), bounds=[(1.0, None)] * n)
    return found.status == 0


def _hull(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inward planes (n, 4) and the points (m, 3) [m], all of which are corners of their hull."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        raise ValueError(
            "vertices: at least four that do not lie in one plane make a polyhedron"
        ) from None
    size = float(np.ptp(points, axis=0).max())
    planes = np.column_stack([-hull.equations[:, :3], hull.equations[:, 3]])
    different = []
    for plane in planes:
        near = [np.abs(plane - other) < (_SAME, _SAME, _SAME, _SAME * size) for other in different]
        if not any(same.all() for same in near):
            different.append(plane)
    inside = sorted(set(range(len(points))) - set(hull.vertices.tolist()))
    if inside:
        raise ValueError(
            f"vertices: number {inside[0] + 1} is no corner, it lies within the hull of the "
            "others; a void that is not convex goes as shape = 'cavity', from an STL file"
        )
    return np.array(different), points


def _polygon(plane: np.ndarray, points: np.ndarray, size: float) -> np.ndarray:
    """The corners in a plane (p, 3), anticlockwise when seen from outside; none where it idles."""
    here = points[np.abs(points @ plane[:3] - plane[3]) < 1e3 * _SAME * size]
    if len(here) < 3:
        return np.zeros((0, 3))
    outward = -plane[:3]
    first = here - here.mean(axis=0)
    one = first[np.argmax(np.linalg.norm(first, axis=1))]
    two = np.cross(outward, one)
    angle = np.arctan2(first @ two, first @ one)
    ordered = here[np.argsort(angle)]
    apart = np.linalg.norm(ordered - np.roll(ordered, 1, axis=0), axis=1) > 1e3 * _SAME * size
    return ordered[apart]
