"""Whether a row of impacts could be there by chance, made up by knocks, ticks or hum.

The first ratio of a row fits any three events, and each further impact only confirms it as far as
it comes when the ratio says. Rows to be expected of events at random times:

    C(n, 3) prod_k min(1, 2 |T(k+1) - T(k)^2/T(k-1)| density),

n events, of which those that the row does not explain have the density. Ticks come in step, so that
they are no random times: between impacts a body flies, and nothing there is as loud as they are.
"""

import math

import numpy as np
from numpy.typing import NDArray

from calibration.impacts.sequence import LOUDER, NEAR

_LIKELY = 0.05  # rows by chance, from which a row is not believed
_FAINTER = 3.0  # [dB] by which an echo is weaker than its impact, at least: 70 % of the amplitude


def doubt(row: list[int], times: NDArray[np.float64], levels: NDArray[np.float64]) -> str | None:
    """Why a row of three events or more (of times (m,) [s], levels (m,) [dB]) is not believed."""
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
        if k not in row and level[k] > weakest and not _is_echo(k, row, t)
    ]  # fmt: skip
    if not spare:
        return 0.0
    flights = np.diff(t[row])
    misses = np.abs(flights[2:] - flights[1:-1] ** 2 / flights[:-2])
    density = len(spare) / (t[-1] - t[0])
    fits = np.minimum(1.0, 2.0 * misses * density)
    return math.comb(len(row) + len(spare), 3) * float(np.prod(fits))


def _is_echo(k: int, row: list[int], t: NDArray[np.float64]) -> bool:
    """Whether an event follows an impact as another event follows another impact."""
    outside = np.delete(t, row)
    for source in [member for member in row if member < k]:
        after = t[[member for member in row if member != source]] + t[k] - t[source]
        if (np.abs(outside[:, None] - after) < NEAR).any():
            return True
    return False
