"""Figure of a measurement of the bench: single trials by group, what they give, recorded curves."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from calibration.bench.measure import Quantity, scale_of, title_of, value
from granulab.campaign.output.figure import BLUE, GREY, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_CURVES = 8  # that are drawn; more would hide each other
_MOST_QUANTITIES = 3


def draw(quantities: Sequence[Quantity], method: str) -> "Figure":
    """A panel for each quantity, and one for the curves of the first where it has some."""
    from matplotlib.figure import Figure

    shown = quantities[:_MOST_QUANTITIES]
    panels = len(shown) + bool(quantities[0].curves)
    figure = Figure(figsize=(max(4.6 * panels, 6.4), 4.4), layout="constrained")
    axes = figure.subplots(1, panels, squeeze=False)[0]
    if quantities[0].curves:
        _curves(axes[0], quantities[0])
    for at, one in zip(axes[panels - len(shown) :], shown, strict=True):
        _trials(at, one)
    first = quantities[0]
    words = f"{title_of(first)} {value(first.pooled.all, scale_of(first))}"
    headline(figure, f"{method}: {words}")
    return figure


def _curves(axes: "Axes", one: Quantity) -> None:
    """Draw what was recorded, and over it what was fitted."""
    for k, curve in enumerate(one.curves[:_MOST_CURVES]):
        axes.plot(curve.x, curve.y, ".-", color=BLUE, alpha=0.6, linewidth=0.6, markersize=2)
        for x, y in curve.fits:
            label = "fitted" if k == 0 and x is curve.fits[0][0] else None
            axes.plot(x, y, color=VERMILION, linewidth=1.4, label=label)
    axes.set_xlabel(one.axes[0])
    axes.set_ylabel(one.axes[1])
    if any(curve.fits for curve in one.curves):
        axes.legend()
    if len(one.curves) > _MOST_CURVES:
        axes.set_title(f"the first {_MOST_CURVES} of {len(one.curves)} trials")


def _trials(axes: "Axes", one: Quantity) -> None:
    """Trials of each group next to each other, its mean with sigma, and that of all as a band."""
    scale, groups = scale_of(one), list(one.pooled.groups)
    for k, group in enumerate(groups):
        values = [v.value / scale for _, of, v in one.trials if of == group]
        spread = [k + 0.3 * ((j + 0.5) / len(values) - 0.5) for j in range(len(values))]
        axes.plot(spread, values, "o", color=BLUE, alpha=0.6, markersize=4)
        mean = one.pooled.groups[group]
        error = (mean.sigma or 0.0) / scale
        axes.errorbar(k + 0.28, mean.value / scale, yerr=error, fmt="s", color=GREY, capsize=3)
    whole = one.pooled.all
    middle, half = whole.value / scale, (whole.sigma or 0.0) / scale
    axes.axhspan(middle - half, middle + half, color=VERMILION, alpha=0.2)
    axes.axhline(middle, color=VERMILION)
    axes.set_xticks(range(len(groups)), groups, rotation=30 if len(groups) > 3 else 0)
    axes.set_xlim(-0.6, len(groups) - 0.4)
    axes.set_ylabel(title_of(one))
