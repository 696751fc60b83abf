"""Residence time: when particles leave, by the level and the position that they start at.

Residence time is from the opening to the passing of y = 0, of the particles that leave; those that
stay are counted. Particles that a refilling brings later are not: they start at no level. Levels
are the painted layers, positions are columns about two particles wide. The order of leaving against
starting height is Spearman's rank correlation: 1 where the lowest leave first (first in, first out,
if the silo was filled from below), -1 where the highest do.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.output.figure import BLUE, GREY, INK, WALL, headline
from silo2d.measures.basics.particles import Series, column_edges, leavers, start_height
from silo2d.view.scene import Scene, read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = "viridis_r"


def measure(folder: Path) -> dict[str, Any]:
    """Mean and standard deviation [s] by layer and by column, order of leaving, who stays.

    Raises InputError where no particle left.
    """
    scene = read_scene(folder)
    leavers(scene, 1, "a residence time")
    filled = scene.trajectory["inside"][0]
    times = scene.trajectory["out_time"][-1][filled]
    left = times[~np.isnan(times)]
    names, layer = np.unique(scene.trajectory.static["layer"][filled], return_inverse=True)
    edges = column_edges(scene)
    column = np.digitize(scene.trajectory["x"][0][filled], edges[1:-1])
    return {
        "n_out": len(left),
        "n_staying": int(np.isnan(times).sum()),
        "mean_s": float(left.mean()) if len(left) else None,
        "sd_s": float(left.std(ddof=1)) if len(left) > 1 else None,
        "order_by_height": order_of_leaving(start_height(scene)[filled], times),
        "by_layer": [
            {"layer": int(name), **_of(times[layer == k])} for k, name in enumerate(names)
        ],
        "by_column": [
            {"left_m": float(edges[k]), "right_m": float(edges[k + 1]), **_of(times[column == k])}
            for k in range(len(edges) - 1)
        ],
    }


def order_of_leaving(height: Series, times: Series) -> float | None:
    """Spearman's rank correlation of starting heights (n,) and times of leaving (n,), NaN: stays.

    None for fewer than three leavers.
    """
    from scipy.stats import spearmanr

    leaves = ~np.isnan(times)
    if leaves.sum() < 3:
        return None
    return float(spearmanr(height[leaves], times[leaves]).statistic)


def _of(times: Series) -> dict[str, Any]:
    """Number, mean and spread [s] of the leavers of a group, and how many stay."""
    left = times[~np.isnan(times)]
    return {
        "n_out": len(left),
        "n_staying": len(times) - len(left),
        "mean_s": float(left.mean()) if len(left) else None,
        "sd_s": float(left.std(ddof=1)) if len(left) > 1 else None,
    }


def draw(folder: Path) -> "Figure":
    """Particles where they start, coloured by when they leave; means by layer and by column."""
    from matplotlib.figure import Figure

    scene, numbers = read_scene(folder), measure(folder)
    figure = Figure(figsize=(9.2, 5.2), layout="constrained")
    headline(figure, scene.headline)
    grid = figure.add_gridspec(2, 2, width_ratios=[1.25, 1])
    _starting_positions(figure, figure.add_subplot(grid[:, 0]), scene)
    levels, positions = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    _means(levels, [row["layer"] + 1 for row in numbers["by_layer"]], numbers["by_layer"])
    levels.set_xlabel("painted layer, from the bottom")
    middles = [500 * (row["left_m"] + row["right_m"]) for row in numbers["by_column"]]
    _means(positions, middles, numbers["by_column"])
    positions.set_xlabel("starting position across the silo [mm]")
    order = numbers["order_by_height"]
    if order is not None:
        levels.set_title(f"order by height (Spearman): {order:.2f}", loc="left", fontsize=9)
    positions.set_title("bars: one standard deviation", loc="left", fontsize=9)
    return figure


def _starting_positions(figure: "Figure", panel: "Axes", scene: Scene) -> None:
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.colors import Normalize

    times = scene.trajectory["out_time"][-1]
    colour = ScalarMappable(Normalize(0, np.nanmax(times)), colormaps[_COLOURS])
    for particles, outlines in scene.outlines(0):
        fills = colour.to_rgba(times[particles])
        fills[np.isnan(times[particles])] = (0.86, 0.86, 0.86, 1)
        panel.add_collection(
            PolyCollection(list(outlines), facecolors=fills, edgecolors=INK, linewidths=0.3)
        )
    panel.add_collection(LineCollection(list(scene.walls), colors=WALL, linewidths=2))
    left, right, bottom, top = scene.window
    bottom = scene.walls[..., 1].min() - 0.01 * (top - bottom)
    panel.set(xlim=(left - 0.004, right + 0.004), ylim=(bottom, top), aspect="equal")
    panel.set_axis_off()
    staying = int(np.isnan(times).sum())
    panel.set_title(f"at the opening; grey: {staying} stay" if staying else "at the opening",
                    loc="left", fontsize=9)  # fmt: skip
    figure.colorbar(colour, ax=panel, label="leaves after [s]", shrink=0.7, pad=0.02)


def _means(axes: "Axes", x: list, rows: list[dict]) -> None:
    found = [(at, row) for at, row in zip(x, rows, strict=True) if row["mean_s"] is not None]
    axes.errorbar(
        [at for at, _ in found],
        [row["mean_s"] for _, row in found],
        [row["sd_s"] or 0.0 for _, row in found],
        fmt="o-", color=BLUE, ecolor=GREY, ms=4, capsize=2,
    )  # fmt: skip
    axes.set_ylabel("residence time [s]")
    axes.set_ylim(bottom=0)
    axes.grid(axis="y")
