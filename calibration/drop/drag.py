"""Air drag on an object that bounces: what its flights show of it, and what it does to restitution.

Drag that grows as the square of speed, y'' = a - |a| v|v|/w^2 with w the speed at which a fall
ends, adds -a^3 s^3|s|/(12 w^2) to a parabola of acceleration a, s from its apex, to first order in
(v/w)^2.
By the same order a flight that begins with speed u takes 2u/a (1 - u^2/4w^2) and ends with
u (1 - u^2/2w^2): speed after over speed before is T(k+1)/T(k) (1 + (u(k)^2 + u(k+1)^2)/4w^2).
A shutter that reads the picture row by row adds c y v, odd about the apex as drag is: where it
explains the flights better, drag is what explains the rest. Contacts, all in one row, are no less
known for it.
Flights that do not show drag do not show that there is none. Restitution has the mean of all drag
that the flights allow, w of any size between two and a hundred impact speeds alike (log-uniform),
and sigma its scatter. From bounce to bounce the ratios rise by drag alone, or by drag and a contact
that yields (Johnson 1985, sec. 11.5) by any amount; both are as likely. Restitution that falls with
falling speed is not known of solids. A terminal speed that is given stands instead of all that, and
the flights check it.
What scatters the flights' accelerations beyond what drag does to them (positions seen wrong over a
whole flight) may bend them as drag does: sigma holds that, so that drag is not read out of it.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from calibration.drop.bounce import Bounces, lever
from calibration.drop.parabolas import scatter_beyond_noise
from calibration.statistics.correlated import pool
from calibration.statistics.robust import for_correlation
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.track import Array

_SIGMAS = 3.0  # by which drag, or a shutter, must be known to be reported, or taken for the cause
# Terminal in impact speeds: below, the first order above is none; above, it is below 1e-4.
_TERMINAL = (2.0, 100.0)


def slowness(found: Bounces) -> Estimate:
    """1/w^2 [frames^2/y^2] with its sigma, by a shutter, too, where that explains more.

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
    parts = [np.arange(i, j) for i, j in pairwise(size)]
    freedom = max(len(y) - 3 * len(parts) - 1, 1)
    residuals, by_shutter = _without(y, air), _without(y, shutter)
    variance = float(residuals @ residuals) / freedom * for_correlation(residuals, parts)
    if float(residuals @ residuals) > float(by_shutter @ by_shutter) + _SIGMAS**2 * variance:
        y, air = by_shutter, _without(air, shutter)
        residuals = _without(y, air)
        variance = float(residuals @ residuals) / freedom * for_correlation(residuals, parts)
    value = float(air @ y / (air @ air))
    accelerations = fitted.own - value * np.stack([altered, np.zeros(len(parts))], axis=1)
    wrong = scatter_beyond_noise(accelerations) * np.array(spread)
    bent = [np.linalg.norm(air[part]) * np.sqrt(len(part)) for part in parts]
    off = np.linalg.norm(wrong * bent) / (air @ air)
    return Estimate(value, float(np.hypot(np.sqrt(variance / (air @ air)), off)), len(parts))


def _without(y: Array, shape: Array) -> Array:
    """Rest of y that a shape, fitted to it, leaves."""
    return np.asarray(y - shape * float(shape @ y / (shape @ shape)))


def with_drag(found: Bounces, known: Estimate | None = None) -> Bounces:
    """The same with the mean of all drag that it allows in restitution, its scatter in sigma.

    known: 1/w^2 [frames^2/y^2] of a terminal speed that is given.
    """
    seen = slowness(found)
    slow = _first_order(found, known) if known else _allowed(found, seen, _most(found))
    assert slow.sigma is not None
    per_slow = _added(found, 1.0)
    best = found.best + slow.value * per_slow
    covariance = found.covariance + slow.sigma**2 * np.outer(per_slow, per_slow)
    pooled, p = pool(best, covariance)
    corrected = replace(
        found, best=best, covariance=covariance, pooled=pooled, p=p, slow=slow,
        exponent=_exponent(found, slow),
    )  # fmt: skip
    if known:
        return replace(corrected, warnings=[*found.warnings, *_unlike(known, seen)])
    if slow.value < _SIGMAS * slow.sigma:
        return corrected
    warning = (
        f"air drag shows in the flights (a fall would end at {slow.value**-0.5:.3g} +- "
        f"{slow.value**-1.5 * slow.sigma / 2:.1g} px/frame): speed after over speed before is "
        f"higher than {found.method} say by {slow.value * np.mean(per_slow):.2g}; it is corrected"
    )
    return replace(corrected, warnings=[*found.warnings, warning])


def _unlike(known: Estimate, seen: Estimate) -> list[str]:
    """A warning where the flights contradict a terminal speed that is given."""
    off = np.hypot(known.sigma or 0.0, seen.sigma or 0.0)
    if abs(seen.value - known.value) <= _SIGMAS * off:
        return []
    share = f"{np.sqrt(known.value / seen.value):.2g} of it" if seen.value > 0 else "no drag"
    return [f"the flights do not show the terminal speed that is given, but {share}; it stands"]


def _added(found: Bounces, slow: float) -> Array:
    """Share that each restitution of `best` lacks for the drag of the flights around it."""
    return np.asarray(found.best * found.best_speeds**2 * (1 + found.best**2) * slow / 4)


def _most(found: Bounces) -> Estimate | None:
    """1/w^2 that would explain all that the ratios rise by as the object gets slower.

    None for one ratio. Ratios that scatter beyond their noise know it less well.
    """
    per_slow, n = _added(found, 1.0), len(found.best)
    if n < 2 or np.ptp(per_slow) == 0:
        return None
    design = np.stack([np.ones(n), -per_slow], axis=1)
    inverse = np.linalg.pinv(found.covariance, hermitian=True)
    spread = np.linalg.inv(design.T @ inverse @ design)
    level, slope = spread @ design.T @ inverse @ found.best
    left = found.best - design @ np.array([level, slope])
    excess = max(1.0, float(left @ inverse @ left) / (n - 2)) if n > 2 else 1.0
    return _first_order(found, Estimate(float(slope), float(np.sqrt(excess * spread[1, 1])), n))


def _allowed(found: Bounces, seen: Estimate, most: Estimate | None) -> Estimate:
    """Mean and scatter of 1/w^2 by the flights' shape and by the ratios; see the text above."""
    from scipy.stats import norm

    fastest, (least, largest) = float(np.max(found.speeds[:, 0])), _TERMINAL
    slow = np.geomspace(1 / (largest * fastest) ** 2, 1 / (least * fastest) ** 2, 2001)
    log = norm.logpdf(slow, seen.value, seen.sigma)
    weight = np.exp(log - log.max())
    if most is not None:
        by_drag = norm.pdf(slow, most.value, most.sigma)
        by_both = norm.sf(slow, most.value, most.sigma) / slow[-1]
        weight *= by_drag + by_both
    weight /= weight.sum()
    value = float(weight @ slow)
    scatter = float(np.sqrt(weight @ (slow - value) ** 2))
    return _first_order(found, Estimate(value, scatter, seen.trials))


def _first_order(found: Bounces, slow: Estimate) -> Estimate:
    """The same with what the second order in (v/w)^2 may be in sigma."""
    second = slow.value**2 * float(np.mean(found.best_speeds**2))
    return replace(slow, sigma=float(np.hypot(slow.sigma or 0.0, second)))


def _exponent(found: Bounces, slow: Estimate) -> Estimate | None:
    """n of e ~ speed^n with drag taken off."""
    if found.exponent is None:
        return None
    share = lever(found.best_speeds, found.best**2 / np.diag(found.covariance))
    by = float(share @ (_added(found, 1.0) / found.best))
    sigma = float(np.hypot(found.exponent.sigma or 0.0, by * (slow.sigma or 0.0)))
    return replace(found.exponent, value=found.exponent.value + by * slow.value, sigma=sigma)
