"""The optimum table as a picture: optima against clearance, and the curves that they come from."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.reproduce.panels import Row
from damper3d.reproduce.quantities.optima import Optimum
from damper3d.studies.map.grid import MapResult
from granulab.campaign.output.figure import BLUE, GREY, INK, ORANGE, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = {"vertical": BLUE, "horizontal": ORANGE}
_SHIFT = {"vertical": -0.35, "horizontal": 0.35}  # mm, so that the two stand side by side
_LINES = {"loose": "--", "close": "-"}
_HEIGHT_LINES = {0: "-", 1: "--", 2: "-.", 3: ":"}

Optima = Mapping[tuple[int, float, str], Optimum | None]
Published = Callable[[int, str], dict[float, float | None]]


def draw_optima(rows: Sequence[Row], found: Optima, published: Published) -> "Figure":
    """A column for each frequency: above optimum against height, below eta against Gamma."""
    from matplotlib.figure import Figure

    frequencies = sorted({row["frequency_hz"] for row in rows})
    figure = Figure(figsize=(1.2 + 3.3 * len(frequencies), 7.2), layout="constrained")
    headline(figure, "Where the bouncing bed damps best")
    panels = figure.subplots(2, len(frequencies), squeeze=False)
    for k, frequency in enumerate(frequencies):
        here = {line: one for line, one in found.items() if line[1] == frequency}
        _draw_heights(panels[0, k], here, frequency, published)
        _draw_curves(panels[1, k], [r for r in rows if r["frequency_hz"] == frequency], here)
        panels[0, k].set_title(f"{frequency:g} Hz", loc="left", fontsize=10)
    panels[0, 0].set_ylabel("Γ at the optimum [-]")
    panels[1, 0].set_ylabel("efficiency [-]")
    for legends in panels:
        named: dict[str, Any] = {}
        for axes in legends:
            named |= dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
        legends[-1].legend(named.values(), named.keys(), loc="upper left", bbox_to_anchor=(1, 1))
    return figure


def _draw_heights(axes: "Axes", here: Optima, frequency: float, published: Published) -> None:
    for orientation, colour in _COLOURS.items():
        for (height, _, own), one in here.items():
            if own != orientation:
                continue
            at = height + _SHIFT[orientation]
            theirs = published(height, orientation).get(frequency)
            if theirs is not None:
                axes.plot(at, theirs, "D", color=VERMILION, ms=5, mfc="white", zorder=3,
                          label="thesis, DEM")  # fmt: skip
            if one is None:
                continue
            spread = np.abs(np.array(one.mean.bracket).reshape(2, 1) - one.gamma)
            axes.errorbar(at, one.gamma, spread, fmt="o", color=colour, ms=4.5, capsize=3,
                          label=f"ours, {orientation}\n(bars: bracket)")  # fmt: skip
    _draw_predicted(axes, here)
    axes.set_xlabel("height [mm]")
    axes.set_xticks(sorted({height for height, _, _ in here}))
    axes.margins(x=0.15)
    if len({height for height, _, _ in here}) == 1:
        axes.margins(x=2.0)  # else the two orientations stand at the ends
    axes.set_ylim(bottom=0)


def _draw_predicted(axes: "Axes", here: Optima) -> None:
    by_height = {height: one for (height, _, _), one in sorted(here.items()) if one is not None}
    for name, style in _LINES.items():
        gammas = [one.predicted(name) or np.nan for one in by_height.values()]
        axes.plot(list(by_height), gammas, style, marker="_", color=GREY, lw=1.2, zorder=1,
                  label=f"eq. 6.11, {name} packing")  # fmt: skip


def _draw_curves(axes: "Axes", rows: Sequence[Row], here: Optima) -> None:
    heights = sorted({height for height, _, _ in here})
    for height, frequency, orientation in here:
        own = [r for r in rows if (r["height_mm"], r["orientation"]) == (height, orientation)]
        result = MapResult.of(own)
        chosen = result.at(frequency)
        style = _HEIGHT_LINES[heights.index(height) % len(_HEIGHT_LINES)]
        axes.errorbar(
            result.gamma[chosen], result.efficiency[chosen],
            np.nan_to_num(result.half_width[chosen]), color=_COLOURS[orientation], ls=style,
            marker=".", ms=3, lw=1, elinewidth=0.6, label=f"{height} mm, {orientation}",
        )  # fmt: skip
    axes.axhline(0.3, color=INK, lw=0.6, zorder=0)
    axes.set(xscale="log", xlabel="Γ [-]", ylim=(0, None))
    gammas = sorted({row["gamma"] for row in rows})
    places = [g for g in (1, 2, 3, 5, 10, 20, 40, 70, 100) if gammas[0] <= g <= gammas[-1]]
    axes.set_xticks(places, [f"{g:g}" for g in places])
    axes.minorticks_off()
