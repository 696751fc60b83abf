"""The picture of clogging by outlet: mean avalanche, sizes, waiting times, arches."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

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
    headline,
    ruled,
)
from silo2d.measures.clogging.sizes import survival
from silo2d.measures.clogging.study import AtOutlet, by_outlet, laws_of
from silo2d.measures.clogging.waits import EDGES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, INK, GREY
_LAWS = {"exponential": (INK, "-"), "power": (VERMILION, "--")}


def draw(found: Mapping[str, Any], rows: Sequence[dict[str, Any]], title: str) -> "Figure":
    """Four panels; rows: of the runs that the study was made of."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 7.6), layout="constrained")
    headline(figure, title)
    (means, sizes), (waits, arches) = figure.subplots(2, 2)
    outlets = by_outlet(rows)
    _means(means, found)
    for one, colour in zip(outlets, _COLOURS * (1 + len(outlets) // len(_COLOURS)), strict=False):
        label = f"{1e3 * one.outlet:g} mm"
        _sizes(sizes, one, colour, label)
        _waits(waits, one, colour, label)
        _arches(arches, one, colour, label)
    sizes.set(yscale="log", xlabel="size over the mean avalanche s/<s>", xlim=(0, None),
              ylabel="share of larger avalanches")  # fmt: skip
    across = np.linspace(0, max(sizes.get_xlim()[1], 1.0), 50)
    sizes.plot(across, np.exp(-across), color=GREY, lw=0.9, ls=":", label="exp(-s/<s>)")
    waits.set(xscale="log", yscale="log", xlabel="time between successive particles [s]",
              ylabel="probability density [1/s]")  # fmt: skip
    arches.set(xlabel="particles of the arch", ylabel="share of arches", ylim=(0, None))
    for axes in (means, sizes, waits, arches):
        ruled(axes, "both")
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=7)
    return figure


def _means(axes: "Axes", found: Mapping[str, Any]) -> None:
    """Mean avalanche against D/d, with both laws; an arrow where nothing clogged."""
    known = [one for one in found["outlets"] if one["mean_avalanche"] is not None]
    for one in known:
        mean, (low, high) = one["mean_avalanche"], one["mean_avalanche_interval"]
        axes.errorbar(one["outlet_over_diameter"], mean, [[mean - low], [high - mean]], fmt="o",
                      color=BLUE, capsize=3, ms=4)  # fmt: skip
    for one in found["outlets"]:
        if one["mean_avalanche"] is None and one["mean_avalanche_interval"][0] > 0:
            axes.plot(one["outlet_over_diameter"], one["mean_avalanche_interval"][0], "^",
                      color=BLUE, ms=6)  # fmt: skip
    if known:
        ends = [one["outlet_over_diameter"] for one in found["outlets"]]
        across = np.linspace(min(ends) - 0.1, max(ends) + 0.4, 200)
        top = 30 * max(one["mean_avalanche"] for one in known)
        for law in laws_of(dict(found)):
            mean = law.mean(across)
            colour, style = _LAWS[law.name]
            axes.plot(across[mean < top], mean[mean < top], style, color=colour, label=law.name)
    if found["n_particles"]:
        axes.axhline(found["n_particles"], color=GREY, lw=0.7, ls=":")
        axes.annotate("particles of the silo", (0.02, found["n_particles"]), va="bottom",
                      xycoords=("axes fraction", "data"), color=GREY, fontsize=7)  # fmt: skip
    axes.set(yscale="log", xlabel="outlet over the particles' diameter D/d",
             ylabel="mean avalanche <s>, 95 %")  # fmt: skip


def _sizes(axes: "Axes", one: AtOutlet, colour: str, label: str) -> None:
    """Share of larger avalanches, over the mean: a straight line where it is exponential."""
    mean = one.mean.value
    if mean is None:
        return
    size, larger = survival(one.sizes, one.cut)
    shown = larger > 0
    axes.step(size[shown] / mean, larger[shown], where="post", color=colour, label=label, lw=1.0)


def _waits(axes: "Axes", one: AtOutlet, colour: str, label: str) -> None:
    """Density of the waiting times."""
    number = np.sum([row["waits"] for row in one.rows], axis=0)
    shown = number > 0
    if not shown.any():
        return
    density = number / np.diff(EDGES) / number.sum()
    middle = np.sqrt(EDGES[1:] * EDGES[:-1])
    axes.plot(middle[shown], density[shown], "o", ms=2.5, color=colour, label=label)


def _arches(axes: "Axes", one: AtOutlet, colour: str, label: str) -> None:
    """Share of arches by their particles."""
    arches = one.all_of("arch_particles")
    if arches:
        number = np.bincount(arches)
        axes.plot(np.flatnonzero(number), number[number > 0] / len(arches), "o-", ms=3, lw=0.8,
                  color=colour, label=label)  # fmt: skip
