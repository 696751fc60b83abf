"""With which power of a sine the force of all impacts rises: the onsets that follow from it.

A pulse that is not a half sine begins earlier or later than one fitted to it, by a part of its
rise. Contacts that get stiffer with overlap rise slower at lower speed (Hertz: as v^(-1/5)), and
the flights in between would be off by what their two rises differ. The power is therefore fitted to
all edges together, and what remains unknown of it is carried to the onsets' uncertainty.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibration.impacts.onset import Edge, Onset, onset, rising

# A dashpot's force sets in at once (power 0); one that sets in smoothly, through a filter, rises
# with a square; a linear spring has 1, a Hertz contact 3/2.
_POWERS = (0.5, 2.0)


def onsets_of(edges: Sequence[Edge]) -> list[Onset]:
    """Onsets with the power that fits all edges best, and their uncertainty."""
    from scipy.optimize import minimize_scalar

    found = [onset(edge, 1.0) for edge in edges]
    clear = [k for k, one in enumerate(found) if one.fit is not None]
    if len(clear) < 2:
        return found
    best = minimize_scalar(
        lambda power: sum(_misfit(edges[k], power) for k in clear),
        bounds=_POWERS, method="bounded", options={"xatol": 1e-3},
    )  # fmt: skip
    found = [onset(edge, float(best.x)) for edge in edges]
    return _with_power(found, float(best.x))


def _misfit(edge: Edge, power: float) -> float:
    """Chi-squared of an edge's best fit."""
    one = onset(edge, power)
    t, y = edge.rising()
    model = np.zeros_like(y) if one.fit is None else rising(t, one.fit, power)
    return float((((y - model) / edge.noise) ** 2).sum())


def _with_power(found: Sequence[Onset], power: float) -> list[Onset]:
    """The same with the power's uncertainty, as far as it moves onsets against one another."""
    slopes = {k: _slopes(one, power) for k, one in enumerate(found) if one.fit is not None}
    if not slopes:
        return list(found)
    information = sum(known for _, known in slopes.values())
    even = (_POWERS[1] - _POWERS[0]) / np.sqrt(12.0)  # of a power that nothing tells
    sigma = min(even, information**-0.5) if information > 0 else even
    mean = float(np.mean([moved for moved, _ in slopes.values()]))
    return [
        replace(one, sigma=float(np.hypot(one.sigma, sigma * (slopes[k][0] - mean))))
        if k in slopes
        else one
        for k, one in enumerate(found)
    ]


def _slopes(one: Onset, power: float) -> tuple[float, float]:
    """Samples by which an onset moves with the power, and what its edge tells of the power."""
    from scipy.optimize import approx_fprime

    t, _ = one.edge.rising()
    at = np.append(np.asarray(one.fit), power)
    jacobian: NDArray[np.float64] = approx_fprime(at, lambda p: rising(t, p[:4], p[4]))
    moved, *_ = np.linalg.lstsq(jacobian[:, :4], jacobian[:, 4], rcond=None)
    left = jacobian[:, 4] - jacobian[:, :4] @ moved
    return -float(moved[2]), float((left / one.edge.noise) @ (left / one.edge.noise))
