"""A filmed and a simulated discharge on one figure: lines every interval, and both curves."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from calibration.compare import Comparison
from calibration.statistics.quantity import plus_minus
from granulab.campaign.output.figure import BLUE, GREY, INK, VERMILION, WALL, headline, write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PANELS = 5
_PANEL = 1.8  # inches across one


def draw_comparison(found: Comparison, path: Path, name: str) -> Path:
    """Write the figure of a film called `name` as a PNG; its path."""
    return write_figure(path, lambda: _sheet(found, name))


def _sheet(found: Comparison, name: str) -> "Figure":
    from matplotlib.figure import Figure

    both = np.isfinite(found.film) | np.isfinite(found.run)
    shown = np.flatnonzero(both.any(axis=(1, 2)))[:_PANELS]
    _, _, bottom, top = found.scene.window
    tall = _PANEL * (top - bottom) / float(np.ptp(found.edges)) + 0.8
    figure = Figure(figsize=(11, tall + 3.4), layout="constrained")
    grid = figure.add_gridspec(2, 1, height_ratios=[tall, 2.9])
    above = grid[0].subgridspec(1, max(len(shown), 3))
    for k, t in enumerate(shown):
        _lines(figure.add_subplot(above[0, k]), found, int(t), first=k == 0)
    below = grid[1].subgridspec(1, 2)
    _curves(figure.add_subplot(below[0]), found)
    _differences(figure.add_subplot(below[1]), found)
    d = plus_minus(1e3 * found.distance.value, 1e3 * (found.distance.sigma or 0))
    headline(figure, f"{name} beside {found.scene.headline}\nlines {d} mm apart (equal flows: "
             f"{1e3 * found.floor:.2g} mm)")  # fmt: skip
    return figure


def _lines(axes: "Axes", found: Comparison, t: int, first: bool) -> None:
    left = found.scene.window[0]
    for wall in found.scene.walls:
        axes.plot(wall[:, 0] - left, wall[:, 1], color=WALL, lw=1.5)
    x = (found.edges[:-1] + found.edges[1:]) / 2
    for layer in range(found.film.shape[1]):
        axes.plot(x, found.run[t, layer], color=BLUE, lw=1.2)
        axes.errorbar(x, found.film[t, layer], found.sigma[t, layer], fmt="o", ms=2, lw=0.8,
                      color=VERMILION)  # fmt: skip
    axes.set(aspect="equal", xlabel="x [m]")
    axes.set_title(f"{found.times[t]:.3g} s", fontsize=9)
    if first:
        axes.set_ylabel("height above the outlet [m]")
    else:
        axes.tick_params(labelleft=False)


def _curves(axes: "Axes", found: Comparison) -> None:
    curve = found.flow.curve
    axes.plot(curve.time, found.remaining_run, color=BLUE, label="run, by mass")
    axes.plot(curve.time, curve.remaining, color=VERMILION, label="film, by area")
    if curve.sigma is not None:
        low, high = curve.remaining - curve.sigma, curve.remaining + curve.sigma
        axes.fill_between(curve.time, low, high, color=VERMILION, alpha=0.2, lw=0)
    axes.set_xlabel("time since the opening [s]")
    axes.set_ylabel("share that remains in the silo")
    axes.legend()


def _differences(axes: "Axes", found: Comparison) -> None:
    off = 1e3 * (found.film - found.run)
    for t, time in enumerate(found.times):
        known = np.isfinite(off[t])
        spread = np.linspace(-0.2, 0.2, max(int(known.sum()), 1)) * found.flow.interval
        axes.plot(time + spread[: known.sum()], off[t][known], ".", color=INK, ms=2)
    axes.axhline(0, color=GREY, lw=0.8)
    axes.set_xlabel("time since the opening [s]")
    axes.set_ylabel("line of the film less that of the run [mm]")
