"""The efficiency over Gamma for several values of each property, as in Fig. 6.13."""

from typing import TYPE_CHECKING

from damper3d.reproduce.properties import STANDARD, VALUES, in_words
from damper3d.reproduce.quantities.curves import curve
from damper3d.reproduce.quantities.sensitivity import Peaks
from damper3d.view.charts import ruled
from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = [BLUE, GREEN, ORANGE, PURPLE]
_TITLES = {
    "density": "density of the particles",
    "modulus": "elastic modulus",
    "restitution": "coefficient of restitution",
    "friction": "coefficient of friction",
}


def sensitivity_panels(found: Peaks) -> "Figure":
    """A panel a property: means with standard deviations over the packings; bars: the optima."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.2, 7.4), layout="constrained")
    headline(figure, "Sensitivity: 358 spheres of 5 mm, fill ratio 0.466, 20 Hz vertical")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, name in zip(panels.flat, VALUES, strict=True):
        _panel(axes, found, name)
    panels[0, 0].annotate(
        "marks: optima with their intervals", (0.99, 0.99), xycoords="axes fraction",
        ha="right", va="top", fontsize=7.5, color=GREY,
    )  # fmt: skip
    for axes in panels[:, 0]:
        axes.set_ylabel("efficiency")
    for axes in panels[-1]:
        axes.set_xlabel("\u0393")
    return figure


def _panel(axes: "Axes", found: Peaks, name: str) -> None:
    ruled(axes)
    values = sorted([*VALUES[name], STANDARD[name]])
    colours = iter(_COLOURS)
    for height, value in enumerate(values):
        standard = value == STANDARD[name]
        key = ("standard", 1.0) if standard else (name, value)
        colour = INK if standard else next(colours)
        if key not in found:
            continue
        own = curve(found[key].rows, "efficiency")
        label = in_words(name, value) + (" (standard)" if standard else "")
        axes.errorbar(own.x, own.mean, own.sd, fmt="o-", ms=3, color=colour, elinewidth=0.8,
                      label=label)  # fmt: skip
        if (peak := found[key].peak) is not None:
            y = 1.07 - 0.025 * height
            axes.plot([peak.low, peak.high], [y, y], color=colour, lw=1)
            axes.plot([peak.gamma], [y], "|", color=colour, ms=7, mew=1.6)
    axes.set_xscale("log")
    ticks = [1, 2, 3, 5, 10, 20, 40]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.set_ylim(0, 1.1)
    axes.set_title(_TITLES[name], loc="left", fontsize=10)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", fontsize=8)
