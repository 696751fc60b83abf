"""The maps of chapter 6 as small multiples: contours and onset lines."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from damper3d.reproduce.map_statements import Ridges
from damper3d.studies.map.chart import LEVELS, draw_onsets, fill_contours, plane
from granulab.campaign.output.figure import headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_chapter(maps: Mapping[int, Mapping[tuple[str, int], Ridges]]) -> "Figure":
    """A column for each diameter, a row for each orientation and height; one legend, one bar."""
    from matplotlib.figure import Figure

    found = {key for own in maps.values() for key in own}
    keys = sorted(found, key=lambda key: (key[0] != "vertical", key[1]))
    size = (1.0 + 3.2 * max(len(maps), 1), 1.4 + 2.4 * max(len(keys), 1))
    figure = Figure(figsize=size, layout="constrained")
    headline(figure, "Efficiency, spheres of the same volume in all columns")
    if not keys:
        return figure
    grid = figure.subplots(len(keys), len(maps), squeeze=False, sharex=True, sharey=True)
    filled = None
    named: dict[str, Any] = {}
    for column, (diameter, own) in zip(grid.T, maps.items(), strict=True):
        for axes, key in zip(column, keys, strict=True):
            one = own.get(key)
            if one is None or len(one.frequencies) < 2:
                axes.axis("off")
                continue
            filled = fill_contours(axes, one.result)
            draw_onsets(axes, one.prediction, one.result)
            _plane(axes, one)
            axes.set_title(f"{diameter} mm, {key[0]}, {key[1]} mm", loc="left", fontsize=8)
            named |= dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
    if filled is not None:
        figure.colorbar(filled, ax=grid, label="efficiency [-]", ticks=LEVELS, shrink=0.25)
        handles, labels = list(named.values()), list(named)
        figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    return figure


def _plane(axes: "Axes", one: Ridges) -> None:
    plane(axes, one.result)
    axes.tick_params(labelsize=6)
    axes.tick_params(axis="x", rotation=60)
    axes.label_outer()
