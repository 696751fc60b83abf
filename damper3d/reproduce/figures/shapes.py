"""The table of shapes as a picture: onsets by ratio and sphericity, curves, properties."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.reproduce.panels import ORIENTATIONS, Row
from damper3d.reproduce.quantities.optima import Optimum
from damper3d.reproduce.quantities.properties import VALUES, in_words
from damper3d.reproduce.quantities.shapes import (
    BOUNCING,
    GRIDDED,
    Found,
    Line,
    Shape,
    by_sphericity,
    onsets,
    particle_text,
    rows_of,
    values_of,
)
from damper3d.reproduce.shapes import COMPARED, COMPARED_AT, FLUIDISED, MODELS, SENSITIVE
from damper3d.studies.map.grid import MapResult
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
    ticked,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

_COLOURS = [INK, BLUE, GREEN, ORANGE, PURPLE, VERMILION, SKY]
_LOOKS = {"vertical": (BLUE, "o", "-"), "horizontal": (VERMILION, "s", "--")}
_FAMILIES = {"spheroid": ("aspect ratio [-]", 1.0), "toroid": ("hole ratio [-]", 0.0)}
_CURVES: dict[str, list[Shape]] = {
    "prolate": [("spheroid", r) for r in (1.0, 1.25, 1.5, 2.0, 2.5, 3.0)],
    "toroid": [("toroid", r) for r in (0.0, 0.05, 0.11, 0.2, 0.27, 0.33)],
    "oblate": [("spheroid", r) for r in (1.0, 0.9, 0.85, 0.8, 0.75, 0.7)],
    "gridded oblate": [("spheroid", 1.0), *((GRIDDED, r) for r in (0.9, 0.85, 0.8, 0.75, 0.7))],
}
_TICKS = 1, 2, 3, 5, 10, 20, 30, 50


def draw_shapes(rows: Sequence[Row], found: Found) -> "Figure":
    """Figs 8.9-8.14, 8.20, 8.21, 8.23, 8.25, E.1, E.3, E.5, each as far as there are runs."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14.0, 31.0), layout="constrained")
    headline(figure, "Particles of unlike shape, the same volume (thesis, chapter 8)")
    heights = [1.15, 1.15, 1.1, 3.9, 3.9, 1.1]
    parts = figure.subfigures(6, 1, squeeze=False, height_ratios=heights)[:, 0]
    _onsets(parts[0], found)
    _bouncing_curves(parts[1], rows, found)
    panels = parts[2].subplots(1, 4)
    _by_sphericity(panels[:2], found)
    _treatments(panels[2:], rows, found)
    for part, orientation in zip(parts[3:5], ORIENTATIONS, strict=True):
        _fluidised_curves(part, rows, orientation)
    _properties(parts[5], rows)
    return figure


def _onsets(part: "SubFigure", found: Found) -> None:
    """Figs 8.11 and 8.12: bars are brackets, lines eq. 6.11 with the shape's close packing."""
    panels = part.subplots(1, 4)
    for k, (family, frequency) in enumerate((g, f) for g in _FAMILIES for f in BOUNCING):
        axes = panels[k]
        ruled(axes)
        for orientation in ORIENTATIONS:
            own = onsets(found, family, Line((family, 1.0), orientation, frequency))
            colour, marker, _ = _LOOKS[orientation]
            gammas = np.array([one.gamma for one in own.values()])
            brackets = np.array([one.mean.bracket for one in own.values()]).reshape(-1, 2)
            bars = np.abs(brackets.T - gammas)
            axes.errorbar(list(own), gammas, bars, color=colour, marker=marker, ms=4, lw=1.2,
                          elinewidth=0.7, capsize=2, label=orientation)  # fmt: skip
            made = onsets(found, GRIDDED, Line((family, 1.0), orientation, frequency))
            if made and family == "spheroid":
                axes.plot(list(made), [one.gamma for one in made.values()], marker, color=colour,
                          mfc="none", ms=5, label=f"{orientation}, nine sub-spheres")  # fmt: skip
            if orientation == "vertical":
                _predicted(axes, own)
        name, sphere = _FAMILIES[family]
        axes.axvline(sphere, color=GREY, lw=0.6, zorder=0)
        axes.set(xlabel=name, ylim=(0, None))
        axes.set_title(f"onset, {family}s, {frequency:g} Hz", loc="left", fontsize=9)
    panels[0].set_ylabel("Γ at the best efficiency [-]")
    _legend(panels[0], "lower right")


def _predicted(axes: "Axes", own: dict[float, Optimum]) -> None:
    """Eq. 6.11 with the close packing of each shape that has one, and with that of spheres."""
    for name, style in (("close", "-"), ("spheres", ":")):
        known = [(ratio, g) for ratio, one in own.items() if (g := one.predicted(name))]
        label = f"eq. 6.11, {'own packing' if name == 'close' else 'packed as spheres'}"
        axes.plot(
            [x for x, _ in known], [y for _, y in known], style, color=GREY, lw=1, label=label
        )


def _bouncing_curves(part: "SubFigure", rows: Sequence[Row], found: Found) -> None:
    """Figs 8.9 and 8.10: the sphere and the prolates of 1.5 and 3."""
    panels = part.subplots(1, 4, sharey=True)
    for k, (frequency, orientation) in enumerate((f, o) for f in BOUNCING for o in ORIENTATIONS):
        axes = panels[k]
        for colour, ratio in zip((INK, BLUE, VERMILION), (1.0, 1.5, 3.0), strict=True):
            line = Line(("spheroid", ratio), orientation, frequency)
            _curve(axes, rows_of(rows, line), colour, f"{ratio:g}")
            if (one := found.get(line)) is not None:
                axes.plot(one.gamma, one.mean.efficiency, "o", mfc="none", mec=colour, ms=8)
        _with_gamma(axes, f"aspect ratios, {frequency:g} Hz {orientation}")
    panels[0].set_ylabel("efficiency [-]")
    panels[0].set_ylim(0, None)
    _legend(panels[0], "upper left")


def _by_sphericity(panels: "Sequence[Axes]", found: Found) -> None:
    """Figs 8.13 and 8.14."""
    for axes, frequency in zip(panels, BOUNCING, strict=True):
        ruled(axes)
        for orientation in ORIENTATIONS:
            pairs = by_sphericity(found, Line(("spheroid", 1.0), orientation, frequency))
            colour, marker, _ = _LOOKS[orientation]
            positions, times = [x for x, _ in pairs], [y for _, y in pairs]
            axes.plot(positions, times, marker, color=colour, ms=4, label=orientation)
        axes.axhline(1, color=GREY, lw=0.6, zorder=0)
        axes.invert_xaxis()
        axes.set(xlabel="sphericity [-]", ylim=(0, None))
        axes.set_title(f"prolates and toroids, {frequency:g} Hz", loc="left", fontsize=9)
    panels[0].set_ylabel("onset over the sphere's [-]")
    _legend(panels[0], "lower left")


def _treatments(panels: "Sequence[Axes]", rows: Sequence[Row], found: Found) -> None:
    """Return what the multi-contact model does to eta and to the onset."""
    for axes, shape in zip(panels, COMPARED, strict=True):
        for colour, model in zip((INK, BLUE, VERMILION), MODELS, strict=True):
            line = Line(shape, "vertical", COMPARED_AT, model)
            _curve(axes, rows_of(rows, line), colour, model)
            if (one := found.get(line)) is not None:
                axes.plot(one.gamma, one.mean.efficiency, "o", mfc="none", mec=colour, ms=8)
        _with_gamma(axes, f"{particle_text(shape)}, {COMPARED_AT:g} Hz vertical, contacts by")
        axes.set_ylim(0, None)
        axes.set_ylabel("efficiency [-]")
        _legend(axes, "upper left")


def _fluidised_curves(part: "SubFigure", rows: Sequence[Row], orientation: str) -> None:
    """Figs 8.21, 8.23, 8.25, or E.1, E.3, E.5: a row a family, a column a frequency."""
    part.suptitle(orientation, x=0.01, ha="left", fontsize=10)
    panels = part.subplots(len(_CURVES), len(FLUIDISED), sharey=True, sharex=True)
    for own, (name, shapes) in zip(panels, _CURVES.items(), strict=True):
        for axes, frequency in zip(own, FLUIDISED, strict=True):
            for colour, shape in zip(_COLOURS, shapes, strict=False):
                line = Line(shape, orientation, frequency)
                _curve(axes, rows_of(rows, line), colour, f"{shape[1]:g}")
            _with_gamma(axes, f"{name}s, {frequency:g} Hz")
        own[0].set_ylabel("efficiency [-]")
        own[0].set_ylim(0, None)
        _legend(own[-1], "upper right")
    for axes in panels[:-1].flat:
        axes.set_xlabel("")


def _properties(part: "SubFigure", rows: Sequence[Row]) -> None:
    """Fig. 8.20."""
    panels = part.subplots(1, len(VALUES), sharey=True)
    for axes, name in zip(panels, VALUES, strict=True):
        ruled(axes)
        for colour, (value, etas) in zip(_COLOURS, values_of(rows, name).items(), strict=False):
            axes.plot(list(etas), list(etas.values()), "o-", ms=3, color=colour, lw=1.1,
                      label=in_words(name, value))  # fmt: skip
        axes.set(xlabel="aspect ratio [-]")
        axes.set_title(name, loc="left", fontsize=9)
        _legend(axes, "best")
    frequency, gamma = SENSITIVE
    panels[0].set_ylabel(f"efficiency [-]\n{frequency:g} Hz, Γ {gamma:g}, horizontal")


def _curve(axes: "Axes", rows: Sequence[Row], colour: str, label: str) -> None:
    """Means over the packings with 95 % intervals."""
    result = MapResult.of(rows)
    known = np.isfinite(result.efficiency)
    if known.any():
        axes.errorbar(
            result.gamma[known], result.efficiency[known], np.nan_to_num(result.half_width[known]),
            color=colour, marker="o", ms=2.5, lw=1.1, elinewidth=0.5, label=label,
        )  # fmt: skip


def _with_gamma(axes: "Axes", title: str) -> None:
    ruled(axes)
    axes.set(xscale="log", xlabel="Γ [-]")
    ticked(axes, _TICKS, axes.get_xlim())
    axes.set_title(title, loc="left", fontsize=9)


def _legend(axes: "Axes", corner: Any) -> None:
    """Return where there is anything to name."""
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc=corner, fontsize=7)
