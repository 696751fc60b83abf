"""Particle cross sections: an outline with rounded corners, and its mass integrals."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granulab.errors import InputError

Points = NDArray[np.float64]

# Corners closer than this part of the polygon's extent are one corner; corners nearer than
# it to the line through their neighbours are none. Well above rounding, well below a saw cut.
COINCIDENT = 1e-6
_AROUND_A_DISC = 96  # points of its outline: the polygon is 0.07 % smaller


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A spheropolygon: a convex core swept by a disc.

    name            as in the shape file
    core            corners of the core (n, 2) [m], counter-clockwise, relative to the centroid
                    of the rounded shape; (1, 2), its centre, for a disc
    spheroradius    radius of the disc [m]
    area            of the rounded shape [m2]
    polar_moment    second moment of that area about its centroid [m4]
    """

    name: str
    core: Points
    spheroradius: float
    area: float
    polar_moment: float

    @property
    def is_disc(self) -> bool:
        """True for a disc, whose core is a point."""
        return len(self.core) == 1

    @property
    def bounding_radius(self) -> float:
        """Radius [m] of the circle about the centroid that holds the rounded shape."""
        return float(np.hypot(*self.core.T).max()) + self.spheroradius

    @property
    def width(self) -> float:
        """The smallest distance of two parallel lines that hold the shape between them [m]."""
        if self.is_disc:
            return 2 * self.spheroradius
        _, _, normals = _edges(self.core)
        heights = np.ptp(self.core @ normals.T, axis=0)
        return float(heights.min()) + 2 * self.spheroradius

    def rounded_outline(self, points_per_corner: int = 5) -> Points:
        """Points (n * points_per_corner, 2) [m] on the rounded outline, for drawing.

        Each corner is an arc between the normals of its edges, both ends included (so give
        at least 2 points); the straight edges lie between one arc and the next.
        """
        if self.is_disc:
            around = np.linspace(0.0, 2 * math.pi, _AROUND_A_DISC, endpoint=False)
            return self.spheroradius * np.stack([np.cos(around), np.sin(around)], axis=-1)
        _, _, normal = _edges(self.core)
        before = np.roll(normal, 1, axis=0)
        start = np.arctan2(before[:, 1], before[:, 0])
        angle = start[:, None] + np.outer(
            corner_angles(self.core), np.linspace(0.0, 1.0, points_per_corner)
        )
        arc = self.spheroradius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return (self.core[:, None, :] + arc).reshape(-1, 2)


@dataclass(frozen=True, slots=True)
class ShapeSet:
    """Shapes and how often each occurs.

    shares    relative frequencies [-], normalised to sum 1; empty means equal
    parts     of a mixture, the [[shape]] that each belongs to; sizes of one are several shapes
    """

    name: str
    shapes: tuple[Shape, ...]
    shares: tuple[float, ...] = ()
    parts: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.parts:
            object.__setattr__(self, "parts", tuple(shape.name for shape in self.shapes))
        given = self.shares or (1.0,) * len(self.shapes)
        total = math.fsum(given)
        object.__setattr__(self, "shares", tuple(share / total for share in given))

    @property
    def mean_area(self) -> float:
        """Mean area of the rounded shapes [m2], weighted by their shares."""
        return math.fsum(
            share * shape.area for share, shape in zip(self.shares, self.shapes, strict=True)
        )

    @property
    def bounding_radius(self) -> float:
        """The largest bounding radius [m]."""
        return max(shape.bounding_radius for shape in self.shapes)


def mass_integrals(core: Points, spheroradius: float) -> tuple[float, Points, float]:
    """Area [m2], centroid (2,) [m] and polar moment about it [m4] of a rounded polygon.

    A convex core (n, 2) [m], counter-clockwise, swept by a disc of radius r is cut into pieces
    that do not overlap:

        triangle of the core's fan, sides a, b, c     area A    moment A (a^2 + b^2 + c^2)/36
        rectangle on an edge of length l              area l r  moment l r (l^2 + r^2)/12
        sector at a corner where the outline bends    area theta r^2/2
        by theta, centroid at d = 4 r sin(theta/2)/(3 theta) from the corner, on the bisector,
                                                      moment theta r^4/4 - theta r^2 d^2/2

    each moment about the piece's own centroid; the parallel-axis theorem adds them up. The
    sectors make one disc, so that the area is A_core + perimeter r + pi r^2 (Steiner).
    """
    r = spheroradius
    apex = core.mean(axis=0)
    edge, length, normal = _edges(core)
    angle = corner_angles(core)
    to_start = core - apex
    to_end = to_start + edge

    triangle = _cross(to_start, to_end) / 2
    sides = (to_start**2 + to_end**2 + edge**2).sum(axis=1)
    bisector = (normal + np.roll(normal, 1, axis=0)) / (2 * np.cos(angle / 2))[:, None]
    distance = 4 * r * np.sin(angle / 2) / (3 * angle)
    sector = angle * r**2 / 2

    area = np.concatenate([triangle, length * r, sector])
    centre = np.concatenate(
        [
            (to_start + to_end) / 3,
            to_start + edge / 2 + normal * r / 2,
            to_start + bisector * distance[:, None],
        ]
    )
    moment = np.concatenate(
        [
            triangle * sides / 36,
            length * r * (length**2 + r**2) / 12,
            angle * r**4 / 4 - sector * distance**2,
        ]
    )
    centroid = area @ centre / area.sum()
    polar = moment.sum() + area @ ((centre - centroid) ** 2).sum(axis=1)
    return float(area.sum()), apex + centroid, float(polar)


def disc(name: str, diameter: float) -> Shape:
    """A disc of a diameter [m]: the spheropolygon whose core is its centre."""
    radius = diameter / 2
    core = np.zeros((1, 2))
    core.setflags(write=False)
    return Shape(name, core, radius, math.pi * radius**2, math.pi * radius**4 / 2)


def regular_outline(corners: int, side: float) -> Points:
    """Outline (corners, 2) [m] of a regular polygon with sides of a length [m], one side down."""
    angle = math.pi * (2 * np.arange(corners) - 1) / corners - math.pi / 2
    radius = side / (2 * math.sin(math.pi / corners))
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def shape_from_outline(name: str, outline: ArrayLike, spheroradius: float, field: str) -> Shape:
    """The spheropolygon whose straight faces lie on an outer outline (n, 2) [m].

    The core is the outline shrunk by the spheroradius [m], so the rounded shape fills the
    outline but for its corners. Only convex outlines are taken: vertex-edge forces would hold
    for concave ones, but the mass integrals and the contact search do not, and cutting an
    outline into convex parts is not offered.

    Raises InputError, "FIELD: [shape NAME] ...", for an outline that is not a simple, convex,
    counter-clockwise polygon, or a spheroradius that is not positive or would swallow an edge.
    """
    where = f"{field}: [shape {name}]"
    corners = simple_polygon(outline, f"{where} outline")
    concave = np.flatnonzero(corner_angles(corners) <= 0)
    if concave.size:
        raise InputError(
            f"{where} outline: concave at {_mm(corners[concave[0]])}; "
            "only convex outlines are simulated"
        )
    core = _shrunk(corners, spheroradius, f"{where} spheroradius")
    area, centroid, polar = mass_integrals(core, spheroradius)
    core -= centroid
    core.setflags(write=False)
    return Shape(name, core, spheroradius, area, polar)


def _shrunk(corners: Points, r: float, field: str) -> Points:
    """A convex polygon with every edge moved inwards by r; refused where an edge would vanish."""
    if not 0 < r < math.inf:
        raise InputError(f"{field} = {1e3 * r:g} mm: must be positive, such as '1 mm'")
    _, length, normal = _edges(corners)
    lost = np.tan(corner_angles(corners) / 2)  # what each corner takes of both its edges, per r
    largest = (length / (lost + np.roll(lost, -1))).min()
    if r > largest * (1 - COINCIDENT):
        raise InputError(
            f"{field} = {1e3 * r:g} mm: too large, the core would lose an edge; "
            f"less than {1e3 * largest:.4g} mm would do"
        )
    before = np.roll(normal, 1, axis=0)
    return corners - r * (before + normal) / (1 + (before * normal).sum(axis=1))[:, None]


def vertex_list(value: object, field: str) -> Points:
    """A list of [x, y] pairs as an array (n, 2); InputError for anything else."""
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        array = np.empty(0)
    if array.ndim != 2 or array.shape[1] != 2 or array.dtype.kind not in "iuf":
        raise InputError(f"{field}: expected a list of points, such as [[0, 0], [15, 0], [15, 15]]")
    if not np.isfinite(array).all():
        bad = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise InputError(f"{field}: point {bad + 1} is not finite; give two numbers")
    return array.astype(np.float64)


def simple_polygon(points: ArrayLike, field: str) -> Points:
    """Corners (n, 2) [m] of a simple polygon, counter-clockwise, collinear points merged.

    Raises InputError, "FIELD: ...", for fewer than three points, repeated points, points on one
    line, an outline that crosses or touches itself, and a clockwise one.
    """
    from shapely import MultiPoint, Polygon

    corners = vertex_list(points, field)
    if len(corners) < 3:
        raise InputError(f"{field}: {len(corners)} points; a polygon needs at least 3")
    extent = np.ptp(corners, axis=0).max()
    gap = np.hypot(*(np.roll(corners, -1, axis=0) - corners).T)
    if gap.min() <= COINCIDENT * extent:
        k = int(gap.argmin())
        raise InputError(
            f"{field}: points {k + 1} and {(k + 1) % len(corners) + 1} are the same, "
            f"{_mm(corners[k])}; list each corner once, the outline closes by itself"
        )
    if MultiPoint(corners).convex_hull.area <= COINCIDENT * extent**2:
        raise InputError(f"{field}: zero area, all points lie on one line; give a polygon")
    polygon = Polygon(corners)
    if not polygon.is_valid:
        raise InputError(f"{field}: crosses or touches itself; give the corners in order")
    if not polygon.exterior.is_ccw:
        raise InputError(f"{field}: clockwise; give the vertices counter-clockwise")
    return merge_collinear(corners)


def merge_collinear(corners: Points) -> Points:
    """A simple polygon (n, 2) without the corners that lie between their neighbours on a line."""
    edge = np.roll(corners, -1, axis=0) - corners
    before = np.roll(edge, 1, axis=0)
    # Twice the area of corner and neighbours over their chord: the distance from the chord.
    distance = np.abs(_cross(before, edge)) / np.hypot(*(before + edge).T)
    return corners[distance > COINCIDENT * np.ptp(corners, axis=0).max()]


def corner_angles(corners: Points) -> NDArray[np.float64]:
    """Angle (n,) [rad] by which a counter-clockwise polygon (n, 2) bends left at each corner."""
    edge = np.roll(corners, -1, axis=0) - corners
    before = np.roll(edge, 1, axis=0)
    return np.arctan2(_cross(before, edge), (before * edge).sum(axis=1))


def _edges(corners: Points) -> tuple[Points, NDArray[np.float64], Points]:
    """Vector, length and outward unit normal of the edge that leaves each corner."""
    edge = np.roll(corners, -1, axis=0) - corners
    length = np.hypot(*edge.T)
    return edge, length, np.column_stack([edge[:, 1], -edge[:, 0]]) / length[:, None]


def _cross(a: Points, b: Points) -> NDArray[np.float64]:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _mm(point: Points) -> str:
    return f"({1e3 * point[0]:g}, {1e3 * point[1]:g}) mm"
