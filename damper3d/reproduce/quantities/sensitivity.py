"""Quantities of the properties: position of the optimum for each value, change of the level."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from damper3d.reproduce.quantities.properties import STANDARD, VALUES, span
from damper3d.studies.map.grid import MapResult
from damper3d.studies.map.peaks import Peak, highest
from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import slope

Row = dict[str, Any]
Key = tuple[str, float]  # property and value; "standard" and 1

SENSITIVITY = Quantities()


@dataclass(frozen=True)
class Optimum:
    """The runs of one value: the highest peak of eta, and its mean in the bouncing bed."""

    rows: list[Row]
    peak: Peak | None
    gammas: set[float]  # above every optimum, that all values have

    def level(self, seed: int | None = None) -> float | None:
        """Mean eta over these Gammas, of all packings or of one; None without any."""
        values = [row["efficiency"] for row in self.rows
                  if row["gamma"] in self.gammas and seed in (None, row["seed"])]  # fmt: skip
        return math.fsum(values) / len(values) if values else None


Peaks = dict[Key, Optimum]


def peaks_of(rows: Sequence[Row]) -> Peaks:
    """By property and value, as they come, of the runs that are done."""
    groups: dict[Key, list[Row]] = {}
    for row in done(rows):
        groups.setdefault((row["property"], row["value"]), []).append(row)
    peaks: dict[Key, Peak | None] = {}
    for key, own in groups.items():
        result = MapResult.of(own)
        peaks[key] = highest(result.peaks(float(result.frequency[0])))
    optima = [peak.gamma for peak in peaks.values() if peak is not None]
    gammas: set[float] = set()
    if groups and len(optima) == len(groups):  # none where a value has no optimum
        common = set.intersection(*({row["gamma"] for row in own} for own in groups.values()))
        gammas = {gamma for gamma in common if gamma > max(optima)}
    return {key: Optimum(own, peaks[key], gammas) for key, own in groups.items()}


@SENSITIVITY.quantity
def optimum_of_value(found: Peaks) -> list[Row]:
    """Gamma of each setting's optimum with its interval (low, high), and the standard's own."""
    standard = found[("standard", 1.0)].peak if ("standard", 1.0) in found else None
    return [
        {"property": name, "setting": setting, "value": own.peak.gamma, "low": own.peak.low,
         "high": own.peak.high, "standard": standard.gamma, "standard_low": standard.low,
         "standard_high": standard.high}
        for (name, setting), own in sorted(found.items(), key=lambda item: item[0])
        if own.peak and standard and name in VALUES
    ]  # fmt: skip


@SENSITIVITY.quantity
def change_of_level(found: Peaks) -> list[Row]:
    """Change of eta from the least setting of a property to the largest, over its mean; its noise.

    From the slope of the mean over the bouncing bed, a packing a point; the standard among them.
    """
    trends = []
    for name in VALUES:
        x, y = [], []
        for (own_name, setting), own in found.items():
            if own_name in (name, "standard"):
                at = span(name, STANDARD[name] if own_name == "standard" else setting)
                for seed in dict.fromkeys(row["seed"] for row in own.rows):
                    if (level := own.level(seed)) is not None:
                        x.append(at)
                        y.append(level)
        if (line := slope(x, y)) is not None:
            scale = (max(x) - min(x)) / (math.fsum(y) / len(y))
            change, noise = line.value * scale, line.half_width * scale
            remark = "" if abs(change) > noise else ", flat within noise"
            trends.append({"property": name, "value": change, "noise": noise,
                           "remark": remark})  # fmt: skip
    return trends
