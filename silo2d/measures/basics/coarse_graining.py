"""Coarse graining with a Gaussian: sums over points become fields that keep their integrals.

    field(r) = sum_k weight_k phi(r - r_k),   phi(r) = exp(-r^2/(2 w^2)) / (2 pi w^2)

(Goldhirsch 2010, Granular Matter 12, 239). A Gaussian of the plane is the product of two on the
line, so a field on a grid is a product of two matrices, linear in the points; it is cut off where
it is below rounding.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from granulab.campaign.output.figure import WALL
from silo2d.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

_MARGIN = 6  # widths round what is deposited: beyond lies 1e-9 of a kernel
_REACH = 12  # widths: 5e-32 of a kernel's peak; products of less are denormal, and slow
_ROWS = 8  # rows of the silo a width, for the part of a kernel that is inside
_ON_BRANCH = 6  # points on a branch vector; their error is 1e-8 for a branch of two widths


@dataclass(frozen=True, eq=False)
class Grid:
    """Points x (i,), y (j,) [m] at even distances; fields on it are (..., j, i).

    width    w of the Gaussian [m]
    """

    x: Floats
    y: Floats
    width: float

    @property
    def cell(self) -> float:
        """Area that belongs to one point [m2]."""
        return float((self.x[1] - self.x[0]) * (self.y[1] - self.y[0]))

    def integral(self, field: Floats) -> Floats:
        """Over the plane (...), up to rounding where the grid reaches six widths beyond."""
        return self.cell * field.sum(axis=(-2, -1))

    def deposit(self, points: Floats, weights: Floats) -> Floats:
        """Field of points (n, 2) [m] with weights (n, ...): (..., j, i), weight per m2."""
        along_x = _gauss(self.x[:, None] - points[:, 0], self.width)
        along_y = _gauss(self.y[:, None] - points[:, 1], self.width)
        flat = weights.reshape(len(points), int(np.prod(weights.shape[1:])))
        weighted = flat.T[:, None] * along_y
        weighted = weighted.reshape(len(flat.T) * len(self.y), len(points))  # also of no points
        return (weighted @ along_x.T).reshape(*weights.shape[1:], len(self.y), len(self.x))


def grid_round(low: Floats, high: Floats, width: float, margin: float = _MARGIN) -> Grid:
    """A grid of half a width over a rectangle (x, y) and `margin` widths round it."""
    x, y = (
        np.arange(low[k] - margin * width, high[k] + (margin + 0.5) * width, width / 2)
        for k in (0, 1)
    )
    return Grid(x, y, width)


def along_branches(start: Floats, end: Floats) -> tuple[Floats, Floats]:
    """Points on branch vectors (n, 2) and the weight of each for a line integral over s in [0, 1].

    Gauss's quadrature: points (n k, 2) and weights (n k, 1), which sum to 1 for every branch, so
    that integrals over the plane are kept exactly.
    """
    nodes, weights = leggauss(_ON_BRANCH)
    s, weights = (nodes + 1) / 2, weights / 2
    points = start[:, None] + s[:, None] * (end - start)[:, None]
    return points.reshape(-1, 2), np.tile(weights, len(start))[:, None]


def part_inside(grid: Grid, edges: Floats) -> Floats:
    """The part (j, i) of the kernel at each point of a grid that lies in the silo.

    edges: of the silo's inside (e, 2, 2) [m]; it goes on upwards beyond its open top.
    Exact along x; the rows along y are an eighth of a width.
    """
    from scipy.special import ndtr

    width, step = grid.width, grid.width / _ROWS
    bottom, rim = edges[..., 1].min(), edges[..., 1].max()
    top = max(rim, grid.y[-1] + _MARGIN * width)
    rows = bottom + step * (np.arange(int((top - bottom) / step)) + 0.5)
    highest = rim - step * 1e-3  # above, the silo is as wide as at its top
    in_row = np.zeros((len(rows), len(grid.x)))
    for k, row in enumerate(rows):
        for left, right in intervals_at(edges, min(row, highest)):
            in_row[k] += ndtr((right - grid.x) / width) - ndtr((left - grid.x) / width)
    return step * _gauss(grid.y[:, None] - rows, width) @ in_row


def intervals_at(edges: Floats, y: float) -> Floats:
    """Left and right ends (k, 2) of a horizontal line at y inside closed lines of edges (e, 2, 2).

    What is in two of them, as an insert in a silo, is outside.
    """
    start, end = edges[:, 0], edges[:, 1]
    crosses = (start[:, 1] <= y) != (end[:, 1] <= y)
    a, b = start[crosses], end[crosses]
    return np.sort(a[:, 0] + (y - a[:, 1]) * (b - a)[:, 0] / (b - a)[:, 1]).reshape(-1, 2)


def _gauss(distance: Floats, width: float) -> Floats:
    """Gaussian on a line: integral 1; 0 beyond _REACH widths."""
    scaled = distance / width
    density = np.exp(-0.5 * scaled**2) / (np.sqrt(2 * np.pi) * width)
    return np.where(np.abs(scaled) < _REACH, density, 0.0)


def inside_polygon(scene: Scene) -> Floats:
    """Corners (n, 2) [m] of the silo: wall by wall, the outlets and the top closed."""
    points = scene.walls[~scene.of_insert].reshape(-1, 2)
    return points[np.r_[True, np.any(points[1:] != points[:-1], axis=1)]]


def inside_edges(scene: Scene) -> Floats:
    """Edges (e, 2, 2) [m] of the silo's inside, the sides of its inserts among them."""
    return np.concatenate([closed(inside_polygon(scene)), scene.walls[scene.of_insert]])


def closed(corners: Floats) -> Floats:
    """Edges (n, 2, 2) from each corner (n, 2) to the next, and from the last to the first."""
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def inside_mask(edges: Floats, grid: Grid) -> NDArray[np.bool_]:
    """Mask (j, i) of the points of a grid that are in closed lines of edges (e, 2, 2)."""
    mask = np.zeros((len(grid.y), len(grid.x)), dtype=bool)
    for j, y in enumerate(grid.y):
        for left, right in intervals_at(edges, float(y)):
            mask[j] |= (grid.x >= left) & (grid.x <= right)
    return mask


def draw_map(
    axes: "Axes", scene: Scene, grid: Grid, field: Floats, label: str, **colours: Any
) -> None:
    """A field (j, i), clipped at the silo's inside, with its colour bar and the walls.

    Where the field is NaN nothing is drawn.
    """
    from matplotlib.patches import Polygon

    half = (grid.x[1] - grid.x[0]) / 2  # a point is the middle of its cell
    extent = grid.x[0] - half, grid.x[-1] + half, grid.y[0] - half, grid.y[-1] + half
    image = axes.imshow(
        np.ma.masked_invalid(field),
        origin="lower", extent=extent, interpolation="bilinear", **colours,
    )  # fmt: skip
    image.set_clip_path(Polygon(inside_polygon(scene), transform=axes.transData))
    assert axes.figure is not None
    axes.figure.colorbar(image, ax=axes, label=label, shrink=0.75)
    for wall in scene.walls:
        axes.plot(*wall.T, color=WALL, lw=2)
    left, right, _, top = scene.window
    axes.set(xlim=(left - 5e-3, right + 5e-3), ylim=(-5e-3, top), aspect="equal")
    axes.set(xlabel="x [m]", ylabel="height over the outlet [m]")
