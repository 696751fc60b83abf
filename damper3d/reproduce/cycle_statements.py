"""What the thesis says of dissipation and velocity within the cycle, judged on rows of ours."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any

from damper3d.reproduce.cycle_histories import BOUNCING, FLUIDISED, FREQUENCY
from damper3d.reproduce.cycle_steps import fields, read
from damper3d.reproduce.statements import Check, Statement
from granulab.campaign.output.layout import done

Readings = dict[tuple[str, float], dict[str, float]]  # by orientation and Gamma: mean readings

# An enclosure is "around its maximum" velocity where it is nearer to it, in phase, than to rest.
_FAST = math.cos(math.pi / 4)
_SLOW = math.sin(math.pi / 8)  # "nearly zero": nearer to rest than to that
_NEARLY = 0.25  # "nearly the same velocity": within so much of V
_HALF = (0.35, 0.65)  # "approximately half a cycle"


def readings(rows: Sequence[dict[str, Any]]) -> Readings:
    """Means over the packings of each point that has a run with histories."""
    found: dict[tuple[str, float], list[dict[str, Any]]] = {}
    for row in done(rows):
        if row.get("cycle.dissipated"):
            key = row["orientation"], float(row["gamma"])
            found.setdefault(key, []).append(dataclasses.asdict(read(row)))
    means: Readings = {}
    for key, several in found.items():
        known = {name: [r[name] for r in several if r[name] is not None] for name in fields()}
        means[key] = {name: math.fsum(v) / len(v) for name, v in known.items() if v}
    return means


def ideal_since(gamma: float) -> float | None:
    """Part of the cycle after which the ideal bouncing bed meets the other wall; None: never.

    With the onset of eqs 6.11 and 6.13 for the close packing.
    """
    from damper3d.case.case import DamperCase
    from damper3d.case.closed_forms import meeting_phase
    from damper3d.studies.predict.prediction import predict

    onset = predict(DamperCase.load("thesis")).clearances[1].onset(FREQUENCY)
    since = float(meeting_phase(gamma / onset)) / (2 * math.pi) if onset else math.nan
    return None if math.isnan(since) else since


def cycle_statements(found: Readings) -> list[Statement]:
    """Secs 6.4.1, 6.4.3.1 and 6.4.3.2 in the thesis's order."""
    return [*_of_the_bouncing_bed(found), *_of_fluidisation(found)]


def _of_the_bouncing_bed(found: Readings) -> list[Statement]:
    up = _series(found, "vertical", BOUNCING)
    return [
        Statement("Fig. 6.7: two steps a cycle in the bouncing bed.", [_steps(up, 2)]),
        Statement("... each collision is earlier in the cycle the larger Gamma.",
                  [_ordered(up, "since", -1, "cycles since the greatest speed")]),
        Statement("... and shorter.", [_ordered(up, "duration", -1, "cycles")]),
        Statement("... most of the energy goes in the two collisions.",
                  [_each(up, "within", lambda part: part > 0.5, "of the energy")]),
        Statement("Fig. 6.10: at Gamma 20 the bed meets the enclosure when that is about fastest.",
                  [_at(found, "vertical", 20.0, "enclosure", lambda v: v > _FAST, "V"),
                   _at(found, "vertical", 20.0, "half_way", lambda v: v > _FAST, "V")]),
        Statement("... against it, with almost the same velocity amplitude.",
                  [_at(found, "vertical", 20.0, "bed", lambda v: abs(v - 1) < _NEARLY, "V"),
                   _at(found, "vertical", 20.0, "against", lambda v: abs(v - 1) < _NEARLY, "V")]),
        Statement("... at Gamma 100 collisions commence at a smaller velocity of the enclosure.",
                  [_compared(found, "enclosure", ("vertical", 100.0), ("vertical", 20.0), -1)]),
        Statement("... and the bed moves with the enclosure for longer.",
                  [_compared(found, "together", ("vertical", 100.0), ("vertical", 20.0), 1)]),
        Statement("... the bed's deceleration grows with Gamma.",
                  [_ordered(up, "deceleration", 1, "m/s2")]),
    ]  # fmt: skip


def _of_fluidisation(found: Readings) -> list[Statement]:
    lying = _series(found, "horizontal", FLUIDISED)
    vertical, horizontal, bouncing = ("vertical", 3.0), ("horizontal", 3.0), ("vertical", 20.0)
    slow, fast, beyond = ("vertical", 1.5), ("vertical", 3.0), ("vertical", 4.0)
    return [
        Statement("Fig. 6.16: one step a cycle in the vertical fluidisation (Gamma 3).",
                  [_steps({vertical: found[vertical]} if vertical in found else {}, 1)]),
        Statement("... two in the horizontal; sec. 6.4.3.2: at any Gamma.", [_steps(lying, 2)]),
        Statement("... much longer than those of the bouncing bed (judged: twice; Gamma 20).",
                  [_compared(found, "duration", horizontal, bouncing, 1, factor=2.0)]),
        Statement("Fig. 6.18a: at Gamma 1.5 the bed meets the base when it is almost at rest.",
                  [_at(found, *slow, "enclosure", lambda v: v < _SLOW, "V")]),
        Statement("... and moves with it for about half a cycle.",
                  [_at(found, *slow, "together", lambda t: _HALF[0] < t < _HALF[1], "cycles")]),
        Statement("... at Gamma 3 when it is about fastest.",
                  [_at(found, *fast, "enclosure", lambda v: v > _FAST, "V")]),
        Statement("... with nearly the same velocity, opposite.",
                  [_at(found, *fast, "against", lambda v: abs(v - 1) < _NEARLY, "V")]),
        Statement("... at Gamma 4 the bed's velocity is less (judged: over V).",
                  [_compared(found, "bed", beyond, fast, -1)]),
        Statement("... and the collision comes at a smaller velocity of the enclosure.",
                  [_compared(found, "enclosure", beyond, fast, -1)]),
        Statement("... and cycles may be unlike in turn (judged: one twice the other).",
                  [_at(found, *beyond, "unevenness", lambda u: u > 1 / 3, "of both")]),
        Statement("Fig. 6.18b: horizontally the bed's velocity over V falls as Gamma grows.",
                  [_ordered(lying, "bed", -1, "V")]),
        Statement("... and the velocity against the enclosure is largest at Gamma 3.",
                  [_largest(lying, "relative", horizontal)]),
    ]  # fmt: skip


def _series(found: Readings, orientation: str, gammas: Sequence[float]) -> Readings:
    keys = [(orientation, gamma) for gamma in gammas]
    return {key: found[key] for key in keys if key in found}


def _steps(points: Readings, wanted: int) -> Check:
    """Whether all points have so many steps a cycle in every packing."""
    told = ", ".join(f"{mean['steps']:.2g} at {gamma:g}" for (_, gamma), mean in points.items())
    holds = all(mean["steps"] == wanted for mean in points.values()) if points else None
    return Check(holds, told or "no run there")


def _ordered(points: Readings, name: str, sign: int, unit: str) -> Check:
    """Whether a number rises (sign 1) or falls (-1) from each Gamma to the next."""
    known = [(gamma, mean[name]) for (_, gamma), mean in points.items() if name in mean]
    told = ", ".join(f"{value:.3g} at {gamma:g}" for gamma, value in known)
    if len(known) < 2:
        return Check(None, f"{told or 'no run there'}; needs two Gammas")
    pairs = itertools.pairwise(known)
    return Check(all(sign * (b - a) > 0 for (_, a), (_, b) in pairs), f"{told} ({unit})")


def _each(points: Readings, name: str, rule: Callable[[float], bool], unit: str) -> Check:
    known = [(gamma, mean[name]) for (_, gamma), mean in points.items() if name in mean]
    told = ", ".join(f"{value:.2f} at {gamma:g}" for gamma, value in known)
    holds = all(rule(value) for _, value in known) if known else None
    return Check(holds, f"{told} ({unit})" if told else "no run there")


def _at(
    found: Readings, orientation: str, gamma: float, name: str, rule: Callable[[float], bool],
    unit: str,
) -> Check:  # fmt: skip
    value = found.get((orientation, gamma), {}).get(name)
    if value is None:
        return Check(None, "no run there")
    return Check(rule(value), f"{name.replace('_', ' ')} {value:.2f} {unit}")


def _compared(
    found: Readings, name: str, one: tuple[str, float], other: tuple[str, float], sign: int,
    factor: float = 1.0,
) -> Check:  # fmt: skip
    """Whether a number of one point is above (sign 1) or below (-1) a factor times the other's."""
    a, b = (found.get(key, {}).get(name) for key in (one, other))
    if a is None or b is None:
        return Check(None, "no run there")
    told = f"{name} {a:.3f} at {one[0]} {one[1]:g}, {b:.3f} at {other[0]} {other[1]:g}"
    return Check(sign * (a - factor * b) > 0, told)


def _largest(points: Readings, name: str, wanted: tuple[str, float]) -> Check:
    told = ", ".join(f"{mean[name]:.2f} at {gamma:g}" for (_, gamma), mean in points.items())
    if len(points) < len(FLUIDISED):
        return Check(None, told or "no run there")
    best = max(points, key=lambda key: points[key][name])
    return Check(best == wanted, f"{told} (V)")
