"""The steps of a dissipation history: where in the cycle the bed collides, and how long it takes.

A history is the mean of pairs of counted cycles, since successive cycles may differ; it is taken as
periodic. A step is a stretch in which the power is above its mean. Parts of the cycle are counted
from when the enclosure, which moves as sin(2 pi p) (eq. 6.2), is fastest one way.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damper3d.case.case import GRAVITY

Floats = NDArray[np.float64]

# The spheres of a bed do not collide all at once: a shorter gap does not part two steps [cycles].
_GAP = 0.05
# A stretch that dissipates less than this part of a cycle's energy is no step.
_LEAST = 0.1
# A step lasts from this part of its energy to all but this part.
_EDGE = 0.1
# Bed and enclosure go together while their velocities differ by less than this part of the peak.
_TOGETHER = 0.1


@dataclass(frozen=True)
class Step:
    """Parts of the cycle at which a step begins, is half over and ends, 0 <= start < 2.

    part    what it dissipates of the energy of a mean cycle
    """

    start: float
    half: float
    end: float
    part: float


@dataclass(frozen=True)
class Reading:
    """Measures of a run's mean pair of cycles; velocities over the enclosure's greatest, V.

    steps          a cycle
    since          part of the cycle from when the enclosure was fastest the other way to a step's
                   start, 0.1 to 0.6: when the bed that left that wall meets this one
    duration       of a step, in cycles
    enclosure      its speed when a step starts
    half_way       its speed when half of the step's energy is dissipated
    against        the bed's greatest velocity in the quarter cycle before the start, against that
                   of the enclosure half way
    bed            largest speed of the bed
    relative       largest speed of the bed against the enclosure
    together       part of the cycle in which the two are alike
    within         part of the energy that is dissipated at more than the mean power
    deceleration   largest, of the bed [m/s2]
    unevenness     |b - a|/(b + a) of the energies of successive cycles
    """

    steps: float
    since: float | None
    duration: float | None
    enclosure: float | None
    half_way: float | None
    against: float | None
    bed: float
    relative: float
    together: float
    within: float
    deceleration: float
    unevenness: float


def steps_of(dissipated: ArrayLike) -> list[Step]:
    """The steps of a pair of cycles, by rising start; (2 n + 1,) energy since its beginning."""
    energy = np.asarray(dissipated, float)
    power = np.diff(energy)
    if not power.sum() > 0:
        return []
    n, per_cycle = len(power), len(power) // 2
    runs = [(a, b) for a, b in _stretches(power, round(_GAP * per_cycle))]
    spread = np.tile(power, 3)
    runs = [(a, b) for a, b in runs if spread[a:b].sum() >= _LEAST * power.sum() / 2]
    return sorted((_step(runs, k, spread, n) for k in range(len(runs))), key=lambda s: s.start)


def _stretches(power: Floats, gap: int) -> list[tuple[int, int]]:
    """First and last+1 index, from n to 3 n, of the stretches above the mean of periodic power."""
    n = len(power)
    above = power > power.mean() * (1 + 1e-9)  # what is even has no step
    if above.all() or not above.any():
        return []
    first = int(np.flatnonzero(above & ~np.roll(above, 1))[0])  # one begins here
    rotated = np.roll(above, -first)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rotated, [False]]).astype(int)))
    found = [(a, b) for a, b in edges.reshape(-1, 2).tolist()]
    merged = [found[0]]
    for a, b in found[1:]:
        if a - merged[-1][1] < gap:
            merged[-1] = (merged[-1][0], b)
        else:
            merged.append((a, b))
    if len(merged) > 1 and merged[0][0] + n - merged[-1][1] < gap:
        start, _ = merged.pop()
        merged[0] = (start - n, merged[0][1])
    return [(a + first + n, b + first + n) for a, b in merged]


def _step(runs: list[tuple[int, int]], k: int, spread: Floats, n: int) -> Step:
    """The step of a stretch, with what is dissipated up to half way to its neighbours."""
    before = runs[k - 1][1] - (n if k == 0 else 0)
    after = runs[(k + 1) % len(runs)][0] + (n if k == len(runs) - 1 else 0)
    a, b = (before + runs[k][0]) // 2, (runs[k][1] + after) // 2
    spread = np.concatenate([spread, spread])  # the last may reach beyond three pairs
    grown = np.concatenate([[0.0], np.cumsum(spread[a:b])])
    edges = np.array([_EDGE, 0.5, 1 - _EDGE]) * grown[-1]
    start, half, end = (a + np.interp(edges, grown, np.arange(len(grown)))) * 2 / n
    cycle = 2 * np.floor(start / 2)
    whole = spread[:n].sum() / 2
    start, half, end = (float(part - cycle) for part in (start, half, end))
    return Step(start, half, end, float(grown[-1] / whole))


def read(row: Mapping[str, Any]) -> Reading:
    """A row with its histories (see reproduce.cycles.history)."""
    dissipated, bed = (np.array(row[f"cycle.{name}"]) for name in ("dissipated", "bed_velocity"))
    n = len(dissipated) - 1
    peak = row["gamma"] * GRAVITY / (2 * np.pi * row["frequency_hz"])
    part = np.linspace(0.0, 2.0, n + 1)
    enclosure, bed = np.cos(2 * np.pi * part), bed / peak
    steps = steps_of(dissipated)
    starts = np.array([step.start for step in steps])
    moving = np.cos(2 * np.pi * starts)
    half_way = np.cos(2 * np.pi * np.array([step.half for step in steps]))
    against = [_against(bed, s, np.sign(v)) for s, v in zip(starts, half_way, strict=True)]
    power = np.diff(dissipated)
    whole = float(power.sum())
    in_steps = float(power[power > power.mean()].sum())
    halves = power[: n // 2].sum(), power[n // 2 :].sum()
    sample_s = 2 / row["frequency_hz"] / n
    apart = np.abs(bed - enclosure)
    return Reading(
        steps=len(steps) / 2,
        since=_mean(0.1 + (starts - 0.1) % 0.5),
        duration=_mean([step.end - step.start for step in steps]),
        enclosure=_mean(np.abs(moving)),
        half_way=_mean(np.abs(half_way)),
        against=_mean(against),
        bed=float(np.abs(bed).max()),
        relative=float(apart.max()),
        together=float((apart[1:] < _TOGETHER).mean()),
        within=in_steps / whole if whole else 0.0,
        deceleration=float(np.abs(np.diff(bed)).max()) * peak / sample_s,
        unevenness=float(abs(halves[1] - halves[0]) / whole) if whole else 0.0,
    )


def _against(bed: Floats, start: float, sign: float) -> float:
    """The bed's greatest velocity against the enclosure's sign in the quarter cycle to a start."""
    n = len(bed) - 1
    last = int(start * n / 2)
    return float((-sign * bed[np.arange(last - n // 8, last + 1) % n]).max())


def _mean(values: ArrayLike) -> float | None:
    values = np.asarray(values, float)
    return float(values.mean()) if values.size else None
