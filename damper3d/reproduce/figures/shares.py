"""The shares as the thesis draws them (Figs 6.28 and 6.29): over Gamma, a line a particle size."""

from typing import TYPE_CHECKING, Any

from damper3d.reproduce.quantities.curves import curve
from damper3d.reproduce.quantities.shares import COUNTS, Landmarks, of_size, quantities
from damper3d.view.charts import ruled
from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, ORANGE, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = {3: BLUE, 4: GREEN, 5: VERMILION, 6: ORANGE}
_STYLES: dict[str, dict[str, Any]] = {
    "budget": {"ls": "-", "marker": "o", "ms": 3},
    "thesis's count": {"ls": (0, (2, 1.5)), "lw": 0.9},
}
_LINES_OF = 5  # mm: the size whose peaks are drawn, as in the thesis's Fig. 6.8
_WORDS = {"fluidisation": "fluidisation\noptimum", "bouncing bed": "bouncing-bed\nonset"}


def share_panels(
    rows: list[dict[str, Any]], marks: Landmarks, frequencies: tuple[float, ...]
) -> "Figure":
    """A row of panels a share, a column a frequency; bars are standard deviations."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    figure = Figure(figsize=(9.6, 9.2), layout="constrained")
    headline(figure, "Shares of what is dissipated: vertical, fill ratio 0.466")
    names = list(quantities("budget"))
    panels = figure.subplots(len(names), len(frequencies), sharex=True, sharey=True, squeeze=False)
    for number, (axes_row, quantity) in enumerate(zip(panels, names, strict=True)):
        for axes, frequency in zip(axes_row, frequencies, strict=True):
            _panel(axes, rows, quantity, frequency)
            _landmarks(axes, marks, frequency, named=number == 0)
        axes_row[0].set_ylabel(f"{quantity} share [%]")
    for axes, frequency in zip(panels[0], frequencies, strict=True):
        axes.set_title(f"{frequency:g} Hz", loc="left", fontsize=10, pad=24)
    for axes in panels[-1]:
        axes.set_xlabel("\u0393")
    lines = [Line2D([], [], color=c, marker="o", ms=3) for c in _COLOURS.values()]
    lines += [Line2D([], [], color=INK, **_STYLES[count]) for count in COUNTS]
    words = [f"{size} mm" for size in _COLOURS] + list(COUNTS)
    figure.legend(lines, words, loc="outside lower center", ncols=len(words))
    return figure


def _panel(axes: "Axes", rows: list[dict[str, Any]], quantity: str, frequency: float) -> None:
    ruled(axes)
    for size, colour in _COLOURS.items():
        for count in COUNTS:
            own = curve(of_size(rows, size, frequency), quantities(count)[quantity])
            if own.x:
                shares = [100 * share for share in own.mean]
                bars = [100 * sd for sd in own.sd] if count == "budget" else None
                axes.errorbar(own.x, shares, bars, color=colour, elinewidth=0.8, **_STYLES[count])
    axes.set_xscale("log")
    ticks = [1, 2, 3, 5, 10, 20, 40, 100]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.set_ylim(0, 100)


def _landmarks(axes: "Axes", marks: Landmarks, frequency: float, named: bool) -> None:
    """The peaks of eta of 5 mm spheres, where these runs have them."""
    for name, gamma in marks.of(_LINES_OF, frequency).items():
        axes.axvline(gamma, color=GREY, lw=0.9, ls=(0, (5, 3)), zorder=0)
        if named:
            axes.annotate(
                _WORDS[name], (gamma, 1), (0, 2), xycoords=("data", "axes fraction"),
                textcoords="offset points", ha="center", va="bottom", fontsize=7.5, color=GREY,
            )  # fmt: skip
