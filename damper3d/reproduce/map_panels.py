"""The maps of the two orientations as panels: contours, onset lines, phases and peaks."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from campaign.figure import headline
from damper3d.map.chart import LEVELS, draw_onsets, draw_peaks, draw_points, fill_contours, plane
from damper3d.reproduce.map_statements import Ridges

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_panels(maps: Mapping[tuple[str, int], Ridges]) -> "Figure":
    """A row for each height, a column for each orientation; one legend a column below."""
    from matplotlib.figure import Figure

    orientations = list(dict.fromkeys(orientation for orientation, _ in maps))
    heights = sorted({height for _, height in maps})
    size = (1.0 + 5.4 * max(len(orientations), 1), 2.6 + 3.1 * max(len(heights), 1))
    figure = Figure(figsize=size, layout="constrained")
    headline(figure, "Efficiency of 358 spheres of 5 mm")
    if not maps:
        return figure
    grid = figure.subplots(len(heights), len(orientations), squeeze=False)
    filled = None
    for column, orientation in enumerate(orientations):
        for row, height in enumerate(heights):
            one = maps.get((orientation, height))
            axes = grid[row, column]
            if one is None or len(one.frequencies) < 2:
                axes.axis("off")
                continue
            filled = _draw(axes, one)
            title = f"{orientation}, {height} mm, fill ratio {one.prediction.fill_ratio:.3f}"
            axes.set_title(title, loc="left", fontsize=9)
        _legend(list(grid[:, column]))
    if filled is not None:
        figure.colorbar(filled, ax=grid, label="efficiency [-]", ticks=LEVELS, shrink=0.5)
    return figure


def _draw(axes: "Axes", one: Ridges) -> Any:
    filled = fill_contours(axes, one.result)
    draw_onsets(axes, one.prediction, one.result)
    draw_points(axes, one.result)
    draw_peaks(axes, one.peaks)
    plane(axes, one.result)
    return filled


def _legend(column: "list[Axes]") -> None:
    """All that any panel of a column shows, below the last of them."""
    named: dict[str, Any] = {}
    for axes in column:
        named |= dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
    named.pop("runs", None)  # white dots, which a white ground does not show
    column[-1].legend(
        named.values(), named.keys(), loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3,
        fontsize=7, markerscale=0.8,
    )  # fmt: skip
