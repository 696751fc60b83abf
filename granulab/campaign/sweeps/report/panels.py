"""Panels of a sweep's picture: curves, dots and scatter, with intervals."""

import itertools
import math
import operator
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    ruled,
)
from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import rank_correlation
from granulab.campaign.sweeps.report.axes import Axis, key_of
from granulab.campaign.sweeps.report.comparison import Combination, Comparison
from granulab.campaign.sweeps.report.quantities import (
    Ending,
    Estimate,
    Number,
    heading,
    name_of,
    pooled,
)
from granulab.campaign.sweeps.report.words import short

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, INK, GREY)
_EDGE = "#f1eee8"
_MARKS = ("x", "v", "s", "d", "*")  # of runs without a value, by how they ended
_STRIP = 0.065  # part of a panel that the marks of one kind take
_BESIDE = 0.05  # of the distance between two positions, by which series are moved apart
_MANY, _LEVEL = 8, 24  # values, and letters of words, that an axis names in one line


class Series(NamedTuple):
    """Estimates along an axis, of the combinations of one group.

    x, found    position and estimate of each value that has combinations
    """

    label: str
    colour: str
    x: list[float]
    found: list[Estimate]


def series_of(
    what: Number | Ending, axis: Axis, combinations: Sequence[Combination], label: str = "",
    colour: str = BLUE,
) -> Series:  # fmt: skip
    """The estimates at each value of an axis, over all combinations that have it."""
    groups: dict[float, list[Combination]] = {}
    for one in combinations:
        groups.setdefault(axis.at(one.labels), []).append(one)
    x = sorted(groups)
    return Series(label, colour, x, [pooled(what, [c.rows for c in groups[at]]) for at in x])


def groups_by(axis: Axis | None, combinations: Sequence[Combination]) -> list[Any]:
    """Label, colour and combinations for each value of an axis; all in one without it."""
    if axis is None:
        return [("", BLUE, list(combinations))]
    column = axis.varied.column
    return [
        (text, COLOURS[k % len(COLOURS)],
         [one for one in combinations if key_of(one.labels[column]) == value])
        for k, (value, text) in enumerate(zip(axis.values, axis.texts, strict=True))
    ]  # fmt: skip


def draw_curves(
    panel: "Axes", what: Number | Ending, axis: Axis, comparison: Comparison, by: Axis | None = None
) -> None:
    """Estimates with their intervals along an axis, each run as a dot behind them."""
    groups = groups_by(by, comparison.combinations)
    for k, (label, colour, combinations) in enumerate(groups):
        aside = _aside(axis, k, len(groups))
        series = series_of(what, axis, combinations, label, colour)
        _draw_runs(panel, what, axis, combinations, colour, aside)
        _draw_estimates(panel, series, "D" if axis.kind == "word" else "o-", aside)
    _along(panel, axis)
    _across(panel, what, axis, comparison)
    mark_lacking(panel, what, axis, comparison)


def _aside(axis: Axis, k: int, n: int) -> Callable[[float], float]:
    """Moves the positions of series k of n a little, so that their bars stand side by side."""
    x = [math.log(at) for at in axis.positions] if axis.is_logarithmic else axis.positions
    closest = min((b - a for a, b in itertools.pairwise(x)), default=1.0)
    by = _BESIDE * closest * (k - (n - 1) / 2)
    return (lambda at: at * math.exp(by)) if axis.is_logarithmic else (lambda at: at + by)


def draw_dots(
    panel: "Axes", what: Number | Ending, axis: Axis, comparison: Comparison, by: Axis | None = None
) -> None:
    """Estimates with their intervals, a line for each word."""
    groups = groups_by(by, comparison.combinations)
    for k, (label, colour, combinations) in enumerate(groups):
        by_so_much = 0.6 * ((k + 0.5) / len(groups) - 0.5)
        series = series_of(what, axis, combinations, label, colour)
        aside = partial(operator.add, by_so_much)
        _draw_runs(panel, what, axis, combinations, colour, aside, lying=True)
        _draw_estimates(panel, series, "D", aside, lying=True)
    panel.set_yticks(range(len(axis.values)), [short(text) for text in axis.texts])
    panel.set_ylim(len(axis.values) - 0.5, -0.5)
    panel.set_ylabel(axis.heading)
    panel.set_xlabel(heading(what))
    panel.set_xlim(_limits(what, comparison, panel.get_xlim()))
    ruled(panel, "x")
    mark_lacking(panel, what, axis, comparison, lying=True)


def draw_scatter(panel: "Axes", what: Number | Ending, axis: Axis, comparison: Comparison) -> None:
    """Runs over a number that was drawn, and the rank correlation of the combinations' means."""
    x, y = _points(what, axis, comparison.combinations)
    panel.plot(x, y, "o", color=BLUE, ms=4, alpha=0.55, mew=0)
    name = name_of(what)
    known = [one for one in comparison.combinations if one.estimates[name].mean is not None]
    found = rank_correlation(
        [axis.at(one.labels) for one in known], [one.estimates[name].mean or 0.0 for one in known]
    )
    if found is not None:
        words = f"{found.value:+.2f} [{found.low:+.2f}, {found.high:+.2f}]".replace("-", "\u2212")
        panel.set_title(f"ρ {words}, n = {len(known)}", loc="right", fontsize=8)
    panel.set_xlabel(axis.heading)
    _across(panel, what, axis, comparison)
    mark_lacking(panel, what, axis, comparison)


def mark_lacking(
    panel: "Axes", what: Number | Ending, axis: Axis, comparison: Comparison, lying: bool = False
) -> None:
    """Mark the runs without a value in a strip at the edge, by how they ended, with their number.

    A share counts every run that is done; those that are not are marked there too.
    """
    all_kinds = enumerate(lacking_of(what, axis, comparison).items())
    kinds = {k: (kind, found) for k, (kind, found) in all_kinds if found}
    if not kinds:
        return
    strip = _STRIP * (len(kinds) + 0.3)
    scale = panel.xaxis if lying else panel.yaxis
    ends = tuple(scale.get_view_interval())
    low = ends[1] - (ends[1] - ends[0]) / (1.0 - strip)
    scale.set_ticks([tick for tick in scale.get_ticklocs() if ends[0] <= tick <= ends[1]])
    (panel.set_xlim if lying else panel.set_ylim)(low, ends[1])
    (panel.axvspan if lying else panel.axhspan)(low, ends[0], color=_EDGE, lw=0, zorder=2.4)
    over = panel.get_yaxis_transform() if lying else panel.get_xaxis_transform()
    for line, (k, (kind, found)) in enumerate(kinds.items()):
        at, place = sorted(found), _STRIP * (line + 0.65)
        where = [(place, x) if lying else (x, place) for x in at]
        colour = COLOURS[1 + k % (len(COLOURS) - 1)]
        panel.plot(*zip(*where, strict=True), transform=over, ls="none", color=colour, ms=4.5,
                   mew=1.4, marker=_MARKS[k % len(_MARKS)], label=kind, zorder=4)  # fmt: skip
        for x, point in zip(at, where, strict=True):
            if found[x] > 1:
                panel.annotate(str(found[x]), point, (4, -2.5), xycoords=over, fontsize=7,
                               textcoords="offset points", color=colour, zorder=4)  # fmt: skip


def lacking_of(
    what: Number | Ending, axis: Axis, comparison: Comparison
) -> dict[str, Counter[float]]:
    """Numbers of runs without a value by how they ended and by position; alike in all panels."""
    kinds = dict.fromkeys(map(comparison.quantities.ended, comparison.rows))
    counts: dict[str, Counter[float]] = {kind: Counter() for kind in [*kinds, "no value"] if kind}
    for one in comparison.combinations:
        for row in one.rows:
            if row["state"] != "done" or (isinstance(what, Number) and what.of(row) is None):
                counts[comparison.quantities.ended(row) or "no value"][axis.at(one.labels)] += 1
    return counts


def _points(
    what: Number | Ending, axis: Axis, combinations: Sequence[Combination]
) -> tuple[list[float], list[float]]:
    """Positions and values of single runs; of shares 0 or 1."""
    x, y = [], []
    for one in combinations:
        for row in done(one.rows):
            value = float(what.is_one(row)) if isinstance(what, Ending) else what.of(row)
            if value is not None:
                x.append(axis.at(one.labels))
                y.append(value)
    return x, y


def _draw_runs(
    panel: "Axes", what: Number | Ending, axis: Axis, combinations: Sequence[Combination],
    colour: str, aside: Callable[[float], float], lying: bool = False,
) -> None:  # fmt: skip
    """Single runs, faint; a share has none."""
    if isinstance(what, Ending):
        return
    x, y = _points(what, axis, combinations)
    place = (y, [aside(at) for at in x]) if lying else ([aside(at) for at in x], y)
    panel.plot(*place, "o", color=colour, ms=3, alpha=0.3, mew=0)


def _draw_estimates(
    panel: "Axes", series: Series, style: str, aside: Callable[[float], float], lying: bool = False
) -> None:
    """Means, their intervals where they are known; a line breaks where there is no mean."""
    mean = np.array([np.nan if e.mean is None else e.mean for e in series.found])
    ends = np.array(
        [[np.nan if end is None else end for end in (e.low, e.high)] for e in series.found]
    ).T
    bars, at = np.abs(np.nan_to_num(ends - mean)), [aside(x) for x in series.x]
    options: dict[str, Any] = {
        "fmt": style, "color": series.colour, "ms": 4.5, "capsize": 2.5, "lw": 1.2,
        "elinewidth": 1.1, "label": series.label or None,
    }  # fmt: skip
    if lying:
        panel.errorbar(mean, at, xerr=bars, **options)
    else:
        panel.errorbar(at, mean, yerr=bars, **options)


def _along(panel: "Axes", axis: Axis) -> None:
    """The scale of an axis, with its values named where they are few."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    panel.set_xlabel(axis.heading)
    if axis.kind == "word":
        texts = [short(text) for text in axis.texts]
        lean = 0 if len("".join(texts)) < _LEVEL else 45
        panel.set_xticks(range(len(texts)), texts, rotation=lean, ha="right" if lean else "center")
        panel.set_xlim(-0.5, len(texts) - 0.5)
        return
    if axis.is_logarithmic:
        panel.set_xscale("log")
    if len(axis.values) <= _MANY:
        panel.xaxis.set_major_locator(FixedLocator(axis.positions))
        panel.xaxis.set_minor_locator(NullLocator())
        panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}"))


def _across(panel: "Axes", what: Number | Ending, axis: Axis, comparison: Comparison) -> None:
    panel.set_ylabel(heading(what))
    panel.set_ylim(_limits(what, comparison, panel.get_ylim()))
    ruled(panel)


def _limits(
    what: Number | Ending, comparison: Comparison, drawn: tuple[float, float]
) -> tuple[float, float]:
    """Ends of a scale: as drawn, but no farther from the values than these are from each other.

    The interval of two runs may be ten times as wide; it leaves the panel.
    """
    if isinstance(what, Ending):
        return -0.03, 1.03
    values = [value for row in done(comparison.rows) if (value := what.of(row)) is not None]
    if not values or min(values) == max(values):
        return drawn
    low, high = min(values), max(values)
    least = low - (high - low) if low < 0 else max(low - (high - low), 0.0)
    return max(drawn[0], least), min(drawn[1], high + (high - low))
