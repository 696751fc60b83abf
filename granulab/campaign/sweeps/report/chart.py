"""The picture of a sweep: what its panels are follows from what was varied.

one number                   curves of the main quantities, each with its intervals
one that was drawn           scatter
one word, such as a case     dots
two numbers                  heat maps
one of two a few words       curves or dots, in a colour for each word
more                         main effects: a row of panels for each quantity, a panel a key
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from granulab.campaign.output.figure import GREY, headline
from granulab.campaign.sweeps.report.axes import Axis
from granulab.campaign.sweeps.report.comparison import Comparison
from granulab.campaign.sweeps.report.heat_map import draw_heat_map
from granulab.campaign.sweeps.report.panels import (
    COLOURS,
    draw_curves,
    draw_dots,
    draw_scatter,
)
from granulab.campaign.sweeps.report.quantities import Ending, Number
from granulab.campaign.sweeps.report.words import NO_INTERVAL, has_intervals

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDE, _HIGH, _MOST_HIGH = 4.4, 3.2, 8.0  # of a panel [inch]
_OF_A_WORD, _OF_A_ROW, _OF_A_COLUMN = 0.34, 0.42, 0.66  # a line of dots, a row and column of cells
_MOST_WIDE = 5.7  # of each of three panels in a row; else there are two [inch]

Quantity = Number | Ending
Draw = Callable[["Axes", Quantity], None]


def draw_sweep(comparison: Comparison) -> "Figure | None":
    """The picture of a study; None where no run has a quantity to be drawn."""
    from matplotlib.figure import Figure

    shown, axes = comparison.shown, comparison.axes
    if not any(one.done for one in comparison.combinations) or not shown:
        return None
    axes = axes or [_without(comparison)]
    size, panels = _panels(comparison, shown, axes)
    columns = max(map(len, panels))
    high = min(size[1], 3 * _MOST_HIGH / len(panels))
    figure = Figure(
        figsize=(size[0] * columns + 0.4, high * len(panels) + 0.9), layout="constrained"
    )
    grid = figure.subplots(len(panels), columns, squeeze=False)
    for row, axes_of_row in zip(panels, grid, strict=True):
        for panel in axes_of_row[len(row) :]:
            panel.set_axis_off()
        for k, ((what, draw), panel) in enumerate(zip(row, axes_of_row, strict=False)):
            draw(panel, what)
            if k:
                _without_repetition(panel, axes_of_row[0])
    _words(figure, comparison, axes, [panel for row in grid for panel in row])
    return figure


def _without_repetition(panel: "Axes", first: "Axes") -> None:
    """Leave out what the first panel of the row says on the same axis."""
    own, its = ([text.get_text() for text in one.get_yticklabels()] for one in (panel, first))
    if panel.get_ylabel() == first.get_ylabel():
        panel.set_ylabel("")
        if own == its and any(own):
            panel.tick_params(labelleft=False)


def _panels(
    comparison: Comparison, shown: Sequence[Quantity], axes: Sequence[Axis]
) -> tuple[tuple[float, float], list[list[tuple[Quantity, Draw]]]]:
    """Size of a panel [inch], and what each row of them shows."""
    if _has_effects(axes):
        effects = [[(what, _effect(comparison, axis)) for axis in axes] for what in shown]
        return (0.82 * _WIDE, _HIGH), effects
    if _is_plane(axes):
        size = _size_of_cells(*axes)
        return size, _in_rows([(what, _heat_map(comparison, *axes)) for what in shown], size[0])
    axis, by = _along_and_by(axes)
    lines = len(axis.values) * (len(by.values) if by else 1) ** 0.5
    size = _WIDE, max(_HIGH, _OF_A_WORD * lines + 1.0 if axis.kind == "word" else 0.0)
    return size, _in_rows([(what, _along(comparison, axis, by)) for what in shown], size[0])


def _without(comparison: Comparison) -> Axis:
    """The axis of a study that varies nothing but seeds: its one combination."""
    first = comparison.varied[0]
    return Axis(first, "word", (comparison.combinations[0].labels[first.column],))


def _has_effects(axes: Sequence[Axis]) -> bool:
    """True where there are more keys than one picture of them all would show."""
    return len(axes) > 1 and not _is_plane(axes) and not _is_by_words(axes)


def _is_plane(axes: Sequence[Axis]) -> bool:
    return [axis.kind for axis in axes] == ["number", "number"]


def _is_by_words(axes: Sequence[Axis]) -> bool:
    """True where one of two axes has few enough words for a colour each."""
    kinds = [axis.kind for axis in axes]
    few = any(axis.kind == "word" and len(axis.values) <= len(COLOURS) for axis in axes)
    return len(axes) == 2 and few and "drawn" not in kinds


def _along_and_by(axes: Sequence[Axis]) -> tuple[Axis, Axis | None]:
    """The axis of a panel, and the words that its colours stand for."""
    if len(axes) == 1:
        return axes[0], None
    first, second = sorted(axes, key=lambda axis: (axis.kind == "word", -len(axis.values)))
    return first, second


def _along(comparison: Comparison, axis: Axis, by: Axis | None) -> Draw:
    if axis.kind == "drawn":
        return lambda panel, what: draw_scatter(panel, what, axis, comparison)
    kind = draw_dots if axis.kind == "word" else draw_curves
    return lambda panel, what: kind(panel, what, axis, comparison, by)


def _effect(comparison: Comparison, axis: Axis) -> Draw:
    kind = draw_scatter if axis.kind == "drawn" else draw_curves
    return lambda panel, what: kind(panel, what, axis, comparison)


def _heat_map(comparison: Comparison, across: Axis, up: Axis) -> Draw:
    return lambda panel, what: draw_heat_map(panel, what, across, up, comparison)


def _in_rows(panels: list[tuple[Quantity, Draw]], wide: float) -> list[list[tuple[Quantity, Draw]]]:
    columns = 3 if len(panels) == 3 and wide <= _MOST_WIDE else 2
    return [panels[k : k + columns] for k in range(0, len(panels), columns)]


def _size_of_cells(across: Axis, up: Axis) -> tuple[float, float]:
    """Width and height of a heat map [inch]."""
    return (
        min(max(_WIDE, _OF_A_COLUMN * len(across.values) + 1.6), 2 * _MOST_HIGH),
        min(max(_HIGH, _OF_A_ROW * len(up.values) + 0.9), _MOST_HIGH),
    )


def _words(
    figure: "Figure", comparison: Comparison, axes: Sequence[Axis], panels: Sequence["Axes"]
) -> None:
    """Headline, key to colours and marks, and a line on the intervals."""
    *others, last = [axis.varied.label for axis in axes]
    over = f"{', '.join(others)} and {last}" if others else last
    headline(figure, f"{comparison.name}: {len(comparison.rows)} runs over {over}")
    entries: dict[Any, Any] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    columns = max(min(len(entries), int(figure.get_figwidth() / 1.8)), 1)
    options: dict[str, Any] = {
        "loc": "outside lower left", "ncols": columns, "fontsize": 8, "alignment": "left",
        "title": _how_to_read(comparison, axes), "title_fontsize": 7.5,
    }  # fmt: skip
    legend = figure.legend(list(entries.values()), list(entries), **options)
    legend.get_title().set_color(GREY)


def _how_to_read(comparison: Comparison, axes: Sequence[Axis]) -> str:
    """A line on the intervals and the number of seeds."""
    if not has_intervals(comparison):
        of = NO_INTERVAL
    elif comparison.seeds == "1":
        of = "95 % intervals over the cycles of one run"
    else:
        shares = any(isinstance(what, Ending) for what in comparison.shown)
        of = f"95 % intervals over {comparison.seeds} seeds: means by Student's t"
        of += ", shares by Wilson" if shares else ""
    effects = "; over each key the mean of those combinations of the others that have a value"
    return of + (effects if _has_effects(axes) else "")
