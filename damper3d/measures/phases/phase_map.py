"""Motional phases over the plane of frequency and Gamma, alone or over an efficiency map."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.measures.phases.criteria import PHASES
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_EDGE, _HALO = "#1a1a1a", "#ffffff"
_CELL = 1.5  # a lone frequency or Gamma takes this factor to either side


def draw_phase_map(
    axes: "Axes", rows: Iterable[Mapping[str, Any]], orientation: str, *, areas: bool = False
) -> None:
    """A marker a point, of the phase that most of its packings show; ringed where not all do.

    `rows` have frequency_hz, gamma and phase, one a run; those without a phase are left out.
    `areas` fills the cell about each point as well, for a map of phases alone (thesis, Figs 6.2,
    6.3); without, the markers lie over what the axes hold (Figs 6.4, 6.5). Labels for a legend are
    set, in the order of PHASES. Raises InputError for a phase that the orientation has not.
    """
    points = phases_of_points(rows)
    looks = PHASES[orientation]
    for name, _ in points.values():
        if name not in looks:
            raise InputError(f"phase {name!r}: none of {orientation}; there are {', '.join(looks)}")
    if areas and points:
        _fill(axes, points, orientation)
    for name, look in looks.items():
        here = [(*point, shared) for point, (phase, shared) in points.items() if phase == name]
        if not here:
            continue
        frequency, gamma, shared = np.array(here).T
        axes.scatter(
            frequency, gamma, s=55, marker=look.marker, color=look.colour, edgecolors=_EDGE,
            linewidths=0.8, label=look.label, zorder=4, clip_on=False,
        )  # fmt: skip
        unsure = shared < 1.0
        axes.scatter(
            frequency[unsure], gamma[unsure], s=130, marker="o", facecolors="none",
            edgecolors=_EDGE if areas else _HALO, linewidths=0.9, zorder=4, clip_on=False,
        )  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel="frequency [Hz]", ylabel="Γ [-]")


def phases_of_points(
    rows: Iterable[Mapping[str, Any]],
) -> dict[tuple[float, float], tuple[str, float]]:
    """Commonest phase of each (frequency, Gamma), and the share of its runs that show it.

    Of equally common ones, that of the first run.
    """
    found: dict[tuple[float, float], list[str]] = {}
    for row in rows:
        if row.get("phase"):
            point = (float(row["frequency_hz"]), float(row["gamma"]))
            found.setdefault(point, []).append(row["phase"])
    return {
        point: (
            Counter(names).most_common(1)[0][0],
            Counter(names).most_common(1)[0][1] / len(names),
        )
        for point, names in sorted(found.items())
    }


def _fill(
    axes: "Axes", points: Mapping[tuple[float, float], tuple[str, float]], orientation: str
) -> None:
    """The cells about the points, from half-way to their neighbours in the logarithm."""
    from matplotlib.colors import ListedColormap

    names = list(PHASES[orientation])
    for frequency, (left, right) in _cells(f for f, _ in points).items():
        column = [gamma for f, gamma in points if f == frequency]
        cells = _cells(column)
        edges = [cells[gamma][0] for gamma in column] + [cells[column[-1]][1]]
        index = [[names.index(points[frequency, gamma][0])] for gamma in column]
        axes.pcolormesh(
            [left, right], edges, index, alpha=0.55, vmin=-0.5, vmax=len(names) - 0.5,
            cmap=ListedColormap([look.colour for look in PHASES[orientation].values()]), zorder=1,
        )  # fmt: skip


def _cells(values: Iterable[float]) -> dict[float, tuple[float, float]]:
    """Ends of the cell of each value, ascending."""
    rising = sorted(set(values))
    inner = [math.sqrt(a * b) for a, b in pairwise(rising)]
    first = rising[0] ** 2 / inner[0] if inner else rising[0] / _CELL
    last = rising[-1] ** 2 / inner[-1] if inner else rising[-1] * _CELL
    ends = [first, *inner, last]
    return {value: (ends[k], ends[k + 1]) for k, value in enumerate(rising)}
