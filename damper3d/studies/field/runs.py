"""A field from runs: steady ones on a grid of a map, and more of them where the curves bend."""

import math
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.run.steady import BLOCK, LEAST_BLOCKS
from damper3d.studies.field.table import Field
from damper3d.studies.map.grid import Grid, MapResult, Points, grow, map_cases
from damper3d.studies.map.peaks import DIGITS
from granulab.errors import InputError

# Cheap where the bed rides along, dense about the onset, and on into the falling branch.
FREQUENCIES = (20.0, 40.0, 80.0)  # [Hz]
GAMMAS = (0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 30.0)
PACKINGS = 3
TOLERANCE = 0.05  # of the bed's mass
IN_PHASE, OUT_OF_PHASE = "effective_mass.in_phase_kg", "effective_mass.out_of_phase_kg"


@dataclass(frozen=True)
class Refinement:
    """Points added to a field where it bends.

    most_runs    that may be added to those of the grid
    tolerance    part of the bed's mass by which a straight line may miss a point
    """

    most_runs: int = 0
    tolerance: float = TOLERANCE

    def __post_init__(self) -> None:
        if self.most_runs < 0:
            raise InputError(f"more runs = {self.most_runs}: must be at least 0")
        if not 0 < self.tolerance < 1:
            raise InputError(
                f"within = {self.tolerance:g}: must be above 0 and below 1, such as 0.05"
            )


def steady_changes(changes: dict[str, Any]) -> dict[str, Any]:
    """The changes of a case with steady runs, which count whole blocks of four cycles.

    So an alternation of the bed from cycle to cycle enters in full. InputError where a run would
    end before the least number of blocks.
    """
    return changes | {"run.steady": True}


def check_length(name: str, max_cycles: int, discard: int) -> None:
    """Raise InputError where the most cycles of a run leave an odd number that count."""
    least = discard + BLOCK * LEAST_BLOCKS
    if max_cycles < least:
        raise InputError(
            f"{name}: max_cycles = {max_cycles}: a field counts whole blocks of {BLOCK} cycles, at "
            f"least {LEAST_BLOCKS}; give {least} or more"
        )


def field_of_runs(
    name_or_path: str, changes: dict[str, Any], grid: Grid, refine: Refinement, *, out: Path,
    **engine: Any,
) -> MapResult:  # fmt: skip
    """Run a case over a grid, and further where it bends; as a map, of which field_of is the field.

    Arguments and errors are those of damper3d.studies.map.grid.map_so_far.
    """
    changes = steady_changes(changes)
    for _, case in map_cases(name_or_path, changes, grid)[:1]:
        check_length(case.name, case.settings.run.max_cycles, case.settings.run.discard)
    there = len(grid.points)

    def to_add(result: MapResult) -> Points:
        left = refine.most_runs // grid.packings - (len(result.gamma) - there)
        return bends(field_of(result), refine.tolerance)[: max(left, 0)]

    return grow(name_or_path, changes, grid, to_add, out=out, **engine)


def field_of(result: MapResult, head: tuple[str, ...] = ()) -> Field:
    """The field of a map's points that have a mass; a Field of no points where none has."""
    if not result.packings.any():
        return Field.of([], [], [], math.nan)
    in_phase, out_of_phase = result.mean(IN_PHASE), result.mean(OUT_OF_PHASE)
    known = np.isfinite(in_phase)
    # One bed; means over packings differ in the last digit, and drawn sizes by more.
    mass = float(np.median([row["mass_kg"] for row in result.rows if row["state"] == "done"]))
    return Field(
        result.frequency[known], result.gamma[known], in_phase[known], out_of_phase[known],
        result.scatter(IN_PHASE)[known], result.scatter(OUT_OF_PHASE)[known],
        result.packings[known], mass, head,
    )  # fmt: skip


def bends(field: Field, tolerance: float) -> list[tuple[float, float]]:
    """Frequency and Gamma of the points to compute next, the worst first.

    At each point between two others the straight line of the force (m Gamma) through these is
    compared with it. Where the mass that it gives, m' or m'', misses that of the point by more
    than the point's interval and the tolerance of the bed's mass, the middles (of ln Gamma) of the
    intervals on both sides are added. Gammas are rounded to DIGITS digits: they name runs.
    """
    found: dict[tuple[float, float], float] = {}
    least = tolerance * field.bed_mass
    for frequency in field.frequencies if len(field.gamma) else ():
        own = np.flatnonzero(field.frequency == frequency)
        for low, k, high in zip(own[:-2], own[1:-1], own[2:], strict=True):
            a, gamma, b = field.gamma[[low, k, high]]
            ends, part = field.mass[[low, high]] * [a, b], (gamma - a) / (b - a)
            off = ((1 - part) * ends[0] + part * ends[1]) / gamma - field.mass[k]
            limits = np.fmax(
                [field.in_phase_half_width[k], field.out_of_phase_half_width[k]], least
            )
            misses = float(max(abs(off.real) / limits[0], abs(off.imag) / limits[1]))
            if misses <= 1:
                continue
            for lower, upper in ((a, gamma), (gamma, b)):
                middle = float(f"{math.sqrt(lower * upper):.{DIGITS}g}")
                if lower < middle < upper:
                    point = (float(frequency), middle)
                    found[point] = max(found.get(point, 0.0), misses)
    return sorted(found, key=lambda point: (-found[point], point))


def unlike(result: MapResult) -> float | None:
    """Largest difference of m'' from the work of the enclosure, over the bed's mass.

    m'' = E/(pi V^2), which knows no sampling: 4 M/pi times the efficiency by wall work. With 100
    samples a cycle the 99th and 101st harmonic of impacts look like the first. None: no run.
    """
    if not result.packings.any():
        return None
    mass = result.mean("mass_kg")
    work = 4.0 / math.pi * result.mean("efficiency_wall_work")
    return float(np.nanmax(np.abs(result.mean(OUT_OF_PHASE) / mass - work)))


def states(result: MapResult) -> dict[str, int]:
    """Runs that are done, failed, interrupted, reused, and that did not become steady."""
    counted = Counter(row["state"] for row in result.rows)
    return {
        "runs": len(result.rows),
        **{name: counted[name] for name in ("done", "failed", "interrupted")},
        "reused": sum(bool(row.get("reused")) for row in result.rows),
        "not_steady": sum(row.get("steady") is False for row in result.rows),
    }
