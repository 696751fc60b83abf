"""Air drag on an object that bounces: what its flights show of it, and what it does to restitution.

Drag that grows as the square of speed, y'' = a - |a| v|v|/w^2 with w the speed at which a fall
ends, adds -a^3 s^3|s|/(12 w^2) to a parabola of acceleration a, s from its apex, to first order in
(v/w)^2.
By the same order a flight that begins with speed u takes 2u/a (1 - u^2/4w^2) and ends with
u (1 - u^2/2w^2): speed after over speed before is T(k+1)/T(k) (1 + (u(k)^2 + u(k+1)^2)/4w^2).
A shutter that reads the picture row by row adds c y v, odd about the apex as drag is: the one that
explains the flights better is taken for the cause. Contacts, all in one row, are no less known for
that.
What scatters the flights' accelerations beyond what drag does to them (positions seen wrong over a
whole flight) may bend them as drag does: sigma holds that, so that drag is not read out of it.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from calibration.drop.bounce import Bounces
from calibration.drop.parabolas import scatter_beyond_noise
from calibration.statistics.robust import for_correlation
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.track import Array

_SIGMAS = 3.0  # by which drag must be known to be reported


def slowness(found: Bounces) -> tuple[Estimate, bool]:
    """1/w^2 [frames^2/y^2] with its sigma; whether drag explains the flights as well as a shutter.

    Each flight has a parabola of its own, so that perspective, alike on both sides of an apex, is
    not taken for drag.
    """
    fitted = found.flights
    left, odd, size, altered, spread = [], [], [0], [], []
    for rows, centre, (_, slope, bend) in zip(
        fitted.rows, fitted.centre, fitted.coefficients, strict=True
    ):
        used = rows[fitted.weights[rows] > 0]
        s = found.base.clock[used] - centre
        late = s + slope / bend  # since the apex
        own = np.stack([np.ones_like(s), s, s**2], axis=1)
        seen = found.track.y[found.base.rows[used]]
        shapes = np.stack([-(bend**3) * late**3 * np.abs(late) / 12, late**3], axis=1)
        left.append(seen - own @ np.linalg.lstsq(own, seen, rcond=None)[0])
        taken_up = np.linalg.lstsq(own, shapes, rcond=None)[0]
        odd.append(shapes - own @ taken_up)
        altered.append(2 * taken_up[2, 0])  # what drag does to the flight's own acceleration
        spread.append(np.std(s**2) / 2)  # of positions, by one unit of acceleration
        size.append(size[-1] + len(used))
    y, (air, shutter) = np.concatenate(left), np.concatenate(odd).T
    value = float(air @ y / (air @ air))
    residuals = y - value * air
    parts = [np.arange(i, j) for i, j in pairwise(size)]
    variance = float(residuals @ residuals) / max(len(y) - 3 * len(parts) - 1, 1)
    variance *= for_correlation(residuals, parts)
    by_shutter = y - shutter * float(shutter @ y / (shutter @ shutter))
    better = float(residuals @ residuals) <= float(by_shutter @ by_shutter) + variance
    accelerations = fitted.own - value * np.stack([altered, np.zeros(len(parts))], axis=1)
    wrong = scatter_beyond_noise(accelerations) * np.array(spread)
    bent = [np.linalg.norm(air[part]) * np.sqrt(len(part)) for part in parts]
    off = np.linalg.norm(wrong * bent) / (air @ air)
    return Estimate(
        value, float(np.hypot(np.sqrt(variance / (air @ air)), off)), len(parts)
    ), better


def with_drag(found: Bounces) -> Bounces:
    """The same, with what drag adds to restitution in its sigma and warnings, where it shows."""
    slow, drags = slowness(found)
    assert slow.sigma is not None
    if not drags or slow.value < _SIGMAS * slow.sigma:
        return found
    more = _added(found, slow.value)
    sigma = float(np.hypot(found.pooled.sigma or 0.0, np.mean(more)))
    warning = (
        f"air drag shows in the flights (a fall would end at {slow.value**-0.5:.3g} +- "
        f"{slow.value**-1.5 * slow.sigma / 2:.1g} px/frame): speed after over speed before is "
        f"higher than {found.method} say by {np.mean(more):.2g}; it is in the sigma"
    )
    return replace(
        found, sigma=np.hypot(found.sigma, more), warnings=[*found.warnings, warning],
        pooled=replace(found.pooled, sigma=sigma),
    )  # fmt: skip


def _added(found: Bounces, slow: float) -> Array:
    """Share that each restitution of `best` lacks for the drag of the flights around it."""
    first = (len(found.contacts) - len(found.best)) // 2
    before = found.speeds[first : first + len(found.best), 0]
    return np.asarray(found.best * before**2 * (1 + found.best**2) * slow / 4)
