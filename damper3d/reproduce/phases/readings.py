"""Names of the points of the table, by docs/damper/phases.md and by other readings of the text.

The text has the border between partial fluidisation and fluidisation/convection, in horizontal
motion, in three ways that are not the same; each is a criterion here, and nothing else differs.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from damper3d.measures.phases.criteria import ALL, MOST, RULES, Criterion, Rules, classify
from granulab.campaign.output.layout import done

Row = dict[str, Any]

_MEASURES = "phase_measures."
PARTIAL = "partial_fluidisation"
OURS = "most rest"
# By which particles a horizontal bed is partially fluidised: the criterion that bounds it.
READINGS: dict[str, Criterion] = {
    # "The type of dynamic motion that appeared to dominate" (sec. 6.3); as docs/damper/phases.md.
    OURS: Criterion("agitated_share", MOST, at_least=False),
    # "Fluidisation spreads to the deep layers" when the phase is global (sec. 6.4.3.3).
    "a tenth rests": Criterion("agitated_share", ALL, at_least=False),
    # "The deep particle layers exhibit a similar motion to the solid-like phase" (sec. 6.4.3.4).
    "deep layers carried": Criterion("deep_carried_share", MOST),
    # "Convection zones extend deeper" in fluidisation/convection (sec. 6.4.3.4): until then more
    # of those that move return in a cycle than go on.
    "more return": Criterion("returning_share", MOST),
}


def rules_by(reading: str) -> Mapping[str, Rules]:
    """The rules of docs/damper/phases.md with another border of partial fluidisation."""
    border = (READINGS[reading],)
    return {
        orientation: [(name, border if name == PARTIAL else rule) for name, rule in rules]
        for orientation, rules in RULES.items()
    }


def returning_share(measures: Mapping[str, Any]) -> float:
    """Of the particles that move against their neighbours, the part that returns; 1 where none."""
    moves = measures["fluidised_share"] + measures["convecting_share"]
    return float(measures["fluidised_share"] / moves) if moves > 0.0 else 1.0


@dataclass(frozen=True)
class Point:
    """A point of the table: the mean over its packings, and the name that most of them have.

    names       by each reading of READINGS
    measures    means of those of damper3d.measures.phases.motion_measures that the rows have
    """

    orientation: str
    height_mm: int
    cycles: int
    frequency_hz: float
    gamma: float
    efficiency: float
    walls: float
    names: Mapping[str, str]
    measures: Mapping[str, float]

    @property
    def name(self) -> str:
        """Its name by docs/damper/phases.md."""
        return self.names[OURS]

    @property
    def labels(self) -> Row:
        """Labels that it is known by."""
        return {label: getattr(self, label) for label in LABELS}


Points = Sequence[Point]
LABELS = "orientation", "height_mm", "cycles", "frequency_hz", "gamma"


def points_of(rows: Sequence[Row]) -> list[Point]:
    """The points of the runs that are done and have a phase, by rising Gamma."""
    found: dict[tuple[Any, ...], list[Row]] = {}
    for row in done(rows):
        if row["phase"]:
            found.setdefault(tuple(row[key] for key in LABELS), []).append(row)
    return [_point(dict(zip(LABELS, key, strict=True)), own) for key, own in sorted(found.items())]


def _point(labels: Row, rows: Sequence[Row]) -> Point:
    measured = [_measures(row) for row in rows]
    names = {
        reading: _commonest([classify(one, labels["orientation"], by).name for one in measured])
        for reading in READINGS
        for by in [rules_by(reading)]
    }

    def mean(values: list[float]) -> float:
        return sum(values) / len(values)

    return Point(
        **labels,
        efficiency=mean([row["efficiency"] for row in rows]),
        walls=mean([row["efficiency_wall_work"] for row in rows]),
        names=names,
        measures={
            name: mean([one[name] for one in measured])
            for name, value in measured[0].items()
            if value is not None
        },
    )


def _measures(row: Row) -> Row:
    own = {k.removeprefix(_MEASURES): v for k, v in row.items() if k.startswith(_MEASURES)}
    # Without gravity nothing is deep: no layer is carried.
    own["deep_carried_share"] = own["deep_carried_share"] or 0.0
    return own | {"returning_share": returning_share(own)}


def _commonest(names: Sequence[str]) -> str:
    return Counter(names).most_common(1)[0][0]
