"""Diagnostic figure of a field: vectors over the picture, sigma, fractions of a pixel."""

from typing import TYPE_CHECKING

import numpy as np

from calibration.piv.field import Reason
from calibration.piv.pictures import grey_levels, read_picture
from calibration.piv.result import Displacement
from granulab.campaign.output.figure import BLUE, GREY, INK, VERMILION, headline, round_length

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw(result: Displacement) -> "Figure":
    """Vectors over the first picture, sigma, and fractions of a pixel."""
    from matplotlib.figure import Figure

    tall = np.ptp(result.field.y) + result.field.window
    wide = np.ptp(result.field.x) + result.field.window
    figure = Figure(figsize=(11.0, float(np.clip(1.7 + 6.3 * tall / wide, 5.5, 11.0))),
                    layout="constrained")  # fmt: skip
    columns = figure.add_gridspec(1, 2, width_ratios=[2, 1])
    _vectors(figure.add_subplot(columns[0]), result)
    right = columns[1].subgridspec(2, 1, height_ratios=[1.8, 1])
    _sigma(figure, figure.add_subplot(right[0]), result)
    _fractions(figure.add_subplot(right[1]), result)
    field = result.field
    known = f"{field.valid.sum()} of {(field.reason != Reason.MASKED).sum()} vectors valid"
    middle = np.median(field.sigma[field.valid])
    headline(figure, f"{result.first.name} to {result.second.name}: {known}, "
                     f"sigma {middle:.3f} px, median ({field.method})")  # fmt: skip
    return figure


def _vectors(axes: "Axes", result: Displacement) -> None:
    """Vectors over the first picture, each from its window's middle; the key has a round length."""
    field = result.field
    grey = grey_levels(read_picture(result.first), str(result.first))
    low, high = np.percentile(grey, (1, 99))
    axes.imshow(grey, cmap="gray", vmin=low - 1.5 * (high - low), vmax=high, zorder=0)
    step = float(max(np.ptp(field.x), np.ptp(field.y))) / max(max(field.x.shape) - 1, 1)
    longest = float(np.percentile(np.hypot(field.u, field.v)[field.valid], 95)) or 1.0
    scale = longest / (1.3 * max(step, 1.0))  # pixels of displacement per pixel drawn
    replaced = ~field.valid & (field.reason != Reason.MASKED)
    for which, colour, words in (
        (field.valid, BLUE, "measured"),
        (replaced, VERMILION, "replaced"),
    ):
        if which.any():
            axes.quiver(field.x[which], field.y[which], field.u[which], field.v[which],
                        color=colour, angles="xy", scale_units="xy", scale=scale, width=0.0022,
                        label=words)  # fmt: skip
    axes.set_xlabel("x [px]")
    axes.set_ylabel("y [px]")
    key = round_length(longest * result.factor)
    axes.set_title(_key(axes, key / result.factor / scale, key, result.unit), fontsize=9)
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.07), ncols=2)
    if result.scale is not None:
        _second_axes(axes, result.scale)


def _key(axes: "Axes", length: float, value: float, unit: str) -> str:
    """Draw an arrow of a round length above the picture; the words for it."""
    right = axes.get_xlim()[1]
    y = axes.get_ylim()[1] - 0.02 * abs(np.diff(axes.get_ylim())[0])
    axes.annotate("", (right, y), (right - length, y), annotation_clip=False,
                  arrowprops={"arrowstyle": "->", "color": INK, "lw": 1.2,
                              "shrinkA": 0, "shrinkB": 0})  # fmt: skip
    return f"from the middle of each window; the arrow on the right is {value:g} {unit}"


def _second_axes(axes: "Axes", scale: float) -> None:
    """Lengths on the upper and the right side."""
    both = (lambda px: 1e3 * scale * px, lambda mm: mm / (1e3 * scale))
    axes.secondary_yaxis("right", functions=both).set_ylabel("y [mm]")


def _sigma(figure: "Figure", axes: "Axes", result: Displacement) -> None:
    field = result.field
    half = field.window / 2
    near = (field.x.min() - half, field.x.max() + half, field.y.max() + half, field.y.min() - half)
    top = np.percentile(field.sigma[field.valid], 98)
    image = axes.imshow(field.sigma, extent=near, vmin=0, vmax=top, cmap="viridis")
    axes.set_facecolor("#dddddd")
    figure.colorbar(image, ax=axes, label="sigma of u and v [px] (grey: not measured)",
                    location="bottom", aspect=30, extend="max")  # fmt: skip
    axes.set_ylabel("y [px]")


def _fractions(axes: "Axes", result: Displacement) -> None:
    """Peaks at 0 and 1 in a field that varies by pixels show that vectors lock to whole ones."""
    field = result.field
    bins = np.linspace(0, 1, 21).tolist()
    for values, colour, name in ((field.u, BLUE, "u"), (field.v, VERMILION, "v")):
        axes.hist(values[field.valid] % 1, bins, histtype="step", color=colour, label=name)
    axes.set_xlim(0, 1)
    axes.set_xlabel("fraction of a pixel of u and v")
    axes.set_ylabel("vectors")
    axes.axhline(field.valid.sum() / 20, color=GREY, lw=0.8, ls=":", label="evenly spread")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
