"""What the thesis says of shapes beyond the onset: prolates past it, fluidisation, properties."""

import itertools
import math
from collections.abc import Callable, Sequence

from damper3d.reproduce.curves import curve
from damper3d.reproduce.dampers import ORIENTATIONS
from damper3d.reproduce.optima import Optimum
from damper3d.reproduce.runs import Row
from damper3d.reproduce.sensitivity_values import STANDARD, VALUES, in_words
from damper3d.reproduce.shape_optima import Found, Line, rows_of
from damper3d.reproduce.shape_plan import BOUNCING, FLUIDISED, Shape
from damper3d.reproduce.statements import Check, Statement, all_of
from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import Slope, mean_sd, slope

_SMALL = 1.5  # largest over least optimum that counts as independent of shape; our choice
_SPHERE: Shape = ("spheroid", 1.0)


def past_onset(rows: Sequence[Row], found: Found) -> Statement:
    """Sec. 8.5.1: beyond their own onset, prolates damp more than spheres."""
    checks = []
    for frequency, orientation in itertools.product(BOUNCING, ORIENTATIONS):
        verdicts, words = [], []
        for ratio in (1.5, 3.0):
            line = Line(("spheroid", ratio), orientation, frequency)
            own = found.get(line)
            if own is None:
                continue
            theirs = efficiencies(rows_of(rows, line._replace(shape=_SPHERE)))
            ours = efficiencies(rows_of(rows, line))
            gains = [ours[g] - theirs[g] for g in ours.keys() & theirs.keys() if g >= own.gamma]
            if gains:
                verdicts.append(min(gains) > 0)
                words.append(f"{ratio:g}: {min(gains):+.3f} to {max(gains):+.3f}")
        checks.append(Check(all_of(verdicts), ", ".join(words), f"{frequency:g} Hz {orientation}"))
    return Statement("prolates of 1.5 and 3.0 damp more than spheres beyond their onset", checks)


def fluidisation_statements(found: Found) -> list[Statement]:
    """Sec. 8.5.2, from the vertical curves at high frequency."""
    at = {
        f: {line.shape: one for line, one in found.items() if line.frequency == f and one}
        for f in FLUIDISED
    }
    without = {
        f: _too_few(len(own), sum(line.frequency == f for line in found)) for f, own in at.items()
    }
    return [_independent(at, without), _no_trend(at, without), _level_rises(at), _place_falls(at)]


def _too_few(peaks: int, curves: int) -> str:
    """What to say where they are not enough to judge; "" where nothing is run."""
    return f"{peaks} of {curves} shapes have a peak" if curves else ""


def _independent(at: dict[float, dict[Shape, Optimum]], without: dict[float, str]) -> Statement:
    words = f"shape does not shift the fluidisation optimum: largest over least at most {_SMALL:g}"
    checks = []
    for frequency, own in at.items():
        gammas = [one.gamma for one in own.values()]
        if len(gammas) < 3:
            checks.append(Check(None, without[frequency], f"{frequency:g} Hz"))
            continue
        ratio = max(gammas) / min(gammas)
        text = f"{min(gammas):.2f} to {max(gammas):.2f} of {len(gammas)} shapes, ratio {ratio:.2f}"
        checks.append(Check(ratio <= _SMALL, text, f"{frequency:g} Hz"))
    return Statement(words, checks)


def _no_trend(at: dict[float, dict[Shape, Optimum]], without: dict[float, str]) -> Statement:
    """Slopes of ln Gamma against ln aspect ratio of prolates, and against the hole ratio."""
    checks = []
    for frequency, own in at.items():
        pairs = {
            "prolates": [(math.log(r), one) for (k, r), one in own.items()
                         if k == "spheroid" and r >= 1],
            "toroids": [(r, one) for (k, r), one in own.items() if k == "toroid"],
        }  # fmt: skip
        verdicts, words = [], []
        for name, points in pairs.items():
            trend = slope([x for x, _ in points], [math.log(one.gamma) for _, one in points])
            if trend is not None:
                verdicts.append(abs(trend.value) <= trend.half_width)
                words.append(f"{name} {trend.value:+.2f} +- {trend.half_width:.2f}")
        text = ", ".join(words) or without[frequency]
        checks.append(Check(all_of(verdicts), text, f"{frequency:g} Hz"))
    return Statement("its small differences follow no trend: slopes within their noise", checks)


def _level_rises(at: dict[float, dict[Shape, Optimum]]) -> Statement:
    words = "its efficiency rises with frequency, for each shape"
    return Statement(words, [_trend_over_frequency(at, lambda one: one.mean.efficiency, +1)])


def _place_falls(at: dict[float, dict[Shape, Optimum]]) -> Statement:
    words = "its Gamma falls with frequency, for each shape"
    return Statement(words, [_trend_over_frequency(at, lambda one: one.gamma, -1)])


def _trend_over_frequency(
    at: dict[float, dict[Shape, Optimum]], value: Callable[[Optimum], float], sign: int
) -> Check:
    """Of each shape with three frequencies or more: the slope of ln value over ln frequency."""
    slopes = {}
    for shape in sorted({shape for own in at.values() for shape in own}):
        points = [(f, math.log(value(own[shape]))) for f, own in at.items() if shape in own]
        trend = _per_e_fold(points)
        if trend is not None:
            slopes[shape] = trend.value
    if not slopes:
        return Check(None, "")
    right = sum(sign * s > 0 for s in slopes.values())
    low, high = min(slopes.values()), max(slopes.values())
    text = f"{right} of {len(slopes)} shapes; slopes {low:+.2f} to {high:+.2f}"
    return Check(right == len(slopes), text)


def _per_e_fold(points: Sequence[tuple[float, float]]) -> Slope | None:
    """Of y over ln x."""
    return slope([math.log(x) for x, _ in points], [y for _, y in points])


def property_statements(rows: Sequence[Row]) -> list[Statement]:
    """Sec. 8.5.1.3 and Fig. 8.20: eta at Gamma 35, 40 Hz, horizontal, against each property."""
    with_property = [
        _with_property(rows, name, sign)
        for name, sign in (("density", -1), ("modulus", +1), ("restitution", +1))
    ]
    return [*with_property, _order_kept(rows), _friction(rows)]


def values_of(rows: Sequence[Row], name: str) -> dict[float, dict[float, float]]:
    """By rising value of a property: mean efficiency over the packings, by aspect ratio."""
    groups: dict[float, dict[float, list[float]]] = {}
    for value, row in _varied(rows, name):
        groups.setdefault(value, {}).setdefault(row["ratio"], []).append(row["efficiency"])
    return {
        value: {ratio: mean_sd(etas).mean or 0.0 for ratio, etas in sorted(own.items())}
        for value, own in sorted(groups.items())
    }


def _varied(rows: Sequence[Row], name: str) -> list[tuple[float, Row]]:
    """The runs that differ in one property alone, its standard among them, with its value."""
    own = [row for row in rows if row["part"] == "sensitivity"]
    return [
        (STANDARD[name] if row["property"] == "standard" else row["value"], row)
        for row in done(own)
        if row["property"] in (name, "standard")
    ]


def _with_property(rows: Sequence[Row], name: str, sign: int) -> Statement:
    """By the slope of eta over ln value, of all packings; within its noise it says nothing."""
    points: dict[float, list[tuple[float, float]]] = {}
    for value, row in _varied(rows, name):
        points.setdefault(row["ratio"], []).append((value, row["efficiency"]))
    checks = []
    for ratio, own in sorted(points.items()):
        trend = _per_e_fold(own)
        if trend is None:
            continue
        beyond_noise = abs(trend.value) > trend.half_width
        text = f"{trend.value:+.3f} +- {trend.half_width:.3f} per e-fold"
        checks.append(Check(sign * trend.value > 0 if beyond_noise else None, text, f"{ratio:g}"))
    rises = "rises" if sign > 0 else "falls"
    return Statement(f"eta {rises} with {name}, for each shape", checks or [Check(None, "")])


def _order_kept(rows: Sequence[Row]) -> Statement:
    """eta at Gamma 35 stands for the onset there (the thesis's own argument)."""
    checks = []
    for name in VALUES:
        gains = {
            value: min(eta for ratio, eta in etas.items() if ratio >= 1.5) - etas[1.0]
            for value, etas in values_of(rows, name).items()
            if 1.0 in etas and 1.5 in etas
        }
        text = ", ".join(f"{in_words(name, value)} {gain:+.3f}" for value, gain in gains.items())
        checks.append(Check(all_of([gain > 0 for gain in gains.values()]), text, name))
    return Statement(
        "prolates of 1.5 and more damp more than spheres whatever the property", checks
    )


def _friction(rows: Sequence[Row]) -> Statement:
    words = "less friction makes eta more sensitive to shape, more friction less: eta(1.5) - eta(1)"
    gains = {
        value: etas[1.5] - etas[1.0]
        for value, etas in values_of(rows, "friction").items()
        if 1.0 in etas and 1.5 in etas
    }
    if len(gains) < 3:
        return Statement(words, [Check(None, "")])
    trend = slope(list(gains), list(gains.values()))
    assert trend is not None
    text = ", ".join(f"mu {value:g} {gain:+.3f}" for value, gain in gains.items())
    return Statement(words, [Check(trend.value < 0, text)])


def efficiencies(rows: Sequence[Row]) -> dict[float, float]:
    """Mean efficiency over the packings at each Gamma."""
    own = curve(rows, lambda row: row["efficiency"])
    return dict(zip(own.x, own.mean, strict=True))
