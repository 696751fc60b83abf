"""The causes of the half V as a picture: rises by variant and reading, and both curves."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from damper3d.reproduce.causes import (
    AT,
    FIRST,
    PRINTED,
    RATIOS,
    READINGS,
    Rise,
    optima,
    read_rise,
    rises,
    rows_at,
)
from damper3d.reproduce.panels import Row
from damper3d.studies.map.grid import GAMMAS, MapResult
from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, ORANGE, VERMILION, ruled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_causes(rows: Sequence[Row]) -> "Figure":
    """The rise of each variant and reading, and the curves of the first variant."""
    from matplotlib.figure import Figure

    risen = rises(optima(rows))
    here = {variant: rise for (variant, where), rise in risen.items() if where == AT}
    read = {name: read_rise(rows, reading, AT) for name, reading in READINGS.items()}
    lines = [(name, rise, BLUE) for name, rise in here.items()]
    lines += [(name, rise, ORANGE) for name, rise in read.items() if rise is not None]
    figure = Figure(figsize=(11.0, 1.6 + 0.25 * max(len(lines), 8)), layout="constrained")
    left, right = figure.subplots(1, 2)
    _rises(left, lines)
    _curves(right, rows)
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper left", ncols=3)
    return figure


def _rises(axes: "Axes", lines: Sequence[tuple[str, Rise, str]]) -> None:
    axes.axvline(100 * PRINTED, color=GREEN, lw=1.2, label="thesis")
    for k, (_, rise, colour) in enumerate(lines):
        centre = math.expm1(rise.value)
        wide = rise.half_width() if rise.freedom else 0.0
        ends = [abs(math.expm1(rise.value + side * wide) - centre) for side in (-1, 1)]
        axes.errorbar(
            100 * centre, k, xerr=[[100 * ends[0]], [100 * ends[1]]], fmt="o", color=colour, ms=4.5,
            capsize=2,
        )  # fmt: skip
    axes.errorbar([], [], xerr=[], fmt="o", color=BLUE, ms=4.5, label="variants, 95 %")
    axes.errorbar([], [], xerr=[], fmt="o", color=ORANGE, ms=4.5, label="readings, 95 %")
    axes.set_yticks(range(len(lines)), [name for name, _, _ in lines])
    axes.set_ylim(max(len(lines), 1) - 0.5, -0.5)
    axes.set_xlabel("rise of the onset from spheres to prolates of 1.5 [%]")
    ruled(axes, "x")


def _curves(axes: "Axes", rows: Sequence[Row]) -> None:
    """Mean curves of the first variant: small points are ours, rings the thesis's Gammas."""
    for ratio, colour in zip(RATIOS, (INK, VERMILION), strict=True):
        curve = MapResult.of(rows_at(rows, FIRST, AT, ratio))
        known = np.isfinite(curve.efficiency)
        gamma, eta = curve.gamma[known], curve.efficiency[known]
        axes.plot(gamma, eta, ".-", color=colour, lw=1, ms=5,
                  label="spheres" if ratio == 1 else f"prolates of {ratio:g}")  # fmt: skip
        printed = [g in GAMMAS for g in gamma]
        axes.plot(gamma[printed], eta[printed], "o", color=colour, mfc="none", ms=9)
    axes.plot([], [], "o", color=GREY, mfc="none", ms=9, label="Gammas of the thesis")
    axes.set(xlabel="Gamma [-]", ylabel=f"eta at {AT[0]:g} Hz, {AT[1]} [-]")
    axes.legend(loc="lower right", fontsize="small")
    ruled(axes)
