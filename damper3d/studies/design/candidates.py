"""Candidates: particles of the catalogue up to the budget, in cylinders of the space.

The motion is along the axis of the cylinder. Of each ball there are some widths, from a tall bed to
one that does not cover its floor, with all of the budget or a part (balls that bounce one by one
may damp better than more of them that carry each other), and clearances about that of the closed
form. A bed that is one body without rebound damps best where the amplitude is 1/pi of its clearance
(thesis, eq. 6.11), at which it takes 4 V^2 m a cycle: with the power of the force that sets the
amplitude, and with it the clearance.

Clearances count from the bed as closely as shaking packs it: the height to which it settles as it
is filled, times the thesis's loose over close packing (eq. 6.13); a single layer stays one.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from damper3d.case.closed_forms import fluidisation_threshold
from damper3d.case.random_packing import CLOSE_PACKING, LOOSE_PACKING
from damper3d.studies.design.spec import Ball, Task
from granulab.errors import InputError

LAYERS = (0.6, 1.0, 2.5, 6.0)  # below one, of the floor that a full layer covers
SHARES = (1.0, 0.6)  # of the budget
_LAYER = math.pi / (3.0 * math.sqrt(3.0))  # volume of a hexagonal layer over floor and diameter
CLEARANCES = np.geomspace(0.25, 64.0, 17)  # over that of the closed form
NEARBY = (0.71, 0.84, 1.19, 1.41)  # of the best clearance: a step of those, and half a step
_LOWEST = 1.2  # Gamma over the threshold of motion, below which no bed damps
_NARROWEST = 3.0  # extents of a particle, of an enclosure
# Height over that of the close bed above which random filling finds room: midway to the loose bed.
_FILLED = (1.0 + CLOSE_PACKING / LOOSE_PACKING) / 2.0


@dataclass(frozen=True)
class Bed:
    """A number of balls in a cylinder."""

    ball: Ball
    count: int
    width: float  # diameter of the cylinder [m]

    @property
    def mass(self) -> float:
        """[kg]"""
        return self.count * self.ball.mass

    @property
    def depth(self) -> float:
        """At close packing [m]; of a single layer a diameter."""
        area = math.pi * self.width**2 / 4.0
        return max(self.count * self.ball.volume / (CLOSE_PACKING * area), self.ball.diameter)

    @property
    def fits(self) -> float:
        """Least height of an enclosure for it [m]: its depth and a particle."""
        return self.depth + self.ball.extent

    def close(self, settled: float) -> float:
        """Height [m] of the close bed, of one that settles to a height [m]."""
        return max(settled * LOOSE_PACKING / CLOSE_PACKING, self.ball.extent)

    def least(self, close: float) -> float:
        """Least height [m] of an enclosure that can be filled with it, by that of the close bed."""
        return close * (_FILLED if close > self.ball.extent else 1.001)


@dataclass(frozen=True)
class Candidate:
    """A bed, and the height of its enclosure."""

    bed: Bed
    height: float  # inside [m]
    clearance: float  # over the close bed [m]

    def changes(self, orientation: str, seed: int) -> dict[str, Any]:
        """Changes of the thesis's case that make it this one."""
        return {
            **dict(self.bed.ball.changes),
            "particles.count": self.bed.count,
            "enclosure.diameter": f"{self.bed.width!r} m",
            "enclosure.height": f"{self.height!r} m",
            "motion.orientation": orientation,
            "run.seed": seed,
            "output.keep": "summary",
            "output.frames": 0,
        }

    @property
    def words(self) -> str:
        """In words."""
        return (
            f"{self.bed.count} of {self.bed.ball.name} in {1e3 * self.bed.width:.4g} mm x "
            f"{1e3 * self.height:.4g} mm"
        )

    def features(self, amplitude: float) -> list[float]:
        """Numbers by which the surrogate tells candidates apart; amplitude [m]: of closed_form."""
        values = (
            self.clearance / amplitude,
            self.bed.width,
            self.bed.count,
            self.bed.ball.diameter,
        )
        return [math.log10(value) for value in values]


def closed_form(task: Task) -> float:
    """Amplitude [m] of the structure with the best bed of the budget, one body without rebound.

    The force gives pi F A a cycle at resonance, the structure takes 2 pi zeta M omega^2 A^2 and the
    bed 4 m omega^2 A^2 (eq. 6.10): A = F/(omega^2 (2 zeta M + 4 m/pi)). Below the Gamma at which a
    bed begins to move it damps nothing, so that A is no less than for 1.2 times that.
    """
    own, level = task.spec.structure, task.spec.level
    force = task.force * max(level.range)
    ideal = force / (
        task.omega**2 * (2.0 * own.damping_ratio * own.mass + 4.0 * task.budget / math.pi)
    )
    least = _LOWEST * fluidisation_threshold(level.orientation, _friction(task))
    return max(ideal, least * task.bare_amplitude / task.bare_gamma)


def refuse_at_rest(task: Task) -> None:
    """Raise InputError where the bare structure never shakes a bed off its enclosure."""
    level = task.spec.level
    moves = fluidisation_threshold(level.orientation, _friction(task))
    most = task.bare_gamma * max(level.range)
    if most <= moves:
        raise InputError(
            f"{task.spec.name}: [level] the bare structure moves by {most:.3g} g at most, and a "
            f"bed rides along up to {moves:.3g} g ({level.orientation}): no bed damps it; give the "
            "level at which it is too much, or another orientation"
        )


def _friction(task: Task) -> float:
    """Smallest friction at a wall in the catalogue."""
    from damper3d.case.case import DamperCase

    loaded = [
        DamperCase.load("thesis", dict(ball.changes) | {"particles.count": 1,
                        "enclosure.diameter": f"{10 * ball.extent!r} m",
                        "enclosure.height": f"{10 * ball.extent!r} m"})
        for ball in {ball.kind: ball for ball in task.catalogue}.values()
    ]  # fmt: skip
    return min(case.wall_law.mu for case in loaded)


def beds_of(task: Task) -> list[Bed]:
    """Beds of the budget that find room; InputError that names what binds where there is none."""
    space, search = task.spec.space, task.spec.search
    widest = task.widest
    found, why = [], dict.fromkeys(("few", "many", "wide", "high"), 0)
    for ball in task.catalogue:
        count = math.floor(task.budget / ball.mass * (1 + 1e-9))
        if not search.fewest <= count <= search.most:
            why["few" if count < search.fewest else "many"] += 1
            continue
        if ball.extent * _NARROWEST > widest:
            why["wide"] += 1
            continue
        counts = {max(math.floor(share * count), search.fewest) for share in SHARES}
        beds = {_bed(ball, n, layers, widest) for n in counts for layers in LAYERS}
        fit = [bed for bed in beds if bed.fits <= space.height]
        why["high"] += not fit
        found += sorted(fit, key=lambda bed: (bed.count, bed.width))
    if found:
        return found
    sizes = [ball.extent for ball in task.catalogue]
    lines = {
        "few": f"the mass budget, {task.budget:.4g} kg, is below {search.fewest} particles of "
        f"{why['few']} balls of the catalogue: allow a larger added_mass, or smaller balls",
        "many": f"the budget makes more than {search.most} particles of {why['many']} balls: give "
        "larger balls, or a larger [search] most",
        "wide": f"the space, {1e3 * widest:g} mm wide, is below {_NARROWEST:g} diameters of "
        f"{why['wide']} balls (the least is {1e3 * min(sizes):g} mm): give more width",
        "high": f"the space, {1e3 * space.height:g} mm high, holds no such bed with a diameter to "
        f"spare, for {why['high']} balls: give more room, or a smaller added_mass",
    }  # fmt: skip
    binding = [lines[name] for name, count in why.items() if count]
    raise InputError(f"{task.spec.name}: no design fits: {'; '.join(binding)}")


def _bed(ball: Ball, count: int, layers: float, widest: float) -> Bed:
    """A bed of so many layers, or as wide as the space."""
    area = count * ball.volume / (layers * _LAYER * ball.diameter)
    width = max(math.sqrt(4.0 * area / math.pi), _NARROWEST * ball.extent)
    return Bed(ball, count, float(f"{min(width, widest):.4g}"))


def pool(
    beds: Sequence[Bed], heights: Sequence[float], amplitude: float, highest: float
) -> list[Candidate]:
    """Candidates of beds that settle to some heights [m], in a space of the height highest [m]."""
    found = []
    for bed, settled in zip(beds, heights, strict=True):
        close = bed.close(settled)
        for part in CLEARANCES:
            height = float(f"{close + part * math.pi * amplitude:.5g}")
            if bed.least(close) <= height <= highest:
                found.append(Candidate(bed, height, height - close))
    return found


def spread(candidates: Sequence[Candidate], amplitude: float, number: int) -> list[int]:
    """Indices of some candidates far from each other, from the closed form's own and the first on.

    Greedy: each next one is the farthest from those chosen, in features over their range.
    """
    x = scaled(candidates, amplitude)
    ideal = [abs(math.log(c.clearance / (math.pi * amplitude))) for c in candidates]
    wide = [-c.bed.width for c in candidates]
    closed_form = min(range(len(candidates)), key=lambda k: (round(ideal[k], 6), wide[k], k))
    chosen = list(dict.fromkeys([closed_form, 0]))[:number]
    while len(chosen) < min(number, len(candidates)):
        gaps = np.linalg.norm(x[:, None] - x[None, chosen], axis=2).min(axis=1)
        chosen.append(int(np.argmax(gaps)))
    return chosen


def scaled(candidates: Sequence[Candidate], amplitude: float) -> np.ndarray:
    """Features (n, 4), each over its range."""
    x = np.array([c.features(amplitude) for c in candidates])
    span = np.ptp(x, axis=0)
    return np.asarray((x - x.min(axis=0)) / np.where(span > 0, span, 1.0))


def rule_of_thumb(task: Task, beds: Sequence[Bed], heights: Sequence[float]) -> Candidate:
    """The thesis's rule I (sec. 9.2): a ball of an eighth of the width, as wide as the space.

    Its clearance makes the bare structure's amplitude the optimum (eq. 6.11); of beds that settle
    to some heights [m] and find room in the space, of which there is one.
    """
    wanted, highest = task.widest / 8, task.spec.space.height

    def order(pair: tuple[Bed, float]) -> tuple[float, ...]:
        bed, _ = pair
        return abs(bed.ball.diameter - wanted), -bed.count, -bed.width

    known = zip(beds, heights, strict=True)
    fit = [(bed, high) for bed, high in known if bed.least(bed.close(high)) <= highest]
    bed, settled = min(fit, key=order)
    close = bed.close(settled)
    return of_height(bed, min(close + math.pi * task.bare_amplitude, highest), close)


def of_height(bed: Bed, height: float, close: float) -> Candidate:
    """A bed of a height [m] when close, in an enclosure of another [m], or the least it fills."""
    rounded = float(f"{max(height, bed.least(close)):.5g}")
    return Candidate(bed, rounded, rounded - close)


def nearby(candidate: Candidate, highest: float) -> list[Candidate]:
    """Candidates of the same bed with somewhat other clearances, up to a height [m]."""
    close = candidate.height - candidate.clearance
    found = [of_height(candidate.bed, close + factor * candidate.clearance, close)
             for factor in NEARBY]  # fmt: skip
    return [one for one in dict.fromkeys(found) if one.height <= highest and one != candidate]


def random_beds(task: Task, beds: Sequence[Bed], number: int) -> list[tuple[Bed, float]]:
    """Random designs: ball, share of the budget, width, height, each evenly over what is allowed.

    Beds, and the part of the height that is left in the space over the closely packed bed.
    """
    rng = np.random.default_rng([task.spec.search.seed, 30])
    found: list[tuple[Bed, float]] = []
    balls = list(dict.fromkeys(bed.ball for bed in beds))
    while len(found) < number:
        ball = balls[int(rng.integers(len(balls)))]
        full = math.floor(task.budget / ball.mass * (1 + 1e-9))
        count = int(rng.integers(max(full // 3, 1), full + 1))
        width = float(f"{rng.uniform(_NARROWEST * ball.extent, task.widest):.4g}")
        bed, part = Bed(ball, count, width), float(rng.uniform())
        if bed.fits <= task.spec.space.height:
            found.append((bed, part))
    return found
