"""What the thesis says about Table 6.3 (sec. 6.4.1), judged from our optima."""

import math
from collections.abc import Mapping
from itertools import pairwise

from damper3d.reproduce.optima import Optimum
from damper3d.reproduce.statements import Check, Statement, all_of

Optima = Mapping[tuple[int, float, str], Optimum | None]  # by height, frequency, orientation
Pooled = tuple[float, int] | None


def statements(found: Optima, pooled: Pooled) -> list[Statement]:
    """Four findings; those of lines that have no peak are left out."""
    known = {line: one for line, one in found.items() if one is not None}
    return [
        _rises_with_clearance(known),
        _goes_as_frequency_squared(known, pooled),
        _orientation_matters_little(known),
        _close_is_better(known),
    ]


def _rises_with_clearance(known: Mapping[tuple[int, float, str], Optimum]) -> Statement:
    steps = {}
    for frequency, orientation in dict.fromkeys((f, o) for _, f, o in known):
        heights = sorted(h for h, f, o in known if (f, o) == (frequency, orientation))
        for low, high in pairwise(heights):
            ratio = known[high, frequency, orientation].gamma
            ratio /= known[low, frequency, orientation].gamma
            steps[f"{orientation} {frequency:g} Hz {low} to {high} mm"] = ratio
    fell = [f"{name}: x {ratio:.2f}" for name, ratio in steps.items() if ratio <= 1]
    found = f"{len(steps) - len(fell)} of {len(steps)} steps rise"
    found += f"; not {', '.join(fell)}" if fell else ""
    words = "the optimum rises with the clearance: each height's is above the one below"
    holds = all_of([ratio > 1 for ratio in steps.values()])
    return Statement(words, [Check(holds, found if steps else "")])


def _goes_as_frequency_squared(
    known: Mapping[tuple[int, float, str], Optimum], pooled: Pooled
) -> Statement:
    """The exponent between neighbouring frequencies of a damper is 2 within its error."""
    found, holds = [], []
    for height, orientation in dict.fromkeys((h, o) for h, _, o in known):
        frequencies = sorted(f for h, f, o in known if (h, o) == (height, orientation))
        for low, high in pairwise(frequencies):
            first, second = known[height, low, orientation], known[height, high, orientation]
            octave = math.log(high / low)
            exponent = math.log(second.gamma / first.gamma) / octave
            error = math.hypot(first.error(pooled), second.error(pooled)) / octave
            holds.append(abs(exponent - 2) <= error)
            found.append(
                f"{height} mm {orientation} {low:g}-{high:g} Hz {exponent:.2f} +- {error:.2f}"
            )
    words = "the optimum rises with the square of the frequency: exponent 2 within its error"
    return Statement(words, [Check(all_of(holds), "; ".join(found))])


def _orientation_matters_little(known: Mapping[tuple[int, float, str], Optimum]) -> Statement:
    """Less than 5 mm more of height do, by eq. 6.11 for the close packing."""
    found, holds = [], []
    for height, frequency in dict.fromkeys((h, f) for h, f, _ in known):
        pair = [known.get((height, frequency, o)) for o in ("vertical", "horizontal")]
        if pair[0] is None or pair[1] is None:
            continue
        change = pair[1].gamma / pair[0].gamma
        clearance = next(c.length for c in pair[0].prediction.clearances if c.name == "close")
        if not clearance:
            continue
        step = 1 + 5e-3 / clearance  # the clearance grows by the height
        holds.append(abs(math.log(change)) < math.log(step))
        found.append(f"{height} mm {frequency:g} Hz {100 * (change - 1):+.0f} %")
    words = "orientation matters little: less than 5 mm of height (horizontal against vertical)"
    return Statement(words, [Check(all_of(holds), "; ".join(found))])


def _close_is_better(known: Mapping[tuple[int, float, str], Optimum]) -> Statement:
    off: dict[str, list[float]] = {"loose": [], "close": []}
    for one in known.values():
        gammas = {name: one.predicted(name) for name in off}
        for name, gamma in gammas.items():
            if None not in gammas.values() and gamma:
                off[name].append(abs(math.log(one.gamma / gamma)))
    nearer = [c < p for c, p in zip(off["close"], off["loose"], strict=True)]
    mean = {name: 100 * math.fsum(v) / len(v) if v else 0.0 for name, v in off.items()}
    found = (
        f"closer in {sum(nearer)} of {len(nearer)} lines; mean |ln(ours/predicted)| "
        f"{mean['close']:.0f} % of CP, {mean['loose']:.0f} % of LP"
    )
    words = "close packing (CP) predicts it better than loose packing (LP), in every line"
    return Statement(words, [Check(all_of(nearer), found if nearer else "")])
