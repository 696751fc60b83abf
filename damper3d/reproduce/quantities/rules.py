"""Quantities of the design rules: optima of each variant, their shifts, what lies beyond them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from damper3d.studies.map.grid import MapResult
from damper3d.studies.map.peaks import Peak, highest
from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import mean_sd, noise_of_difference, slope

Row = dict[str, Any]
Key = tuple[str, float]  # variant and frequency [Hz]

RULES = Quantities()
BOUNCING = "bouncing_bed"


@dataclass(frozen=True)
class Variant:
    """A damper beside the thesis's, and where it is run.

    rule       number of the rule that it is for
    height     in mm, where that is what differs
    width      diameter in mm, where that is what differs, at equal volume and mass
    """

    rule: str
    changes: Row
    frequencies: tuple[float, ...]
    gammas: tuple[float, ...]
    height: float = math.nan
    width: float = math.nan


# About the onset of eq. 6.11 at 40 Hz for a close packing: Gamma 32, 43 and 53 for the heights.
_BOUNCE = (8.0, 14.0, 20.0, 26.0, 32.0, 38.0, 46.0, 55.0, 66.0, 80.0)
_FLUID = (1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
_NEAR = (1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 8.0)  # the same about its optimum
_SHAPES = (8.0, 11.0, 14.0, 17.0, 20.0, 24.0, 29.0, 35.0)
_FREQUENCIES = (40.0, 80.0, 160.0)
# 6 mm and 3 mm by mass 3 to 2, which pack denser than one size: the mass of 358 of 5 mm.
_DENSER = [
    {"shape": "sphere:6mm", "count": 124},
    {"shape": "sphere:3mm", "count": 663},
]


def _high(height: float, **more: Any) -> Row:
    return {"particles.count": 358, "enclosure.height": f"{height:g} mm", **more}


_SIDE = 40.0  # [mm] height and width of the thesis's cylinder


def slenderness(variant: str) -> float:
    """Height over width [-] of a cylinder of the thesis's volume; NaN where width is not varied."""
    return (_SIDE / VARIANTS[variant].width) ** 3


def _wide(width: float, gammas: tuple[float, ...]) -> Variant:
    """The thesis's cylinder of 40 mm by 40 mm made deeper or flatter at the same volume."""
    size = {"enclosure.diameter": f"{width:g} mm"}
    return Variant("II", _high(round(_SIDE**3 / width**2, 1)) | size, (80.0,), gammas, width=width)


VARIANTS: dict[str, Variant] = {
    **{
        f"{height:g} mm": Variant("I", _high(height), (40.0,), _BOUNCE, height)
        for height in (45.0, 50.0, 55.0)
    },
    "denser": Variant(
        "I", {"enclosure.height": "50 mm", "particles.kind": _DENSER}, (40.0,), _BOUNCE
    ),
    "no gravity": Variant(
        "I", _high(50.0) | {"motion.orientation": "none"}, (40.0,), (1.0, 3.0, *_BOUNCE)
    ),
    "vertical": Variant("II", _high(40.0), _FREQUENCIES, _FLUID, width=40.0),
    "horizontal": Variant(
        "II", _high(40.0) | {"motion.orientation": "horizontal"}, _FREQUENCIES, _FLUID
    ),
    **{f"{width:g} mm wide": _wide(width, _NEAR) for width in (50.0, 34.0)},
    "narrow": _wide(28.28, _FLUID),
    "24 mm wide": _wide(24.0, _NEAR),
    "round": Variant(
        "9.3", {"particles.shape": "sphere:7.6mm", "particles.count": 90}, (40.0,), _SHAPES
    ),
    "oblate": Variant(
        "9.3", {"particles.shape": "oblate:0.5", "particles.count": 90}, (40.0,), _SHAPES
    ),
}  # fmt: skip


def points() -> list[Row]:
    """The labels of each point."""
    return [
        {"variant": name, "frequency_hz": frequency, "gamma": gamma}
        for name, variant in VARIANTS.items()
        for frequency in variant.frequencies
        for gamma in variant.gammas
    ]


@dataclass(frozen=True)
class Optimum:
    """The runs of a variant at a frequency, and their highest peak."""

    rows: list[Row]
    peak: Peak | None

    @property
    def phase(self) -> str | None:
        """Phase of most runs at the Gamma nearest to the peak."""
        if self.peak is None:
            return None
        gammas = sorted({row["gamma"] for row in self.rows})
        near = min(gammas, key=lambda gamma: abs(math.log(gamma / self.peak.gamma)))  # type: ignore[union-attr]
        names = [row.get("phase") for row in self.rows if row["gamma"] == near]
        return max(names, key=names.count, default=None)

    def at(self, gamma: float) -> list[float]:
        """Efficiencies at a Gamma, of each packing."""
        return [
            row["efficiency"] for row in self.rows
            if row["gamma"] == gamma and row["efficiency"] is not None
        ]  # fmt: skip


Found = dict[Key, Optimum]


def found_in(rows: Sequence[Row]) -> Found:
    """By variant and frequency, as they come, of the runs that are done."""
    groups: dict[Key, list[Row]] = {}
    for row in done(rows):
        groups.setdefault((row["variant"], float(row["frequency_hz"])), []).append(row)
    return {key: Optimum(own, _highest(own)) for key, own in groups.items()}


def _highest(rows: Sequence[Row]) -> Peak | None:
    result = MapResult.of(rows)
    return highest(result.peaks(float(result.frequency[0])))


@RULES.quantity
def optimum_of_variant(found: Found) -> list[Row]:
    """Gamma of each variant's optimum, with its interval and its height [mm]."""
    return [
        {"variant": name, "frequency_hz": frequency, "value": own.peak.gamma,
         "low": own.peak.low, "high": own.peak.high, "rule": VARIANTS[name].rule,
         "height_mm": VARIANTS[name].height}
        for (name, frequency), own in found.items() if own.peak
    ]  # fmt: skip


@RULES.quantity
def shift_of_optimum(found: Found, of: str, against: str) -> list[Row]:
    """Distance of the intervals of two variants' optima, |ln Gamma|; below 0: they overlap.

    Also both Gammas, first and second.
    """
    rows = []
    for (name, frequency), own in found.items():
        other = found.get((against, frequency))
        if name == of and other and own.peak and other.peak:
            a, b = own.peak, other.peak
            gap = max(math.log(b.low / a.high), math.log(a.low / b.high))
            rows.append({"frequency_hz": frequency, "value": gap, "first": a.gamma,
                         "second": b.gamma})  # fmt: skip
    return rows


@RULES.quantity
def power_of_depth(found: Found, frequency: float) -> list[Row]:
    """Size of the power of height over width with which the optimum goes, at equal volume.

    Also the power itself, and how many beds of unlike width have an optimum at the frequency [Hz].
    """
    beds = [(slenderness(name), own.peak.gamma) for (name, at), own in found.items()
            if at == frequency and own.peak and not math.isnan(slenderness(name))]  # fmt: skip
    line = slope([math.log(part) for part, _ in beds], [math.log(gamma) for _, gamma in beds])
    if line is None:
        return []
    return [{"value": abs(line.value), "power": line.value, "noise": line.half_width,
             "beds": len(beds)}]  # fmt: skip


@RULES.quantity
def other_phases(found: Found, variant: str) -> list[Row]:
    """Best mean efficiency of each phase over that of the bouncing bed, of a variant."""
    rows = []
    for (name, frequency), own in found.items():
        if name != variant:
            continue
        best: dict[str, float] = {}
        for gamma in sorted({row["gamma"] for row in own.rows}):
            names = [row.get("phase") for row in own.rows if row["gamma"] == gamma]
            phase, values = max(names, key=names.count), own.at(gamma)
            if phase and values:
                best[phase] = max(best.get(phase, 0.0), math.fsum(values) / len(values))
        if BOUNCING in best:
            rows += [
                {"frequency_hz": frequency, "phase": phase, "value": eta / best[BOUNCING]}
                for phase, eta in best.items() if phase != BOUNCING
            ]  # fmt: skip
    return rows


@RULES.quantity
def beyond_optimum(found: Found, variants: Sequence[str], factor: float) -> list[Row]:
    """Change of eta at the Gamma nearest to so many times that of the optimum; with its noise."""
    rows = []
    for (name, frequency), own in found.items():
        if name not in variants or own.peak is None:
            continue
        gammas = sorted({row["gamma"] for row in own.rows})
        top, there = (
            min(gammas, key=lambda g: abs(math.log(g / (own.peak.gamma * part))))  # type: ignore[union-attr]
            for part in (1.0, factor)
        )
        first, second = mean_sd(own.at(top)), mean_sd(own.at(there))
        if first.mean is None or second.mean is None or there <= top:
            continue
        noise = noise_of_difference(first, second)
        rows.append({"variant": name, "frequency_hz": frequency, "gamma": there,
                     "value": second.mean - first.mean, "eta": second.mean,
                     "noise": math.nan if noise is None else noise})  # fmt: skip
    return rows
