"""The six rules by which claims are judged.

A rule takes items (a frame with a column `value`, labels, and what else the quantity gives, such as
`noise`, the half width of a 95 % interval) and says of each case whether it holds. A limit is a
number, or the name of a column. A value that lacks (NaN) fails where each item counts, and is
left out elsewhere.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from pandas import DataFrame, Series

Limit = float | str


@dataclass(frozen=True)
class Outcome:
    """Of a rule: the items that it looked at, and its cases with their verdicts.

    cases       a row each: a single item, a step between two, a ratio of a group
    verdicts    True, False, or None where noise hides the difference, a case each
    """

    items: "DataFrame"
    cases: "DataFrame"
    verdicts: Sequence[bool | None]

    @property
    def holds(self) -> bool | None:
        """Return whether all hold; None without any, or where one is unknown and none fails."""
        return all_of(self.verdicts)


def all_of(verdicts: Sequence[bool | None]) -> bool | None:
    """False where one fails; None where one is not known, or where there is none."""
    if False in verdicts:
        return False
    return None if None in verdicts or not verdicts else True


def each(
    items: "DataFrame", *, above: Limit | None = None, below: Limit | None = None,
    at_least: Limit | None = None, at_most: Limit | None = None, equal: Limit | None = None,
    beyond_noise: bool = False, need: int = 1,
) -> Outcome:  # fmt: skip
    """Each value lies above or below a limit, or between two.

    beyond_noise    a value nearer to the limit than its noise, or of unknown noise, is not judged
    """
    value, holds = items["value"], items["value"].notna()
    hidden = np.zeros(len(items), bool)
    for limit, holds_at in (
        (above, value.gt), (below, value.lt), (at_least, value.ge), (at_most, value.le),
        (equal, value.eq),
    ):  # fmt: skip
        if limit is not None:
            at = _limit(items, limit)
            holds &= holds_at(at)
            if beyond_noise:
                hidden |= ~((value - at).abs() > items["noise"]).to_numpy(bool)
    hidden &= value.notna().to_numpy(bool)  # what lacks fails, whatever its noise
    verdicts = [None if h else bool(v) for h, v in zip(hidden, holds, strict=True)]
    return Outcome(items, items, verdicts if len(items) >= need else [])


def steps(
    items: "DataFrame", *, along: str, way: str, per: Sequence[str] = (), need: int = 2
) -> Outcome:
    """The value rises or falls (way) with every step of a label; a case is a step: low, high.

    The value of a case is the ratio of its two ends, NaN over a low end of 0.
    """
    from pandas import DataFrame

    items = items.dropna(subset="value")
    sign = {"rises": 1, "falls": -1}[way]
    found, verdicts = [], []
    for labels, own in groups(items, per):
        own = own.sort_values(along)
        values, points = own["value"].tolist(), own[along].tolist()
        for k in range(1, len(own)):
            times = values[k] / values[k - 1] if values[k - 1] else np.nan
            found.append(labels | {"low": points[k - 1], "high": points[k], "value": times})
            verdicts.append(sign * (values[k] - values[k - 1]) > 0)
    return Outcome(items, DataFrame(found), verdicts if len(items) >= need else [])


def ordered(
    items: "DataFrame", *, first: Mapping[str, Any], way: str, second: Mapping[str, Any],
    factor: float = 1.0, per: Sequence[str] = (),
) -> Outcome:  # fmt: skip
    """One value is above or below (way) another, or a factor times it, in every group.

    Where a selection has several values, their mean counts; each that it names must be there. The
    value of a case is first over second, its change that less one.
    """
    from pandas import DataFrame

    items = items.dropna(subset="value")
    sign = {"above": 1, "below": -1}[way]
    cases, verdicts = [], []
    for labels, own in groups(items, per):
        one, other = select(own, first), select(own, second)
        if not (_whole(one, first) and _whole(other, second)):
            continue
        a, b = float(one["value"].mean()), float(other["value"].mean())
        times = a / b if b else np.nan
        cases.append(labels | {"first": a, "second": b, "value": times, "change": times - 1})
        verdicts.append(sign * (a - factor * b) > 0)
    return Outcome(items, DataFrame(cases), verdicts)


def extreme(items: "DataFrame", *, least: Mapping[str, Any] | None = None,
            largest: Mapping[str, Any] | None = None, need: int = 1) -> Outcome:  # fmt: skip
    """The least or the largest value lies at a point."""
    items = items.dropna(subset="value")
    point = least or largest or {}
    if len(items) < need or not len(select(items, point)):
        return Outcome(items, items.head(0), [])
    value = items["value"]
    case = items.loc[[value.idxmin() if least else value.idxmax()]]
    return Outcome(items, case, [len(select(case, point)) == 1])


def ratio(items: "DataFrame", *, at_most: float, per: Sequence[str] = (), need: int = 2) -> Outcome:
    """The largest value over the least is within a limit, in every group.

    Over a least value of 0 or below it is infinite; where none is above 0 it is not judged.
    """
    from pandas import DataFrame

    items = items.dropna(subset="value")
    cases, verdicts = [], []
    for labels, own in groups(items, per):
        if len(own) >= need:
            least, largest = own["value"].min(), own["value"].max()
            value = largest / least if least > 0 else np.inf if largest > 0 else np.nan
            cases.append(labels | {"value": value})
            verdicts.append(None if np.isnan(value) else bool(value <= at_most))
    return Outcome(items, DataFrame(cases), verdicts)


def compared(
    items: "DataFrame", *, printed: Limit, within: Limit = 0.0, factor: float | None = None,
    mean: bool = False, interval: Sequence[str] = (), telling: Limit | None = None,
) -> Outcome:  # fmt: skip
    """Each value agrees with a printed number, or with a column.

    within      how far it may be away
    factor      instead: by which factor
    mean        it is the mean of all values that is compared
    interval    instead: the columns low, high of two intervals, which must have a point in common
    telling     a value that agrees is not judged where `within` is more: noise would hide as much

    Of unknown noise (`within` is NaN) nothing is judged.
    """
    items = items.dropna(subset="value")
    if interval:
        low, high, other_low, other_high = (items[name] for name in interval)
        holds = (low <= other_high) & (other_low <= high)
        return Outcome(items, items, [bool(v) for v in holds])
    target, allowed = _limit(items, printed), _limit(items, within)
    value = items["value"]
    if mean:
        return Outcome(items, items, [bool(abs(value.mean() - target) <= allowed)][: len(items)])
    if factor is not None:
        holds = np.abs(np.log(value / target)) <= np.log(factor)
    else:
        holds = np.abs(value - target) <= allowed
    hidden = np.broadcast_to(np.isnan(allowed), holds.shape)
    if telling is not None:
        hidden = hidden | (holds & (allowed > _limit(items, telling)))
    verdicts = [None if h else bool(v) for v, h in zip(holds, hidden, strict=True)]
    return Outcome(items, items, verdicts)


RULES: dict[str, Callable[..., Outcome]] = {
    rule.__name__: rule for rule in (each, steps, ordered, extreme, ratio, compared)
}


def select(items: "DataFrame", where: Mapping[str, Any]) -> "DataFrame":
    """The items that have one of the values of each label."""
    for label, values in where.items():
        if label not in items:
            return items.head(0)
        items = items[items[label].isin(values if isinstance(values, list) else [values])]
    return items


def groups(items: "DataFrame", per: Sequence[str]) -> list[tuple[dict[str, Any], "DataFrame"]]:
    """The labels and the items of each group, in the order of the items; all of them without."""
    if not per or not len(items):
        return [({}, items)] if len(items) else []
    grouped = items.groupby(list(per), sort=False)
    return [(dict(zip(per, key, strict=True)), own) for key, own in grouped]


def _whole(items: "DataFrame", selection: Mapping[str, Any]) -> bool:
    """True if each combination of the values that a selection names has an item."""
    named = [values if isinstance(values, list) else [values] for values in selection.values()]
    if not named or not len(items):
        return len(items) > 0
    there = set(zip(*(items[label] for label in selection), strict=True))
    return there >= set(itertools.product(*named))


def _limit(items: "DataFrame", limit: Limit) -> "Series | float":
    return items[limit] if isinstance(limit, str) else limit
