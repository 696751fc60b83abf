"""The tables of maps as figures: contours with onset lines, phases and peaks; small multiples."""

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from damper3d.reproduce.panels import ORIENTATIONS
from damper3d.reproduce.quantities.maps import Maps, Ridges
from damper3d.studies.map.chart import (
    LEVELS,
    draw_onsets,
    draw_peaks,
    draw_points,
    fill_contours,
    plane,
)
from granulab.campaign.output.figure import entries, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_panels(counts: Mapping[str, Maps]) -> "Figure":
    """A column for each orientation and count, in it a row a height; a legend an orientation.

    counts    the maps by what is counted, in words; the first has the phases
    """
    from matplotlib.figure import Figure

    found = {key for maps in counts.values() for key in maps}
    orientations = [o for o in ORIENTATIONS if o in {own for own, _ in found}]
    heights = sorted({height for _, height in found})
    size = (
        1.0 + max(len(orientations), 1) * (1.0 + 5.2 * max(len(counts), 1)),
        2.6 + 3.1 * max(len(heights), 1),
    )
    figure = Figure(figsize=size, layout="constrained")
    headline(figure, "Efficiency of 358 spheres of 5 mm")
    if not found:
        return figure
    parts = figure.subfigures(1, len(orientations), squeeze=False)[0]
    for part, orientation in zip(parts, orientations, strict=True):
        upper, below = part.subfigures(2, 1, height_ratios=[len(heights), 0.4])
        grid = upper.subplots(len(heights), len(counts), squeeze=False)
        filled = None
        for (row, height), (column, words) in itertools.product(
            enumerate(heights), enumerate(counts)
        ):
            axes, one = grid[row, column], counts[words].get((orientation, height))
            if one is None or len(one.frequencies) < 2:
                axes.axis("off")
                continue
            filled = _draw(axes, one, named=column == 0)
            title = f"{orientation}, {height} mm, fill ratio {one.prediction.fill_ratio:.3f}"
            axes.set_title(f"{title}: {words}", loc="left", fontsize=9)
        if filled is not None:
            upper.colorbar(filled, ax=grid, label="efficiency [-]", ticks=LEVELS, shrink=0.3)
        _legend(below.subplots(), list(grid.flat))
    return figure


def _draw(axes: "Axes", one: Ridges, *, named: bool) -> Any:
    filled = fill_contours(axes, one.result)
    draw_onsets(axes, one.prediction, one.result)
    if named:
        draw_points(axes, one.result)
    # Where no interval of one packing is known, a small maximum may be noise.
    draw_peaks(axes, [peak for peak in one.peaks if named or peak.ridge != "other"])
    plane(axes, one.result)
    return filled


def _legend(below: "Axes", panels: "list[Axes]") -> None:
    """All that any panel of a column shows."""
    named = entries(panels)
    named.pop("runs", None)  # white dots, which a white ground does not show
    below.axis("off")
    below.legend(
        list(named.values()), list(named), loc="upper center", ncols=3, fontsize=7, markerscale=0.8
    )


def draw_chapter(maps: Mapping[str, Maps]) -> "Figure":
    """A column for each entry, a row for each orientation and height; one legend, one bar.

    maps    by what distinguishes a column, in words
    """
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
    for column, (words, own) in zip(grid.T, maps.items(), strict=True):
        for axes, key in zip(column, keys, strict=True):
            one = own.get(key)
            if one is None or len(one.frequencies) < 2:
                axes.axis("off")
                continue
            filled = fill_contours(axes, one.result)
            draw_onsets(axes, one.prediction, one.result)
            _plane(axes, one)
            axes.set_title(f"{words}, {key[0]}, {key[1]} mm", loc="left", fontsize=8)
    if filled is not None:
        figure.colorbar(filled, ax=grid, label="efficiency [-]", ticks=LEVELS, shrink=0.25)
        named = entries(grid.T.flat)
        handles, labels = list(named.values()), list(named)
        figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    return figure


def _plane(axes: "Axes", one: Ridges) -> None:
    plane(axes, one.result)
    axes.tick_params(labelsize=6)
    axes.tick_params(axis="x", rotation=60)
    axes.label_outer()
