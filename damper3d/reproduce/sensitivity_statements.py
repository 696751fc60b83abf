"""What the thesis says of the properties (secs 6.4.1, 8.5.1.3), judged on rows of ours."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from damper3d.reproduce.sensitivity_values import STANDARD, VALUES, span
from damper3d.reproduce.statements import Check, Statement
from damper3d.studies.map.peaks import Peak
from granulab.campaign.output.layout import done, percent, signed
from granulab.campaign.output.statistics import overlap, slope

Row = dict[str, Any]
Key = tuple[str, float]  # property and value; "standard" and 1

_SLIGHTLY = 0.25  # a "slight" change of eta over the range of a property is below this part of it


@dataclass(frozen=True)
class Optimum:
    """The curve of one value: its highest peak, and the mean eta of the bouncing bed."""

    peak: Peak | None
    level: float | None


Peaks = dict[Key, Optimum]


def of_value(rows: Sequence[Row], key: Key) -> list[Row]:
    """The runs of a property's value that are done."""
    return [row for row in done(rows) if (row["property"], row["value"]) == key]


def peaks_of(rows: Sequence[Row]) -> Peaks:
    """By property and value, as they come; the level is over Gammas that all values have."""
    from damper3d.studies.map.grid import MapResult

    keys = list(dict.fromkeys((row["property"], row["value"]) for row in done(rows)))
    found: dict[Key, Peak | None] = {}
    for key in keys:
        own = MapResult.of(of_value(rows, key))
        peaks = own.peaks(float(own.frequency[0]))
        found[key] = max(peaks, key=lambda peak: peak.efficiency, default=None)
    gammas = _common(rows, found)
    return {key: Optimum(peak, _level(of_value(rows, key), gammas)) for key, peak in found.items()}


def _common(rows: Sequence[Row], found: dict[Key, Peak | None]) -> set[float]:
    """The Gammas above every optimum that every value has; none where a value has no optimum."""
    optima = [peak.gamma for peak in found.values() if peak is not None]
    if len(optima) < len(found) or not found:
        return set()
    each = [{row["gamma"] for row in of_value(rows, key)} for key in found]
    return {gamma for gamma in set.intersection(*each) if gamma > max(optima)}


def _level(rows: list[Row], gammas: set[float]) -> float | None:
    values = [row["efficiency"] for row in rows if row["gamma"] in gammas]
    return math.fsum(values) / len(values) if values else None


def sensitivity_statements(rows: Sequence[Row], found: Peaks) -> list[Statement]:
    """That the optimum stays, for each property; then how the level of eta goes."""
    trends = {name: _trend(rows, found, name) for name in VALUES}
    return [
        Statement(
            "Sec. 6.4.1: the optimum amplitude is insensitive to material and contact properties.",
            [_stays(found, name) for name in VALUES],
        ),
        Statement(
            "... the level of eta differs slightly (judged: less than a quarter over the range).",
            [_slightly(name, trend) for name, trend in trends.items()],
        ),
        Statement(
            "Fig. 6.13b: a larger elastic modulus gives a larger eta.",
            [_goes(trends["modulus"], 1)],
        ),
        Statement(
            "Sec. 8.5.1.3 (Fig. 8.20a, and Fig. 6.13): eta falls slightly as the density grows.",
            [_goes(trends["density"], -1)],
        ),
        Statement(
            "Sec. 8.5.1.3 (Fig. 8.20c; 40 Hz, lying): a higher restitution gives a higher eta.",
            [_goes(trends["restitution"], 1)],
        ),
    ]


def _stays(found: Peaks, name: str) -> Check:
    """Whether no value's interval of the optimum leaves the standard's."""
    standard = found.get(("standard", 1.0), Optimum(None, None)).peak
    own = {value: one.peak for (n, value), one in sorted(found.items()) if n == name and one.peak}
    if standard is None or not own:
        return Check(None, "no peak found for the standard, or for any value", name)
    moved = [
        v for v, p in own.items() if not overlap((p.low, p.high), (standard.low, standard.high))
    ]
    gammas = [peak.gamma for peak in own.values()]
    numbers = (
        f"Gamma {min(gammas):.2f} to {max(gammas):.2f}; standard {standard.gamma:.2f} "
        f"[{standard.low:.2f}, {standard.high:.2f}]"
    )
    if moved:
        numbers += f"; moves at {', '.join(f'{value:g}' for value in moved)}"
    return Check(not moved, numbers, name)


@dataclass(frozen=True)
class _Trend:
    """Change of eta from the least value to the largest over its mean, and its half width."""

    change: float
    noise: float


def _trend(rows: Sequence[Row], found: Peaks, name: str) -> _Trend | None:
    """Of the mean over the bouncing bed, a packing a point; the standard's value among them."""
    gammas = _common(rows, {key: one.peak for key, one in found.items()})
    x, y = [], []
    for key in found:
        if key[0] not in (name, "standard"):
            continue
        own = of_value(rows, key)
        for seed in dict.fromkeys(row["seed"] for row in own):
            level = _level([row for row in own if row["seed"] == seed], gammas)
            if level is not None:
                x.append(span(name, STANDARD[name] if key[0] == "standard" else key[1]))
                y.append(level)
    line = slope(x, y)
    if line is None:
        return None
    scale = (max(x) - min(x)) / (math.fsum(y) / len(y))
    return _Trend(line.value * scale, line.half_width * scale)


def _goes(trend: _Trend | None, sign: int) -> Check:
    """Whether the level changes that way by more than noise."""
    if trend is None:
        return Check(None, "too few runs for a trend")
    clear = sign * trend.change > trend.noise
    word = "" if abs(trend.change) > trend.noise else ", flat within noise"
    return Check(clear, f"{signed(trend.change)} (+- {percent(trend.noise)}){word}")


def _slightly(name: str, trend: _Trend | None) -> Check:
    if trend is None:
        return Check(None, "too few runs for a trend", name)
    told = f"{signed(trend.change)} (+- {percent(trend.noise)}) of eta over the range"
    return Check(abs(trend.change) < _SLIGHTLY, told, name)
