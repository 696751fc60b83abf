"""Verification of designs by simulations of structure and bed together, and the intervals.

A design is simulated at levels, on packings that the search has not seen, at the frequency of the
peak that its field predicts and on both sides of it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.case.host.host import FORGOTTEN, cycles_until
from damper3d.studies.design.candidates import Candidate
from damper3d.studies.design.search import Design, Rows, responses_near
from damper3d.studies.design.spec import Task
from granulab.campaign.output.statistics import mean_sd, noise_of_one_more, pooled_sd, quantile

_ALIKE = 2  # designs of a bed that are verified
_BESIDE = 0.85  # of the predicted peak, where the structure is simulated on both sides of it


@dataclass
class Verified:
    """A design simulated with the structure."""

    design: Design
    # Of each level, by its number in the task, peak over the bare structure's; of each seed.
    levels: dict[int, dict[int, float]] = field(default_factory=dict)
    rows: Rows = field(default_factory=list)
    # Of a level whose largest response stayed at an end of the simulated frequencies, these [Hz].
    at_end: dict[int, tuple[float, float]] = field(default_factory=dict)

    def note(self, task: Task, level: int, rows: Rows) -> None:
        """Take the rows of a level."""
        self.levels[level] = _reductions(task, level, rows)
        if beyond_edge(rows):
            each = [row["frequency_hz"] for row in rows]
            self.at_end[level] = min(each), max(each)
        self.rows += rows

    @property
    def seeds(self) -> list[int]:
        """Of the packings that are done at all levels."""
        seen = list(self.levels.values())
        return [seed for seed in (seen[0] if seen else {}) if all(seed in one for one in seen)]

    @property
    def reductions(self) -> list[float]:
        """At the worst of its levels, of each of these packings."""
        return [max(one[seed] for one in self.levels.values()) for seed in self.seeds]

    @property
    def sample(self) -> Any:
        """Logarithms of the reductions as a sample."""
        return mean_sd([math.log(value) for value in self.reductions])

    @property
    def mean(self) -> float:
        """Mean reduction, of the logarithms."""
        return math.exp(self.sample.mean)

    def largest(self, name: str) -> float | None:
        """Largest value of a column of the runs."""
        found = [row[name] for row in self.rows if isinstance(row.get(name), float)]
        return max(found, default=None)


def best_of(verified: Sequence[Verified]) -> Verified | None:
    """The one of the least mean reduction at the levels that it is known at; None of none."""
    able = [one for one in verified if one.reductions]
    return min(able, key=lambda one: one.mean, default=None)


def to_verify(designs: Sequence[Design], number: int, rule: Candidate) -> list[Design]:
    """The best of designs in their order, at most _ALIKE of a bed, and the rule of thumb's.

    Fields of one bed err alike, so that another bed is the better second choice.
    """
    chosen = [one for one in designs if one.candidate == rule and one.field is not None]
    number += len(chosen)
    for one in designs:
        alike = sum(one.candidate.bed == other.candidate.bed for other in chosen)
        able = one.field is not None and one.candidate != rule
        if able and alike < _ALIKE and len(chosen) < number:
            chosen.append(one)
    return chosen


def verification_cases(
    task: Task, design: Design, level: int, at: Sequence[float], seeds: Sequence[int], number: int
) -> list[tuple[dict[str, Any], DamperCase]]:
    """Labelled runs of a design with the structure at a level, by its number, and frequencies [Hz].

    A run is not judged before its start is forgotten: with the damping that the response over the
    bare one tells.
    """
    own = task.spec.structure
    slowest = 2.0 * math.pi * own.frequency * own.damping_ratio
    force = task.spec.level.range[level] * task.force
    cases = []
    for seed in seeds:
        changes = design.candidate.changes(task.spec.level.orientation, seed) | {
            "host.mass": f"{own.mass!r} kg", "host.frequency": own.frequency,
            "host.damping_ratio": own.damping_ratio, "host.force": f"{force!r} N",
        }  # fmt: skip
        for frequency in at:
            labels = {"design": number, "seed": seed, "frequency_hz": frequency}
            waits = math.ceil(design.reduction * (cycles_until(FORGOTTEN, slowest, frequency) or 0))
            here = changes | {"motion.frequency": frequency, "run.discard": waits}
            cases.append((labels, DamperCase.load("thesis", here)))
    return cases


def about_peak(task: Task, design: Design, level: int) -> list[float]:
    """Frequencies [Hz] of the predicted peak at a level, by its number, and on both sides of it.

    There the predicted response has fallen to _BESIDE of it.
    """
    assert design.field is not None
    responses = responses_near(task, design.field, [task.spec.level.range[level]])
    frequency = responses.frequency
    each = np.nan_to_num(responses.stable[0]).max(axis=1, initial=0.0)
    top = int(np.argmax(each))
    low = each >= _BESIDE * each[top]
    left = top - int(np.argmin(low[top::-1])) if not low[: top + 1].all() else 0
    right = top + int(np.argmin(low[top:])) if not low[top:].all() else len(each) - 1
    return sorted({float(f"{frequency[k]:.6g}") for k in (left, top, right)})


def peak_of(frequency: Sequence[float], amplitude: Sequence[float]) -> float:
    """Largest amplitude, by a parabola through the largest of the points and its neighbours."""
    top = int(np.argmax(amplitude))
    if 0 < top < len(frequency) - 1:
        near = slice(top - 1, top + 2)
        a, b, c = np.polyfit(np.array(frequency[near]) - frequency[top], amplitude[near], 2)
        if a < 0:
            return float(c - b**2 / (4.0 * a))
    return float(max(amplitude))


def beyond_edge(rows: Rows) -> list[float]:
    """Frequency [Hz] one step further where the largest mean response is at an edge; else none."""
    done = [row for row in rows if row["state"] == "done"]
    at = sorted({row["frequency_hz"] for row in done})
    if len(done) < len(rows) or len(at) < 2:
        return []
    means = [np.mean([r["host.amplitude_m"] for r in done if r["frequency_hz"] == f]) for f in at]
    top = int(np.argmax(means))
    if 0 < top < len(at) - 1:
        return []
    further = 2.0 * at[top] - (at[1] if top == 0 else at[-2])
    return [float(f"{further:.6g}")] if further > 0 else []


def _reductions(task: Task, level: int, rows: Rows) -> dict[int, float]:
    """Of each seed whose runs are done at all frequencies."""
    bare = task.spec.level.range[level] * task.bare_amplitude
    found = {}
    for seed in dict.fromkeys(row["seed"] for row in rows):
        own = sorted((row for row in rows if row["seed"] == seed),
                     key=lambda row: row["frequency_hz"])  # fmt: skip
        if all(row["state"] == "done" for row in own):
            amplitudes = [row["host.amplitude_m"] for row in own]
            found[seed] = peak_of([row["frequency_hz"] for row in own], amplitudes) / bare
    return found


def interval(one: Verified, all_verified: Sequence[Verified]) -> tuple[float, float] | None:
    """Of 95 %, for one more packing; None for too few packings.

    The scatter is pooled over `one` and another design of each bed: those of a bed scatter alike on
    the same packings, and tell no more than one of them.
    """
    known = [each for each in [*all_verified, one] if len(each.reductions) > 1]
    apart = {(each.design.candidate.bed, *each.seeds): each for each in known}
    pooled = pooled_sd([each.sample for each in apart.values()])
    if pooled is None or not one.reductions:
        return None
    half = noise_of_one_more(len(one.reductions), *pooled)
    middle = one.mean
    return middle * math.exp(-half), middle * math.exp(half)


def of_field(design: Design, all_verified: Sequence[Verified]) -> tuple[float, float] | None:
    """Interval of a design that was not verified, by how far fields and simulations differ."""
    off = [
        math.log(value / each.design.reduction)
        for each in all_verified for value in each.reductions
    ]  # fmt: skip
    if not off:
        return None
    half = quantile(len(off)) * math.sqrt(sum(x * x for x in off) / len(off))
    return design.reduction * math.exp(-half), design.reduction * math.exp(half)
