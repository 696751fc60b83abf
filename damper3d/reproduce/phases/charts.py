"""The phases as maps over frequency and Gamma, and the shares of particles that decide."""

from typing import TYPE_CHECKING, Any

from damper3d.measures.phases.phase_map import draw_phase_map
from damper3d.reproduce.phases.points import LARGE, STANDARD
from damper3d.reproduce.phases.quantities import grouped
from damper3d.reproduce.phases.readings import Points, points_of
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    entries,
    headline,
    ruled,
    ticked,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = dict[str, Any]

_MAPS = (
    (STANDARD, 8, "8 cycles"), (STANDARD, 60, "60 cycles, 50 not counted"), (LARGE, 8, "8 cycles"),
)  # fmt: skip
_AT = 40.0, 160.0  # Hz
_TICKS = 20.0, 40.0, 80.0, 160.0, 320.0, 1024.0


def phase_charts(rows: list[Row]) -> "Figure":
    """A row of panels for each orientation: three maps, and shares at two frequencies."""
    from matplotlib.figure import Figure

    points = points_of(rows)
    figure = Figure(figsize=(15.5, 9.6), layout="constrained")
    headline(figure, "Phases of 358 spheres of 5 mm")
    for (row,), orientation in zip(
        figure.subfigures(2, 1, squeeze=False), ("vertical", "horizontal"), strict=True
    ):
        panels = row.subplots(1, 4)
        for axes, (height, cycles, words) in zip(panels, _MAPS, strict=False):
            _map(axes, points, orientation, height, cycles)
            axes.set_title(f"{orientation}, {height} mm, {words}", loc="left", fontsize=9)
        _shares(panels[3], points, orientation)
        found = entries(panels[:3])
        row.legend(list(found.values()), list(found), loc="outside lower left", ncols=5, fontsize=8)
        row.legend(*panels[3].get_legend_handles_labels(), loc="outside lower right", ncols=2,
                   fontsize=8)  # fmt: skip
    return figure


def _map(axes: "Axes", points: Points, orientation: str, height: int, cycles: int) -> None:
    wanted = (orientation, height, cycles)
    own = [one for one in points if (one.orientation, one.height_mm, one.cycles) == wanted]
    draw_phase_map(axes, [one.labels | {"phase": one.name} for one in own], orientation,
                   areas=cycles == 8)  # fmt: skip
    if own:
        ticked(axes, _TICKS, inside=(own[0].frequency_hz, max(one.frequency_hz for one in own)))


def _shares(axes: "Axes", points: Points, orientation: str) -> None:
    """Efficiency, fluidised and convecting particles over Gamma, at the lower and higher of _AT."""
    ruled(axes)
    standard = [one for one in points if (one.orientation, one.height_mm, one.cycles)
                == (orientation, STANDARD, 8) and one.frequency_hz in _AT]  # fmt: skip
    for labels, own in grouped(standard, "frequency_hz"):
        style = "-" if labels["frequency_hz"] == _AT[0] else "--"
        gamma = [one.gamma for one in own]
        words = f"{labels['frequency_hz']:g} Hz"
        for values, colour, name in (
            ([one.efficiency for one in own], INK, "efficiency"),
            ([one.measures["fluidised_share"] for one in own], BLUE, "fluidised"),
            ([one.measures["convecting_share"] for one in own], ORANGE, "convecting"),
            ([one.measures["deep_carried_share"] for one in own], GREEN, "deepest carried"),
        ):
            axes.plot(gamma, values, style, color=colour, lw=1.2, label=f"{name}, {words}")
    axes.set(xscale="log", ylim=(0, 1.05), xlabel="Γ", ylabel="share of particles; efficiency")
    axes.set_title(f"{orientation}, {STANDARD} mm", loc="left", fontsize=9)
