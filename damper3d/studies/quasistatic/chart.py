"""The curves of slow tests as the thesis draws them (Figs 8.16 to 8.19), and what is judged."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.studies.quasistatic.claims import MEASURE
from damper3d.studies.quasistatic.shapes import Scatter, Shape, by_shape, ratio_of, scatter_of
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

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = [INK, BLUE, SKY, GREEN, ORANGE, VERMILION, PURPLE, GREY]
_AXES = {
    "compress": ("displacement of the table, z [mm]", "rise of the force on the base [N]"),
    "shear": ("displacement of the top half, x [mm]", "rise of the force on the bottom half [N]"),
}
_NAMES = {
    "prolate": ("spheroids", "aspect ratio"),
    "toroid": ("circular toroids", "hole ratio"),
    "": ("other shapes", ""),
}


def draw(rows: Sequence[dict[str, Any]]) -> "Figure":
    """A panel a family with means and deviations over the packings; what is judged below it."""
    from matplotlib.figure import Figure

    found = by_shape(rows)
    groups = _groups(found)
    first = next(iter(next(iter(groups.values())))).rows[0]
    figure = Figure(figsize=(5.1 * max(len(groups), 1), 7.4), layout="constrained")
    kind = "Compression" if first["test"] == "compress" else "Shear"
    headline(
        figure,
        f"{kind} of {first['n_particles']} particles in two half containers, pre-load "
        f"{first['preload_n']:g} N",
    )
    panels = figure.subplots(2, len(groups), squeeze=False, height_ratios=[2, 1], sharey="row")
    scatter = scatter_of(found, first["test"], MEASURE[first["test"]])
    for column, (family, shapes) in enumerate(groups.items()):
        _curves(panels[0, column], shapes, family, first["test"])
        _measured(panels[1, column], shapes, family, first["test"], scatter)
    panels[1, 0].set_ylim(bottom=0.0)  # of the row, which shares it: after all that it shows
    panels[0, 0].set_ylabel(_AXES[first["test"]][1])
    secant = f"secant stiffness\nto {1e3 * first['at_m']:g} mm [N/mm]"
    panels[1, 0].set_ylabel(secant if first["test"] == "compress" else "mean rise [N]")
    return figure


def _groups(shapes: dict[str, Shape]) -> dict[str, list[Shape]]:
    """Spheroids (with oblates), toroids and what else there is."""
    groups: dict[str, list[Shape]] = {}
    for name, shape in shapes.items():
        kind = name.partition(":")[0]
        family = {"prolate": "prolate", "oblate": "prolate", "toroid": "toroid"}.get(kind, "")
        groups.setdefault(family, []).append(shape)
    return groups


def _curves(axes: "Axes", shapes: list[Shape], family: str, test: str) -> None:
    ruled(axes)
    for number, shape in enumerate(shapes):
        colour = _COLOURS[number % len(_COLOURS)]
        way, mean, spread = shape.curve()
        label = shape.name if family == "" else f"{ratio_of(shape.name):g}"
        axes.plot(1e3 * way, mean, color=colour, label=label)
        if np.isfinite(spread).all():
            axes.fill_between(1e3 * way, mean - spread, mean + spread, color=colour, alpha=0.12,
                              linewidth=0)  # fmt: skip
    axes.set_title(_NAMES[family][0], loc="left", fontsize=10)
    axes.set_xlabel(_AXES[test][0])
    axes.set_xlim(left=0.0)
    axes.locator_params(axis="x", nbins=5)
    axes.legend(loc="upper left", title=_NAMES[family][1] or None, fontsize=8, title_fontsize=8)


def _measured(
    axes: "Axes", shapes: list[Shape], family: str, test: str, scatter: Scatter | None
) -> None:
    """Measure that the statements judge, with the 95 % interval of the mean."""
    ruled(axes)
    scale = 1e-3 if test == "compress" else 1.0
    for number, shape in enumerate(shapes):
        sample = shape.sample(MEASURE[test])
        x = number if family == "" else ratio_of(shape.name)
        width = None if scatter is None else scatter.half_width(sample)
        axes.errorbar(
            [x], [scale * (sample.mean or 0.0)], None if width is None else [scale * width],
            fmt="o", color=_COLOURS[number % len(_COLOURS)], capsize=3, elinewidth=0.9,
        )  # fmt: skip
        axes.update_datalim([(x, 0.0)])  # the margin above the points is a part of their height
    if family == "":
        axes.set_xticks(range(len(shapes)), [shape.name for shape in shapes])
    else:
        axes.set_xlabel(_NAMES[family][1])
