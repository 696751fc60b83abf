"""Heat maps: an estimate over two numbers that were varied, with its interval in each cell."""

from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.output.figure import INK, VERMILION
from granulab.campaign.output.layout import with_half_width
from granulab.campaign.sweeps.report.axes import Axis, key_of
from granulab.campaign.sweeps.report.comparison import Combination, Comparison
from granulab.campaign.sweeps.report.quantities import Ending, Estimate, Number, heading, name_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_NONE = "#dedbd4"  # of a cell whose runs have no value


def draw_heat_map(
    panel: "Axes", what: Number | Ending, across: Axis, up: Axis, comparison: Comparison
) -> None:
    """Estimates in cells, with their intervals in words; brighter is better.

    A cell without a value says how its runs ended; where the study has none it is left white.
    """
    from matplotlib.patches import Rectangle

    found, words, best = heat_map(what, across, up, comparison)
    less = isinstance(what, Ending) or what.better == "less"
    colours: dict[str, Any] = {"cmap": "viridis_r" if less else "viridis"}
    if isinstance(what, Ending):
        colours |= {"vmin": 0.0, "vmax": 1.0}
    shape = found.shape
    image = panel.pcolormesh(
        np.arange(shape[1] + 1) - 0.5, np.arange(shape[0] + 1) - 0.5,
        np.ma.masked_invalid(found), edgecolors="white", linewidth=0.8, **colours,
    )  # fmt: skip
    assert panel.figure is not None
    side = "less" if less else "more" if isinstance(what, Number) and what.better else ""
    bar = panel.figure.colorbar(image, ax=panel, pad=0.02)
    bar.set_label(heading(what) + (f"; {side} is better" if side else ""))
    _write_cells(panel, image, found, words)
    if best is not None:
        row, column = best
        panel.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, fill=False, ec=VERMILION, lw=2))
    panel.set_xlabel(across.heading)
    panel.set_ylabel(up.heading)
    for scale, axis, set_ticks in (
        (panel.xaxis, across, panel.set_xticks), (panel.yaxis, up, panel.set_yticks),
    ):  # fmt: skip
        set_ticks(range(len(axis.values)), axis.texts)
        every = -(-len(axis.values) // 24)
        for k, label in enumerate(scale.get_ticklabels()):
            label.set_visible(k % every == 0)
    panel.tick_params(length=0)
    if len("".join(across.texts)) > 60:
        panel.tick_params(axis="x", rotation=60)


def heat_map(
    what: Number | Ending, across: Axis, up: Axis, comparison: Comparison
) -> tuple[np.ndarray, dict[tuple[int, int], str], tuple[int, int] | None]:
    """Means (rows, columns) of an estimate, NaN where there is none; words; the best cell.

    words: of each cell that the study has: the estimate, or how its runs ended.
    """
    shape = len(up.values), len(across.values)
    found, words = np.full(shape, np.nan), {}
    for one in comparison.combinations:
        row, column = (
            axis.values.index(key_of(one.labels[axis.varied.column])) for axis in (up, across)
        )
        own = one.estimates[name_of(what)]
        found[row, column] = np.nan if own.mean is None else own.mean
        words[row, column] = cell_words(what, own, one, comparison)
    if isinstance(what, Ending) or not what.better or not np.isfinite(found).any():
        return found, words, None
    at = int((np.nanargmax if what.better == "more" else np.nanargmin)(found))
    return found, words, divmod(at, shape[1])


def cell_words(
    what: Number | Ending, own: Estimate, one: Combination, comparison: Comparison
) -> str:
    """Words in a cell: the estimate with its half width, and of how many runs where some lack."""
    if own.mean is None:
        ends = Counter(comparison.quantities.ended(row) or "none" for row in one.rows)
        return "\n".join(f"{n} {word}" for word, n in ends.most_common(2))
    if isinstance(what, Ending):
        return f"{own.n} of {own.of}\n{100 * (own.low or 0):.0f} to {100 * (own.high or 0):.0f} %"
    number = with_half_width(own.mean, own.half_width)
    lack = f"\n{own.n} of {len(one.rows)}" if own.n < len(one.rows) else ""
    return number.replace(" ± ", "\n±") + lack


def _write_cells(
    panel: "Axes", image: Any, found: np.ndarray, words: dict[tuple[int, int], str]
) -> None:
    """Put the words into the cells, as large as they have room for; nothing where too small."""
    from matplotlib.patches import Rectangle

    longest = max((len(line) for text in words.values() for line in text.split("\n")), default=1)
    assert panel.figure is not None
    box = panel.get_window_extent()
    wide, high = (72.0 / panel.figure.dpi * side for side in (box.width, box.height))
    size = min(8.0, wide / found.shape[1] / (0.65 * longest), high / found.shape[0] / 2.6)
    for (row, column), text in words.items():
        none = np.isnan(found[row, column])
        if none:
            panel.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, fc=_NONE, ec="white",
                                      hatch="///", lw=0.8, zorder=1.5))  # fmt: skip
        if size < 4.0:
            continue
        red, green, blue, _ = image.cmap(image.norm(0.0 if none else found[row, column]))
        dark = not none and 0.3 * red + 0.59 * green + 0.11 * blue < 0.5
        panel.text(column, row, text, ha="center", va="center", fontsize=size,
                   color="white" if dark else INK, linespacing=1.1)  # fmt: skip
