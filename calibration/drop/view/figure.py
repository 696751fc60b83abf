"""The diagnostic figure of a drop test: track, parabolas, residuals, speeds, frames."""

from typing import TYPE_CHECKING

import numpy as np

from calibration.drop.result import Drop
from calibration.drop.view.annotate import Still, scale_bar, with_sigma
from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, PAPER, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_figure(drop: Drop) -> "Figure":
    """Track, parabolas, residuals, restitution against speed, pictures of the film."""
    from matplotlib.figure import Figure

    pictures = drop.pictures
    figure = Figure(figsize=(11, 11.2 if pictures else 7.6), layout="constrained")
    rows = [2.2, 1, 1.8, 2.4] if pictures else [2.2, 1, 1.8]
    grid = figure.add_gridspec(len(rows), 2, height_ratios=rows)
    above = figure.add_subplot(grid[0, :])
    _heights(above, drop)
    _residuals(figure.add_subplot(grid[1, :], sharex=above), drop)
    _path(figure.add_subplot(grid[2, 0]), drop)
    _against_speed(figure.add_subplot(grid[2, 1]), drop)
    if pictures:
        row = grid[3, :].subgridspec(1, len(pictures))
        for k, still in enumerate(pictures):
            _still(figure.add_subplot(row[k]), still, drop if k == 0 else None)
    e = drop.restitution
    words = f"{drop.name}: restitution {with_sigma(e.value, e.sigma)}"
    if drop.bounces.constant_within_noise is False:
        words += ", not one number for the whole clip"
    headline(figure, words)
    return figure


def _upwards(axes: "Axes", drop: Drop) -> None:
    """Show the plate below, whichever way y counts."""
    if drop.bounces.flights.acceleration[0] > 0:
        axes.invert_yaxis()


def _unit(drop: Drop) -> str:
    return "m" if drop.bounces.track.scale == 1 else "px"


def _heights(axes: "Axes", drop: Drop) -> None:
    found = drop.bounces
    t, y = found.base.clock, found.track.y[found.base.rows]
    axes.plot(t, y, ".", color=GREY, ms=3, label="positions")
    bad = found.flights.weights == 0
    axes.plot(t[bad], y[bad], "x", color=VERMILION, ms=5, label="fit no parabola")
    ends = [t[found.flights.rows[0][0]], *found.contacts[:, 0], t[found.flights.rows[-1][-1]]]
    for k, (centre, c) in enumerate(
        zip(found.flights.centre, found.flights.coefficients, strict=True)
    ):
        s = np.linspace(ends[k], ends[k + 1], 80) - centre
        label = "parabolas" if k == 0 else None
        axes.plot(s + centre, c[0] + c[1] * s + c[2] * s**2 / 2, color=BLUE, lw=1, label=label)
    axes.plot(found.contacts[:, 0], found.plate[:, 0], "o-", color=INK, mfc="none", lw=0.8,
              label="contacts, plate")  # fmt: skip
    axes.set_xlim(ends[0] - 0.05 * np.ptp(ends), ends[-1] + 0.03 * np.ptp(ends))
    axes.set_ylabel(f"y [{_unit(drop)}]")
    axes.legend(loc="upper right", ncols=4)
    _upwards(axes, drop)


def _residuals(axes: "Axes", drop: Drop) -> None:
    found = drop.bounces
    axes.axhline(0, color=GREY, lw=0.6)
    axes.plot(found.base.clock, found.flights.residuals, ".", color=BLUE, ms=3)
    inside = found.flights.residuals[found.flights.weights > 0]
    limit = 1.15 * float(np.abs(inside).max()) or 1.0
    axes.set_ylim(-limit, limit)
    for contact in found.contacts[:, 0]:
        axes.axvline(contact, color=INK, lw=0.5, ls=(0, (2, 2)))
    axes.set_ylabel(f"residual [{_unit(drop)}]")
    rate = "" if drop.rate is None else f", {drop.rate.value:.4g} frames/s"
    axes.set_xlabel(f"time [frames{rate}]")


def _path(axes: "Axes", drop: Drop) -> None:
    """The path in the picture, with a bar of a round length where the scale is known."""
    found = drop.bounces
    x, y = found.track.x[found.base.rows], found.track.y[found.base.rows]
    axes.plot(x, y, "-", color=GREY, lw=0.6)
    flying = np.concatenate(found.flights.rows)
    axes.plot(x[flying], y[flying], ".", color=BLUE, ms=3)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"x [{_unit(drop)}]")
    axes.set_ylabel(f"y [{_unit(drop)}]")
    _upwards(axes, drop)
    if drop.scale is None:
        return
    length, words = scale_bar(0.5 * float(np.ptp(y)) * drop.scale.value)
    bar = length / drop.scale.value
    right = float(np.max(x)) + 0.15 * float(np.ptp(y))
    axes.plot([right, right], [float(np.mean(y)) - bar / 2, float(np.mean(y)) + bar / 2], color=INK)
    axes.annotate(f" {words}", (right, float(np.mean(y))), va="center")


def _still(axes: "Axes", still: Still, drop: Drop | None) -> None:
    """A picture of the film in its own pixels; the first has the scale bar."""
    height, width = still.height, still.width
    axes.imshow(still.image, extent=(-0.5, width - 0.5, height - 0.5, -0.5))
    axes.set_title(f"frame {still.number}", fontsize=9)
    axes.set_xlabel("x [px]")
    if drop is None:
        axes.set_yticklabels([])
        return
    axes.set_ylabel("y [px]")
    if drop.scale is not None:
        length, words = scale_bar(0.5 * width * drop.scale.value)
        left, y = 0.06 * width, 0.08 * height
        axes.plot([left, left + length / drop.scale.value], [y, y], lw=3, color=INK)
        box = {"facecolor": PAPER, "edgecolor": "none", "pad": 1.5, "alpha": 0.8}
        axes.annotate(words, (left, y), (0, 5), textcoords="offset points", bbox=box)


def _against_speed(axes: "Axes", drop: Drop) -> None:
    found = drop.bounces
    known = [drop.speed(k) for k in range(len(found.contacts))]
    speeds = found.speeds[:, 0]
    if drop.scale is not None:
        speeds = np.array([one.value for one in known if one is not None])
    ways = (
        ("velocities", found.velocities, "o", BLUE),
        ("times", found.times, "s", VERMILION),
        ("heights", found.heights, "^", GREEN),
    )
    for name, values, marker, colour in ways:
        seen = np.isfinite(values[:, 0])
        axes.errorbar(speeds[seen], values[seen, 0], values[seen, 1], fmt=marker, color=colour,
                      ms=4, mfc="none", label=f"from {name}", lw=1)  # fmt: skip
    e = found.pooled
    if e.sigma is not None:
        axes.axhspan(e.value - e.sigma, e.value + e.sigma, color=GREY, alpha=0.25, lw=0)
    axes.axhline(e.value, color=GREY, lw=0.8)
    axes.set_xlabel("impact speed [m/s]" if drop.scale else f"impact speed [{_unit(drop)}/frame]")
    axes.set_ylabel("restitution")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
