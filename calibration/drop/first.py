"""The first contact of a drop from rest: H0, H1 and sqrt(H1/H0) (paper, eq. 3.5).

One bounce is enough. The fall and the rebound are two parabolas of one acceleration that meet in
the contact; an object that was held lay at the apex of its fall. H0 and H1 are the ways of the
centroid, so that it may rotate: the next contact of a block meets another corner at another height,
and is another experiment.

Positions have three errors. Noise of their own, and noise that is alike where the object hardly
moves (what lies behind its rim, coding): about half each, the latter over some pixels. How large
these are the picture says beforehand (blobs.py); with that as so many positions' worth of
knowledge, the residuals of a dozen positions say it better (a scaled inverse chi-square prior;
Gelman et al. 2013, Bayesian data analysis, sec. 2.6).
Grain moves the centroid alike in all pictures, in a direction that rotates with the object: a share
u of contrast moves an edge by 4 u px where weights rise twice as fast as shares (blobs.py) over a
rim of 2 px, and two opposite edges, of which each moves the centroid by half of that, by 2.8 u. In
the picture that turns with the angle once, or twice where an outline has two ends: four amplitudes,
sine and cosine of both, which share the variance.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from calibration.drop.bounce import Bounces
from calibration.statistics.correlated import propagated
from calibration.statistics.uncertainty import Estimate, student
from calibration.tracking.orientation import orientation
from calibration.tracking.track import Array, Rows, Track
from granulab.errors import InputError

# Of 40 rendered drops (calibration.rendered.low_drop): half of the variance is alike at positions
# next to one another, and no longer so at some pixels' distance; and what the picture says of it
# scatters from clip to clip as an estimate of so many degrees of freedom does.
_ALIKE, _LENGTH = 0.5, 12.0  # share; px
_WORTH = 3  # positions
_RIM = 2.8 / 2  # px: each amplitude of what grain of contrast 1 moves a centroid by, see the text
_STRAYS = 0.2  # rad: a silhouette that strays so far from an even rotation is no rigid outline
_OUTLIER = 4.0  # sigma
_FEWEST = 3  # positions of a flight
_SIZES = 4.0  # diameters
_HELD = 3  # positions at rest that show where the object was held
_STILL = 4.0  # sigma within which they lie
_MISSED = 2  # positions that a contact alone does not spoil
_NO_NOISE = 10.0  # sigma, of a position as the picture says
_REFUTED = 4.0  # sigma by which a fall did not begin at rest


class Rotation(NamedTuple):
    """Angle that an object rotates through in one frame, before and after the contact [rad]."""

    before: Estimate
    after: Estimate


@dataclass(frozen=True)
class FirstBounce:
    """A drop and its first rebound.

    fall, rise    H0 and H1 of the centroid [y]
    fall_time, rise_time   of these [frames]
    acceleration  of both flights [y/frame^2]
    restitution   sqrt(H1/H0)
    held          True if it was seen at rest before, and fell from there
    positions     of the rebound that were used
    rotation      None where the silhouette is round, or only positions are known
    """

    fall: Estimate
    rise: Estimate
    fall_time: Estimate
    rise_time: Estimate
    acceleration: Estimate
    restitution: Estimate
    held: bool
    positions: int
    rotation: Rotation | None


def may_overlap(found: Bounces) -> bool:
    """True if an object in a film falls by less than four diameters, and is not seen at rest.

    It leaves its own picture behind then, in which it is not seen, for half of its fall.
    """
    radius = found.track.radius
    if radius is None:
        return False
    first = first_bounce(found)
    return not first.held and first.fall.value < _SIZES * 2 * float(np.median(radius))


def with_first(found: Bounces) -> tuple[Bounces, FirstBounce]:
    """The first contact; and the bounces with it as their result where the object is not round.

    A block meets the plate with another corner each time: its bounces are no repeats of one
    another, and only the first follows a fall from rest (eq. 3.5).
    """
    first = first_bounce(found)
    if first.rotation is not None or len(found.contacts) == 1:
        _refuse_hidden_contact(found)
    if first.rotation is None:
        return _with_disagreement(found, first), first
    value, sigma = first.acceleration.value, first.acceleration.sigma or 0.0
    said = list(found.track.remarks)
    if len(found.contacts) > 1:
        said.append(
            "the object is not round: each contact is another corner's; the first alone counts"
        )
    return replace(
        found, flights=replace(found.flights, acceleration=(value, sigma)), method="first contact",
        best=np.array([first.restitution.value]),
        covariance=np.array([[(first.restitution.sigma or 0.0) ** 2]]), slow=None,
        disagreement=np.zeros(1), pooled=first.restitution, p=None, exponent=None, warnings=said,
    ), first  # fmt: skip


def _refuse_hidden_contact(found: Bounces) -> None:
    """InputError where the positions next to the first contact are of neither flight.

    They are off by more than the way that gravity adds in a frame, which light and grain do not do.
    """
    rows, base, flights = found.flights.rows[1][:_MISSED], found.base, found.flights
    off = np.abs(flights.residuals[rows])
    bad = flights.weights[rows] == 0
    if found.track.covariance is not None:
        noise = np.sqrt(found.track.covariance[base.rows[rows], 1, 1])
        bad |= off > _NO_NOISE * noise
    if np.all(bad & (off > abs(flights.acceleration[0]))):
        frame = found.track.frame[base.rows[rows[0]]]
        raise InputError(
            f"the positions from frame {frame:.0f} on, just after the first contact, are on no "
            "parabola with those that follow: it touches the plate again before a flight is seen; "
            "film at a higher rate, or drop from higher"
        )


def _with_disagreement(found: Bounces, first: FirstBounce) -> Bounces:
    """The bounces; what the first contact after a fall from rest gives less them is in their sigma.

    Only beyond four sigma, as where two ways of measuring a bounce disagree: an object that is
    nearly round, and is not seen to rotate, still has another restitution at each contact.
    """
    pooled = found.pooled
    off = first.restitution.value + _lost_to_drag(found) - pooled.value
    sigma = np.hypot(first.restitution.sigma or 0.0, pooled.sigma or 0.0)
    if not first.held or not abs(off) > _REFUTED * sigma:
        return found
    said = (
        f"the first contact has {first.restitution.value:.4f}, all of them {pooled.value:.4f}: the "
        "difference is in the sigma"
    )
    return replace(
        found, pooled=replace(pooled, sigma=float(np.hypot(pooled.sigma or 0.0, off))),
        warnings=[*found.warnings, said],
    )  # fmt: skip


def _lost_to_drag(found: Bounces) -> float:
    """Share of the first contact's restitution that drag takes: as much from heights as times."""
    if found.slow is None:
        return 0.0
    e = found.pooled.value
    return float(found.slow.value * e * found.speeds[0, 0] ** 2 * (1 + e**2) / 4)


class _Seen(NamedTuple):
    """Positions of both flights, and of the object at rest where it was held."""

    time: Array  # (n,) [frames]
    y: Array
    after: Array  # (n,) 1 after the contact, else 0
    angle: Array | None  # (n,) [rad]
    sigma: float | None  # of a position, as the picture says
    grain: float  # contrast of the object's grain
    rest: tuple[float, float] | None  # position and angle at rest


def first_bounce(found: Bounces) -> FirstBounce:
    """H0, H1 and restitution of the first contact that was found, the fall before it from rest."""
    angles = _angles(found.track.chosen(found.base.rows))
    rotation = None if angles is None else _rotation(found, angles)
    seen = _seen(found, None if rotation is None else angles)
    start = _start(found, seen)
    fit, held = _fitted(seen, start), seen.rest is not None
    if held and _thrown(seen, start):
        fit, held = _fitted(seen._replace(rest=None), start), False
    value, covariance = propagated(fit.parameters, fit.covariance, _quantities)
    sigma = np.sqrt(np.diag(covariance))
    fall, rise, fall_time, rise_time, acceleration, restitution = (
        Estimate(float(v), float(s), 1) for v, s in zip(value, sigma, strict=True)
    )
    return FirstBounce(
        fall, rise, fall_time, rise_time, acceleration, restitution, held,
        int(seen.after.sum()), rotation,
    )  # fmt: skip


def _seen(found: Bounces, angles: Array | None) -> _Seen:
    """The positions of the fall and of the rebound; angles (n,) are those of the clock."""
    flights, base = found.flights, found.base
    track = found.track.chosen(base.rows)
    rows = [one[flights.weights[one] > 0] for one in flights.rows[:2]]
    if min(map(len, rows)) < _FEWEST:
        rows = flights.rows[:2]
    every = np.concatenate(rows)
    sigma = None
    if track.covariance is not None:
        sigma = float(np.sqrt(np.median(track.covariance[every, 1, 1])))
    rest = _rest(track, base.clock, rows[0], angles)
    after = np.repeat([0.0, 1.0], [len(one) for one in rows])
    return _Seen(
        base.clock[every], track.y[every], after, None if angles is None else angles[every],
        sigma, 0.0 if track.look is None else track.look.grain, rest,
    )  # fmt: skip


def _angles(track: Track) -> Array | None:
    """(n,) angle at each position [rad]; None where it is not seen."""
    try:
        found = orientation(track)
    except InputError:
        return None
    known = np.isfinite(found.angle)
    return np.interp(track.frame, track.frame[known], found.angle[known])


def _rest(
    track: Track, clock: Array, fall: Rows, angles: Array | None
) -> tuple[float, float] | None:
    """Position and angle of an object that lies still until it falls; None where it does not.

    It moves by a sigma within a frame or two of its release, and not before.
    """
    y = track.y[: fall[0]]
    if track.covariance is None or len(y) < _HELD:
        return None
    sigma = float(np.sqrt(np.median(track.covariance[: fall[0], 1, 1])))
    level = float(np.median(y))
    still = np.abs(y - level) < _STILL * sigma
    if still.sum() < max(_HELD, len(y) / 2):
        return None
    at = 0.0 if angles is None else float(np.median(angles[: fall[0]][still]))
    return float(np.mean(y[still])), at


def _start(found: Bounces, seen: _Seen) -> Array:
    """(5,) time and position of the fall's apex, acceleration, time and speed at the contact."""
    flights = found.flights
    (c0, c1, c2), (_, d1, d2) = flights.coefficients[:2]
    release = flights.centre[0] - c1 / c2
    contact = found.contacts[0, 0]
    after = d1 + d2 * (contact - flights.centre[1])
    return np.array([release, c0 - c1**2 / (2 * c2), c2, contact, after])


def _path(p: Array, time: Array, after: Array) -> Array:
    """(n,) position: y0 + a (t - t0)^2/2 until the contact at tc, from there with speed v."""
    t0, y0, a, tc, v = p[:5]
    fall = y0 + a * (time - t0) ** 2 / 2
    s = time - tc
    rebound = y0 + a * (tc - t0) ** 2 / 2 + v * s + a * s**2 / 2
    return np.where(after > 0, rebound, fall)


def _quantities(p: Array) -> Array:
    """H0 and H1, their times, acceleration, sqrt(H1/H0): as in FirstBounce."""
    t0, _, a, tc, v = p[:5]
    fall, rise = tc - t0, abs(v / a)
    return np.array([abs(a) * fall**2 / 2, abs(a) * rise**2 / 2, fall, rise, a, rise / fall])


class _Fit(NamedTuple):
    parameters: Array
    covariance: Array
    freedom: float


def _fitted(seen: _Seen, start: Array) -> _Fit:
    """Least squares with correlated noise; bad positions are left out once."""
    fit = _least_squares(seen, start, np.ones(len(seen.time), dtype=bool))
    off = np.abs(fit[1]) > _OUTLIER
    left = np.bincount(seen.after[~off].astype(int), minlength=2)
    if off.any() and left.min() >= _FEWEST:
        fit = _least_squares(seen, start, ~off)
    parameters, _, covariance, freedom = fit
    return _Fit(parameters, covariance, freedom)


def _least_squares(
    seen: _Seen, start: Array, kept: np.ndarray
) -> tuple[Array, Array, Array, float]:
    """Parameters, residuals in sigma, covariance, degrees of freedom."""
    from scipy.linalg import cholesky, solve_triangular
    from scipy.optimize import least_squares

    time, y, after = seen.time[kept], seen.y[kept], seen.after[kept]
    rotates = seen.angle is not None
    angle = np.zeros(len(y)) if seen.angle is None else seen.angle[kept]
    if seen.rest is not None:
        y, angle = np.append(y, seen.rest[0]), np.append(angle, seen.rest[1])
    apart = np.abs(y[:, None] - y[None])
    noise = (1 - _ALIKE) * np.eye(len(y)) + _ALIKE * np.exp(-apart / _LENGTH)
    if seen.rest is not None:
        noise[-1, -1] = _ALIKE + 1e-3  # many pictures of one place: what is alike in all is left
    root = cholesky(noise, lower=True)
    bias = _RIM * seen.grain if rotates else 0.0
    scale = seen.sigma or float(np.std(y)) * 1e-3

    def residual(p: Array) -> Array:
        at = _path(p, time, after)
        if seen.rest is not None:
            at = np.append(at, p[1])
        if bias:
            turns = np.outer([1, 2], angle)  # an outline of two ends looks alike twice a turn
            at = at + bias * np.concatenate([np.sin(turns), np.cos(turns)]).T @ p[5:]
        white = solve_triangular(root, y - at, lower=True) / scale
        return np.append(white, p[5:])

    first = np.append(start, np.zeros(4)) if bias else start
    steps = np.maximum(np.abs(first), 1e-3)
    found = least_squares(residual, first, x_scale=steps, method="lm")
    square = float(np.sum(found.fun**2))  # amplitudes that are known beforehand are data too
    freedom = len(y) - 5 + (_WORTH if seen.sigma else 0)
    factor = (square + (_WORTH if seen.sigma else 0)) / freedom
    covariance = np.linalg.pinv(found.jac.T @ found.jac) * factor * student(freedom) ** 2
    left = (root @ found.fun[: len(y)])[: int(kept.sum())] / np.sqrt(factor)
    every = np.zeros(len(kept))
    every[kept] = left
    return found.x, every, covariance, freedom


def _thrown(seen: _Seen, start: Array) -> bool:
    """True if the fall's apex lies elsewhere than the object did, by more than noise."""
    assert seen.rest is not None
    alone = _fitted(seen._replace(rest=None), start)
    off = seen.rest[0] - alone.parameters[1]
    sigma = np.hypot(np.sqrt(alone.covariance[1, 1]), seen.sigma or 0.0)
    return bool(abs(off) > _REFUTED * sigma)


def _rotation(found: Bounces, angles: Array) -> Rotation | None:
    """Mean rates over the fall and over the rebound; None where the angle is no free rotation's."""
    rates = []
    for rows in found.flights.rows[:2]:
        t, angle = found.base.clock[rows], angles[rows]
        slope, covariance = np.polyfit(t - t.mean(), angle, 1, cov="unscaled")
        left = angle - np.polyval(slope, t - t.mean())
        if np.std(left) > _STRAYS:
            return None
        spread = np.sqrt(float(left @ left) / max(len(t) - 2, 1) * covariance[0, 0])
        rates.append(Estimate(float(slope[0]), float(spread), len(rows)))
    return Rotation(*rates)
