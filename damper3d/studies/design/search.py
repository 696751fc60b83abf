"""The search: fields of some candidates, a surrogate with uncertainty, and the next to compute.

A field of a candidate is made at the structure's own frequency and taken as that of the same Gamma
about it; the reduction is then that of the harmonic balance at the worst level. The surrogate is a
Gaussian process of its logarithm (scikit-learn), and the next candidates are those of the largest
expected improvement. All follows from specification and seed: what is there is not done again.
"""

import dataclasses
import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.case.parts import gamma_at
from damper3d.studies.design.candidates import Candidate, scaled, spread
from damper3d.studies.design.spec import Task
from damper3d.studies.field.balance import Responses, spaced, with_peaks
from damper3d.studies.field.runs import IN_PHASE, OUT_OF_PHASE
from damper3d.studies.field.several import respond_together
from damper3d.studies.field.structure import Structure
from damper3d.studies.field.table import Field

POINTS = 5  # Gammas of a field at first; then those of the responses that it predicts
NEAR = 0.03  # of ln Gamma, within which a point stands for another
CYCLES, DISCARD = 24, 12
_LEAST = 0.08  # of the bare structure's Gamma, at the lowest level, where a field begins
_OVER = 1.26  # of its Gamma at the highest level, where it ends: the level may be a fifth off
_ABOUT = (0.7, 1.4)  # of the structure's frequency, between which the field is taken as one
_BELOW = 0.9  # of the frequency of the structure with all of the budget riding, likewise
_NEAR = (0.85, 1.15)  # of it, where its peak is looked for; lower with a bed that rides along
FIRST, BATCH = 8, 2  # candidates before there is a surrogate, and at a time then
Rows = list[dict[str, Any]]


@dataclass
class Design:
    """A candidate with what is known of it."""

    candidate: Candidate
    field: Field | None = None  # None: its runs failed
    reductions: list[float] = dataclasses.field(default_factory=list)  # at each level
    peaks: list[tuple[float, float]] = dataclasses.field(
        default_factory=list
    )  # [Hz], [m] at each level
    rows: Rows = dataclasses.field(default_factory=list)  # of the field's runs

    @property
    def reduction(self) -> float:
        """Response over the bare structure's, at the worst level; 1 where nothing is known."""
        return max(self.reductions, default=1.0)

    @property
    def worst(self) -> int:
        """Number of the level at which it is the worst."""
        return int(np.argmax(self.reductions)) if self.reductions else 0


def gammas(task: Task) -> list[float]:
    """Gammas of a field, evenly in their logarithm."""
    level = task.spec.level
    low = _LEAST * task.bare_gamma * min(level.range)
    if level.orientation == "vertical":
        low = max(low, min(0.8, 0.5 * task.bare_gamma))  # below 1 it rides along
    ends = low, _OVER * task.bare_gamma * max(level.range)
    return [float(f"{gamma:.4g}") for gamma in np.geomspace(*ends, POINTS)]


def predicted(design: "Design") -> list[float]:
    """Gammas of the response at each level that no run of its field is near to.

    So the field is computed where the structure will be, and interpolated elsewhere: just above the
    onset of motion its curve bends too sharply for a few points.
    """
    if design.field is None:
        return []
    known = [row["gamma"] for row in design.rows]
    found: list[float] = []
    for frequency, amplitude in design.peaks:
        gamma = float(f"{gamma_at(amplitude, frequency):.3g}")
        if all(abs(math.log(gamma / other)) > NEAR for other in (*known, *found)):
            found.append(gamma)
    return found


def field_cases(
    task: Task, candidate: Candidate, number: int, frequency: float,
    at: Sequence[float] | None = None,
) -> list[tuple[dict[str, Any], DamperCase]]:  # fmt: skip
    """Labelled runs of a candidate's field at a frequency [Hz], at Gammas or the first ones."""
    level, search = task.spec.level, task.spec.search
    return [
        (
            {"design": number, "frequency_hz": frequency, "gamma": gamma},
            DamperCase.load(
                "thesis",
                candidate.changes(level.orientation, search.seed)
                | {"motion.frequency": frequency, "motion.gamma": gamma,
                   "run.cycles": CYCLES, "run.discard": DISCARD},
            ),
        )
        for gamma in (gammas(task) if at is None else at)
    ]  # fmt: skip


def structure_of(task: Task, factor: float = 1.0) -> Structure:
    """The structure, its frequency times a factor, under the force of level 1."""
    own = task.spec.structure
    return Structure.single(own.mass, factor * own.frequency, own.damping_ratio, force=task.force)


def _lowest(task: Task, part: float) -> float:
    """A part of the frequency, or what all of the budget brings it to when it rides, and a tenth.

    A mass m that rides on M lowers its frequency by 1/sqrt(1 + m/M).
    """
    riding = 1.0 / math.sqrt(1.0 + task.budget / task.spec.structure.mass)
    return min(part, _BELOW * riding)


def field_from(task: Task, rows: Rows, frequency: float) -> Field | None:
    """A field that is the same in Gamma about a frequency, from runs there; None of failed ones."""
    done = [row for row in rows if row["state"] == "done" and row.get(IN_PHASE) is not None]
    if len(done) < len(rows) or not done:
        return None
    mass = [complex(row[IN_PHASE], -row[OUT_OF_PHASE]) for row in done]
    own = [row["gamma"] for row in done]
    places = [factor * frequency for factor in (_lowest(task, _ABOUT[0]), 1.0, _ABOUT[1])]
    at = np.repeat(places, len(own))
    return Field.of(at, own * len(places), mass * len(places), done[0]["mass_kg"])


def responses_near(
    task: Task, own: Field, levels: Sequence[float], factor: float = 1.0
) -> Responses:
    """Responses about the structure's frequency, times a factor, with a bed's field."""
    structure = structure_of(task, factor)
    centre = factor * task.spec.structure.frequency
    frequency = spaced(structure, _lowest(task, _NEAR[0]) * centre, _NEAR[1] * centre)
    sharpest = task.spec.structure.damping_ratio
    answer = partial(respond_together, [structure], [own], levels=levels)
    return with_peaks(answer, frequency, sharpest)[0]


def judge(
    task: Task, own: Field, levels: Sequence[float], factor: float = 1.0
) -> tuple[list[float], list[tuple[float, float]]]:
    """Reduction at each level, and frequency and amplitude of the peak; 1 beyond the field."""
    responses = responses_near(task, own, levels, factor)
    centre = factor * task.spec.structure.frequency
    reductions, peaks = [], []
    for k in range(len(levels)):
        bare, largest = float(responses.bare[k].max()), responses.largest(k)
        peaks.append(largest or (centre, bare))
        reductions.append(peaks[-1][1] / bare)
    return reductions, peaks


def evaluated(
    task: Task, candidates: Sequence[Candidate], rows: Rows, frequency: float | None = None,
    factor: float = 1.0,
) -> list[Design]:  # fmt: skip
    """Designs of candidates from the rows of their runs, which their labels number.

    frequency of the runs [Hz], by itself that of the structure; factor on the structure's own.
    """
    found = []
    for number, candidate in enumerate(candidates):
        own = [row for row in rows if row["design"] == number]
        made_at = frequency or task.spec.structure.frequency
        design = Design(candidate, field_from(task, own, made_at), rows=own)
        if design.field is not None:
            design.reductions, design.peaks = judge(
                task, design.field, task.spec.level.range, factor
            )
        found.append(design)
    return found


def search(
    task: Task, candidates: Sequence[Candidate], amplitude: float, number: int,
    compute: Callable[[Sequence[Candidate]], list[Design]],
) -> list[Design]:  # fmt: skip
    """Designs that were computed, the best first; compute gives those of some candidates."""
    x = scaled(candidates, amplitude)
    number = min(number, len(candidates))
    order = spread(candidates, amplitude, min(FIRST, number))
    designs = compute([candidates[k] for k in order])
    while len(order) < number:
        wanted = min(BATCH, number - len(order))
        chosen = propose(x, order, [design.reduction for design in designs], wanted)
        designs += compute([candidates[k] for k in chosen])
        order += chosen
    return sorted(designs, key=lambda design: design.reduction)


def propose(x: np.ndarray, known: Sequence[int], values: Sequence[float], number: int) -> list[int]:
    """Rows of x (n, k) to compute next, of the largest expected improvement of ln(values).

    Several at once: each is taken to come out as the surrogate says before the next is chosen.
    """
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    at, seen = list(known), [math.log(value) for value in values]
    kernel = ConstantKernel(1.0, (1e-2, 1e2)) * Matern(
        np.full(x.shape[1], 0.5), (0.05, 20.0), nu=2.5
    ) + WhiteKernel(0.02, (1e-4, 1.0))
    surrogate = GaussianProcessRegressor(kernel, normalize_y=True, random_state=0)
    with warnings.catch_warnings():  # an end of the ranges may be the best there is
        warnings.simplefilter("ignore", ConvergenceWarning)
        surrogate.fit(x[at], seen)
    surrogate.set_params(kernel=surrogate.kernel_, optimizer=None)
    chosen: list[int] = []
    for _ in range(number):
        mean, sigma = surrogate.predict(x, return_std=True)
        gain = expected_improvement(mean, sigma, min(seen))
        gain[at] = -1.0
        chosen.append(int(np.argmax(gain)))
        at.append(chosen[-1])
        seen.append(float(mean[chosen[-1]]))
        surrogate.fit(x[at], seen)
    return chosen


def expected_improvement(mean: np.ndarray, sigma: np.ndarray, best: float) -> np.ndarray:
    """Mean gain over the best (smallest) value of normal variables (n,)."""
    from scipy.special import ndtr

    z = (best - mean) / np.maximum(sigma, 1e-12)
    return np.asarray(
        (best - mean) * ndtr(z) + sigma * np.exp(-0.5 * z**2) / math.sqrt(2 * math.pi)
    )
