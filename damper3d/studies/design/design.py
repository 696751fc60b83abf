"""The steps of a design: settled heights, search, verification with the structure, robustness.

Every run goes through the folders of a sweep: a command that is repeated goes on where it was.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.run.sweep import DAMPER, run_cases
from damper3d.studies.design import candidates as making
from damper3d.studies.design.candidates import Bed, Candidate
from damper3d.studies.design.search import (
    Design,
    Rows,
    evaluated,
    field_cases,
    judge,
    predicted,
    responses_near,
    search,
    structure_of,
)
from damper3d.studies.design.spec import Task
from damper3d.studies.field.simulated import forgotten
from granulab.campaign.output.statistics import mean_sd, noise_of_one_more, pooled_sd, quantile
from granulab.errors import InputError, Stopped

_SEARCH_CPU = 1200.0  # [s of CPU] that the search takes by itself
_REFINED = 1.5  # runs of a field over those that it begins with
ROUNDS = 2  # of runs at the responses that a field predicts
_FEWEST, _MOST = 12, 40  # candidates by itself
_BESIDE = 0.85  # of the predicted peak, where the structure is simulated on both sides of it
_FILLING = {"motion.frequency": 100.0, "motion.gamma": 0.5, "run.cycles": 1, "run.discard": 0,
            "fill.settle_time": "60 ms"}  # fmt: skip
OFF = 0.2  # of level and frequency, for which robustness is asked
UNSEEN = 1000  # added to the seed for packings that nothing was chosen by

Say = Callable[[str], None]


@dataclass
class Verified:
    """A design simulated with the structure: peaks at its worst level, for each packing."""

    design: Design
    level: float
    reductions: list[float] = field(default_factory=list)  # of each packing
    rows: Rows = field(default_factory=list)

    @property
    def sample(self) -> Any:
        """Logarithms of the reductions as a sample."""
        return mean_sd([math.log(value) for value in self.reductions])

    def largest(self, name: str) -> float | None:
        """Largest value of a column of the runs."""
        found = [row[name] for row in self.rows if isinstance(row.get(name), float)]
        return max(found, default=None)


@dataclass
class Designer:
    """A task, and how it is computed."""

    task: Task
    out: Path
    engine: dict[str, Any]
    say: Say

    @cached_property
    def amplitude(self) -> float:
        """Amplitude of the closed form [m]."""
        return making.closed_form(self.task)

    @cached_property
    def beds(self) -> list[Bed]:
        """Beds that find room."""
        return making.beds_of(self.task)

    @property
    def number(self) -> int:
        """Candidates whose fields are computed."""
        given = self.task.spec.search.candidates
        if given is not None:
            return given
        costs = [self.cost_of(bed) for bed in self.beds]
        return int(np.clip(_SEARCH_CPU / (sum(costs) / len(costs)), _FEWEST, _MOST))

    def cost_of(self, bed: Bed) -> float:
        """About what a field of a bed costs [s of CPU]."""
        clearance = math.pi * self.amplitude
        tall = Candidate(bed, bed.depth + clearance, clearance)
        cases = field_cases(self.task, tall, 0, self.task.spec.structure.frequency)
        costs = [DAMPER.expected_cpu_s(case) for _, case in cases]
        return costs[0][0] + _REFINED * sum(run for _, run in costs)

    def run(self, cases: Sequence[Any]) -> Rows:
        """Rows of labelled cases; Stopped where some were interrupted."""
        rows = run_cases(list(cases), out=self.out, **self.engine)
        if any(row["state"] == "interrupted" for row in rows):
            raise Stopped("the same command goes on")
        return rows

    def heights(self, beds: Sequence[Bed]) -> list[float]:
        """Heights [m] to which beds settle in an enclosure as high as the space."""
        space, level = self.task.spec.space, self.task.spec.level
        cases = []
        for number, bed in enumerate(beds):
            tall = Candidate(bed, space.height, 0.0)
            changes = tall.changes(level.orientation, self.task.spec.search.seed) | _FILLING
            cases.append(({"design": number}, DamperCase.load("thesis", changes)))
        rows = self.run(cases)
        return [
            float(row["packing.height_m"]) if row["state"] == "done" else math.inf for row in rows
        ]

    def compute(self, chosen: Sequence[Candidate]) -> list[Design]:
        """Designs of candidates, by their fields."""
        frequency = self.task.spec.structure.frequency
        return self.refined(chosen, frequency, partial(evaluated, self.task, chosen))

    def refined(
        self, chosen: Sequence[Candidate], frequency: float, judged: Callable[[Rows], list[Design]]
    ) -> list[Design]:
        """Designs whose fields hold the responses that they predict, after ROUNDS at most."""

        def computed(at: Sequence[Sequence[float] | None]) -> Rows:
            return self.run(
                [
                    case
                    for number, (candidate, wanted) in enumerate(zip(chosen, at, strict=True))
                    for case in field_cases(self.task, candidate, number, frequency, wanted)
                ]
            )

        rows = computed([None] * len(chosen))
        designs = judged(rows)
        for _ in range(ROUNDS):
            wanted = [predicted(design) for design in designs]
            if not any(wanted):
                break
            rows = rows + computed(wanted)
            designs = judged(rows)
        return designs

    def searched(self) -> list[Design]:
        """Designs of the search, the best first."""
        self.say(f"{len(self.beds)} beds: how high they settle")
        space = self.task.spec.space
        pool = making.pool(self.beds, self.heights(self.beds), self.amplitude, space.height)
        if not pool:
            raise InputError(
                f"{self.task.spec.name}: no design fits: the space, {1e3 * space.height:g} mm "
                "high, leaves no clearance over any bed; give more height, or a smaller added_mass"
            )
        number, done, best = min(self.number, len(pool)), 0, 1.0

        def compute(chosen: Sequence[Candidate]) -> list[Design]:
            nonlocal done, best
            self.say(
                f"fields of candidates {done + 1} to {done + len(chosen)} of {number}, best so far "
                f"{best:.3f} of the bare response"
            )
            found = self.compute(chosen)
            done, best = done + len(chosen), min([best, *(one.reduction for one in found)])
            return found

        return search(self.task, pool, self.amplitude, number, compute)

    def verify(self, designs: Sequence[Design], first_seed: int) -> list[Verified]:
        """Simulate structure and bed about the predicted peak at the worst level.

        A run is not judged before its start is forgotten: with the damping that the response over
        the bare one tells.
        """
        bare = structure_of(self.task)
        own, orientation = self.task.spec.structure, self.task.spec.level.orientation
        cases, found = [], []
        for number, design in enumerate(designs):
            level = self.task.spec.level.range[design.worst]
            found.append(Verified(design, level))
            for seed in range(first_seed, first_seed + self.task.spec.search.seeds):
                changes = design.candidate.changes(orientation, seed) | {
                    "host.mass": f"{own.mass!r} kg", "host.frequency": own.frequency,
                    "host.damping_ratio": own.damping_ratio,
                    "host.force": f"{level * self.task.force!r} N",
                }  # fmt: skip
                for frequency in about_peak(self.task, design):
                    labels = {"design": number, "seed": seed, "frequency_hz": frequency}
                    waits = math.ceil(design.reduction * forgotten(bare, frequency))
                    here = changes | {"motion.frequency": frequency, "run.discard": waits}
                    cases.append((labels, DamperCase.load("thesis", here)))
        for row in self.run(cases):
            found[row["design"]].rows.append(row)
        for one in found:
            one.reductions = _reductions(self.task, one)
        return found

    def robustness(self, design: Design) -> dict[str, float | None]:
        """Reduction at the worst level where level or frequency of the structure are off by OFF."""
        level, own = self.task.spec.level, design.field
        assert own is not None
        ends = [(1 - OFF) * level.range[0], *level.range, (1 + OFF) * level.range[-1]]
        found: dict[str, float | None] = {"level_off": max(judge(self.task, own, ends)[0])}
        for name, factor in (("frequency_low", 1 - OFF), ("frequency_high", 1 + OFF)):
            frequency = float(f"{factor * self.task.spec.structure.frequency:.6g}")
            judged = partial(
                evaluated, self.task, [design.candidate], frequency=frequency, factor=factor
            )
            (there,) = self.refined([design.candidate], frequency, judged)
            found[name] = None if there.field is None else there.reduction
        return found

    def others(self, number: int) -> tuple[Design, list[Design]]:
        """The thesis's rule of thumb, and random designs, by their fields."""
        space, bare = self.task.spec.space, self.task.bare_amplitude
        rule = making.rule_of_thumb(self.task, self.beds)
        drawn = making.random_beds(self.task, self.beds, number)
        settled = self.heights([rule, *(bed for bed, _ in drawn)])
        chosen = [_candidate(rule, min(settled[0] + math.pi * bare, space.height), settled[0])]
        for (bed, part), height in zip(drawn, settled[1:], strict=True):
            if height < space.height:
                chosen.append(_candidate(bed, height + part * (space.height - height), height))
        found = self.compute(chosen)
        return found[0], sorted(found[1:], key=lambda design: design.reduction)


def _candidate(bed: Bed, height: float, settled: float) -> Candidate:
    rounded = float(f"{height:.5g}")
    return Candidate(bed, rounded, rounded - settled)


def about_peak(task: Task, design: Design) -> list[float]:
    """Frequencies [Hz] of the predicted peak at the worst level, and on both sides of it.

    There the predicted response has fallen to _BESIDE of it.
    """
    assert design.field is not None
    responses = responses_near(task, design.field, [task.spec.level.range[design.worst]])
    frequency = responses.frequency
    each = np.nan_to_num(responses.stable[0]).max(axis=1, initial=0.0)
    top = int(np.argmax(each))
    low = each >= _BESIDE * each[top]
    left = top - int(np.argmin(low[top::-1])) if not low[: top + 1].all() else 0
    right = top + int(np.argmin(low[top:])) if not low[top:].all() else len(each) - 1
    return sorted({float(f"{frequency[k]:.6g}") for k in (left, top, right)})


def peak_of(frequency: Sequence[float], amplitude: Sequence[float]) -> float:
    """Largest amplitude, by a parabola through three points where it has its top among them."""
    if len(frequency) == 3 and amplitude[1] >= max(amplitude[0], amplitude[2]):
        a, b, c = np.polyfit(np.array(frequency) - frequency[1], amplitude, 2)
        if a < 0:
            return float(c - b**2 / (4.0 * a))
    return float(max(amplitude))


def _reductions(task: Task, one: Verified) -> list[float]:
    """Of each packing that is done at all frequencies."""
    bare = one.level * task.bare_amplitude
    found = []
    for seed in dict.fromkeys(row["seed"] for row in one.rows):
        own = sorted((row for row in one.rows if row["seed"] == seed),
                     key=lambda row: row["frequency_hz"])  # fmt: skip
        if all(row["state"] == "done" for row in own):
            amplitudes = [row["host.amplitude_m"] for row in own]
            found.append(peak_of([row["frequency_hz"] for row in own], amplitudes) / bare)
    return found


def interval(one: Verified, all_verified: Sequence[Verified]) -> tuple[float, float] | None:
    """Of 95 %, for one more packing: scatter pooled over all designs; None for too few packings."""
    pooled = pooled_sd([each.sample for each in all_verified if len(each.reductions) > 1])
    if pooled is None or not one.reductions:
        return None
    half = noise_of_one_more(len(one.reductions), *pooled)
    middle = math.exp(one.sample.mean)
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
