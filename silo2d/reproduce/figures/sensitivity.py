"""The five panels of the sensitivity table: time against each parameter."""

from typing import TYPE_CHECKING, Any

from granulab.campaign.output.figure import BLUE, ORANGE, VERMILION
from silo2d.reproduce.published import Point
from silo2d.reproduce.quantities.trends import LOGARITHMIC

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from silo2d.reproduce.quantities.trends import Series

_LABELS = {
    "kn": "kn [N/mm], kt/kn and gamma_n/omega_0 held",
    "kt": "kt [N/mm]",
    "mu": "mu [-]",
    "gamma_n": "gamma_n [1/s]",
    "gamma_t": "gamma_t [1/s]",
}
_COLOURS = {"Table 4": BLUE, "implied": ORANGE}
_PAIRS: dict[str, tuple[str, dict[str, Any]]] = {
    "both": ("", {"fmt": "o-"}),
    "particle": (", particles alone", {"fmt": "^--", "mfc": "white", "lw": 0.9}),
    "wall": (", walls alone", {"fmt": "v:", "mfc": "white", "lw": 0.9}),
}


def sensitivity_panels(
    series: "dict[tuple[str, str], dict[str, Series]]", published: dict[str, list[Point]]
) -> "Figure":
    """Published points, and ours with their standard deviations, from each baseline."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 6.2), layout="constrained")
    panels = figure.subplots(2, 3, sharey=True)
    handles: dict[str, Any] = {}
    for axes, (parameter, points) in zip(panels.flat, published.items(), strict=False):
        _scale(axes, parameter, [point.value for point in points])
        axes.set_xlabel(_LABELS[parameter])
        axes.plot([p.value for p in points], [p.time_s for p in points], "D", color=VERMILION,
                  ms=5, label="SPOLY", zorder=3)  # fmt: skip
        for (name, pairs), one in series.items():
            for own in one.values() if name == parameter else ():
                _draw_series(axes, own, pairs)
        handles |= dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
    for axes in panels[:, 0]:
        axes.set_ylabel("discharge time of A4 [s]")
    panels[-1, -1].axis("off")
    panels[-1, -1].legend(handles.values(), handles.keys(), loc="center", title="mean and sd")
    return figure


def _scale(axes: "Axes", parameter: str, values: list[float]) -> None:
    """Ticks at the published values, as the paper spaces them."""
    if parameter in LOGARITHMIC:
        axes.set_xscale("log")
    elif parameter == "gamma_t":
        axes.set_xscale("symlog", linthresh=3)
    axes.set_xticks(values, [f"{value:g}" for value in values])
    axes.minorticks_off()
    axes.grid(axis="y", color="#e6e3dc", lw=0.7)
    axes.set_axisbelow(True)


def _draw_series(axes: "Axes", own: "Series", pairs: str) -> None:
    words, style = _PAIRS[pairs]
    samples = [(value, own.time(value)) for value in own.values]
    known = [(value, s.mean, s.sd or 0) for value, s in samples if s.mean is not None]
    if known:
        x, y, bars = zip(*known, strict=True)
        axes.errorbar(x, y, bars, color=_COLOURS[own.baseline], capsize=3, ms=4.5,
                      label=f"ours, {own.baseline}{words}", **style)  # fmt: skip
