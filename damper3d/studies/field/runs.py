"""Runs of a field: the effective mass at each point of a grid, refined where it bends.

Runs are steady, of an even number of counted cycles. A round of refinement halves, on a logarithmic
scale, the intervals of Gamma on both sides of a point that the line through its neighbours misses
by more than its interval and by more than a twentieth of the bed's mass.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.parts import GRAVITY
from damper3d.run.sweep import run_cases
from damper3d.studies.field.table import COLUMNS, Field, Floats
from damper3d.studies.map.grid import Grid, map_cases
from granulab.campaign.output.statistics import mean_sd, quantile
from granulab.campaign.sweeps.sweep import Labelled

Rows = list[dict[str, Any]]

_BENT = 0.05  # of the bed's mass, by which a line may miss a point
STEADY = {"run.steady": True}
_COLUMNS = ("effective_mass.in_phase_kg", "effective_mass.out_of_phase_kg")


@dataclass(frozen=True)
class Points:
    """Effective mass at the points of a field, from its runs that are done (n,)."""

    frequency: Floats
    gamma: Floats
    mass: np.ndarray  # complex, m' - i m'' [kg]
    half_width: np.ndarray  # complex, of m' and of m'', 95 % over packings; NaN for one
    packings: np.ndarray

    @property
    def field(self) -> Field:
        """Their field."""
        return Field(self.frequency, self.gamma, self.mass)

    def rows(self) -> Rows:
        """A row for each point, by COLUMNS."""
        amplitude = self.gamma * GRAVITY / (2 * np.pi * self.frequency) ** 2
        columns = (
            self.frequency, self.gamma, amplitude, self.mass.real, self.half_width.real,
            -self.mass.imag, self.half_width.imag, self.packings,
        )  # fmt: skip
        lists = [[None if x != x else x for x in column.tolist()] for column in columns]
        return [dict(zip(COLUMNS, values, strict=True)) for values in zip(*lists, strict=True)]


def field_cases(
    name: str, changes: dict[str, Any], grid: Grid, points: list[tuple[float, float]] | None = None
) -> list[Labelled]:
    """The cases of a field, or those at some points of frequency [Hz] and Gamma."""
    return map_cases(name, STEADY | changes, grid, points)


def measure(
    name: str, changes: dict[str, Any], grid: Grid, bed_mass: float, *, out: Path, **engine: Any
) -> tuple[Rows, Points]:
    """Run a case over a grid; rows of the runs, and the points.

    Points are added in grid.refine rounds, after whole rounds only, and runs that are finished
    below `out` are not done again. engine: as run_cases takes it.
    """
    rows = run_cases(field_cases(name, changes, grid), out=out, **engine)
    for _ in range(grid.refine):
        added = _to_add(points_of(rows), bed_mass)
        if not added or any(row["state"] == "interrupted" for row in rows):
            break
        rows = rows + run_cases(field_cases(name, changes, grid, added), out=out, **engine)
    return rows, points_of(rows)


def points_of(rows: Rows) -> Points:
    """The points of rows as run_cases gives them."""
    groups: dict[tuple[float, float], list[complex]] = {}
    for row in rows:
        if row["state"] == "done" and all(row.get(name) is not None for name in _COLUMNS):
            at = (row["frequency_hz"], row["gamma"])
            groups.setdefault(at, []).append(complex(row[_COLUMNS[0]], -row[_COLUMNS[1]]))
    known = sorted(groups)
    mass = [np.array(groups[at]) for at in known]
    frequency, gamma = np.array(known, float).reshape(-1, 2).T
    return Points(
        frequency, gamma, np.array([m.mean() for m in mass]),
        np.array([complex(_half(m.real), _half(m.imag)) for m in mass]),
        np.array([len(m) for m in mass]),
    )  # fmt: skip


def _half(values: np.ndarray) -> float:
    found = mean_sd(values.tolist())
    if found.sd is None:
        return math.nan
    return quantile(found.n - 1) * found.sd / math.sqrt(found.n)


def _to_add(points: Points, bed_mass: float) -> list[tuple[float, float]]:
    """Points in the middle of the intervals beside those at which a field bends."""
    added = []
    for f in np.unique(points.frequency).tolist():
        here = np.flatnonzero(points.frequency == f)
        here = here[np.argsort(points.gamma[here])]
        log, mass, half = np.log(points.gamma[here]), points.mass[here], points.half_width[here]
        bent = set()
        for k in range(1, len(here) - 1):
            part = (log[k] - log[k - 1]) / (log[k + 1] - log[k - 1])
            off = mass[k] - (mass[k - 1] * (1 - part) + mass[k + 1] * part)
            for missed, width in ((abs(off.real), half[k].real), (abs(off.imag), half[k].imag)):
                if missed > max(_BENT * bed_mass, 0.0 if width != width else width):
                    bent |= {k - 1, k}
        added += [(f, _digits(math.exp(0.5 * (log[k] + log[k + 1])))) for k in sorted(bent)]
    return added


def _digits(gamma: float) -> float:
    """Three digits, as people read them."""
    return float(f"{gamma:.3g}")


@dataclass(frozen=True)
class Power:
    """m ~ Gamma^exponent over a range of Gamma."""

    exponent: float
    half_width: float  # 95 %
    low: float
    high: float
    points: int


def power_of(gamma: Floats, mass: Floats, bed_mass: float) -> Power | None:
    """Power with which m' falls with Gamma, where it has left the bed's mass; None: too few points.

    Fitted from the first point below nine tenths of the bed's mass down to the least one, or to the
    last above a hundredth of it, by least squares of the logarithms.
    """
    order = np.argsort(gamma)
    gamma, mass = gamma[order], mass[order]
    fallen = np.flatnonzero(mass < 0.9 * bed_mass)
    if not len(fallen):
        return None
    gone = np.flatnonzero(mass[fallen[0] :] < 0.01 * bed_mass)
    end = fallen[0] + (gone[0] if len(gone) else np.argmin(mass[fallen[0] :]) + 1)
    chosen = slice(fallen[0], end)
    x, y = np.log(gamma[chosen]), np.log(mass[chosen])
    if len(x) < 3:
        return None
    slope, intercept = np.polyfit(x, y, 1)
    left = y - slope * x - intercept
    error = math.sqrt(float(left @ left) / (len(x) - 2) / float(((x - x.mean()) ** 2).sum()))
    half = quantile(len(x) - 2) * error
    return Power(float(slope), half, float(gamma[chosen][0]), float(gamma[chosen][-1]), len(x))
