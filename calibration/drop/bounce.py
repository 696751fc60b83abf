"""Restitution of every bounce of a track, with uncertainty: paper eq. 3.5, and times of flight.

Bounce k is at contact k, where flight k ends and flight k + 1 begins:
    from times       T(k+1)/T(k), T the time between the contacts that bound a flight
    from velocities  speed after over speed before, of the two parabolas at the contact
    from heights     sqrt(H1/H0), eq. 3.5, H from the plate to the highest point of a flight
No scale and no rate are needed for these. sigma comes from the covariance of all parabolas: two
bounces that share a flight are correlated, and the pooled value and the test know it. Where two
ways disagree by more than three sigma (a plate that drifts, a contact that takes time), the clip is
no set of parabolas on a level plate, and what they disagree by is added to sigma.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from calibration.drop.parabolas import (
    Flights,
    ShortFlightError,
    contact_times,
    fit,
    from_heights,
    from_times,
    from_velocities,
    inner_velocities,
    levels,
    speeds,
)
from calibration.drop.timebase import TimeBase, check
from calibration.statistics.correlated import CHANCE, pool, propagated, with_sigma
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.segments import flights
from calibration.tracking.track import Array, Track
from granulab.errors import InputError

STANDARD_GRAVITY = Estimate(9.80665, 0.03, 1)  # m/s2; sigma: what it varies by over the earth
_EXACT = 1e-9  # sigma of restitution that numbers without noise have from their rounding
_UNEVEN = 0.05  # of a frame: stamps that vary by more are compared with an even clock

_Formula = Callable[[Array, Array], Array]


@dataclass(frozen=True)
class Bounces:
    """Bounces of a clip; times in frames, lengths in the track's unit. Covariances are joint.

    track, base   the positions and the clock used; flights are fitted on base.clock
    flights       parabolas
    contacts      (n,) time of each contact on base.clock, and sigma
    plate         (n,) level of each contact, and sigma
    drift         change of the plate's level from first to last contact, and sigma
    speeds        (n,) before each contact, normal to the plate (along y), and sigma
    times, velocities, heights   restitution (n, 2) of each bounce, sigma; NaN where it has none
    best, covariance   (b,) restitution from `method` of every bounce that has it; (b, b) of these
    disagreement  (b,) what the next way gives less `best`, where more than three sigma; else 0
    pooled        one restitution from `best`, p of the test that one number describes the clip
    exponent      n of e ~ speed^n, with sigma; None for fewer than two bounces
    slow          1/w^2 of the terminal speed w in air [frames^2/y^2], as far as it is taken off
    """

    track: Track
    base: TimeBase
    flights: Flights
    contacts: Array
    plate: Array
    drift: Estimate
    speeds: Array
    times: Array
    velocities: Array
    heights: Array
    method: str
    best: Array
    covariance: Array
    disagreement: Array
    pooled: Estimate
    p: float | None
    exponent: Estimate | None
    warnings: list[str] = field(default_factory=list)
    slow: Estimate | None = None

    @property
    def sigma(self) -> Array:
        """(b,) of `best`."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def best_speeds(self) -> Array:
        """(b,) before the contacts of `best`."""
        return _around(self.speeds[:, 0], len(self.best))

    @property
    def constant_within_noise(self) -> bool | None:
        """True if one number describes the clip (p at least 0.01); None for one bounce."""
        return None if self.p is None else self.p >= CHANCE


def find_bounces(track: Track, *, one_is_enough: bool = False) -> Bounces:
    """All bounces of a track.

    Raises InputError where nothing falls in it, or it bounces less than twice (less than once with
    one_is_enough: then eq. 3.5 and the velocities alone give the restitution).
    """
    track = track.seen()
    if len(track.frame) < 8:
        raise InputError(f"{len(track.frame)} positions; a fall and two bounces need 8 and more")
    found, other = _on_clock(track, track.clock), _on_even_clock(track)
    if other is not None and (found is None or other.flights.sigma < 0.7 * found.flights.sigma):
        remark = "the time stamps are uneven and free fall is not: an even clock is used"
        found = replace(other, base=replace(other.base, remarks=[*other.base.remarks, remark]))
    if found is None:
        raise InputError("nothing falls: no stretch of the track is a parabola with a bounce after")
    if len(found.contacts) < 2 and not one_is_enough:
        e, sigma = found.velocities[0]
        raise InputError(
            f"one bounce, at frame {_frame(found, found.contacts[0, 0]):.2f} (its velocities give "
            f"{e:.3f}, sigma {sigma:.3f}); two and more are needed to check one by another, or "
            "--one-bounce"
        )
    return found


def _on_even_clock(track: Track) -> Bounces | None:
    """The same with frame numbers as time, where stamps are uneven."""
    if track.time is None:
        return None
    even = np.round(track.frame - track.frame[0])
    if np.any(np.diff(even) < 1) or np.abs(track.clock - track.clock[0] - even).max() < _UNEVEN:
        return None
    return _on_clock(track, even)


def _on_clock(track: Track, clock: Array) -> Bounces | None:
    """All bounces with this clock; None where nothing falls and bounces."""
    base = check(track, clock)
    t, y = base.clock, track.y[base.rows]
    ranges, _ = flights(t, y)
    if len(ranges) < 2:
        return None
    spread = None
    if track.covariance is not None:
        spread = np.sqrt(track.covariance[base.rows, 1, 1])
    fitted = _bouncing(t, y, ranges, spread)
    return None if fitted is None else _measured(track, base, fitted)


def _bouncing(
    t: Array, y: Array, ranges: list[tuple[int, int]], spread: Array | None
) -> Flights | None:
    """Parabolas of most of the flights that follow one another through contacts; None for one.

    Contacts come in order, and reverse the velocity. A block that comes to rest rattles, and its
    last stretches are no flights.
    """
    while len(ranges) > 1:
        try:
            found = fit(t, y, ranges, spread)
        except ShortFlightError as error:
            ranges = max(ranges[: error.flight], ranges[error.flight + 1 :], key=len)
            continue
        parabolas = found.centre, found.coefficients
        reverses = from_velocities(*parabolas) > 0  # not where it is NaN
        follows = np.diff(contact_times(*parabolas), prepend=-np.inf) > 0
        wrong = np.flatnonzero(~(reverses & follows))
        if not len(wrong):
            return found
        flight = int(wrong[0]) + 1
        ranges = max(ranges[:flight], ranges[flight:], key=len)
    return None


def _measured(track: Track, base: TimeBase, fitted: Flights) -> Bounces:
    centre = fitted.centre

    def known(quantity: Callable[[Array], Array]) -> tuple[Array, Array]:
        return _known(fitted, lambda c: np.asarray(quantity(c)))

    contacts = with_sigma(*known(lambda c: contact_times(centre, c)))
    plate, plate_covariance = known(lambda c: levels(centre, c))
    before = with_sigma(*known(lambda c: np.abs(speeds(centre, c)[0])))
    times = np.full((len(contacts), 2), np.nan)
    method, best, other = "velocities", from_velocities, from_heights
    if len(contacts) > 2:
        method, best, other = "times", from_times, inner_velocities
        times[1:-1] = with_sigma(*known(lambda c: best(centre, c)))
    e, covariance = known(lambda c: best(centre, c))
    off = with_sigma(*known(lambda c: other(centre, c) - best(centre, c)))
    far = np.abs(off[:, 0]) > np.maximum(3 * off[:, 1], _EXACT)
    off = np.where(far, off[:, 0], 0.0)  # also where it is NaN
    covariance = covariance + np.diag(off**2 + _EXACT**2 + e**2 * _hidden(fitted, base, before, e))
    pooled, p = pool(e, covariance)
    found = Bounces(
        track, base, fitted, contacts, with_sigma(plate, plate_covariance),
        _drift(plate, plate_covariance), before, times,
        with_sigma(*known(lambda c: from_velocities(centre, c))),
        with_sigma(*known(lambda c: from_heights(centre, c))),
        method, e, covariance, off, pooled, p,
        _exponent(fitted, best, np.diag(covariance), off) if len(e) > 1 else None,
    )  # fmt: skip
    return replace(found, warnings=_warnings(found))


def _hidden(fitted: Flights, base: TimeBase, before: Array, e: Array) -> Array:
    """(b,) relative variance of restitution from frames lost within contacts, as in flights.

    A frame there moves an end of a flight T = 2 v/a by up to itself.
    """
    speed = _around(before[:, 0], len(e))
    flight = 2 * np.stack([speed, speed * e]) / abs(fitted.acceleration[0])
    return np.asarray(base.lost * np.sum(1 / flight**2, axis=0))


def _around(of_contacts: Array, n: int) -> Array:
    """(n,) of the contacts in the middle: those between two whole flights, or all."""
    first = (len(of_contacts) - n) // 2
    return of_contacts[first : first + n]


def _known(fitted: Flights, quantity: Callable[[Array], Array]) -> tuple[Array, Array]:
    """A vector of quantities of the parabolas' coefficients (m, 3), and its covariance."""
    return propagated(
        fitted.coefficients.ravel(), fitted.covariance, lambda c: quantity(c.reshape(-1, 3))
    )


def _exponent(fitted: Flights, best: _Formula, variance: Array, off: Array) -> Estimate:
    """n of e ~ speed^n from the logarithms, each bounce weighted by its own sigma."""
    centre = fitted.centre
    weight = best(centre, fitted.coefficients) ** 2 / variance  # of ln e

    def levers(c: Array) -> Array:
        return lever(_around(np.abs(speeds(centre, c)[0]), len(weight)), weight)

    def slope(c: Array) -> Array:
        return np.atleast_1d(levers(c) @ np.log(np.abs(best(centre, c))))

    value, covariance = _known(fitted, slope)
    extra = np.sum((levers(fitted.coefficients) * off / best(centre, fitted.coefficients)) ** 2)
    return Estimate(float(value[0]), float(np.sqrt(covariance[0, 0] + extra)), len(weight))


def lever(speed: Array, weight: Array) -> Array:
    """(n,) of each logarithm in the weighted slope against the logarithm of the speed."""
    log = np.log(speed)
    log = log - weight @ log / weight.sum()
    return np.asarray(weight * log / (weight @ log**2))


def _drift(levels: Array, covariance: Array) -> Estimate:
    """Change of the plate's level from the first contact to the last."""
    ends = np.zeros(len(levels))
    ends[0], ends[-1] = (-1.0, 1.0) if len(levels) > 1 else (0.0, 0.0)
    return Estimate(float(ends @ levels), float(np.sqrt(ends @ covariance @ ends)), len(levels))


def _warnings(found: Bounces) -> list[str]:
    """Warnings about the numbers."""
    warnings = list(found.track.remarks)
    fitted = found.flights
    if fitted.scatter:
        own = ", ".join(f"{a:.4g}" for a in fitted.own[:, 0])
        warnings.append(
            f"the flights do not share one acceleration (p = {fitted.p:.1g}: {own}): drag, "
            "perspective, or a clock that changes; each was given its own, as far as it is known"
        )
    if found.drift.sigma and abs(found.drift.value) > 3 * found.drift.sigma:
        warnings.append(
            f"the plate's level changes by {found.drift.value:.3g} "
            f"(sigma {found.drift.sigma:.2g}) over the clip"
        )
    used = np.isfinite(fitted.weights)
    out = int(np.sum(fitted.weights[used] == 0))
    if out:
        warnings.append(f"{out} of {int(used.sum())} positions fit no parabola: left out")
    if np.any(found.disagreement):
        other = "velocities" if found.method == "times" else "heights"
        warnings.append(
            f"{found.method} and {other} disagree by up to {np.abs(found.disagreement).max():.2g}: "
            "the plate is not level or a contact takes time; it is in the sigma"
        )
    if found.constant_within_noise is False:
        warnings.append(
            f"one number does not describe the clip (p = {found.p:.2g}): see restitution against "
            "impact speed"
        )
    return warnings


def _frame(found: Bounces, time: float) -> float:
    """The frame number at a time of the clock."""
    return float(np.interp(time, found.base.clock, found.track.frame[found.base.rows]))
