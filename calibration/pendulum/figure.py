"""The diagnostic figure of a pendulum test: swings, residuals, arcs, restitution."""

from typing import TYPE_CHECKING

import numpy as np

from calibration.pendulum.fit import rests, states
from calibration.pendulum.motion import across
from calibration.pendulum.result import Pendulum
from calibration.tracking.film.reader import Picture, is_film, open_film
from calibration.tracking.track import Array
from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, ORANGE, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = (BLUE, VERMILION)
_NAMES = ("left", "right")
_SHOWN = 6  # frames of the film


def draw_figure(found: Pendulum) -> "Figure":
    """Swings, residuals, arcs, restitution, and frames of the film where there is one."""
    from matplotlib.figure import Figure

    pictures = _frames(found)
    figure = Figure(figsize=(11, 10.4 if pictures else 7.8), layout="constrained")
    ratios = [2, 1, 2, 2] if pictures else [2, 1, 2]
    grid = figure.add_gridspec(len(ratios), 2, height_ratios=ratios)
    above = figure.add_subplot(grid[0, :])
    _swings(above, found)
    _residuals(figure.add_subplot(grid[1, :], sharex=above), found)
    _path(figure.add_subplot(grid[2, 0]), found, pictures[0][1] if pictures else None)
    _restitution(figure.add_subplot(grid[2, 1]), found)
    if pictures:
        row = grid[3, :].subgridspec(1, len(pictures), wspace=0.02)
        for k, (number, picture) in enumerate(pictures):
            _frame(figure.add_subplot(row[0, k]), found, number, picture)
    e = found.pooled
    words = f"{found.objects.name}: restitution {e.value:.3f} \N{PLUS-MINUS SIGN} {e.sigma:.3f}"
    if found.planar is False:
        words += ", not planar"
    if found.constant_within_noise is False:
        words += ", not one number for the whole clip"
    headline(figure, words)
    return figure


def _of(found: Pendulum, k: int) -> str:
    return _NAMES[k] if len(found.arcs) == 2 else "positions"


def _swings(axes: "Axes", found: Pendulum) -> None:
    seen, p = found.fitted.seen, found.fitted.parameters
    for k, z in enumerate(seen.z):
        axes.plot(seen.t, z, ".", color=GREY, ms=3)
        bad = found.fitted.weights[k] == 0
        label = "fit no swing" if bad.any() else None
        axes.plot(seen.t[bad], z[bad], "x", color=ORANGE, ms=5, label=label)
        for i, rows in enumerate(seen.rows):
            t = np.linspace(seen.t[rows[0]], seen.t[rows[-1]], 80)
            q, _ = states(p, seen, np.full(len(t), i), t)
            q = q if seen.angles else across(found.fitted.law, q)
            axes.plot(t, rests(p, len(seen.z))[k] + q[k], color=_COLOURS[k], lw=1,
                      label=f"swings, {_of(found, k)}" if i == 0 else None)  # fmt: skip
    for i, time in enumerate(found.times[:, 0]):
        axes.axvline(time, color=INK, lw=0.5, ls=(0, (2, 2)), label=None if i else "contacts")
    ends = seen.t[seen.rows[0][0]], seen.t[seen.rows[-1][-1]]
    axes.set_xlim(ends[0] - 0.08 * (ends[1] - ends[0]), ends[1] + 0.03 * (ends[1] - ends[0]))
    axes.set_ylabel(f"{'arc length' if seen.angles else 'x'} [{found.objects.unit}]")
    axes.margins(y=0.18)
    axes.legend(loc="upper right", ncols=4)


def _residuals(axes: "Axes", found: Pendulum) -> None:
    axes.axhline(0, color=GREY, lw=0.6)
    for k, off in enumerate(found.fitted.residuals):
        axes.plot(found.fitted.seen.t, off, ".", color=_COLOURS[k], ms=3)
    inside = found.fitted.residuals[found.fitted.weights > 0]
    limit = 1.15 * float(np.abs(inside).max()) or 1.0
    axes.set_ylim(-limit, limit)
    for time in found.times[:, 0]:
        axes.axvline(time, color=INK, lw=0.5, ls=(0, (2, 2)))
    axes.set_ylabel(f"residual [{found.objects.unit}]")
    rate = "" if found.objects.rate is None else f", {found.objects.rate:.4g} frames/s"
    axes.set_xlabel(f"time [frames{rate}]")


def _path(axes: "Axes", found: Pendulum, picture: Picture | None) -> None:
    """The path in the picture, and the circles where they are known."""
    if picture is not None:
        axes.imshow(picture[:, :, ::-1], alpha=0.6)
    for k, (arc, x, y) in enumerate(zip(found.arcs, found.objects.x, found.objects.y, strict=True)):
        axes.plot(x, y, ".", color=_COLOURS[k], ms=3, label=_of(found, k))
        if not arc.known:
            continue
        reach = np.abs(np.arcsin(np.clip((x - arc.pivot[0]) / arc.length.value, -1, 1))).max()
        angle = np.linspace(-reach, reach, 100)
        axes.plot(
            arc.pivot[0] + arc.length.value * np.sin(angle),
            arc.pivot[1] + arc.down * arc.length.value * np.cos(angle),
            color=GREEN, lw=1, label="circle" if k == 0 else None,
        )  # fmt: skip
    if picture is None:
        axes.set_aspect("equal", adjustable="datalim")
        if all(arc.down == 1 for arc in found.arcs):
            axes.invert_yaxis()
    axes.set_xlabel(f"x [{found.objects.unit}]")
    axes.set_ylabel(f"y [{found.objects.unit}]")
    axes.legend(loc="upper right", fontsize=8)


def _restitution(axes: "Axes", found: Pendulum) -> None:
    hit, e = found.collisions, found.pooled
    speed, whole = hit.speeds[:, 0], hit.from_heights
    own = np.sqrt(np.diag(hit.covariance))
    axes.errorbar(speed, hit.restitution, own, fmt="o", color=BLUE, ms=4, mfc="none", lw=1,
                  label="speeds at the contact")  # fmt: skip
    axes.errorbar(speed, whole[:, 0], whole[:, 1], fmt="^", color=GREEN, ms=4, mfc="none", lw=1,
                  label="heights of whole swings")  # fmt: skip
    assert e.sigma is not None
    axes.axhspan(e.value - e.sigma, e.value + e.sigma, color=GREY, alpha=0.25, lw=0)
    axes.axhline(e.value, color=GREY, lw=0.8)
    axes.set_xlabel(f"speed of approach [{found.objects.unit}/frame]")
    axes.set_ylabel("restitution")
    axes.margins(y=0.25)
    axes.legend(loc="best", fontsize=8)


def _frames(found: Pendulum) -> list[tuple[int, Picture]]:
    """Frames of the film at contacts and in the swings between; [] for a table."""
    path = found.objects.source
    if path is None or not is_film(path):
        return []
    times: Array = np.sort(np.concatenate([found.fitted.seen.centre, found.times[:, 0]]))
    wanted = {round(found.frame(time)) for time in times[:_SHOWN]}
    return [(frame.number, frame.picture) for frame in open_film(path).some(wanted)]


def _frame(axes: "Axes", found: Pendulum, number: int, picture: Picture) -> None:
    axes.imshow(picture[:, :, ::-1])
    near = np.abs(found.objects.frame - number) <= 8
    here = found.objects.frame == number
    for k, (x, y) in enumerate(zip(found.objects.x, found.objects.y, strict=True)):
        axes.plot(x[near], y[near], "-", color="white", lw=0.8)
        axes.plot(x[here], y[here], "+", color=_COLOURS[k], ms=8)
    axes.set_title(f"frame {number}", fontsize=8)
    axes.set_axis_off()
