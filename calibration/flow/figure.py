"""Diagnostic figure of a discharge film: lines over pictures of the film, curve, velocities."""

from typing import TYPE_CHECKING

import numpy as np

from calibration.flow.layers import Profile
from calibration.flow.result import Flow
from calibration.tracking.film.reader import Picture
from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, PAPER, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PANELS = 5
_PANEL = 2.0  # inches across one


def draw(flow: Flow) -> "Figure":
    """Lines of the layers over the film's pictures, curve, depths of the layers, velocities."""
    shown = [p for p in flow.profiles if np.isfinite(p.lines).any()] or flow.profiles[:1]
    steps = np.linspace(0, len(shown) - 1, min(_PANELS, len(shown))).round().astype(int)
    panels = [shown[k] for k in dict.fromkeys(steps.tolist())]
    return _figure(flow, panels, _pictures(flow, panels))


def _pictures(flow: Flow, panels: list[Profile]) -> list[Picture]:
    """The film's frame that is nearest to each profile."""
    wanted = [round(flow.opening.value + p.time * flow.rate) for p in panels]
    found = {frame.number: frame.picture for frame in flow.film.some({0, *wanted})}
    return [found[min(found, key=lambda n: abs(n - number))] for number in wanted]


def _figure(flow: Flow, panels: list[Profile], pictures: list[Picture]) -> "Figure":
    from matplotlib.figure import Figure

    height, width = pictures[0].shape[:2]
    tall = _PANEL * min(height / width, height / flow.silo.width) + 0.8
    figure = Figure(figsize=(11, tall + 3.6), layout="constrained")
    grid = figure.add_gridspec(2, 1, height_ratios=[tall, 3.2])
    above = grid[0].subgridspec(1, max(len(panels), 3))
    below = grid[1].subgridspec(1, 3, width_ratios=[1.5, 1, 1])
    for k, (one, picture) in enumerate(zip(panels, pictures, strict=True)):
        _panel(figure.add_subplot(above[0, k]), flow, one, picture, first=k == 0)
    _curve(figure.add_subplot(below[0]), flow)
    _depth(figure.add_subplot(below[1]), flow)
    _velocity(figure.add_subplot(below[2]), flow)
    headline(figure, f"{flow.name}: {flow.end}")
    return figure


def _panel(axes: "Axes", flow: Flow, one: Profile, picture: Picture, first: bool) -> None:
    from matplotlib import patheffects

    height, width = picture.shape[:2]
    (x0, y1), (x1, y0) = flow.silo.metres(np.array([[0.0, 0.0], [width, height]]))
    axes.imshow(picture[:, :, ::-1], extent=(x0, x1, y0, y1), interpolation="antialiased")
    x = (flow.edges[:-1] + flow.edges[1:]) / 2
    halo = [patheffects.withStroke(linewidth=2.6, foreground=PAPER)]
    for k, line in enumerate(one.lines):
        axes.errorbar(x, line, one.sigma[k], fmt="o-", ms=1.5, lw=1.1, elinewidth=0.8,
                      color=(BLUE, VERMILION)[k % 2], path_effects=halo)  # fmt: skip
    side = flow.silo.width * flow.silo.scale.value
    axes.plot([0, side], [0, 0], color=GREEN, lw=0.8, ls=(0, (3, 3)))
    axes.set(xlim=(-0.06 * side, 1.06 * side), aspect="equal")
    axes.set_title(f"{one.time:.3g} s", fontsize=9)
    axes.set_xlabel(f"x [{flow.silo.unit}]")
    if first:
        axes.set_ylabel(f"height above the outlet [{flow.silo.unit}]")
    else:
        axes.tick_params(labelleft=False)


def _curve(axes: "Axes", flow: Flow) -> None:
    curve = flow.curve
    if curve.sigma is not None:
        axes.fill_between(curve.time, curve.area - curve.sigma, curve.area + curve.sigma,
                          color=BLUE, alpha=0.2, lw=0)  # fmt: skip
        axes.plot(curve.time, curve.area, color=BLUE, label="by area of the material")
    axes.plot(curve.time, curve.tracers, color=INK, lw=1, ls=(0, (4, 2)), label="by tracers")
    axes.axvline(0, color=GREY, lw=0.8)
    if flow.discharge is not None:
        d, sigma = flow.discharge.value, flow.discharge.sigma or 0.0
        axes.axvspan(d - sigma, d + sigma, color=GREEN, alpha=0.3, lw=0, label="last particle")
    axes.set_ylim(bottom=0)
    axes.set_xlabel("time since the opening [s]")
    axes.set_ylabel("share that remains in the silo")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, fontsize=8, borderaxespad=0.2)


def _depth(axes: "Axes", flow: Flow) -> None:
    depth, sigma = flow.depths()
    time, ends = [p.time for p in flow.profiles], (0, len(flow.bands) - 1)
    for k in range(len(flow.bands)):
        shade = k / max(len(flow.bands) - 1, 1)
        axes.errorbar(time, depth[:, k], sigma[:, k], fmt="o-", ms=3, lw=1,
                      color=(0.1 + 0.75 * shade, 0.35 + 0.4 * shade, 0.7),
                      label=f"layer {k + 1}" if k in ends else None)  # fmt: skip
    axes.set_xlabel("time since the opening [s]")
    axes.set_ylabel(f"depth of the layers' V [{flow.silo.unit}]")
    if len(flow.bands) > 1:
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, fontsize=8, borderaxespad=0.2)


def _velocity(axes: "Axes", flow: Flow) -> None:
    if not flow.velocities:
        axes.set_axis_off()
        return
    one = flow.velocities[0]
    speed = np.hypot(one.vx, one.vy)
    arrows = axes.quiver(one.x, one.y, one.vx, one.vy, speed, cmap="viridis", angles="xy")
    axes.set_aspect("equal")
    axes.figure.colorbar(arrows, ax=axes, label=f"speed [{flow.silo.unit}/s]")
    axes.set_title(f"mean from {one.start:.3g} to {one.end:.3g} s", fontsize=9)
    axes.set_xlabel(f"x [{flow.silo.unit}]")
    axes.set_ylabel(f"height above the outlet [{flow.silo.unit}]")
