"""Results of the bench as lines that people read."""

from collections.abc import Sequence

from calibration.bench.measure import Result
from calibration.statistics.quantity import plus_minus
from calibration.statistics.uncertainty import Estimate
from granulab.contact.files.units import to_si

_MOST_TRIALS = 60  # lines of single trials; JSON has them all


def as_text(results: Sequence[Result]) -> str:
    """Every quantity: by trial, by group, together, and whether the groups are alike."""
    return "\n\n".join("\n".join(_lines(result)) for result in results)


def values(results: Sequence[Result]) -> str:
    """A line for every quantity: what holds for all trials."""
    return "\n".join(f"{_title(r)}: {value(r.pooled.all, _scale(r))}" for r in results)


def _title(result: Result) -> str:
    return result.name if result.unit == "1" else f"{result.name} [{result.unit}]"


def _scale(result: Result) -> float:
    """SI units in one of the units that are shown."""
    return 1.0 if result.unit == "1" else to_si(f"1 {result.unit}", result.si, result.name)


def _lines(result: Result) -> list[str]:
    scale = _scale(result)
    lines = [_title(result)]
    shown = result.trials[:_MOST_TRIALS] if len(result.trials) > 1 else ()
    several = len(result.pooled.groups) > 1
    names = [f"{group}, {name}" if several else name for name, group, _ in shown]
    width = max(map(len, [*names, *result.pooled.groups, "all"]))
    lines += [
        f"  {name:{width}}  {value(one, scale)}"
        for name, (_, _, one) in zip(names, shown, strict=True)
    ]
    if len(result.trials) > len(shown) > 0:
        lines.append(f"  ... and {len(result.trials) - len(shown)} more")
    if several:
        lines += [
            f"  {name:{width}}  {value(one, scale)}, {_trials(one, scale)}"
            for name, one in result.pooled.groups.items()
        ]
    whole = result.pooled.all
    lines.append(f"  {'all':{width}}  {value(whole, scale)}, {_trials(whole, scale)}")
    lines += [f"  {line}" for line in [*_alike(result), *_shared(result, scale), *result.remarks]]
    return lines


def value(one: Estimate, scale: float = 1.0) -> str:
    """A value and its sigma in a unit of `scale` SI units."""
    if not one.sigma:
        return f"{one.value / scale:.4g}"
    return plus_minus(one.value / scale, one.sigma / scale)


def _trials(one: Estimate, scale: float) -> str:
    if not one.trials:
        return "from constants"
    if one.scatter is None:
        return "1 trial" if one.trials == 1 else f"{one.trials} trials"
    share = f" ({100 * one.scatter / abs(one.value):.0f} %)" if one.value else ""
    return f"{one.trials} trials, scatter {one.scatter / scale:.2g}{share}"


def _alike(result: Result) -> list[str]:
    if result.pooled.p is None:
        return []
    said = "are alike" if result.pooled.alike else "differ: each counts once"
    return [f"the groups {said} (analysis of variance: p = {result.pooled.p:.2g})"]


def _shared(result: Result, scale: float) -> list[str]:
    return [
        f"in sigma, from {name}, which all trials share: {sigma / scale:.2g}"
        for name, sigma in result.shared.items()
    ]
