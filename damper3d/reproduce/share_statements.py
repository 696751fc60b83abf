"""What the thesis says of the shares (sec. 6.5), judged point by point on rows of ours."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from damper3d.engine.records import CLASSES
from damper3d.reproduce.curves import Curve, curve
from damper3d.reproduce.share_rules import about, above, falls
from damper3d.reproduce.statements import Check, Statement
from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import slope

Row = dict[str, Any]
Value = Callable[[Row], float | None]

_IMPACT, _DASHPOT, _SLIDER = "normal_damping", "tangential_damping", "friction"
# What a row's columns begin with, and what is called friction. Eq. 6.7 has one tangential term, the
# slider's where it slides and the dashpot's where not, and eq. 2.2 knows friction and impact alone.
COUNTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "budget": ("shares", (_SLIDER,)),
    "thesis's count": ("shares_contact_count", (_SLIDER, _DASHPOT)),
}


def _sum_of(column: str, pairs: tuple[str, ...], mechanisms: tuple[str, ...]) -> Value:
    def value(row: Row) -> float | None:
        parts = [row.get(f"{column}.{pair}.{name}") for pair in pairs for name in mechanisms]
        return None if None in parts else math.fsum(p for p in parts if p is not None)

    return value


def quantities(count: str) -> dict[str, Value]:
    """The three shares of a row as one of COUNTS has them."""
    column, friction = COUNTS[count]
    return {
        "inter-particle": _sum_of(column, CLASSES[:1], (_IMPACT, _DASHPOT, _SLIDER)),
        "friction": _sum_of(column, CLASSES, friction),
        "inter-particle friction": _sum_of(column, CLASSES[:1], friction),
    }


@dataclass(frozen=True)
class Landmarks:
    """Gamma of the peaks by diameter [mm] and frequency [Hz]; a peak that is not there lacks."""

    fluidisation: dict[tuple[int, float], float]
    bouncing_bed: dict[tuple[int, float], float]

    def of(self, size: int, frequency: float) -> dict[str, float]:
        """The peaks of one size and frequency by their names."""
        known = {"fluidisation": self.fluidisation, "bouncing bed": self.bouncing_bed}
        key = size, frequency
        return {name: gammas[key] for name, gammas in known.items() if key in gammas}

    def words(self, frequency: float) -> str:
        """All peaks of a frequency."""
        parts = []
        for name, gammas in (
            ("fluidisation optimum", self.fluidisation),
            ("bouncing-bed onset", self.bouncing_bed),
        ):
            own = [f"{g:.3g} ({d} mm)" for (d, f), g in sorted(gammas.items()) if f == frequency]
            parts.append(f"{name} at Gamma {', '.join(own)}" if own else f"no {name}")
        return "; ".join(parts)


def landmarks(rows: list[Row]) -> Landmarks:
    """The two peaks of the efficiency along Gamma of each size and frequency in the rows."""
    from damper3d.case.case import DamperCase
    from damper3d.studies.map.grid import MapResult
    from damper3d.studies.map.ridges import ridges
    from damper3d.studies.predict.prediction import predict

    prediction = predict(DamperCase.load("thesis"))
    found: dict[str, dict[tuple[int, float], float]] = {"fluidisation": {}, "bouncing_bed": {}}
    for size in dict.fromkeys(row["diameter_mm"] for row in done(rows)):
        own = MapResult.of(row for row in rows if row["diameter_mm"] == size)
        for one in ridges(own, prediction):
            if one.ridge in found:
                found[one.ridge][size, one.frequency] = one.peak.gamma
    return Landmarks(**found)


def of_size(rows: list[Row], size: int, frequency: float) -> list[Row]:
    """The runs of a diameter [mm] and frequency [Hz] that are done."""
    return [r for r in done(rows) if r["diameter_mm"] == size and r["frequency_hz"] == frequency]


@dataclass(frozen=True)
class _Counted:
    """The curves of one way of counting, by size and frequency, beside the landmarks."""

    rows: list[Row]
    count: str  # of COUNTS
    marks: Landmarks

    def curves(self, quantity: str) -> Iterator[tuple[int, float, Curve]]:
        """Diameter [mm], frequency [Hz], share against Gamma."""
        places = sorted({(r["frequency_hz"], r["diameter_mm"]) for r in done(self.rows)})
        for frequency, size in places:
            own = of_size(self.rows, size, frequency)
            yield size, frequency, curve(own, quantities(self.count)[quantity])

    def points(self, quantity: str, part: str = "") -> list[tuple[str, float]]:
        """Name and share of the points of a part of Gamma; "" is all of it."""
        found = []
        for size, frequency, own in self.curves(quantity):
            low, high = _part(part, self.marks.of(size, frequency))
            chosen = own.between(low, high)
            for gamma, share in zip(chosen.x, chosen.mean, strict=True):
                found.append((f"{size} mm, {frequency:g} Hz, Gamma {gamma:g}", share))
        return found

    def slopes(self, quantity: str, part: str) -> list[tuple[str, float]]:
        """Name and slope against ln Gamma of each curve that has the part."""
        found = []
        for size, frequency, own in self.curves(quantity):
            chosen = own.between(*_part(part, self.marks.of(size, frequency)))
            line = slope([math.log(x) for x in chosen.x], chosen.mean)
            if line is not None:
                found.append((f"{size} mm, {frequency:g} Hz", line.value))
        return found

    def by_size(self, quantity: str) -> list[tuple[str, float]]:
        """Name and slope of the share against the diameter [1/mm] of each frequency and Gamma."""
        columns: dict[tuple[float, float], list[tuple[float, float]]] = {}
        for size, frequency, own in self.curves(quantity):
            for gamma, share in zip(own.x, own.mean, strict=True):
                columns.setdefault((frequency, gamma), []).append((size, share))
        lines = {
            key: slope([size for size, _ in pairs], [share for _, share in pairs])
            for key, pairs in columns.items()
        }
        return [
            (f"{frequency:g} Hz, Gamma {gamma:g}", line.value)
            for (frequency, gamma), line in lines.items()
            if line is not None
        ]


def _part(name: str, marks: dict[str, float]) -> tuple[float, float]:
    """Gammas of a part of a curve; an empty interval where its landmark is not there."""
    nowhere = math.inf, -math.inf
    optimum, onset = marks.get("fluidisation"), marks.get("bouncing bed")
    if name == "to the optimum":
        return (0.0, optimum) if optimum else nowhere
    if name == "bouncing bed":
        return (onset, math.inf) if onset else nowhere
    if name == "beyond the optimum":
        return (optimum, onset or math.inf) if optimum else nowhere
    return 0.0, math.inf


def share_statements(rows: list[Row], marks: Landmarks) -> list[Statement]:
    """Sec. 6.5, each statement for both counts."""
    e_fold = "per factor e in Gamma"
    rules: list[tuple[str, Callable[[str, _Counted], Check]]] = [
        ("Particle-particle contacts dissipate more than 60 % everywhere.",
         lambda of, c: above(of, c.points("inter-particle"), 0.6)),
        ("... more than 80 % up to the fluidisation optimum.",
         lambda of, c: above(of, c.points("inter-particle", "to the optimum"), 0.8)),
        ("... less and less from there to the bouncing-bed onset, or to the end without one.",
         lambda of, c: falls(of, c.slopes("inter-particle", "beyond the optimum"), e_fold)),
        ("... generally more than 80 % beyond the bouncing-bed onset (judged: each point).",
         lambda of, c: above(of, c.points("inter-particle", "bouncing bed"), 0.8)),
        ("... the less the larger the particles (judged: a line over the sizes at each Gamma).",
         lambda of, c: falls(of, c.by_size("inter-particle"), "per mm")),
        ("Friction is the dominant source everywhere (judged: more than 50 %).",
         lambda of, c: above(of, c.points("friction"), 0.5)),
        ("... mainly between particles (judged: more than half of the friction).",
         lambda of, c: above(of, _ratios(c), 0.5)),
        ("... falls from low amplitudes to the fluidisation optimum.",
         lambda of, c: falls(of, c.slopes("friction", "to the optimum"), e_fold)),
        ("... goes on falling beyond the optimum, where there is convection.",
         lambda of, c: falls(of, c.slopes("friction", "beyond the optimum"), e_fold)),
        ("... is about 80 % in the bouncing bed (judged: the mean is between 70 and 90 %).",
         lambda of, c: about(of, c.points("friction", "bouncing bed"), 0.8)),
        ("... generally less the larger the particles (judged: a line over the sizes).",
         lambda of, c: falls(of, c.by_size("friction"), "per mm")),
    ]  # fmt: skip
    counted = {name: _Counted(rows, name, marks) for name in COUNTS}
    return [Statement(words, [rule(of, c) for of, c in counted.items()]) for words, rule in rules]


def _ratios(counted: _Counted) -> list[tuple[str, float]]:
    """Name and part of the friction that is between particles, of each point."""
    whole = dict(counted.points("friction"))
    own = counted.points("inter-particle friction")
    return [(name, share / whole[name]) for name, share in own if whole.get(name)]


def tangential_damping(rows: list[Row]) -> str:
    """What friction would have more if tangential damping were counted with it."""
    value = _sum_of("shares", CLASSES, (_DASHPOT,))
    shares = [share for row in done(rows) if (share := value(row)) is not None]
    if not shares:
        return ""
    return (
        f"tangential damping: {100 * min(shares):.1f} to {100 * max(shares):.1f} % of what is "
        "dissipated (budget), which friction would have more if it were counted there too"
    )
