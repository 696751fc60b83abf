"""Quantities of efficiency maps: where their ridges lie, how high they are, how alike two maps are.

The fluidisation optimum of a frequency is here its largest eta up to Gamma 6, also where that lies
at the least Gamma that was run: at high frequencies it does.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from damper3d.reproduce.panels import Row, prediction_of
from damper3d.studies.map.grid import MapResult
from damper3d.studies.map.peaks import Peak
from damper3d.studies.map.ridges import FLUIDISATION, OnRidge, ridges
from damper3d.studies.predict.prediction import Prediction
from granulab.campaign.claims.judge import Quantities

_APART = 2.0  # by which factor the onset is above Gamma 3 where the two ridges are distinguished
_MOST = 6.0  # Gamma up to which the optimum is looked for: twice that of the thesis

MAPS = Quantities()


@dataclass(frozen=True)
class Ridges:
    """A map with what is predicted of it and the peaks that it has."""

    result: MapResult
    prediction: Prediction
    peaks: list[OnRidge]

    @property
    def frequencies(self) -> list[float]:
        """Those that have a value [Hz]."""
        return [f for f in np.unique(self.result.frequency).tolist() if len(self.result.at(f))]

    def peak(self, frequency: float, ridge: str) -> Peak | None:
        """The peak of a ridge at a frequency [Hz]."""
        found = (p for p in self.peaks if (p.frequency, p.ridge) == (frequency, ridge))
        return next((item.peak for item in found), None)

    def expected(self, ridge: str) -> list[float]:
        """The frequencies at which a ridge can be seen in the map, by eq. 6.11 (close packing).

        The bouncing bed's where its onset is below the largest Gamma but one, so that a maximum
        can stand out; the fluidisation's where that onset is well above Gamma 3.
        """
        least, most = FLUIDISATION * _APART, sorted(set(self.result.gamma.tolist()))[-2:][0]
        onsets = {f: self.prediction.best.onset(f) or math.inf for f in self.frequencies}
        if ridge == "bouncing_bed":
            return [f for f, onset in onsets.items() if onset < most]
        return [f for f, onset in onsets.items() if onset > least]

    def along(self, ridge: str) -> list[tuple[float, Peak]]:
        """Frequency [Hz] and peak of a ridge where it can be seen."""
        peaks = [(frequency, self.peak(frequency, ridge)) for frequency in self.expected(ridge)]
        return [(frequency, peak) for frequency, peak in peaks if peak is not None]

    def optima(self) -> dict[float, tuple[float, float]]:
        """Gamma and efficiency of the fluidisation optimum by frequency [Hz]."""
        found = {}
        for frequency in self.expected("fluidisation"):
            at = self.result.at(frequency)
            at = at[self.result.gamma[at] <= _MOST]
            if len(at):
                best = at[self.result.efficiency[at].argmax()]
                found[frequency] = (
                    float(self.result.gamma[best]), float(self.result.efficiency[best])
                )  # fmt: skip
        return found


Maps = Mapping[tuple[str, int], Ridges]  # by orientation and height [mm]


def ridges_by_panel(rows: Sequence[Row]) -> dict[tuple[str, int], Ridges]:
    """The maps that rows have, by orientation and height [mm]; all of one diameter."""
    panels: dict[tuple[str, int], list[Row]] = {}
    for row in rows:
        panels.setdefault((row["orientation"], row["height_mm"]), []).append(row)
    found = {}
    for key, own in panels.items():
        prediction = prediction_of(own)
        if prediction is not None:
            result = MapResult.of(own)
            found[key] = Ridges(result, prediction, ridges(result, prediction))
    return found


def exponent(frequencies: Sequence[float], values: Sequence[float]) -> float | None:
    """Exponent of f, of a line through ln value over ln f; None for fewer than two points."""
    if len(values) < 2:
        return None
    return float(np.polyfit(np.log(frequencies), np.log(values), 1)[0])


def geometric_mean(values: Sequence[float]) -> float:
    """The exponential of the mean logarithm."""
    return math.exp(sum(map(math.log, values)) / len(values))


def likeness(first: MapResult, second: MapResult) -> tuple[float, float] | None:
    """Correlation of eta over the points that both have, and root-mean-square difference.

    None for fewer than three points, or where one does not vary.
    """
    known = [
        {(f, g): eta for f, g, eta in zip(*columns, strict=True) if np.isfinite(eta)}
        for columns in (
            (r.frequency.tolist(), r.gamma.tolist(), r.efficiency.tolist())
            for r in (first, second)
        )
    ]  # fmt: skip
    common = sorted(known[0].keys() & known[1].keys())
    a, b = np.array([[values[point] for point in common] for values in known])
    if len(common) < 3 or not (a.std() and b.std()):
        return None
    return float(np.corrcoef(a, b)[0, 1]), float(np.sqrt(np.mean((a - b) ** 2)))


@MAPS.quantity
def ridge_efficiency(maps: Maps, ridge: str) -> list[Row]:
    """Efficiency of a ridge at each frequency at which it can be seen; NaN where no peak is."""
    peaks = [(key, f, one.peak(f, ridge)) for key, one in maps.items() for f in one.expected(ridge)]
    return [_efficiency(key, f, peak.efficiency if peak else None) for key, f, peak in peaks]


@MAPS.quantity
def optimum_efficiency(maps: Maps) -> list[Row]:
    """Efficiency of the fluidisation optimum at each frequency."""
    return [
        _efficiency(key, f, eta)
        for key, one in maps.items()
        for f, (_, eta) in one.optima().items()
    ]


def _efficiency(key: tuple[str, int], frequency: float, eta: float | None) -> Row:
    shown = "no peak" if eta is None else f"{eta:.2f}"
    return _labels(key) | {"frequency_hz": frequency, "value": eta, "shown": shown}


@MAPS.quantity
def ridge_gamma(maps: Maps, ridge: str) -> list[Row]:
    """Geometric mean of Gamma along a ridge, of each map that has it."""
    along = {key: [peak.gamma for _, peak in one.along(ridge)] for key, one in maps.items()}
    return [_labels(k) | {"value": geometric_mean(own)} for k, own in along.items() if own]


@MAPS.quantity
def ridge_exponent(maps: Maps, ridge: str) -> list[Row]:
    """Exponent of f along a ridge; noise: what the grid leaves open between its ends."""
    found = []
    for key, one in maps.items():
        points = one.along(ridge)
        value = exponent([f for f, _ in points], [peak.gamma for _, peak in points])
        if value is not None:
            open_ends = [math.log(p.bracket[1] / p.bracket[0]) / 2 for _, p in points]
            noise = math.hypot(open_ends[0], open_ends[-1]) / math.log(points[-1][0] / points[0][0])
            found.append(_labels(key) | {"value": value, "noise": noise})
    return found


@MAPS.quantity
def likeness_of_orientations(maps: Maps) -> list[Row]:
    """Correlation of the vertical and the horizontal map of a height; rms: their difference."""
    found = []
    for height in dict.fromkeys(height for _, height in maps):
        pair = [maps.get((o, height)) for o in ("vertical", "horizontal")]
        if pair[0] and pair[1] and (alike := likeness(pair[0].result, pair[1].result)):
            found.append({"height_mm": height, "value": alike[0], "rms": alike[1]})
    return found


@MAPS.quantity
def optimum_exponent(maps: Maps, of: str) -> list[Row]:
    """Exponent of f of the fluidisation optimum's "gamma" or "efficiency", of each map."""
    found = []
    for key, one in maps.items():
        own = {f: both[of == "efficiency"] for f, both in one.optima().items()}
        value = exponent(list(own), list(own.values()))
        if value is not None:
            found.append(_labels(key) | {"value": value})
    return found


@MAPS.quantity
def mean_optimum_efficiency(maps: Maps) -> list[Row]:
    """Mean efficiency of the fluidisation optimum over the frequencies of both orientations."""
    found = []
    for height in dict.fromkeys(height for _, height in maps):
        own = {
            o: maps[o, height].optima() for o in ("vertical", "horizontal") if (o, height) in maps
        }
        common = _common(list(own.values())) if len(own) == 2 else []
        found += [
            _labels((o, height)) | {"value": sum(at[f][1] for f in common) / len(common)}
            for o, at in own.items()
            if common
        ]
    return found


@MAPS.quantity
def optimum_by_fill(maps: Maps) -> list[Row]:
    """Geometric means of Gamma and eta of the vertical fluidisation optima; `of` says which.

    Over the frequencies that all heights have.
    """
    optima = {height: one.optima() for (o, height), one in maps.items() if o == "vertical"}
    optima = {height: own for height, own in optima.items() if own}
    common, found = _common(list(optima.values())), []
    for height, own in optima.items() if common else ():
        gamma, eta = (geometric_mean([own[f][i] for f in common]) for i in (0, 1))
        found += [
            {"height_mm": height, "of": "gamma", "value": gamma,
             "shown": f"{height} mm Gamma {gamma:.2f}"},
            {"height_mm": height, "of": "eta", "value": eta, "shown": f"eta {eta:.2f}"},
        ]  # fmt: skip
    return found


@MAPS.quantity
def overestimate(maps: Maps, by: str) -> list[Row]:
    """Ratio of what is dissipated to another count, `by` its column: geometric mean over the fills.

    Of each orientation, frequency and Gamma; where both are above zero and known.
    """
    found: dict[tuple[str, float, float], list[float]] = {}
    for (orientation, _), one in maps.items():
        result = one.result
        if by not in result.columns:
            continue
        points = zip(
            result.frequency.tolist(), result.gamma.tolist(), result.efficiency.tolist(),
            result.mean(by).tolist(), strict=True,
        )  # fmt: skip
        for frequency, gamma, counted, other in points:
            if counted > 0 and other > 0:  # NaN is not
                found.setdefault((orientation, frequency, gamma), []).append(counted / other)
    return [
        {"orientation": key[0], "frequency_hz": key[1], "gamma": key[2],
         "value": geometric_mean(own)}
        for key, own in found.items()
    ]  # fmt: skip


def _common(each: Sequence[Mapping[float, Any]]) -> list[float]:
    """Frequencies that all have, rising."""
    return sorted(set.intersection(*map(set, each))) if each else []


def _labels(key: tuple[str, int]) -> Row:
    return {"orientation": key[0], "height_mm": key[1]}
