"""Figs 6.12, 6.22 and 6.26: spheres of 3, 4, 5 and 6 mm, the same volume, at 20 and 160 Hz.

In the cylinder of 40 mm (fill ratio 0.466), in both orientations. At 20 Hz the optimum is the
bouncing bed's onset, at 160 Hz that of fluidisation. The thesis's Gammas are run for each packing,
then the intervals next to each peak are halved twice.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from damper3d.reproduce.panels import (
    ORIENTATIONS,
    PANEL_COLUMNS,
    SPHERES,
    Panel,
    Row,
    about,
    close_onset,
    completeness,
    labels_of,
    panel,
    run_of_panels,
)
from damper3d.reproduce.quantities.optima import Optimum, optimum, pooled_scatter, with_scatter
from damper3d.studies.map.grid import MapResult
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import Quantities, report_claims
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    entries,
    headline,
    ticked,
)
from granulab.campaign.output.layout import columns, paragraphs
from granulab.campaign.output.statistics import slope

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SEEDS = 3
COLUMNS = PANEL_COLUMNS
RIDGES = {20.0: "bouncing_bed", 160.0: "fluidisation"}  # by frequency [Hz]
REFINE = 2
_HEIGHT = 40  # mm
_FLUIDISED = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0]  # Gammas at 160 Hz
_AROUND = 2.5  # factor about the onset of the bouncing bed at 20 Hz

Key = tuple[str, float]  # orientation, frequency [Hz]

_CRITERION = """\
ours: where eta peaks along Gamma on the ridge named, geometric mean +- standard deviation over the
  packings, each with its own peak (their number); bracket: between which Gammas the peak of the
  mean curve lies by more than noise; +-: the scatter of the mean, pooled over all lines, and
  half the bracket together. A small effect: largest over least optimum at most 1.5, about
  what 5 mm of height do at 40 mm (eq. 6.11, close packing). The trend is the slope of ln Gamma
  against ln diameter through the mean optima, with its 95 % interval."""


def panels() -> list[Panel]:
    """The eight dampers, with the points before their refinement."""
    points = [(20.0, g) for g in about(close_onset(_HEIGHT, 20.0), _AROUND)]
    points += [(160.0, g) for g in _FLUIDISED]
    return [panel(o, _HEIGHT, diameter, points) for o in ORIENTATIONS for diameter in SPHERES]


run = run_of_panels(panels, REFINE)


Found = Mapping[Key, Mapping[int, Optimum | None]]  # then by diameter [mm]


class Readings(NamedTuple):
    """Data of the claims: the rows and their optima."""

    rows: Sequence[Row]
    found: Found


QUANTITIES = Quantities()


def optima(rows: Sequence[Row]) -> dict[Key, dict[int, Optimum | None]]:
    """The optima of each orientation and frequency, by the spheres' diameter [mm]."""
    found: dict[Key, dict[int, Optimum | None]] = {}
    for (orientation, frequency), diameter in itertools.product(_keys(rows), SPHERES):
        own = [row for row in rows if _is_of(row, (orientation, frequency), diameter)]
        if own:
            here = found.setdefault((orientation, frequency), {})
            here[diameter] = optimum(own, frequency, RIDGES[frequency])
    return found


def _keys(rows: Sequence[Row]) -> list[Key]:
    return sorted({(row["orientation"], row["frequency_hz"]) for row in rows}, reverse=True)


def _is_of(row: Row, key: Key, diameter: int) -> bool:
    return (row["orientation"], row["frequency_hz"], row["diameter_mm"]) == (*key, diameter)


def report(rows: list[Row]) -> str:
    """Return what lacks, the optimum of each size, the claims, the criterion."""
    found = optima(rows)
    pooled = pooled_scatter([one for own in found.values() for one in own.values()])
    lines = [
        _line(key, diameter, one, pooled)
        for key, own in found.items()
        for diameter, one in own.items()
    ]
    heads = [
        "orientation",
        "f [Hz]",
        "ridge",
        "spheres",
        "ours",
        "bracket",
        "+-",
        "eta",
        "LP",
        "CP",
    ]
    return paragraphs(
        completeness(rows, labels_of(panels()), SEEDS),
        columns(heads, lines),
        report_claims(QUANTITIES.judge(claims_of("damper_sizes"), Readings(rows, found))),
        _CRITERION,
    )


def _line(
    key: Key, diameter: int, one: Optimum | None, pooled: tuple[float, int] | None
) -> list[str]:
    orientation, frequency = key
    ridge = RIDGES[frequency].replace("_", " ")
    head = [orientation, f"{frequency:g}", ridge, f"{diameter} mm"]
    if one is None:
        return [*head, "no peak", "-", "-", "-", "-", "-"]
    low, high = one.mean.bracket
    onsets = [one.predicted(name) for name in ("loose", "close")]
    shown = [f"{onset:.3g}" if onset and ridge == "bouncing bed" else "-" for onset in onsets]
    error = f"{100 * one.error(pooled):.0f} %"
    return [*head, with_scatter(one), f"{low:.3g} to {high:.3g}", error,
            f"{one.mean.efficiency:.3f}", *shown]  # fmt: skip


@QUANTITIES.quantity
def optimum_by_size(readings: Readings) -> list[Row]:
    """Gamma of the optimum of each size that has one."""
    return [
        _labels(key) | {"diameter_mm": diameter, "value": one.gamma}
        for key, own in readings.found.items()
        for diameter, one in own.items()
        if one
    ]


@QUANTITIES.quantity
def exponent_of_size(readings: Readings) -> list[Row]:
    """Slope of ln Gamma over ln diameter through the mean optima, with its noise."""
    found = []
    for key, own in readings.found.items():
        points = [(math.log(diameter), math.log(one.gamma)) for diameter, one in own.items() if one]
        trend = slope([x for x, _ in points], [y for _, y in points])
        if trend is not None:
            hidden = abs(trend.value) <= trend.half_width
            found.append(_labels(key) | {"value": trend.value, "noise": trend.half_width,
                                         "remark": " (within noise)" * hidden})  # fmt: skip
    return found


@QUANTITIES.quantity
def distance_from_5_mm(readings: Readings) -> list[Row]:
    """Root-mean-square difference of each size's eta from that of 5 mm, where both have Gammas."""
    found = []
    for key in readings.found:
        curves = {d: _curve([r for r in readings.rows if _is_of(r, key, d)]) for d in SPHERES}
        for diameter, curve in curves.items():
            common = curve.keys() & curves[5].keys()
            if diameter != 5 and common:
                squares = [(curve[gamma] - curves[5][gamma]) ** 2 for gamma in common]
                rms = math.sqrt(math.fsum(squares) / len(squares))
                found.append(_labels(key) | {"diameter_mm": diameter, "value": rms})
    return found


def _curve(rows: Sequence[Row]) -> dict[float, float]:
    result = MapResult.of(rows)
    known = zip(result.gamma.tolist(), result.efficiency.tolist(), strict=True)
    return {gamma: eta for gamma, eta in known if math.isfinite(eta)}


def _labels(key: Key) -> Row:
    return {"orientation": key[0], "frequency_hz": key[1]}


_LOOKS = {3: (BLUE, "o"), 4: (GREEN, "s"), 5: (ORANGE, "^"), 6: (PURPLE, "D")}  # by diameter [mm]
_LINES = {"loose": "--", "close": "-"}
_ONSET_BELOW = 100.0  # onsets beyond the thesis's Gammas are not drawn


def draw(rows: list[Row]) -> "Figure":
    """Efficiency against Gamma of each size, a panel for each orientation and frequency."""
    from matplotlib.figure import Figure

    found = optima(rows)
    orientations = list(dict.fromkeys(orientation for orientation, _ in found))
    frequencies = sorted({frequency for _, frequency in found})
    down, across = max(len(orientations), 1), max(len(frequencies), 1)
    figure = Figure(figsize=(1.8 + 4.0 * across, 0.8 + 3.2 * down), layout="constrained")
    headline(figure, "Spheres of four sizes, the same volume")
    panels = figure.subplots(down, across, squeeze=False, sharey=True)
    for (orientation, frequency), own in found.items():
        axes = panels[orientations.index(orientation), frequencies.index(frequency)]
        here = [
            r for r in rows if (r["orientation"], r["frequency_hz"]) == (orientation, frequency)
        ]
        _draw(axes, here, own)
        axes.set_title(f"{orientation}, {frequency:g} Hz", loc="left", fontsize=9)
    for axes in panels[:, 0]:
        axes.set_ylabel("efficiency [-]")
        axes.set_ylim(bottom=0)  # of all: they share it
    named = entries(panels.flat)
    figure.legend(named.values(), named.keys(), loc="outside right upper")
    return figure


def _draw(axes: "Axes", rows: Sequence[Row], own: Mapping[int, Optimum | None]) -> None:
    for diameter, one in own.items():
        colour, marker = _LOOKS[diameter]
        result = MapResult.of(row for row in rows if row["diameter_mm"] == diameter)
        known = np.isfinite(result.efficiency)
        axes.errorbar(
            result.gamma[known], result.efficiency[known], np.nan_to_num(result.half_width[known]),
            color=colour, marker=marker, ms=3, lw=1.1, elinewidth=0.6, label=f"{diameter} mm",
        )  # fmt: skip
        if one is not None:
            axes.plot(one.gamma, one.mean.efficiency, marker, color=colour, mec=INK, ms=7, zorder=4)
    _draw_onsets(axes, own)
    axes.axhline(0.3, color=GREY, lw=0.6, zorder=0)
    axes.set(xscale="log", xlabel="Γ [-]")
    gammas = sorted({row["gamma"] for row in rows})
    ticked(axes, (1, 2, 3, 5, 10, 20, 50, 100), (gammas[0], gammas[-1]))


def _draw_onsets(axes: "Axes", own: Mapping[int, Optimum | None]) -> None:
    """Lines of eq. 6.11 where they are among the Gammas."""
    one = next((one for one in own.values() if one is not None), None)
    for name, style in _LINES.items():
        onset = one.predicted(name) if one else None
        if onset is not None and onset < _ONSET_BELOW:
            axes.axvline(onset, color=GREY, ls=style, lw=1, zorder=0,
                         label=f"eq. 6.11,\n{name} packing")  # fmt: skip
