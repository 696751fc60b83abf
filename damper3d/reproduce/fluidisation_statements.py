"""What the thesis says about the fluidisation optimum over the map (sec. 6.4.3), judged from ours.

The optimum of a frequency is here its largest eta up to Gamma 6, also where that lies at the least
Gamma that was run: at high frequencies it does.
"""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from damper3d.reproduce.map_statements import Maps, Ridges, effective, place
from damper3d.reproduce.statements import Check, Statement, all_of

_MOST = 6.0  # Gamma up to which the optimum is looked for: twice that of the thesis
_ALIKE = 1.25  # largest over least mean of four fills that is insensitive; the grid steps are more


class Optimum(NamedTuple):
    """Where eta is largest up to Gamma 6."""

    frequency: float  # [Hz]
    gamma: float
    efficiency: float


def statements(maps: Maps) -> list[Statement]:
    """The findings, each over all maps that there are."""
    found = {key: one for key, own in maps.items() if (one := optima(own))}
    etas = [(key, p.frequency, p.efficiency) for key, points in found.items() for p in points]
    return [
        effective("fluidisation, at its optimum", etas),
        _trend(found, "the fluidisation optimum falls with frequency", "gamma", lambda x: x < 0),
        _trend(found, "the efficiency there rises with frequency", "efficiency", lambda x: x > 0),
        _less_when_lying(found),
        _whatever_the_fill(found),
    ]


def optima(one: Ridges) -> list[Optimum]:
    """Of the frequencies at which the bouncing bed's onset is well above it."""
    found = []
    for frequency in one.expected("fluidisation"):
        at = one.result.at(frequency)
        at = at[one.result.gamma[at] <= _MOST]
        if len(at):
            best = at[one.result.efficiency[at].argmax()]
            values = one.result.gamma[best], one.result.efficiency[best]
            found.append(Optimum(frequency, *map(float, values)))
    return found


Found = Mapping[tuple[str, int], list[Optimum]]


def _trend(found: Found, words: str, of: str, holds: Callable[[float], bool]) -> Statement:
    """Whether the exponent of f has the sign that the thesis tells, in every map."""
    exponents = {}
    for key, points in found.items():
        if len(points) > 1:
            f = np.log([p.frequency for p in points])
            exponents[key] = float(np.polyfit(f, np.log([getattr(p, of) for p in points]), 1)[0])
    text = ", ".join(f"{place(key)} f^{x:+.2f}" for key, x in exponents.items())
    return Statement(words, [Check(all_of([holds(x) for x in exponents.values()]), text)])


def _less_when_lying(found: Found) -> Statement:
    """Whether eta is smaller in the horizontal case, on the mean of the common frequencies."""
    verdicts, texts = [], []
    for height in dict.fromkeys(height for _, height in found):
        standing, lying = (
            {p.frequency: p.efficiency for p in found.get((o, height), [])}
            for o in ("vertical", "horizontal")
        )
        common = standing.keys() & lying.keys()
        if common:
            means = [sum(own[f] for f in common) / len(common) for own in (standing, lying)]
            verdicts.append(means[1] < means[0])
            texts.append(f"{height} mm {means[1]:.2f} against {means[0]:.2f}")
    words = "around the fluidisation optimum eta is smaller in the horizontal case"
    return Statement(words, [Check(all_of(verdicts), ", ".join(texts))])


def _whatever_the_fill(found: Found) -> Statement:
    """Whether Gamma and eta of the optimum, means over the common frequencies, hardly vary."""
    own = {height: points for (o, height), points in found.items() if o == "vertical"}
    words = (
        "vertical: the fluidisation optimum and its eta are insensitive to the fill ratio: largest "
        f"over least mean at most {_ALIKE:g}"
    )
    common = _common(own)
    if len(own) < 2 or not common:
        return Statement(words, [Check(None, "")])
    gamma, eta = (
        {
            height: math.exp(
                float(np.mean([math.log(p[i]) for p in points if p.frequency in common]))
            )
            for height, points in own.items()
        }
        for i in (1, 2)
    )
    ratios = [max(values.values()) / min(values.values()) for values in (gamma, eta)]
    texts = (f"{height} mm Gamma {gamma[height]:.2f} eta {eta[height]:.2f}" for height in own)
    return Statement(words, [Check(all(ratio <= _ALIKE for ratio in ratios), ", ".join(texts))])


def _common(own: Mapping[int, list[Optimum]]) -> set[float]:
    """Frequencies that all have."""
    each = [{p.frequency for p in points} for points in own.values()]
    return set.intersection(*each) if each else set()
