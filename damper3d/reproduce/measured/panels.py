"""Nine panels of the beds that others measured: our points, and theirs as a band or a line."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.case.closed_forms import collect_and_collide
from damper3d.measures.phases.particle_motion import SEEN
from damper3d.reproduce.measured.beds import BEDS, clearance_onset, onset_of_mean
from damper3d.reproduce.measured.quantities import (
    MOVES,
    STILL,
    UNLIKE,
    Found,
    convects,
    found_in,
    published,
    rises,
    unlike,
)
from damper3d.reproduce.quantities.curves import curve
from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, ORANGE, headline, ruled, ticked

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = dict[str, Any]


def measured_panels(rows: list[Row]) -> "Figure":
    """Lift-off, sliding, flight; rolls, suspension, no gravity; effective mass, rise, drops."""
    from matplotlib.figure import Figure

    found = found_in(rows)
    figure = Figure(figsize=(13.4, 10.6), layout="constrained")
    headline(figure, "Shaken and dropped beds: ours (points), and what others measured (grey)")
    draws = (_lifting, _sliding, _doubling, _rolls, _suspended, _weightless, _mass, _rise, _drops)
    for axes, draw in zip(figure.subplots(3, 3).flat, draws, strict=True):
        ruled(axes)
        draw(axes, found)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=7.5)
    return figure


def _points(axes: "Axes", rows: list[Row], value: Any, colour: str, label: str | None = None,
            scale: float = 1.0) -> None:  # fmt: skip
    own = curve(rows, value, "at")
    axes.errorbar([x * scale for x in own.x], own.mean, own.sd, fmt="o-", ms=3, color=colour,
                  elinewidth=0.8, label=label)  # fmt: skip


def _band(axes: "Axes", name: str) -> None:
    low, high = published()[name]
    axes.axvspan(low, high, color=GREY, alpha=0.3, lw=0) if low < high else axes.axvline(
        low, color=GREY, lw=1.2
    )


def _lifting(axes: "Axes", found: Found) -> None:
    _moving(axes, found, {"vertical": BLUE}, "lift_off")
    axes.set_title("lifting off, 15 Hz", loc="left", fontsize=10)


def _sliding(axes: "Axes", found: Found) -> None:
    _moving(axes, found, {"horizontal": ORANGE, "horizontal, rolling": GREEN}, "sliding")
    axes.set_title("sliding, 15 Hz", loc="left", fontsize=10)


def _moving(axes: "Axes", found: Found, beds: dict[str, str], name: str) -> None:
    for bed, colour in beds.items():
        _points(axes, found.get(bed, []), "efficiency_wall_work", colour, bed)
    _band(axes, name)
    axes.axhline(MOVES, color=INK, lw=0.6, ls=":")
    axes.set(yscale="log", ylim=(1e-4, 0.9), xlabel="\u0393", ylabel="efficiency")


def _doubling(axes: "Axes", found: Found) -> None:
    _points(axes, found.get("flying", []), unlike, BLUE)
    _band(axes, "doubling")
    axes.axhline(UNLIKE, color=INK, lw=0.6, ls=":")
    axes.set(ylim=(0, 1), xlabel="\u0393", ylabel="difference of successive cycles")
    axes.set_title("flights that differ, 20 Hz", loc="left", fontsize=10)


def _rolls(axes: "Axes", found: Found) -> None:
    _points(axes, found.get("rolls", []), "phase_measures.circulation", BLUE)
    _band(axes, "convection")
    axes.axhline(SEEN, color=INK, lw=0.6, ls=":")
    axes.set(ylim=(0, 2 * SEEN), xlabel="\u0393", ylabel="part of the displacements in a roll")
    axes.set_title("convection, 30 Hz", loc="left", fontsize=10)


def _suspended(axes: "Axes", found: Found) -> None:
    for frequency, colour in ((80, BLUE), (160, ORANGE)):
        own = curve(found.get(f"suspended, {frequency} Hz", []), convects, "at")
        axes.plot(own.x, own.mean, "o-", ms=3, color=colour, label=f"{frequency} Hz")
    _band(axes, "leidenfrost")
    axes.set(ylim=(-0.05, 1.05), xlabel="\u0393", ylabel="part of the packings")
    axes.set_title("carried by a gas (Leidenfrost effect)", loc="left", fontsize=10)


def _weightless(axes: "Axes", found: Found) -> None:
    middle = onset_of_mean()
    _points(axes, found.get("weightless", []), "efficiency", BLUE, scale=1 / middle)
    parts = np.geomspace(1, 7, 100)
    axes.plot(parts, collect_and_collide(parts), color=GREY, lw=1.2, label="one body")
    axes.axvspan(clearance_onset("loose") / middle, clearance_onset("close") / middle, color=GREY,
                 alpha=0.3, lw=0)  # fmt: skip
    axes.set(xscale="log", ylim=(0, 1.1), xlabel="amplitude over clearance/\u03c0",
             ylabel="efficiency")  # fmt: skip
    ticked(axes, (0.5, 1, 2, 5))
    axes.set_title("without gravity, 20 Hz", loc="left", fontsize=10)


def _mass(axes: "Axes", found: Found) -> None:
    for frequency, marker in ((80, "o"), (160, "s")):
        own = found.get(f"no lid, {frequency} Hz", [])
        for part, colour in (("in_phase", BLUE), ("out_of_phase", ORANGE)):
            column = f"effective_mass.{part}_kg"
            shares = [row | {"share": row[column] / row["mass_kg"]} for row in own]
            mass = curve(shares, "share", "at")
            axes.plot(mass.x, [m if m > 0 else math.nan for m in mass.mean], marker + "-", ms=3,
                      color=colour, lw=0.9,
                      label=f"{part.replace('_', ' ')}, {frequency} Hz")  # fmt: skip
    gammas = np.array([2.0, 20.0])
    for power in (-2, -1):
        line = (gammas / gammas[0]) ** power
        axes.plot(gammas, line, color=GREY, lw=1.2)
        axes.annotate(f"$\\Gamma^{{{power}}}$", (gammas[1], line[1]), fontsize=8, color=GREY)
    axes.set(
        xscale="log", yscale="log", ylim=(3e-3, 3), xlabel="\u0393", ylabel="mass over the bed's"
    )
    ticked(axes, (2, 5, 10, 20))
    axes.set_title("effective mass without a lid", loc="left", fontsize=10)


def _rise(axes: "Axes", found: Found) -> None:
    table = rises(found.get("thin", []))
    for count, colour in zip(BEDS["thin"].counts, (INK, BLUE, GREEN, ORANGE), strict=True):
        own = np.exp([row for row in table if round(math.exp(row[1])) == count])
        if len(own):
            axes.loglog(own[:, 0], own[:, 2] * 1e3, "o", ms=3, color=colour, label=f"{count}")
    speeds = np.array([0.3, 0.7])
    axes.plot(speeds, 18 * speeds, color=GREY, lw=1.2)  # [mm], a slope of 1 beside the points
    axes.annotate("$v$", (speeds[1], 18 * speeds[1]), fontsize=9, color=GREY)
    axes.set(xlabel="peak velocity [m/s]", ylabel="rise of the centre of mass [mm]")
    axes.set_yticks([2, 5, 10, 20], ["2", "5", "10", "20"])
    ticked(axes, (0.3, 0.5, 0.7))
    axes.set_title("rise by number of particles, 50 Hz", loc="left", fontsize=10)


def _drops(axes: "Axes", found: Found) -> None:
    dropped = [name for name, bed in BEDS.items() if bed.dropped]
    for bed, colour in zip(dropped, (BLUE, GREEN, ORANGE), strict=True):
        _points(axes, found.get(bed, []), "rebound", colour, bed)
    _band(axes, "rebound")
    axes.axhline(STILL, color=INK, lw=0.6, ls=":")
    axes.set(yscale="log", xlabel="bed over e0 times the enclosure", ylabel="rebound over drop")
    axes.set_title("dropped cylinder", loc="left", fontsize=10)
