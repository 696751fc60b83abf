"""Histories within the cycle as the thesis draws them, and when the bouncing bed collides."""

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.case.case import GRAVITY
from damper3d.measures.efficiency import reference_energy
from damper3d.reproduce.cycles import BOUNCING, FLUIDISED
from damper3d.reproduce.quantities.cycles import ideal_since, readings
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    VERMILION,
    headline,
    ruled,
    ticked,
)
from granulab.campaign.output.layout import done

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = dict[str, Any]
Key = tuple[str, float]

_COLOURS = [BLUE, GREEN, ORANGE, VERMILION, PURPLE]


def cycle_panels(rows: Sequence[Row]) -> "Figure":
    """Dissipation (Figs 6.7, 6.16) and velocities (6.10, 6.18), of the first packing there is."""
    from matplotlib.figure import Figure

    first: dict[Key, Row] = {}
    for row in done(rows):
        if row.get("cycle.dissipated"):
            first.setdefault((row["orientation"], float(row["gamma"])), row)
    figure = Figure(figsize=(11.4, 7.2), layout="constrained")
    headline(figure, "Within the cycle: 358 spheres of 5 mm, fill ratio 0.466, 40 Hz")
    (bouncing, both, late), (far, up, lying) = figure.subplots(2, 3)
    _energies(bouncing, first, [("vertical", g) for g in BOUNCING], "vertical (Fig. 6.7)")
    _energies(both, first, [("vertical", 3.0), ("horizontal", 3.0)], "\u0393 = 3 (Fig. 6.16)")
    _meetings(late, rows)
    ends = [("vertical", gamma) for gamma in (BOUNCING[0], BOUNCING[-1])]
    _velocities(far, first, ends, "vertical (Fig. 6.10)")
    _velocities(up, first, [("vertical", g) for g in FLUIDISED], "vertical (Fig. 6.18a)")
    _velocities(lying, first, [("horizontal", g) for g in FLUIDISED], "horizontal (Fig. 6.18b)")
    return figure


def _part(row: Row) -> np.ndarray:
    return np.linspace(0.0, 2.0, len(row["cycle.dissipated"]))


def _speed(row: Row) -> float:
    """V = Gamma g/omega [m/s]."""
    return row["gamma"] * GRAVITY / (2 * math.pi * row["frequency_hz"])


def _energies(axes: "Axes", first: dict[Key, Row], keys: Iterable[Key], title: str) -> None:
    for colour, (key, row) in zip(_COLOURS, _there(first, keys), strict=False):
        energy = np.array(row["cycle.dissipated"]) / reference_energy(_speed(row), row["mass_kg"])
        label = f"\u0393 = {key[1]:g}" if "Fig. 6.7" in title else key[0]
        axes.plot(_part(row), energy, color=colour, label=label)
    axes.set(ylabel="dissipated / 4 (\u0393g/\u03c9)\u00b2 M", xlim=(0, 2))
    _finish(axes, title)


def _velocities(axes: "Axes", first: dict[Key, Row], keys: Iterable[Key], title: str) -> None:
    part = np.linspace(0, 2, 201)
    axes.plot(part, np.cos(2 * np.pi * part), color=INK, lw=1, ls=(0, (4, 2)), label="enclosure")
    for colour, (key, row) in zip(_COLOURS, _there(first, keys), strict=False):
        bed = np.array(row["cycle.bed_velocity"]) / _speed(row)
        axes.plot(_part(row), bed, color=colour, label=f"\u0393 = {key[1]:g}")
    axes.set(ylabel="mean velocity / (\u0393g/\u03c9)", xlim=(0, 2))
    axes.set_ylim(top=1.75)
    _finish(axes, title)


def _there(first: dict[Key, Row], keys: Iterable[Key]) -> list[tuple[Key, Row]]:
    return [(key, first[key]) for key in keys if key in first]


def _finish(axes: "Axes", title: str) -> None:
    ruled(axes)
    axes.set_xlabel("cycles")
    axes.set_title(title, loc="left", fontsize=10)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", fontsize=8, ncols=2, columnspacing=1, handlelength=1.6)


def _meetings(axes: "Axes", rows: Sequence[Row]) -> None:
    """Start and end of the steps against Gamma, compared with the ideal bouncing bed."""
    gammas = np.geomspace(BOUNCING[0], BOUNCING[-1], 60)
    ideal = [(g, since) for g in gammas.tolist() if (since := ideal_since(g)) is not None]
    if ideal:
        axes.plot(*zip(*ideal, strict=True), color=GREY, lw=1, ls=(0, (4, 2)),
                  label="ideal bed meets the wall")  # fmt: skip
    found = readings(rows)
    found = found[(found["orientation"] == "vertical") & found["gamma"].isin(BOUNCING)]
    if len(found) and "since" in found:
        found = found.dropna(subset="since").sort_values("gamma")
        ends = found["since"] + found["duration"]
        axes.plot(found["gamma"], found["since"], "o-", color=BLUE, ms=4, label="step starts")
        axes.plot(found["gamma"], ends, "o-", color=VERMILION, ms=4, label="step ends")
    axes.set_xscale("log")
    ticked(axes, BOUNCING)
    axes.set_ylim(0, 0.8)
    axes.set_ylabel("cycles since the wall left was fastest")
    ruled(axes)
    axes.set_xlabel("\u0393")
    axes.set_title("bouncing bed, means of packings", loc="left", fontsize=10)
    axes.legend(loc="upper right", fontsize=8)
