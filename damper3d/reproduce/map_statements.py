"""What the thesis says about Figs 6.4 and 6.5 (sec. 6.3), judged from our maps."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from damper3d.reproduce.statements import Check, Statement, all_of
from damper3d.studies.map.grid import MapResult
from damper3d.studies.map.peaks import Peak
from damper3d.studies.map.ridges import FLUIDISATION, OnRidge
from damper3d.studies.predict.prediction import Prediction

EFFECTIVE = 0.3  # of eta, the level that the thesis marks
_APART = 2.0  # by which factor the onset is above Gamma 3 where the two ridges are told apart
_NEAR = 1.5  # factor about Gamma 3: the thesis's Gammas next to it are 2 and 4
_INDEPENDENT = 0.2  # largest exponent of f on the fluidisation ridge; the bouncing bed's is 2
_ALIKE = 0.9  # least correlation of the maps of the two orientations


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


Maps = Mapping[tuple[str, int], Ridges]  # by orientation and height [mm]


def statements(maps: Maps) -> list[Statement]:
    """The findings, each over all maps that there are."""
    return [
        _effective(maps),
        _near_three(maps),
        _independent_of_frequency(maps),
        _follows_frequency_squared(maps),
        _alike(maps),
    ]


def _effective(maps: Maps) -> Statement:
    """Whether eta exceeds 0.3 at the peak of the bouncing bed wherever it can be seen."""
    found = []
    for key, one in maps.items():
        for frequency in one.expected("bouncing_bed"):
            peak = one.peak(frequency, "bouncing_bed")
            found.append((key, frequency, peak.efficiency if peak else None))
    return effective("the bouncing bed", found)


def effective(
    ridge: str, found: Sequence[tuple[tuple[str, int], float, float | None]]
) -> Statement:
    """Whether eta exceeds 0.3 on a ridge: from key, frequency [Hz] and eta (None: no peak)."""
    low = [
        f"{place(key)} {frequency:g} Hz " + ("no peak" if eta is None else f"{eta:.2f}")
        for key, frequency, eta in found
        if eta is None or eta <= EFFECTIVE
    ]
    text = f"{len(found) - len(low)} of {len(found)} frequencies"
    text += f"; not {', '.join(low)}" * bool(low)
    words = f"eta > {EFFECTIVE:g} on the ridge of {ridge}"
    return Statement(words, [Check(not low if found else None, text if found else "")])


def _near_three(maps: Maps) -> Statement:
    means = {}
    for key, one in maps.items():
        points = _points(one, "fluidisation")
        if points:
            means[key] = math.exp(sum(math.log(peak.gamma) for _, peak in points) / len(points))
    holds = [abs(math.log(mean / FLUIDISATION)) <= math.log(_NEAR) for mean in means.values()]
    found = ", ".join(f"{place(key)} {mean:.2f}" for key, mean in means.items())
    words = f"the fluidisation ridge lies near Gamma 3: mean within a factor of {_NEAR:g}"
    return Statement(words, [Check(all_of(holds), found)])


def _independent_of_frequency(maps: Maps) -> Statement:
    found, holds = [], []
    for key, one in maps.items():
        exponent = _exponent(_points(one, "fluidisation"))
        if exponent is not None:
            holds.append(abs(exponent) <= _INDEPENDENT)
            found.append(f"{place(key)} {exponent:+.2f}")
    words = (
        "the fluidisation ridge hardly depends on frequency: |exponent of f| at most "
        f"{_INDEPENDENT:g}"
    )
    return Statement(words, [Check(all_of(holds), ", ".join(found))])


def _follows_frequency_squared(maps: Maps) -> Statement:
    """The exponent from the first to the last frequency is 2 within what the grid leaves open."""
    found, holds = [], []
    for key, one in maps.items():
        points = _points(one, "bouncing_bed")
        exponent = _exponent(points)
        if exponent is None:
            continue
        span = math.log(points[-1][0] / points[0][0])
        error = math.hypot(_resolution(points[0][1]), _resolution(points[-1][1])) / span
        holds.append(abs(exponent - 2) <= error)
        found.append(f"{place(key)} {exponent:.2f} +- {error:.2f}")
    words = "the ridge of the bouncing bed follows f^2: exponent 2 within the grid's resolution"
    return Statement(words, [Check(all_of(holds), ", ".join(found))])


def _alike(maps: Maps) -> Statement:
    found, holds = [], []
    for height in dict.fromkeys(height for _, height in maps):
        pair = [maps.get((o, height)) for o in ("vertical", "horizontal")]
        if pair[0] is None or pair[1] is None:
            continue
        alike = likeness(pair[0].result, pair[1].result)
        if alike is None:
            continue
        correlation, away = alike
        holds.append(correlation >= _ALIKE)
        found.append(f"{height} mm {correlation:.3f} (rms difference of eta {away:.3f})")
    words = f"the map is alike in both orientations: correlation at least {_ALIKE:g}"
    return Statement(words, [Check(all_of(holds), ", ".join(found))])


def likeness(first: MapResult, second: MapResult) -> tuple[float, float] | None:
    """Correlation of eta over the points that both have, and root-mean-square difference.

    None for fewer than three points, or where one does not vary.
    """
    known = [_values(result) for result in (first, second)]
    common = sorted(known[0].keys() & known[1].keys())
    a, b = np.array([[values[point] for point in common] for values in known])
    if len(common) < 3 or not (a.std() and b.std()):
        return None
    return float(np.corrcoef(a, b)[0, 1]), float(np.sqrt(np.mean((a - b) ** 2)))


def points_of(one: Ridges, ridge: str) -> tuple[list[tuple[float, Peak]], float | None]:
    """Frequency [Hz] and peak of a ridge where it can be seen, and the exponent of f."""
    points = _points(one, ridge)
    return points, _exponent(points)


def _points(one: Ridges, ridge: str) -> list[tuple[float, Peak]]:
    peaks = [(frequency, one.peak(frequency, ridge)) for frequency in one.expected(ridge)]
    return [(frequency, peak) for frequency, peak in peaks if peak is not None]


def _exponent(points: list[tuple[float, Peak]]) -> float | None:
    """Of f, from a line through ln Gamma against ln f; None for fewer than two points."""
    if len(points) < 2:
        return None
    f, gamma = np.log([f for f, _ in points]), np.log([peak.gamma for _, peak in points])
    return float(np.polyfit(f, gamma, 1)[0])


def _resolution(peak: Peak) -> float:
    return math.log(peak.bracket[1] / peak.bracket[0]) / 2


def _values(result: MapResult) -> dict[tuple[float, float], float]:
    points = zip(result.frequency, result.gamma, result.efficiency, strict=True)
    return {(float(f), float(g)): float(eta) for f, g, eta in points if np.isfinite(eta)}


def place(key: tuple[str, int]) -> str:
    """A map in words."""
    return f"{key[0]} {key[1]} mm"
