"""Figures of a fit: posterior, observation and prediction, identifiability."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calibration.inverse.prediction import Panel, panels
from calibration.inverse.result import Fitted
from calibration.inverse.statistics.identify import NARROWER
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    SKY,
    VERMILION,
    headline,
    write_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CELL = 2.6  # inches


def write_figures(found: Fitted) -> list[Path]:
    """posterior.png, prediction.png and identifiability.png in the figures of the fit's folder."""
    folder = found.folder.figures
    made = [write_figure(folder / "posterior.png", lambda: draw_posterior(found))]
    if found.goodness is not None:
        made.append(write_figure(folder / "prediction.png", lambda: draw_prediction(found)))
    made.append(write_figure(folder / "identifiability.png", lambda: draw_identifiability(found)))
    return made


def _label(found: Fitted, k: int) -> str:
    """The name of a parameter on an axis, with its unit; several keys on lines of their own."""
    prior = found.fit.priors[k]
    return "\n".join(prior.keys) + ("" if prior.unit == "1" else f" [{prior.unit}]")


def draw_posterior(found: Fitted) -> "Figure":
    """Each parameter's posterior over its prior, and each pair's, with the points that were run."""
    from matplotlib.figure import Figure

    count = len(found.fit.priors)
    size = max(_CELL * count + 1.0, 4.4)
    figure = Figure(figsize=(size, size), layout="constrained")
    pairs = ", of pairs 68.3 and 95.4 %" if count > 1 else ""
    headline(figure, f"{found.fit.name}: posterior; shaded: 68.3 %{pairs}")
    grid = figure.subplots(count, count, squeeze=False)
    values = found.posterior.values()
    points = np.stack(
        [p.value(found.runs.points[:, k]) for k, p in enumerate(found.fit.priors)], axis=1
    )
    for i in range(count):
        for j in range(count):
            axes = grid[i, j]
            if j > i:
                axes.set_axis_off()
            elif i == j:
                _one(axes, found, k=i, values=values[:, i])
            else:
                _two(axes, found, values[:, [j, i]], points[:, [j, i]], (j, i))
            if i == count - 1:
                axes.set_xlabel(_label(found, j))
            if j == 0 and i > 0:
                axes.set_ylabel(_label(found, i))
            if i < count - 1:
                axes.tick_params(labelbottom=False)
            if j > 0:
                axes.tick_params(labelleft=False)
            axes.locator_params(nbins=4)
    return figure


def _one(axes: "Axes", found: Fitted, k: int, values: np.ndarray) -> None:
    prior = found.fit.priors[k]
    ends = prior.ends
    axes.hist(values, bins=50, density=True, color=BLUE, alpha=0.35, lw=0)
    edges = np.linspace(prior.low, prior.high, 61)
    mass, at = np.diff(prior.share(edges)), prior.value(edges)
    axes.stairs(mass / np.diff(at), at, color=GREY, lw=1.0)
    axes.axvspan(*found.interval[:, k], color=BLUE, alpha=0.15, lw=0)
    axes.axvline(found.mean[k], color=BLUE)
    axes.set_xlim(ends)
    axes.set_yticks([])
    axes.set_title("prior in grey", fontsize=8, color=GREY, loc="left")


def _two(axes: "Axes", found: Fitted, values: np.ndarray, points: np.ndarray,
         which: tuple[int, int]) -> None:  # fmt: skip
    """The smallest areas that hold 68 and 95 % of the samples, and the points."""
    ends = [found.fit.priors[k].ends for k in which]
    held, x, y = np.histogram2d(values[:, 0], values[:, 1], bins=40, range=ends)
    ranked = np.sort(held.ravel())[::-1]
    share = np.cumsum(ranked) / ranked.sum()
    levels = [ranked[np.searchsorted(share, part)] for part in (0.954, 0.683)]
    middles = (x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2
    if levels[0] < levels[1] < ranked[0]:
        axes.contourf(*middles, held.T, levels=[*levels, ranked[0]], colors=[SKY, BLUE],
                      alpha=0.4)  # fmt: skip
    axes.plot(points[:, 0], points[:, 1], ".", color=INK, ms=3)
    axes.set_xlim(ends[0])
    axes.set_ylim(ends[1])


def draw_prediction(found: Fitted) -> "Figure":
    """Observation and prediction of the fitted simulator: 95 % of its trials in the band."""
    from matplotlib.figure import Figure

    drawn = panels(found)
    columns = min(len(drawn), 3)
    rows = -(-len(drawn) // columns)
    figure = Figure(figsize=(4.4 * columns + 0.4, 3.4 * rows + 0.6), layout="constrained")
    headline(figure, f"{found.fit.name}: observed (+- sigma), and predicted by the fit (95 %)")
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, panel in zip(grid, drawn, strict=False):
        _panel(axes, panel)
    for axes in grid[len(drawn) :]:
        axes.set_axis_off()
    return figure


def _panel(axes: "Axes", panel: Panel) -> None:
    colours = (BLUE, VERMILION, GREEN, ORANGE, INK, GREY)
    for k, line in enumerate(panel.lines):
        colour = colours[k % len(colours)]
        shown: dict[str, Any] = {"color": colour, "ms": 4, "lw": 1.0, "capsize": 2}
        axes.errorbar(line.x, line.observed, yerr=line.sigma, fmt="o", **shown)
        if len(line.x) > 1:
            axes.plot(line.x, line.median, color=colour, lw=1.2, label=line.name or None)
            axes.fill_between(line.x, line.low, line.high, color=colour, alpha=0.2, lw=0)
        else:
            off = [[line.median[0] - line.low[0]], [line.high[0] - line.median[0]]]
            position = line.x + panel.aside
            axes.errorbar(position, line.median, yerr=off, fmt="s", mfc="none", label=line.name or
                          None, **shown)  # fmt: skip
    if panel.abscissa:
        axes.set_xlabel(panel.abscissa)
    else:
        axes.set_xticks([0, panel.aside], ["observed", "predicted"])
        axes.set_xlim(-1.0, panel.aside + 1.0)
    axes.set_ylabel(panel.ordinate)
    axes.set_title(panel.title, fontsize=9, loc="left")
    if any(line.name for line in panel.lines) and len(panel.lines) <= len(colours):
        axes.legend(fontsize=7)


def draw_identifiability(found: Fitted) -> "Figure":
    """Widths; of several parameters, correlations and directions of the Fisher information, too."""
    from matplotlib.figure import Figure

    count = len(found.fit.priors)
    if count == 1:
        figure = Figure(figsize=(6.5, 2.4), layout="constrained")
        headline(figure, f"{found.fit.name}: what the observation determines")
        _widths(figure.subplots(), found)
        return figure
    figure = Figure(figsize=(13.0, max(0.55 * count + 2.0, 3.2)), layout="constrained")
    headline(figure, f"{found.fit.name}: what the observation determines, and what it cannot")
    bars, matrix, along = figure.subplots(1, 3, width_ratios=[1.1, 1.0, 1.2])
    names = [_label(found, k) for k in range(count)]
    _widths(bars, found)
    _matrix(matrix, found.correlations, names, names)
    matrix.set_title("correlations of the posterior", loc="left", fontsize=9)
    loads = np.array([direction.along for direction in found.directions])
    widths = [f"{direction.width:.2f}" for direction in found.directions]
    _matrix(along, loads, names, widths)
    along.set_title("directions of the Fisher information, best known first", loc="left",
                    fontsize=9)  # fmt: skip
    along.set_ylabel("posterior width/prior width along it [-]")
    return figure


def _widths(bars: "Axes", found: Fitted) -> None:
    """A bar for each parameter."""
    count = len(found.fit.priors)
    colours = [BLUE if width <= NARROWER else VERMILION for width in found.widths]
    bars.barh(range(count), found.widths, color=colours, height=0.6)
    bars.axvline(NARROWER, color=GREY, lw=1.0, ls=(0, (4, 2)))
    bars.set_yticks(range(count), [_label(found, k) for k in range(count)])
    bars.set_ylim(count - 0.5, -0.5)
    bars.set_xlim(0, max(1.05, float(found.widths.max()) * 1.05))
    bars.set_xlabel(f"posterior width/prior width [-]; identifiable below {NARROWER:g}")
    bars.set_title("how much narrower", loc="left", fontsize=9)


def _matrix(axes: "Axes", numbers: np.ndarray, columns: list[str], rows: list[str]) -> None:
    axes.imshow(numbers, cmap="RdBu_r", vmin=-1, vmax=1, aspect="auto")
    axes.set_xticks(range(len(columns)), columns, fontsize=8)
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    for spine in axes.spines.values():
        spine.set_visible(False)
    for (i, j), value in np.ndenumerate(numbers):
        axes.text(j, i, f"{value:+.2f}", ha="center", va="center", fontsize=8,
                  color="white" if abs(value) > 0.6 else INK)  # fmt: skip
