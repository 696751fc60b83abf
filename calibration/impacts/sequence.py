"""Impacts of one bouncing body among all candidates: intervals that shrink geometrically.

A body that bounces with a restitution e flies T, e T, e^2 T, ... (thesis, eqs 7.3 to 7.5). Release
clicks, echoes at walls, knocks and speech have no such times. Of all rows of candidates whose
intervals shrink, by a ratio that changes little from pair to pair, and whose levels fall as the
speed may let them, the one is taken with the largest sum of levels over the noise; less for a
changing ratio, and for events inside it that are much louder than the impact before. A row of
echoes repeats that of the impacts a little later: of two such rows the earlier one is taken.

The significance of a row: it may be there by chance, made up by knocks, ticks or hum. The first
ratio of a row fits any three events, and each further impact only confirms it as far as it comes
when the ratio says. Rows to be expected of events at random times:

    C(n, 3) prod_k min(1, 2 |T(k+1) - T(k)^2/T(k-1)| density),

n events, of which those that the row does not explain have the density. Ticks come in step, so that
they are no random times: between impacts a body flies, and nothing there is as loud as they are.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

STEADY = 0.1  # the largest change of ln(e) from one pair of flights to the next, and
YIELDING = 0.25  # this part of ln(e): e ~ v^(-1/4) where a contact yields (Johnson 1985, sec. 11.5)
LOUDER = 6.0  # [dB] that an impact may be louder than the one before, on another spot
_STEEPEST = 3.0  # largest power of the impact speed with which the amplitude goes
LEAST, MOST = 0.05, 1.0  # of a ratio of two flights that is taken for a restitution
_SAME = 0.03  # of the shortest flight: how far an echo's row may be from the impacts' in step
_CHANCE = 5e-3  # below which events in step are echoes, and not there by chance
NEAR = 2e-3  # [s] how far echoes may be from in step with their impacts
_MOST_CANDIDATES = 60  # the strongest; the search takes the cube of it
_LIKELY = 0.05  # rows by chance, from which a row is not believed
_FAINTER = 3.0  # [dB] by which an echo is weaker than its impact, at least: 70 % of the amplitude


def bouncing(times: ArrayLike, levels: ArrayLike) -> list[int]:
    """The indices of the candidates that are impacts of one body, ascending; empty for none.

    times (m,) [s] ascending, levels (m,) > 0 [dB]. Three impacts make a row at least.
    """
    kept = np.sort(np.argsort(levels)[::-1][:_MOST_CANDIDATES])
    t, weight = np.asarray(times, float)[kept], np.asarray(levels, float)[kept]
    while True:
        row = _earliest(_heaviest(t, weight), t)
        echo = next((k for k in row if _is_echo(k, row, t, weight)), None)
        if echo is None:
            return [int(kept[k]) for k in row]
        kept, t, weight = (np.delete(of_all, echo) for of_all in (kept, t, weight))


def _is_echo(
    member: int, row: list[int], t: NDArray[np.float64], weight: NDArray[np.float64]
) -> bool:
    """True if a member follows another as weaker events follow others, more often than by chance.

    Flights shrink and never repeat; the way by a wall is as long for every impact.
    """
    from scipy.stats import binom

    outside = ~np.isin(np.arange(len(t)), row)  # flights near e = 1 are nearly in step themselves
    chance = min(1.0, 2.0 * NEAR * len(t) / (t[-1] - t[0]))  # of an event at a given time
    for source in row[: row.index(member)]:
        delay = t[member] - t[source]
        others = [k for k in row if k not in (member, source) and t[k] + delay < t[-1] + NEAR]
        followed = [
            k for k in others
            if (outside & (np.abs(t - t[k] - delay) < NEAR) & (weight < weight[k])).any()
        ]  # fmt: skip
        by_chance = binom.sf(len(followed) - 1, len(others), chance)
        if weight[member] < weight[source] and by_chance < _CHANCE:
            return True
    return False


def _heaviest(t: NDArray[np.float64], weight: NDArray[np.float64]) -> list[int]:
    """The row with the largest sum of levels: see the head of this file."""
    best: dict[tuple[int, int], list[_Row]] = {}
    found = _Row(0.0, 0.0, ())
    for last in range(len(t)):
        for middle in range(last):
            rows = _rows_that_end(middle, last, t, weight, best)
            best[middle, last] = rows
            found = max([found, *rows], key=lambda row: row.weight)
    return list(found.members)


def _earliest(row: list[int], t: NDArray[np.float64]) -> list[int]:
    """The row, or an earlier one with its very flights: of the two, it is the echo."""
    if not row:
        return row
    shortest = t[row[-1]] - t[row[-2]]
    for begin in range(row[0]):
        delay = t[row[0]] - t[begin]
        wanted = t[row] - delay
        near = [int(np.argmin(np.abs(t - time))) for time in wanted]
        if delay < shortest and np.abs(t[near] - wanted).max() < _SAME * shortest:
            return near
    return row


class _Row:
    """Impacts that end with a certain flight, and the ratio of their last two flights."""

    __slots__ = ("members", "ratio", "weight")

    def __init__(self, weight: float, ratio: float, members: tuple[int, ...]) -> None:
        self.weight, self.ratio, self.members = weight, ratio, members


def _rows_that_end(
    middle: int,
    last: int,
    t: NDArray[np.float64],
    weight: NDArray[np.float64],
    best: dict[tuple[int, int], list[_Row]],
) -> list[_Row]:
    """For each flight before the flight middle to last, the best row that ends with both."""
    rows = []
    flight = t[last] - t[middle]
    gain = float(weight[last]) - _louder(middle, last, weight)
    for first in range(middle):
        ratio = float(flight / (t[middle] - t[first]))
        if weight[middle] - weight[first] > LOUDER:
            continue
        if not LEAST < ratio < MOST or not _fits(weight[last] - weight[middle], ratio):
            continue
        begun = float(weight[first] + weight[middle]) - _louder(first, middle, weight)
        longest = _Row(begun, ratio, (first, middle))
        for row in best[first, middle]:
            change = abs(np.log(ratio / row.ratio)) / (STEADY - YIELDING * np.log(ratio))
            if change < 1.0 and row.weight - change * weight[last] > longest.weight:
                longest = _Row(row.weight - change * weight[last], row.ratio, row.members)
        rows.append(_Row(longest.weight + gain, ratio, (*longest.members, last)))
    return rows


def _fits(change: float, ratio: float) -> bool:
    """True if the level may change so [dB] when the speed falls by a ratio."""
    softest = _STEEPEST * 20.0 * np.log10(ratio) - LOUDER
    return bool(softest <= change <= LOUDER)


def _louder(before: int, after: int, weight: NDArray[np.float64]) -> float:
    """The levels of events between two impacts that are too loud for echoes of the first."""
    between = weight[before + 1 : after]
    return float(between[between > weight[before] + LOUDER].sum())


def weakness(row: list[int], times: NDArray[np.float64], levels: NDArray[np.float64]) -> str | None:
    """Reason not to believe a row of three events or more: times (m,) [s], levels (m,) [dB]."""
    loud = _as_loud(row, times, levels)
    if loud >= len(row) - 2:  # as many as the row has ratios
        return (
            f"{loud} other events among the {len(row)} that would make a row are about as loud: no "
            "restitution; cut the signal to one drop"
        )
    expected = _expected(row, times, levels)
    if expected < _LIKELY:
        return None
    return (
        f"{len(row)} events would make a row, but {expected:.2g} such rows are to be expected of "
        "all that is heard here by chance: no restitution; cut the signal to one drop"
    )


def _as_loud(row: list[int], t: NDArray[np.float64], level: NDArray[np.float64]) -> int:
    """Events outside the row about as loud as the impact before, up to one flight around it."""
    flights = np.diff(t[row])
    first = t[row[0]] - flights[0] ** 2 / flights[1]  # where an impact before it would have been
    found = 0
    for k in np.flatnonzero((t > first) & (t < t[row[-1]] + flights[-1])):
        before = max((member for member in row if member < k), default=row[0])
        found += k not in row and level[k] > level[before] - _FAINTER
    return found


def _expected(row: list[int], t: NDArray[np.float64], level: NDArray[np.float64]) -> float:
    """Rows as good as this one, of events at random times; 0 where it explains all events."""
    weakest = level[row].min() - LOUDER
    spare = [
        k for k in range(len(t))
        if k not in row and level[k] > weakest and not _echoes(k, row, t)
    ]  # fmt: skip
    if not spare:
        return 0.0
    flights = np.diff(t[row])
    misses = np.abs(flights[2:] - flights[1:-1] ** 2 / flights[:-2])
    density = len(spare) / (t[-1] - t[0])
    fits = np.minimum(1.0, 2.0 * misses * density)
    return math.comb(len(row) + len(spare), 3) * float(np.prod(fits))


def _echoes(k: int, row: list[int], t: NDArray[np.float64]) -> bool:
    """True if an event follows an impact as another event follows another impact."""
    outside = np.delete(t, row)
    for source in [member for member in row if member < k]:
        after = t[[member for member in row if member != source]] + t[k] - t[source]
        if (np.abs(outside[:, None] - after) < NEAR).any():
            return True
    return False
