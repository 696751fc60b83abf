"""The displacement profile as a picture: lines of the layers over their grains."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from granulab.campaign.output.figure import BLUE, INK, PAPER, VERMILION, WALL, headline
from silo2d.measures.from_contacts.particles import Series, column_edges
from silo2d.view.scene import WOOD, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINE_COLOURS = BLUE, VERMILION  # of the layers, in turn
_PANEL_WIDTH, _MOST_PANELS = 2.0, 8  # inches; in a row


def profile_sheet(scene: Scene, frames: Sequence[int], lines: Series, depth: Series) -> "Figure":
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
        _grains(panel, scene, frame)
        draw_lines(panel, scene, lines[:, f])
        v = depth[:, f]
        remark = f"\ndeepest V {1e3 * np.nanmax(v):.0f} mm" if np.isfinite(v).any() else "\n "
        panel.set_title(f"{scene.time[frame]:.2f} s{remark}", fontsize=9)
        panel.set(xlim=(left - 0.004, right + 0.004), ylim=(bottom, top), aspect="equal")
    return figure


def _grains(panel: "Axes", scene: Scene, frame: int) -> None:
    from matplotlib.collections import LineCollection, PolyCollection

    layer = scene.trajectory.static["layer"]
    for grains, outlines in scene.outlines(frame):
        colours = [WOOD[tone] for tone in layer[grains] % len(WOOD)]
        panel.add_collection(
            PolyCollection(list(outlines), facecolors=colours, edgecolors="none", alpha=0.45)
        )
    panel.add_collection(
        LineCollection(list(scene.walls), colors=WALL, linewidths=2, capstyle="round")
    )


def draw_lines(panel: "Axes", scene: Scene, lines: Series) -> None:
    """Draw the lines (l, c) [m] of one moment, gaps where a column has no grains."""
    from matplotlib import patheffects

    edges = column_edges(scene)
    x = (edges[:-1] + edges[1:]) / 2
    halo = [patheffects.withStroke(linewidth=2.8, foreground=PAPER)]
    for k, line in enumerate(lines):
        panel.plot(x, line, "o-", color=LINE_COLOURS[k % 2], ms=2, lw=1.3, path_effects=halo)
    (left, y), (right, _) = scene.trajectory.attributes["lips"]
    panel.plot([left, right], [y, y], color=INK, lw=0.7, ls=(0, (3, 3)))
