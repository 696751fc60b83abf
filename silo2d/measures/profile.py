"""Displacement profile of the painted layers: their lines every 0.25 s, V depth and V width.

The line of layer k at a time t, over columns j about two particles wide (by where particles are at
t):

    y_k(j) = <y(0)>_k + <y(t) - y(0)>_kj

with the mean starting height of all the layer's particles, and the mean displacement of those in
column j that have not left, at least two of them. Heights at the start scatter by 45 mm/sqrt(12)
within a layer; the displacement does not, so the line is smoother than the mean of y(t).

The paper shows such pictures and no numbers (Granular Matter 15 (2013) 811, sec. 4.2.1, Figs. 14
and 15); depth and width are ours:

    depth    mean of the line's outermost columns, left and right, less the column at the outlet
    width    between the two points where the line stands half the depth above that column

A layer whose column at the outlet is empty while others are not is pierced: it has no depth. How
far the particles of a layer have mixed is given by the scatter: the standard deviation of the
displacements about their column's mean (in a column two particles wide it holds some shear as
well).
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.output.figure import BLUE, INK, PAPER, VERMILION, WALL, headline
from silo2d.measures.basics.particles import (
    Series,
    column_edges,
    in_silo,
    numbers,
    outlet_centre,
    start_height,
)
from silo2d.view.scene import WOOD, Scene, read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINE_COLOURS = BLUE, VERMILION  # of the layers, alternating
_PANEL_WIDTH, _MOST_PANELS = 2.0, 8  # inches; in a row
INTERVAL = 0.25  # s, as in the paper's figures
_FEWEST = 2  # particles that make a mean
_SHALLOW = 0.5  # particle sizes: a V less deep has no width


def measure(folder: Path, interval: float = INTERVAL) -> dict[str, Any]:
    """Lines [m], V depth and V width [m] of each layer at multiples of `interval` [s]."""
    scene = read_scene(folder)
    frames = profile_frames(scene.time, interval)
    lines, counts, scatter = layer_lines(scene, frames)
    depth, width, pierced = v_shapes(scene, lines)
    names = np.unique(scene.trajectory.static["layer"])
    deepest = np.nanmax(depth) if np.isfinite(depth).any() else None
    edges = column_edges(scene)
    return {
        "interval_s": interval,
        "column_width_m": float(edges[1] - edges[0]),
        "deepest_v_m": None if deepest is None else float(deepest),
        "column_edges_m": edges.tolist(),
        "times_s": scene.time[frames].tolist(),
        "layers": [
            {
                "layer": int(name),
                "lines_m": numbers(lines[k]),
                "grains": counts[k].tolist(),
                "depth_m": numbers(depth[k]),
                "width_m": numbers(width[k]),
                "pierced": pierced[k].tolist(),
                "scatter_m": numbers(scatter[k]),
            }
            for k, name in enumerate(names)
        ],
    }


def profile_frames(time: Series, interval: float = INTERVAL) -> list[int]:
    """Frames nearest to the multiples of `interval` [s] within the run, for frames at `time`."""
    wanted = interval * np.arange(int(time[-1] / interval + 1e-9) + 1)
    return [int(np.abs(time - t).argmin()) for t in wanted]


def layer_lines(scene: Scene, frames: Sequence[int]) -> tuple[Series, np.ndarray, Series]:
    """Lines of the layers (l, f, c) [m], their particles (l, f, c), and their scatter (l, f) [m].

    NaN where a column has too few particles, and where no column of a layer has enough.
    """
    names, layer = np.unique(scene.trajectory.static["layer"], return_inverse=True)
    edges, start = column_edges(scene), start_height(scene)
    inside = in_silo(scene)
    poured = inside[0]  # what waits in a store is of no layer
    level = np.bincount(layer[poured], start[poured], len(names)) / np.maximum(
        np.bincount(layer[poured], minlength=len(names)), 1
    )
    shape = len(names), len(frames), len(edges) - 1
    lines, counts = np.full(shape, np.nan), np.zeros(shape, dtype=np.int64)
    scatter = np.full(shape[:2], np.nan)
    for f, frame in enumerate(frames):
        fallen = start - scene.trajectory["y"][frame]
        column = np.digitize(scene.trajectory["x"][frame], edges[1:-1])
        here = inside[frame] & poured
        n, mean, squares = _cells(layer[here], column[here], fallen[here], (shape[0], shape[2]))
        enough = n >= _FEWEST
        lines[:, f] = np.where(enough, level[:, None] - mean, np.nan)
        counts[:, f] = n
        freedom = np.where(enough, n - 1, 0).sum(axis=1)
        about = np.where(enough, squares, 0.0).sum(axis=1)
        np.sqrt(about / np.maximum(freedom, 1), out=scatter[:, f], where=freedom > 0)
    return lines, counts, scatter


def _cells(
    layer: np.ndarray, column: np.ndarray, value: Series, shape: tuple[int, int]
) -> tuple[np.ndarray, Series, Series]:
    """Number, mean, and sum of squares about the mean of values in cells (l, c)."""
    cell = layer * shape[1] + column
    size = shape[0] * shape[1]
    n = np.bincount(cell, minlength=size)
    mean: Series = np.bincount(cell, value, minlength=size) / np.maximum(n, 1)
    squares = np.bincount(cell, np.square(value - mean[cell]), minlength=size).astype(float)
    return n.reshape(shape), mean.reshape(shape), squares.reshape(shape)


def v_shapes(scene: Scene, lines: Series) -> tuple[Series, Series, np.ndarray]:
    """V depth and V width of lines (l, f, c) [m], and which are pierced, (l, f) each."""
    edges = column_edges(scene)
    middle = int(np.digitize(outlet_centre(scene), edges[1:-1]))
    x = (edges[:-1] + edges[1:]) / 2
    depth, width = np.full(lines.shape[:2], np.nan), np.full(lines.shape[:2], np.nan)
    pierced = np.zeros(lines.shape[:2], dtype=bool)
    for index in np.ndindex(lines.shape[:2]):
        line = lines[index]
        filled = np.flatnonzero(np.isfinite(line))
        pierced[index] = len(filled) > 0 and np.isnan(line[middle])
        if len(filled) == 0 or not filled[0] < middle < filled[-1] or pierced[index]:
            continue
        deep = float(line[filled[[0, -1]]].mean() - line[middle])
        depth[index] = deep
        if deep > _SHALLOW * scene.particle_size:
            at = int(np.searchsorted(filled, middle))
            width[index] = _width_at(x[filled], line[filled], at, deep / 2)
    return depth, width, pierced


def _width_at(x: Series, line: Series, middle: int, above: float) -> float:
    """Between the first points left and right of x[middle] where a line is so far above it.

    Straight between columns; NaN where one side does not reach so high.
    """
    height = line - line[middle] - above
    left, right = slice(middle, None, -1), slice(middle, None)
    return _crossing(x[right], height[right]) - _crossing(x[left], height[left])


def _crossing(x: Series, height: Series) -> float:
    """Position at which heights that begin below zero first reach it, or NaN."""
    over = np.flatnonzero(height >= 0)
    if len(over) == 0:
        return np.nan
    k = over[0]
    part = height[k - 1] / (height[k - 1] - height[k])
    return float(x[k - 1] + part * (x[k] - x[k - 1]))


def draw(folder: Path) -> "Figure":
    """The lines of all layers in the silo, over its particles, every 0.25 s."""
    scene = read_scene(folder)
    frames = profile_frames(scene.time)
    lines, _, _ = layer_lines(scene, frames)
    return profile_figure(scene, frames, lines, v_shapes(scene, lines)[0])


def profile_figure(scene: Scene, frames: Sequence[int], lines: Series, depth: Series) -> "Figure":
    """A panel a frame, with the lines (l, f, c) [m] and the deepest V, for depths (l, f) [m]."""
    from matplotlib.figure import Figure

    left, right, bottom, top = scene.window
    columns = min(len(frames), _MOST_PANELS)
    rows = -(-len(frames) // columns)
    height = _PANEL_WIDTH * (top - bottom) / (right - left) + 0.45
    size = max(columns * (_PANEL_WIDTH + 0.15), 4.5), rows * height + 0.55
    figure = Figure(figsize=size, layout="constrained")
    headline(figure, scene.headline)
    panels = figure.subplots(rows, columns, squeeze=False)
    for panel in panels.flat:
        panel.set_axis_off()
    for f, (frame, panel) in enumerate(zip(frames, panels.flat, strict=False)):
        _particles(panel, scene, frame)
        draw_lines(panel, scene, lines[:, f])
        v = depth[:, f]
        remark = f"\ndeepest V {1e3 * np.nanmax(v):.0f} mm" if np.isfinite(v).any() else "\n "
        panel.set_title(f"{scene.time[frame]:.2f} s{remark}", fontsize=9)
        panel.set(xlim=(left - 0.004, right + 0.004), ylim=(bottom, top), aspect="equal")
    return figure


def _particles(panel: "Axes", scene: Scene, frame: int) -> None:
    from matplotlib.collections import LineCollection, PolyCollection

    layer = scene.trajectory.static["layer"]
    for particles, outlines in scene.outlines(frame):
        colours = [WOOD[tone] for tone in layer[particles] % len(WOOD)]
        panel.add_collection(
            PolyCollection(list(outlines), facecolors=colours, edgecolors="none", alpha=0.45)
        )
    panel.add_collection(
        LineCollection(list(scene.walls), colors=WALL, linewidths=2, capstyle="round")
    )


def draw_lines(panel: "Axes", scene: Scene, lines: Series) -> None:
    """Draw the lines (l, c) [m] of one moment, gaps where a column has no particles."""
    from matplotlib import patheffects

    edges = column_edges(scene)
    x = (edges[:-1] + edges[1:]) / 2
    halo = [patheffects.withStroke(linewidth=2.8, foreground=PAPER)]
    for k, line in enumerate(lines):
        panel.plot(x, line, "o-", color=LINE_COLOURS[k % 2], ms=2, lw=1.3, path_effects=halo)
    (left, y), (right, _) = scene.trajectory.attributes["lips"]
    panel.plot([left, right], [y, y], color=INK, lw=0.7, ls=(0, (3, 3)))
