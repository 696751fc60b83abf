"""The diagnostic figure of a triaxial test: markers, load, displacements, rotation, and fits."""

from typing import TYPE_CHECKING

import numpy as np

from calibration.statistics.quantity import plus_minus
from calibration.tracking.film.reader import open_film
from calibration.tracking.track import Array
from calibration.triaxial.result import Triaxial
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    VERMILION,
    headline,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ARROW = 0.15  # of the picture's width: the longest displacement drawn


def draw_figure(found: Triaxial) -> "Figure":
    """First frame with markers and contact, load and displacements in time, and the fits."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 9.5), layout="constrained")
    grid = figure.add_gridspec(2, 6, height_ratios=[1.2, 1])
    _picture(figure.add_subplot(grid[0, :3]), found)
    inner = grid[0, 3:].subgridspec(3, 1)
    load = figure.add_subplot(inner[0])
    load.plot(found.dots.frame, found.load, color=INK)
    load.set_ylabel("load [N]")
    across, along = _components(found)
    moved = figure.add_subplot(inner[1], sharex=load)
    moved.plot(found.dots.frame, across, color=BLUE, label="approach")
    moved.plot(found.dots.frame, along, color=VERMILION, label="slip")
    moved.set_ylabel("displacement [\N{MICRO SIGN}m]")
    moved.legend()
    turn = figure.add_subplot(inner[2], sharex=load)
    turn.plot(found.dots.frame, 1e3 * found.moved.rotation, color=PURPLE)
    turn.set_ylabel("rotation [mrad]")
    turn.set_xlabel("frame")
    angle = found.setting.inclination.value
    for axes in (load, moved, turn):
        for rows in found.fitted.branches:
            first, last = found.dots.frame[rows[[0, -1]]]
            axes.axvspan(first, last, color=GREY, alpha=0.2)
    shown = (
        (np.cos(angle), across, "kn", "approach [\N{MICRO SIGN}m]", "normal force [N]", BLUE),
        (np.sin(angle), along, "kt", "slip [\N{MICRO SIGN}m]", "tangential force [N]", VERMILION),
    )
    for k, (share, x, name, below, beside, colour) in enumerate(shown):
        one = found.values[name]
        axes = figure.add_subplot(grid[1, 2 * k : 2 * k + 2])
        _curve(axes, found, x, share * found.load, 1e6 / one.value, colour)
        axes.set_xlabel(below)
        axes.set_ylabel(beside)
        said = plus_minus(1e-3 * one.value, 1e-3 * (one.sigma or 0.0))
        axes.set_title(f"{name} {said} N/mm", fontsize=9)
    _moment(figure.add_subplot(grid[1, 4:]), found)
    kn, kt = (found.values[name] for name in ("kn", "kt"))
    words = ", ".join(
        f"{name} {plus_minus(1e-3 * one.value, 1e-3 * (one.sigma or 0.0))} N/mm"
        for name, one in (("kn", kn), ("kt", kt))
    )
    headline(figure, f"{found.path.stem}: {words}")
    return figure


def _components(found: Triaxial) -> tuple[Array, Array]:
    """Approach and slip [um]."""
    axes = found.setting.line.axes(found.setting.inclination.value)
    along, across = axes @ np.stack([found.moved.x, found.moved.y])
    factor = 1e6 * found.setting.scale.value
    return factor * across, factor * along


def _picture(axes: "Axes", found: Triaxial) -> None:
    """First frame: contact, markers, and how each moved to the highest load, enlarged."""
    picture = next(open_film(found.path).frames()).picture
    axes.imshow(picture[:, :, ::-1])
    dots, line = found.dots, found.setting.line
    top = int(np.nanargmax(found.load))
    u, v = dots.x[top] - dots.x[0], dots.y[top] - dots.y[0]
    longest = float(np.nanmax(np.hypot(u, v))) or 1.0
    enlarged = _ARROW * picture.shape[1] / longest
    for mine, colour in ((found.moved.upper, VERMILION), (~found.moved.upper, BLUE)):
        axes.plot(dots.x[0, mine], dots.y[0, mine], "+", color=colour)
        axes.quiver(dots.x[0, mine], dots.y[0, mine], u[mine], v[mine], color=colour, angles="xy",
                    scale_units="xy", scale=1 / enlarged, width=0.004)  # fmt: skip
    axes.plot(line.ends[:, 0], line.ends[:, 1], color=ORANGE)
    axes.plot(*line.middle, "o", color=ORANGE, ms=4)
    if found.setting.load_line is not None:
        axes.axvline(found.setting.load_line, color=INK, lw=0.8, ls=(0, (4, 3)))
    axes.set_title(f"displacements at {found.peak:.4g} N, {enlarged:.0f} times", fontsize=9)
    axes.set_xlabel("x [px]")
    axes.set_ylabel("y [px]")


def _curve(
    axes: "Axes", found: Triaxial, x: Array, force: Array, slope: float, colour: str
) -> None:
    """Force against displacement, and a line of the fitted slope through each unloading."""
    axes.plot(x, force, "-", color=GREY, lw=0.6)
    for one in found.fitted.branches:
        axes.plot(x[one], force[one], ".", color=colour, ms=3)
        middle = x[one].mean() - slope * force[one].mean()
        axes.plot(middle + slope * force[one], force[one], color=INK, lw=0.9)


def _moment(axes: "Axes", found: Triaxial) -> None:
    """Contact moment, or the load where it is not known, against the blocks' rotation."""
    lever = found.values.get("eccentricity")
    turn = 1e3 * found.moved.rotation
    y = found.load if lever is None else found.load * lever.value
    axes.plot(turn, y, "-", color=GREY, lw=0.6)
    for one in found.fitted.branches:
        axes.plot(turn[one], y[one], ".", color=GREEN, ms=3)
    axes.set_xlabel("relative rotation, clockwise [mrad]")
    axes.set_ylabel("load [N]" if lever is None else "contact moment [N m]")
    stiff = found.values.get("rotational_stiffness")
    words = "contact moment not known" if lever is None else "contact moment"
    if stiff is not None:
        words = f"rotational stiffness {plus_minus(stiff.value, stiff.sigma)} N m/rad"
    axes.set_title(words, fontsize=9)
