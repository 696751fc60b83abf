"""Packing fractions by shape as a picture: spheroids and toroids."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from damper3d.reproduce.quantities.packing import Shape, Values
from granulab.campaign.output.figure import BLUE, GREEN, INK, ORANGE, headline
from granulab.campaign.output.statistics import Sample

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Published close packings: family, ratio, fraction, whose.
_PUBLISHED = (
    ("spheroid", 1.0, 0.64, "thesis, below eq. 6.13"),
    ("spheroid", 1.5, 0.71, "Donev et al. 2004 (thesis [219])"),
)
_TITLES = {"spheroid": "spheroids", "toroid": "toroids"}
_RATIOS = {"spheroid": "aspect ratio a/b [-]", "toroid": "hole ratio (a - b)/(a + b) [-]"}


def draw_packings(found: Mapping[Shape, Values], bodies: int) -> "Figure":
    """Close in the periodic cell, shaken down and poured in the enclosure; bars are deviations."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 4.0), layout="constrained")
    headline(figure, "How densely particles pack at random")
    panels = figure.subplots(1, 2, sharey=True, width_ratios=(1.4, 1))
    for axes, family in zip(panels, _TITLES, strict=True):
        own = {shape[1]: one for shape, one in found.items() if shape[0] == family}
        close = {r: one.close[bodies] for r, one in own.items() if bodies in one.close}
        _curve(axes, close, BLUE, "o", f"close: jammed, periodic cell of {bodies}")
        shaken = {ratio: one.shaken for ratio, one in own.items() if one.shaken}
        _curve(axes, shaken, GREEN, "s", "shaken down in 40 mm x 40 mm")
        loose = {ratio: one.loose for ratio, one in own.items() if one.loose}
        _curve(axes, loose, ORANGE, "^", "loose: poured into 40 mm x 40 mm")
        for (kind, ratio, value, whose), marker in zip(_PUBLISHED, "x+", strict=True):
            if kind == family:
                axes.plot(ratio, value, marker, color=INK, ms=9, mew=1.6, ls="none", label=whose)
        axes.set_xlabel(_RATIOS[family])
        axes.set_title(_TITLES[family], loc="left", fontsize=9)
        axes.grid(axis="y", color="#e6e3dc", lw=0.7)
    panels[0].set_ylabel("packing fraction [-]")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper")
    return figure


def _curve(
    axes: "Axes", points: Mapping[float, Sample], colour: str, marker: str, label: str
) -> None:
    ratios = sorted(points)
    means = [points[ratio].mean or 0.0 for ratio in ratios]
    spread = [points[ratio].sd or 0.0 for ratio in ratios]
    axes.errorbar(
        ratios, means, spread, color=colour, marker=marker, ms=4, lw=1.2, elinewidth=0.8,
        capsize=2, label=label,
    )  # fmt: skip
