"""The steps of a design: settled heights, search, verification with the structure, robustness.

Every run goes through the folders of a sweep: a command that is repeated goes on where it was.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.case.host.host import COUNTED
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
    search,
)
from damper3d.studies.design.spec import Task
from damper3d.studies.design.verification import (
    Verified,
    about_peak,
    best_of,
    beyond_edge,
    verification_cases,
)
from granulab.campaign.output.layout import stopped
from granulab.errors import InputError, SimulationError, Stopped

_SEARCH_CPU = 1200.0  # [s of CPU] that the search takes by itself
_REFINED = 1.5  # runs of a field over those that it begins with
ROUNDS = 2  # of runs at the responses that a field predicts
EDGES = 3  # times that a peak is looked for further out
_ABOUT_A_PEAK = 3  # frequencies that a design is simulated at: of its peak, and on both sides
_SUPPOSED = 0.5  # of the bare response, of a design that is not known yet
_FEWEST, _MOST = 12, 40  # candidates by itself
_FILLING = {"motion.frequency": 100.0, "motion.gamma": 0.5, "run.cycles": 1, "run.discard": 0}
# Beds settle by random filling of an enclosure of so many depths and a particle; balls of a layer,
# of less depth than so many extents, meet seldom and bounce longer (steel of 15 mm: 0.7 s).
_FALLING, _LAYER = 1.5, 1.5
_SETTLING, _OF_A_LAYER = "0.4 s", "1.2 s"
OFF = 0.2  # of level and frequency, for which robustness is asked
AGAIN = 2  # times the packings that a design is verified on, for the one that is proposed
UNSEEN = 1000  # added to the seed for packings that nothing was chosen by

Say = Callable[[str], None]


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
        tall = Candidate(bed, max(bed.depth + clearance, bed.ball.extent), clearance)
        cases = field_cases(self.task, tall, 0, self.task.spec.structure.frequency)
        costs = [DAMPER.expected_cpu_s(case) for _, case in cases]
        return costs[0][0] + _REFINED * sum(run for _, run in costs)

    def cost_with_structure(self, bed: Bed) -> tuple[float, float]:
        """About what a packing of a bed and a run with the structure cost [s of CPU].

        Of a run that ends when it is first judged, with a response of _SUPPOSED of the bare one.
        """
        clearance, own = math.pi * self.amplitude, self.task.spec.structure
        tall = Candidate(bed, max(bed.depth + clearance, bed.ball.extent), clearance)
        supposed = Design(tall, reductions=[_SUPPOSED])
        ((_, case),) = verification_cases(self.task, supposed, 0, [own.frequency], [1], 0)
        packing, run = DAMPER.expected_cpu_s(case)
        least = case.settings.run.discard + COUNTED
        return packing, run * min(least / case.settings.run.max_cycles, 1.0)

    def expected_cpu_s(self, compare: int, simulated: int) -> dict[str, float]:
        """About what each part costs [s of CPU], of beds as they are in the mean.

        Beds come to rest sooner than the settling that they are given, in a third of this time.
        compare: random designs to compare with, of which so many are simulated.
        """
        search, levels = self.task.spec.search, len(self.task.spec.level.range)
        settling = [DAMPER.expected_cpu_s(case) for _, case in self._settling(self.beds)]
        field = sum(map(self.cost_of, self.beds)) / len(self.beds)
        each = [self.cost_with_structure(bed) for bed in self.beds]
        packing, run = (sum(part) / len(each) for part in zip(*each, strict=True))
        alone = search.verified + 1 + len(making.NEARBY)  # at a level; then the best at all
        unseen = AGAIN * levels  # the first, on packings that nothing was chosen by
        others = (1 + simulated) * levels if compare else 0  # the rule and random ones
        runs = (alone + levels - 1 + unseen + others) * _ABOUT_A_PEAK
        of_settling = sum(map(sum, settling))
        return {
            "settling": of_settling * (1.0 + compare / len(settling)),
            "fields": self.number * field,
            # Other clearances of the best, other frequencies of the first, and those compared with.
            "more fields": (len(making.NEARBY) + 2 + (compare and compare + 1)) * field,
            "with the structure": search.seeds * (runs * run + (alone + AGAIN) * packing),
        }

    def run(self, cases: Sequence[Any]) -> Rows:
        """Rows of labelled cases; Stopped where some were interrupted."""
        rows = run_cases(list(cases), out=self.out, **self.engine)
        if stopped(rows):
            raise Stopped("the same command goes on")
        return rows

    def _settling(self, beds: Sequence[Bed]) -> list[tuple[dict[str, Any], DamperCase]]:
        """Labelled cases in which beds settle."""
        cases = []
        for number, bed in enumerate(beds):
            tall = Candidate(bed, float(f"{_FALLING * bed.depth + bed.ball.extent:.5g}"), 0.0)
            single = bed.depth < _LAYER * bed.ball.extent
            changes = tall.changes("vertical", self.task.spec.search.seed) | _FILLING
            changes["fill.settle_time"] = _OF_A_LAYER if single else _SETTLING
            cases.append(({"design": number}, DamperCase.load("thesis", changes)))
        return cases

    def heights(self, beds: Sequence[Bed]) -> list[float]:
        """Heights [m] to which beds settle along the axis; inf of those that do not."""
        rows = self.run(self._settling(beds))
        return [
            float(row["packing.height_m"]) if row["state"] == "done" else math.inf for row in rows
        ]

    @cached_property
    def settled(self) -> list[float]:
        """Heights [m] to which the beds settle."""
        self.say(f"{len(self.beds)} beds: how high they settle")
        return self.heights(self.beds)

    @cached_property
    def rule(self) -> Candidate:
        """The thesis's rule of thumb, from which the search starts."""
        return making.rule_of_thumb(self.task, self.beds, self.settled)

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
        space = self.task.spec.space
        if all(map(math.isinf, self.settled)):
            raise SimulationError(
                f"{self.task.spec.name}: the runs in which {len(self.beds)} beds settle failed; "
                f"`damper3d list {self.out}` names them"
            )
        pool = making.pool(self.beds, self.settled, self.amplitude, space.height)
        if not pool:
            raise InputError(
                f"{self.task.spec.name}: no design fits: the space, {1e3 * space.height:g} mm "
                "high, leaves no clearance over any bed; give more height, or a smaller added_mass"
            )
        pool = list(dict.fromkeys([self.rule, *pool]))
        number, done, best = min(self.number, len(pool)), 0, math.inf

        def compute(chosen: Sequence[Candidate]) -> list[Design]:
            nonlocal done, best
            known = f", best so far {best:.3f} of the bare response" if done else ""
            self.say(f"fields of candidates {done + 1} to {done + len(chosen)} of {number}{known}")
            found = self.compute(chosen)
            done, best = done + len(chosen), min([best, *(one.reduction for one in found)])
            return found

        return search(self.task, pool, self.amplitude, number, compute)

    def verify(self, designs: Sequence[Design], first_seed: int) -> list[Verified]:
        """Simulate structure and bed together, each design at the level that its field has worst.

        Then the best one with other clearances; then the best of all at all levels, and the next if
        that one is no longer the best.
        """
        verified = [Verified(design) for design in designs]
        self.simulate([(one, one.design.worst) for one in verified], first_seed)
        if best := best_of(verified):
            self.say("the best with other clearances")
            near = making.nearby(best.design.candidate, self.task.spec.space.height)
            known = {one.design.candidate for one in verified}
            found = self.compute([one for one in near if one not in known])
            beside = [Verified(design) for design in found if design.field is not None]
            self.simulate([(one, one.design.worst) for one in beside], first_seed)
            verified += beside
        every = range(len(self.task.spec.level.range))
        while best := best_of(verified):
            missing = [(best, level) for level in every if level not in best.levels]
            if not missing:
                break
            self.say("the best at its other levels")
            self.simulate(missing, first_seed)
        return verified

    def again(self, one: Verified) -> Verified:
        """The same design at its levels on packings that nothing was chosen by.

        What is the least of several on the same packings is so by chance in part.
        """
        found = Verified(one.design)
        seed = self.task.spec.search.seed + UNSEEN
        self.simulate([(found, level) for level in one.levels], seed, AGAIN)
        return found

    def simulate(
        self, wanted: Sequence[tuple[Verified, int]], first_seed: int, times: int = 1
    ) -> None:
        """Simulate designs with the structure, each at a level, and note what came out.

        About the predicted peak; and further out while the largest response is at the edge.
        times: packings over those that the task asks for.
        """
        seeds = range(first_seed, first_seed + times * self.task.spec.search.seeds)
        own: list[Rows] = [[] for _ in wanted]
        at = [about_peak(self.task, one.design, level) for one, level in wanted]
        for _ in range(EDGES + 1):
            cases = [
                case
                for number, (one, level) in enumerate(wanted)
                for case in verification_cases(
                    self.task, one.design, level, at[number], seeds, number
                )
            ]
            for row in self.run(cases):
                own[row["design"]].append(row)
            at = [beyond_edge(rows) for rows in own]
            if not any(at):
                break
        for (one, level), rows in zip(wanted, own, strict=True):
            one.note(self.task, level, rows)

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
        highest = self.task.spec.space.height
        drawn = making.random_beds(self.task, self.beds, number)
        settled = self.heights([bed for bed, _ in drawn])
        chosen = [self.rule]
        for (bed, part), height in zip(drawn, settled, strict=True):
            if height < highest:
                inside = height + part * (highest - height)
                chosen.append(making.of_height(bed, inside, bed.close(height)))
        found = self.compute(chosen)
        return found[0], sorted(found[1:], key=lambda design: design.reduction)
