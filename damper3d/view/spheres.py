"""Shaded spheres in a picture, seen from far away: what is nearer hides what is behind."""

from granulab.contact.jit import njit  # isort: skip

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damper3d.engine.enclosures import Enclosure
from damper3d.view.scene import Scene, View

Array = NDArray[np.float64]

_AROUND = 0.04  # of the enclosure's size, left free around it
_STEP, _HAIR = 0.02, 1e-6  # of the enclosure's depth
_SMOOTH = 2  # a pixel is the mean of so many squared
_AMBIENT, _GLOSS = 0.42, 0.28
_DIMMED = 0.45  # of the light, at what is farthest; a haze would change the colours' meaning
_LIGHT = (-0.450, 0.600, 0.661)  # where it comes from, of length one: right, up, towards the eye
_HALF = (-0.247, 0.329, 0.911)  # likewise between it and the eye, where a highlight lies


@dataclass(frozen=True)
class Window:
    """Part of the plane that a picture shows: left, right, bottom, top [m], at a scale [px/m]."""

    left: float
    right: float
    bottom: float
    top: float
    scale: float

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width [px]."""
        high, wide = self.top - self.bottom, self.right - self.left
        return max(round(high * self.scale), 1), max(round(wide * self.scale), 1)

    def pixels(self, points: Array) -> Array:
        """Columns and rows (..., 2) [px] of points (..., 2) [m]; rows count downwards."""
        return (points - (self.left, self.top)) * (self.scale, -self.scale)


def draw_spheres(
    centre: Array, radius: Array, colour: Array, window: Window, paper: tuple[float, float, float]
) -> NDArray[np.uint8]:
    """A picture (rows, columns, 3) of spheres on paper, red green blue.

    centre      (n, 3) [m]: right, up, towards the eye
    radius      (n,) [m]
    colour      (n, 3) between 0 and 1

    Each pixel shows the sphere whose surface is nearest there; what is farther is darker.
    """
    rows, columns = window.shape
    scale = window.scale * _SMOOTH
    position = np.empty((len(centre), 3))  # column, row, towards the eye, in small pixels
    position[:, :2] = window.pixels(centre[:, :2]) * _SMOOTH
    position[:, 2] = centre[:, 2] * scale
    behind = centre[:, 2].max(initial=-np.inf) - centre[:, 2]
    light = 1 - _DIMMED * behind / max(behind.max(initial=0.0), 1e-30)
    owner, depth = _nearest(position, radius * scale, rows * _SMOOTH, columns * _SMOOTH)
    picture = np.zeros((rows, columns, 3))
    _shade(owner, depth, position, radius * scale, light, colour, np.array(paper), picture)
    return np.rint(255 / _SMOOTH**2 * picture).astype(np.uint8)


@njit
def _nearest(position, radius, rows, columns):
    """Sphere that each pixel shows (-1: none), and the depth of its surface towards the eye."""
    owner = np.full((rows, columns), -1, dtype=np.int32)
    depth = np.full((rows, columns), -np.inf)
    for k in range(len(position)):
        x, y, z = position[k]
        r = radius[k]
        for row in range(max(int(y - r), 0), min(int(y + r) + 2, rows)):
            for column in range(max(int(x - r), 0), min(int(x + r) + 2, columns)):
                across, upwards = column + 0.5 - x, y - row - 0.5
                over = r * r - across * across - upwards * upwards
                if over > 0.0:
                    surface = z + np.sqrt(over)
                    if surface > depth[row, column]:
                        depth[row, column] = surface
                        owner[row, column] = k
    return owner, depth


@njit
def _shade(owner, depth, position, radius, light, colour, paper, picture):
    """Add up the small pixels of each of the picture's: Lambert's law and a highlight, or paper."""
    for row in range(owner.shape[0]):
        for column in range(owner.shape[1]):
            k = owner[row, column]
            pixel = picture[row // _SMOOTH, column // _SMOOTH]
            if k < 0:
                for part in range(3):
                    pixel[part] += paper[part]
                continue
            a = (column + 0.5 - position[k, 0]) / radius[k]
            b = (position[k, 1] - row - 0.5) / radius[k]
            c = (depth[row, column] - position[k, 2]) / radius[k]
            facing = max(a * _LIGHT[0] + b * _LIGHT[1] + c * _LIGHT[2], 0.0)
            shine = max(a * _HALF[0] + b * _HALF[1] + c * _HALF[2], 0.0)
            for _ in range(5):
                shine *= shine  # its 32nd power
            diffuse = light[k] * (_AMBIENT + (1.0 - _AMBIENT) * facing)
            for part in range(3):
                pixel[part] += min(diffuse * colour[k, part] + light[k] * _GLOSS * shine, 1.0)


def corners(scene: Scene) -> Array:
    """Least and largest right and up (2, 2) [m] of the enclosure in its own frame."""
    width, depth, height = scene.size
    ends = np.array([[-width / 2, -depth / 2, 0.0], [width / 2, depth / 2, height]])
    across = scene.view.project(ends)[:, :2]
    return np.stack([across.min(axis=0), across.max(axis=0)])


def outline(scene: Scene) -> list[Array]:
    """Lines (k, 2) [m] in which the plane of the cut, see cut_open, meets the walls."""
    return section(scene.enclosure, scene.view)


def section(enclosure: Enclosure, view: View) -> list[Array]:
    """Lines (k, 2) [m] in which the middle plane of a view meets the walls.

    Right and up, in the enclosure's own frame; closed ones end where they begin. Where the plane
    meets no void, as between two cells, it is moved away from the eye until it does.
    """
    from shapely import MultiLineString, line_merge, node

    polygons = [view.project(points) for _, points in enclosure.polygons]
    depths = np.concatenate(polygons)[:, 2]
    level, step = view.project(np.array([0.0, 0.0, enclosure.height / 2]))[2], 0.0
    pieces: list[Array] = []
    while not pieces and level - step >= depths.min():
        # Off the corners by a hair, where a line would be met twice or not at all.
        pieces = [
            piece for corners in polygons
            if len(piece := _cut(corners, level - step - _HAIR * np.ptp(depths))) == 2
        ]  # fmt: skip
        step += _STEP * np.ptp(depths)
    merged = line_merge(node(MultiLineString([np.round(piece, 9) for piece in pieces])))
    return [np.array(line.coords) for line in getattr(merged, "geoms", [merged])]


def _cut(points: Array, level: float) -> Array:
    """Right and up of the two points (2, 2) at which a polygon passes a level, or (0, 2)."""
    over = points[:, 2] - level
    after, following = np.roll(over, -1), np.roll(points, -1, axis=0)
    passes = (over < 0.0) != (after < 0.0)
    part = (over[passes] / (over[passes] - after[passes]))[:, None]
    return (points[passes] + part * (following[passes] - points[passes]))[:, :2]


def window(scene: Scene, scale: float) -> Window:
    """Window that holds the enclosure wherever it goes, at a scale [px/m]."""
    low, high = corners(scene)
    moved = scene.view.project(scene.way)
    margin = _AROUND * max(high - low)
    left, bottom = low + moved[:, :2].min(axis=0) - margin
    right, top = high + moved[:, :2].max(axis=0) + margin
    return Window(float(left), float(right), float(bottom), float(top), scale)


def cut_open(scene: Scene, frame: int) -> tuple[Array, NDArray[np.bool_]]:
    """Centres (n, 3) [m] as drawn, in the lab, and which are: the half that is nearer is away."""
    view = scene.view
    inside = view.project(scene.particles(frame).position)
    middle = view.project(np.array([0.0, 0.0, scene.enclosure.height / 2]))[2]
    return inside + view.project(scene.shift(frame)), inside[:, 2] <= middle


def spheres_drawn(scene: Scene, frame: int) -> tuple[Array, Array, NDArray[np.int64]]:
    """The spheres of the particles that are drawn.

    Centres (m, 3) [m] as seen, in the lab, radii (m,) [m], and the particles' numbers (m,).
    """
    centre, kept = cut_open(scene, frame)
    arm, radius, whose = scene.spheres(frame)
    stays = kept[whose]
    return (centre[whose] + scene.view.project(arm))[stays], radius[stays], whose[stays]
