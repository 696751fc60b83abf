"""Quantities of the shares (sec. 6.5): particle-particle contacts and friction, by two counts."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from damper3d.engine.records import CLASSES
from damper3d.reproduce.quantities.curves import Curve, curve
from granulab.campaign.claims.judge import Quantities
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


def of_size(rows: Sequence[Row], size: int, frequency: float) -> list[Row]:
    """The runs of a diameter [mm] and frequency [Hz] that are done."""
    return [r for r in done(rows) if r["diameter_mm"] == size and r["frequency_hz"] == frequency]


@dataclass(frozen=True)
class Readings:
    """Data of the claims: the rows and the peaks of the efficiency in them."""

    rows: Sequence[Row]
    marks: Landmarks

    def curves(self, share: str, part: str = "") -> Iterator[tuple[Row, Curve]]:
        """Count, diameter and frequency, and the share against Gamma, in a part of it or all."""
        points = sorted({(r["frequency_hz"], r["diameter_mm"]) for r in done(self.rows)})
        for count in COUNTS:
            for frequency, size in points:
                low, high = _part(part, self.marks.of(size, frequency))
                own = curve(of_size(self.rows, size, frequency), quantities(count)[share])
                labels = {"count": count, "diameter_mm": size, "frequency_hz": frequency}
                yield labels, own.between(low, high)


SHARES = Quantities()


@SHARES.quantity
def share_at_points(readings: Readings, of: str, part: str = "") -> list[Row]:
    """A share at each point of a part of Gamma, by both counts."""
    return [
        labels | {"gamma": gamma, "value": share}
        for labels, own in readings.curves(of, part)
        for gamma, share in own.points.items()
    ]


@SHARES.quantity
def slope_of_share(readings: Readings, of: str, part: str) -> list[Row]:
    """Slope over ln Gamma of each curve that has the part [points of per cent]."""
    found = []
    for labels, own in readings.curves(of, part):
        line = slope([math.log(x) for x in own.x], own.mean)
        if line is not None:
            found.append(labels | {"value": 100 * line.value})
    return found


@SHARES.quantity
def slope_over_size(readings: Readings, of: str) -> list[Row]:
    """Slope of a share over the diameter at each frequency and Gamma [points of per cent/mm]."""
    columns: dict[tuple[str, float, float], list[tuple[float, float]]] = {}
    for one in share_at_points(readings, of):
        key = one["count"], one["frequency_hz"], one["gamma"]
        columns.setdefault(key, []).append((one["diameter_mm"], one["value"]))
    found = []
    for (count, frequency, gamma), pairs in columns.items():
        line = slope([size for size, _ in pairs], [share for _, share in pairs])
        if line is not None:
            found.append({"count": count, "frequency_hz": frequency, "gamma": gamma,
                          "value": 100 * line.value})  # fmt: skip
    return found


@SHARES.quantity
def friction_between_particles(readings: Readings) -> list[Row]:
    """Part of the friction that is between particles, at each point, by both counts."""
    whole = [one["value"] for one in share_at_points(readings, "friction")]
    own = share_at_points(readings, "inter-particle friction")
    return [
        one | {"value": one["value"] / friction}
        for one, friction in zip(own, whole, strict=True)
        if friction
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


def tangential_damping(rows: list[Row]) -> str:
    """Return what friction would have more if tangential damping were counted with it."""
    value = _sum_of("shares", CLASSES, (_DASHPOT,))
    shares = [share for row in done(rows) if (share := value(row)) is not None]
    if not shares:
        return ""
    return (
        f"tangential damping: {100 * min(shares):.1f} to {100 * max(shares):.1f} % of what is "
        "dissipated (budget), which friction would have more if it were counted there too"
    )
