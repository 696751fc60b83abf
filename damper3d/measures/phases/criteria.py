"""The motional phase of a run, named from its measures by stated criteria (docs/damper/phases.md).

The names are the thesis's (sections 2.5, 6.3, 6.4), which gave them by eye. Every threshold
stands here with its reason; none depends on the run, the frequency or the amplitude.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from damper3d.measures.phases.particle_motion import SEEN
from granulab.contact.files.units import nearest
from granulab.errors import InputError

# What most of the particles do names the phase ("the type of dynamic motion that appeared to
# dominate the granular medium", sec. 6.3).
MOST = 0.5
# A bed is solid where all but an unseen tenth of it is; a part that moves makes another phase.
ALL = 1.0 - SEEN
# An end is struck by the bed where it reverses a quarter of the ideal collision's momentum 2 M V
# (eq. 6.10), as for a bed that arrives at rest and leaves with V/2.
STRUCK = 0.25
# A bed goes from end to end where its mass crosses half of the clearance.
CROSSED = 0.5
# One collision twice as strong as the next, in |b - a|/(b + a): "significant difference".
UNEVEN = 1.0 / 3.0
# A layer is hot where its particles have twice the energy of those in the middle of the bed.
HOT = 2.0
# A cage ends where a particle goes its own diameter from one touch to the next. In an even gas this
# is so below a fill ratio of about 0.1 (mean free path d/(6 sqrt 2 phi chi)).
CAGE = 1.0


class Look(NamedTuple):
    """Label, colour and marker of a phase."""

    label: str
    colour: str
    marker: str


class Criterion(NamedTuple):
    """measure >= threshold, or below it."""

    measure: str
    threshold: float
    at_least: bool = True

    def holds(self, measures: Mapping[str, Any]) -> bool:
        """True where the measures fulfil it."""
        return (measures[self.measure] >= self.threshold) is self.at_least


class Neighbour(NamedTuple):
    """The phase that it would be if one measure were on the other side of its threshold."""

    phase: str
    measure: str
    value: float
    threshold: float

    @property
    def distance(self) -> float:
        """|ln(value/threshold)|: 0 at the boundary, 0.7 a factor of two away."""
        return abs(math.log(self.value / self.threshold)) if self.value > 0.0 else math.inf


class Phase(NamedTuple):
    """The name of a run's phase, and what is next to it, nearest first."""

    name: str
    orientation: str
    neighbours: list[Neighbour]

    def as_json(self) -> dict[str, Any]:
        """Name, and per neighbouring phase the measure, its value and threshold, and how near."""
        near = [
            {**n._asdict(), "distance": n.distance if math.isfinite(n.distance) else None}
            for n in self.neighbours
        ]
        return {"name": self.name, "orientation": self.orientation, "next": near}


_ALL = {
    "solid_like": Look("solid-like", "#8c8c8c", "s"),
    "local_fluidisation": Look("local fluidisation", "#a6cee3", "v"),
    "global_fluidisation": Look("global fluidisation", "#1f78b4", "o"),
    "partial_fluidisation": Look("partial fluidisation", "#a6cee3", "v"),
    "fluidisation_convection": Look("fluidisation/convection", "#1f78b4", "o"),
    "transition": Look("transition", "#ffbf00", "D"),
    "leidenfrost": Look("Leidenfrost effect", "#b2df8a", "^"),
    "buoyancy_convection": Look("buoyancy convection", "#33a02c", "P"),
    "convection": Look("convection", "#66c2a5", "<"),
    "bouncing_bed": Look("bouncing bed", "#e31a1c", "*"),
    "gas_like": Look("gas-like", "#cab2d6", "h"),
}
Rules = list[tuple[str, tuple[Criterion, ...]]]  # a name, and what must hold together
_ALWAYS: Rules = [
    ("gas_like", (Criterion("free_path", CAGE),)),
    (
        "bouncing_bed",
        (
            Criterion("low_impulse", STRUCK),
            Criterion("high_impulse", STRUCK),
            Criterion("stroke", CROSSED),
            Criterion("coherence", MOST),
        ),
    ),
    ("solid_like", (Criterion("carried_share", ALL),)),
]
# "Significant decompaction of particles in a cycle that allows the particles to be transported"
# (sec. 6.4.3): a bed that comes together in each cycle is not loose, whatever happens between.
_CONVECTING = (Criterion("travelling_share", MOST), Criterion("packed_share", MOST, at_least=False))
_VERTICAL: Rules = [
    *_ALWAYS,
    ("transition", (Criterion("coherence", MOST), Criterion("contrast", UNEVEN))),
    ("buoyancy_convection", (*_CONVECTING, Criterion("circulation", SEEN))),
    ("leidenfrost", (*_CONVECTING, Criterion("hot_low", HOT))),
    ("convection", _CONVECTING),
    ("local_fluidisation", (Criterion("agitated_share", MOST, at_least=False),)),
    ("global_fluidisation", ()),
]
_HORIZONTAL: Rules = [
    *_ALWAYS,
    ("convection", _CONVECTING),
    ("partial_fluidisation", (Criterion("agitated_share", MOST, at_least=False),)),
    ("fluidisation_convection", ()),
]
# The first rule that holds names the phase. Without gravity nothing says what is below, so that the
# horizontal names serve.
RULES = {"vertical": _VERTICAL, "horizontal": _HORIZONTAL, "none": _HORIZONTAL}
# Phases of each orientation in the order of maps and legends.
PHASES = {
    orientation: {name: look for name, look in _ALL.items() if name in {rule[0] for rule in rules}}
    for orientation, rules in RULES.items()
}


def criteria_of(orientation: str, rules: Mapping[str, Rules] = RULES) -> list[Criterion]:
    """The criteria that name phases, once each, in the order of the rules."""
    return list(dict.fromkeys(c for _, together in rules[orientation] for c in together))


def classify(
    measures: Mapping[str, Any], orientation: str, by: Mapping[str, Rules] = RULES
) -> Phase:
    """The phase of a run from its measures (motion_measures.py) and how gravity points.

    by: other rules than those of docs/damper/phases.md, for a study of them. Raises InputError for
    an orientation that there is not.
    """
    if orientation not in by:
        raise InputError(f"orientation {orientation!r}: {nearest(orientation, list(by))}")
    rules, criteria = by[orientation], criteria_of(orientation, by)
    holds = {criterion: criterion.holds(measures) for criterion in criteria}
    name = _first(rules, holds)
    neighbours: dict[str, Neighbour] = {}
    for criterion in criteria:
        other = _first(rules, {**holds, criterion: not holds[criterion]})
        there = Neighbour(
            other, criterion.measure, float(measures[criterion.measure]), criterion.threshold
        )
        known = neighbours.get(other)
        if other != name and (known is None or there.distance < known.distance):
            neighbours[other] = there
    return Phase(name, orientation, sorted(neighbours.values(), key=lambda n: n.distance))


def phase_of_run(folder: str | Path, discard: int | None = None) -> dict[str, Any]:
    """Phase, what is next to it, and measures of a run folder, as its summary holds them.

    All None where the run keeps too little: not one counted cycle with a frame on either
    side, or fewer than eight frames a cycle. `discard` cycles do not count; None: as in the folder.
    Raises FolderError where the folder holds no run or a damaged one.
    """
    from damper3d.measures.phases.motion import of_run
    from damper3d.measures.phases.motion_measures import measure_motion

    motion = of_run(folder, discard)
    if motion is None:
        return {"phase": None, "phase_next": None, "phase_measures": None}
    measures = measure_motion(motion)
    phase = classify(measures, motion.orientation)
    return {"phase": phase.name, "phase_next": phase.as_json()["next"], "phase_measures": measures}


def _first(rules: Rules, holds: Mapping[Criterion, bool]) -> str:
    return next(name for name, together in rules if all(holds[c] for c in together))
