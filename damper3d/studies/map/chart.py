"""An efficiency map as a picture: contours over frequency and Gamma, onset lines, peaks, phases."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from damper3d.case.closed_forms import bouncing_bed_onset
from damper3d.measures.phases.phase_map import draw_phase_map
from damper3d.studies.map.grid import MapResult, counted
from damper3d.studies.map.ridges import OnRidge
from damper3d.studies.predict.prediction import Clearance, Prediction
from granulab.campaign.output.figure import (
    BLUE,
    INK,
    PAPER,
    SKY,
    VERMILION,
    entries,
    headline,
    ruled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.contour import ContourSet
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

# Few, as in the thesis (Figs 6.4, 6.5), which marks 0.3.
LEVELS = (0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0)
MARKED = 0.3
_LINES = {"loose": (0, (5, 2)), "close": "-", "own": (0, (1, 1)), "counted": (0, (4, 1, 1, 1))}
_RIDGE_MARKERS = {"bouncing_bed": "D", "fluidisation": "o", "other": "x"}
_GAMMAS = [1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0, 200.0]  # that an axis names
_BETWEEN = 400  # points of the interpolation along Gamma


def draw_map(result: MapResult, prediction: Prediction, on_ridges: list[OnRidge]) -> "Figure":
    """The map of a case with what is predicted and what was found; phases where runs have them.

    Of what is dissipated, and beside it of the work of the walls. Of one frequency, or of one
    Gamma, both are curves against the other.
    """
    from matplotlib.figure import Figure

    counts = {"dissipated": result} | _by_the_walls(result)
    maps = {words: one for words, one in counts.items() if _is_plane(one)}
    figure = Figure(figsize=(3.0 + 5.6 * max(len(maps), 1), 5.6), layout="constrained")
    headline(
        figure,
        f"{prediction.name}: efficiency, fill ratio {prediction.fill_ratio:.3f}, "
        f"{prediction.orientation}",
    )
    panels = figure.subplots(1, max(len(maps), 1), squeeze=False)[0]
    if not maps:
        _draw_curves(panels[0], counts, prediction)
    for axes, (words, one) in zip(panels, maps.items(), strict=False):
        draw_contours(axes, one)
        draw_onsets(axes, prediction, one)
        if axes is panels[0]:
            draw_points(axes, one)
        if one is result:
            draw_peaks(axes, on_ridges)
        plane(axes, one)
        if len(counts) > 1:
            axes.set_title(words, loc="left", fontsize=9)
    legend = entries(panels)
    figure.legend(legend.values(), legend.keys(), loc="outside right upper", labelspacing=0.7)
    return figure


def _by_the_walls(result: MapResult) -> dict[str, MapResult]:
    """The map with the work of the walls as its efficiency, by its name; {} where no run has it."""
    column = "efficiency_wall_work"
    if column not in result.columns:
        return {}
    return {"work of the walls": MapResult.of(counted(result.rows, column))}


def _is_plane(result: MapResult) -> bool:
    """True where several frequencies and several Gammas have an efficiency."""
    return min(_values(result, result.frequency), _values(result, result.gamma)) > 1


def _draw_curves(axes: "Axes", counts: Mapping[str, MapResult], prediction: Prediction) -> None:
    """The efficiencies with their intervals, along the quantity of which there are several."""
    result = list(counts.values())[-1]  # of the last count no point lacks that another has
    along_gamma = _values(result, result.frequency) == 1
    known = np.flatnonzero(np.isfinite(result.efficiency))
    first = known[0] if known.size else 0
    frequency, gamma = float(result.frequency[first]), float(result.gamma[first])
    looks = ("o-", INK), ("s--", BLUE)
    for (label, one), (style, colour) in zip(counts.items(), looks, strict=False):
        x = one.gamma if along_gamma else one.frequency
        axes.errorbar(
            x, one.efficiency, yerr=np.nan_to_num(one.half_width), fmt=style, color=colour, ms=4,
            capsize=2, label=label,
        )  # fmt: skip
    if along_gamma:
        for clearance in prediction.clearances:
            onset = clearance.onset(frequency)
            if onset is not None:
                axes.axvline(onset, color=VERMILION, ls=_LINES[clearance.name],
                             label=_onset_label(clearance))  # fmt: skip
    ruled(axes)
    label = "Γ [-]" if along_gamma else "frequency [Hz]"
    axes.set(xscale="log", xlabel=label, ylabel="efficiency [-]", ylim=(0, None))
    _plain_ticks(axes.xaxis, _GAMMAS if along_gamma else _spaced(np.unique(result.frequency)))
    fixed = f"{frequency:g} Hz" if along_gamma else f"Γ = {gamma:g}"
    axes.set_title(fixed, loc="left", fontsize=9)


def _values(result: MapResult, of: Floats) -> int:
    """Number of values of a coordinate that have an efficiency."""
    return len(np.unique(of[np.isfinite(result.efficiency)]))


def draw_contours(axes: "Axes", result: MapResult) -> None:
    """Filled contours of the efficiency with their bar, the level 0.3 as a line."""
    filled = fill_contours(axes, result)
    assert axes.figure is not None
    bar = axes.figure.colorbar(filled, ax=axes, label="efficiency [-]", ticks=LEVELS, pad=0.02)
    if np.nanmin(result.efficiency) < MARKED < np.nanmax(result.efficiency):
        bar.ax.axhline(MARKED, color=INK, lw=1.2)


def fill_contours(axes: "Axes", result: MapResult) -> "ContourSet":
    """Filled contours of the efficiency, the level 0.3 as a line."""
    frequency, gamma, eta = gridded(result)
    filled = axes.contourf(frequency, gamma, eta, levels=LEVELS, cmap="viridis", extend="both")
    if np.nanmin(eta) < MARKED < np.nanmax(eta):
        axes.contour(frequency, gamma, eta, levels=[MARKED], colors=INK, linewidths=1.2)
    return filled


def gridded(result: MapResult) -> tuple[Floats, Floats, Floats]:
    """Frequencies (m,) [Hz], Gammas (k,), efficiency (k, m), linear in ln Gamma between points.

    NaN beyond a frequency's least and greatest Gamma; frequencies without a value are left out.
    """
    frequencies = [f for f in np.unique(result.frequency) if len(result.at(f))]
    gamma = np.geomspace(result.gamma.min(), result.gamma.max(), _BETWEEN)
    columns = []
    for frequency in frequencies:
        known = result.at(frequency)
        at, eta = np.log(result.gamma[known]), result.efficiency[known]
        columns.append(np.interp(np.log(gamma), at, eta, left=np.nan, right=np.nan))
    return np.array(frequencies), gamma, np.array(columns).reshape(-1, _BETWEEN).T


def draw_onsets(axes: "Axes", prediction: Prediction, result: MapResult) -> None:
    """Lines of eq. 6.11 for each packing, and the Gamma above which the bed moves at all."""
    span = result.frequency.min(), result.frequency.max()
    frequency = np.geomspace(*span, 200)
    for clearance in prediction.clearances:
        if clearance.length is None:
            continue
        onset = bouncing_bed_onset(frequency, clearance.length)
        axes.plot(frequency, onset, color=VERMILION, ls=_LINES[clearance.name], lw=1.6,
                  label=_onset_label(clearance))  # fmt: skip
    if prediction.threshold and prediction.threshold >= result.gamma.min():
        axes.axhline(
            prediction.threshold, color=SKY, lw=2, clip_on=False, label="onset of fluidisation"
        )


def _onset_label(clearance: Clearance) -> str:
    packed = f", {clearance.packing:g}" if clearance.packing is not None else ""
    return f"onset of the bouncing\nbed ({clearance.name}{packed})"


def draw_points(axes: "Axes", result: MapResult) -> None:
    """Markers of the runs: of the phase that they show, or a dot where none was named."""
    unnamed = np.array([phase is None for phase in result.phases])
    if unnamed.any():  # no points would be drawn at the origin, which spoils the layout
        axes.plot(result.frequency[unnamed], result.gamma[unnamed], ".", color=PAPER, ms=3,
                  alpha=0.6, clip_on=False, label="runs")  # fmt: skip
    named = [row for row in result.rows if row.get("phase")]
    if named:
        draw_phase_map(axes, named, named[0]["orientation"])


def plane(axes: "Axes", result: MapResult) -> None:
    """Logarithmic axes from the first to the last frequency and Gamma, with their numbers."""
    axes.set(xscale="log", yscale="log", xlabel="frequency [Hz]", ylabel="Γ [-]")
    _plain_ticks(axes.xaxis, _spaced(np.unique(result.frequency)))
    _plain_ticks(axes.yaxis, _GAMMAS)
    axes.set_xlim(result.frequency.min(), result.frequency.max())
    axes.set_ylim(result.gamma.min(), result.gamma.max())


def draw_peaks(axes: "Axes", on_ridges: list[OnRidge]) -> None:
    """The peaks that were found, with the bracket that each lies in."""
    for ridge, marker in _RIDGE_MARKERS.items():
        found = [item for item in on_ridges if item.ridge == ridge]
        if not found:
            continue
        at = np.array([item.peak.gamma for item in found])
        brackets = np.array([item.peak.bracket for item in found])
        axes.errorbar(
            [item.frequency for item in found], at, yerr=np.abs(brackets.T - at), fmt=marker,
            color=VERMILION, mec=PAPER, ms=7, elinewidth=1.5, capsize=3, zorder=5, clip_on=False,
            label=f"peak: {ridge.replace('_', ' ')}",
        )  # fmt: skip


def _plain_ticks(axis: "Axis", positions: list[float]) -> None:
    """Ticks at these positions only, as numbers that people write."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    axis.set_major_locator(FixedLocator(positions))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def _spaced(frequencies: Floats) -> list[float]:
    """Those of the frequencies whose numbers do not touch on a logarithmic axis."""
    spacing = 0.06 * np.log(frequencies[-1] / frequencies[0])
    named = [float(frequencies[0])]
    for frequency in frequencies.tolist():
        if np.log(frequency / named[-1]) > spacing:
            named.append(frequency)
    return named
