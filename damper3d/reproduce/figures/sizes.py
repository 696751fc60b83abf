"""The table of sizes as a picture: efficiency against Gamma for each diameter."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.reproduce.panels import Row
from damper3d.reproduce.quantities.optima import Optimum
from damper3d.studies.map.grid import MapResult
from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LOOKS = {3: (BLUE, "o"), 4: (GREEN, "s"), 5: (ORANGE, "^"), 6: (PURPLE, "D")}  # by diameter [mm]
_LINES = {"loose": "--", "close": "-"}
_ONSET_BELOW = 100.0  # onsets beyond the thesis's Gammas are not drawn

Found = Mapping[tuple[str, float], Mapping[int, Optimum | None]]


def draw_sizes(rows: Sequence[Row], found: Found) -> "Figure":
    """A row for each orientation, a column for each frequency; bars are 95 % intervals."""
    from matplotlib.figure import Figure

    orientations = list(dict.fromkeys(orientation for orientation, _ in found))
    frequencies = sorted({frequency for _, frequency in found})
    rows_of, columns = max(len(orientations), 1), max(len(frequencies), 1)
    figure = Figure(figsize=(1.8 + 4.0 * columns, 0.8 + 3.2 * rows_of), layout="constrained")
    headline(figure, "Spheres of four sizes, the same volume")
    panels = figure.subplots(rows_of, columns, squeeze=False, sharey=True)
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
    named: dict[str, Any] = {}
    for axes in panels.flat:
        named |= dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
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
    places = [g for g in (1, 2, 3, 5, 10, 20, 50, 100) if gammas[0] <= g <= gammas[-1]]
    axes.set_xticks(places, [f"{g:g}" for g in places])
    axes.minorticks_off()


def _draw_onsets(axes: "Axes", own: Mapping[int, Optimum | None]) -> None:
    """Lines of eq. 6.11 where they are among the Gammas."""
    one = next((one for one in own.values() if one is not None), None)
    for name, style in _LINES.items():
        onset = one.predicted(name) if one else None
        if onset is not None and onset < _ONSET_BELOW:
            axes.axvline(onset, color=GREY, ls=style, lw=1, zorder=0,
                         label=f"eq. 6.11,\n{name} packing")  # fmt: skip
