"""What neighbouring parabolas say of the contact between them: when, where, and how it rebounds.

Parabola k is c0 + c1 s + c2 s^2/2 with s = t - centre[k]; centre is (m,), coefficients c (m, 3).
All functions give one value per contact, so m - 1, but for those between two whole flights.
"""

import numpy as np

from calibration.tracking.track import Array


def contact_times(centre: Array, coefficients: Array) -> Array:
    """(m - 1,) where neighbouring parabolas meet; NaN where they do not.

    For a common acceleration they meet once; else Newton's steps from halfway between the
    flights' centres end at the root there.
    """
    times = np.full(len(centre) - 1, np.nan)
    for k in range(len(times)):
        s = (centre[k] + centre[k + 1]) / 2
        for _ in range(50):
            gap, turn = _difference(centre, coefficients, k, s)
            step = -gap / turn if turn else np.nan
            s += step
            if not abs(step) > 1e-12 * max(1.0, abs(s)):
                break
        times[k] = s
    return times


def _difference(centre: Array, coefficients: Array, k: int, t: float) -> tuple[float, float]:
    """Flight k + 1 less flight k at time t: in place and in speed."""
    place, speed = [], []
    for i in (k, k + 1):
        s = t - centre[i]
        c = coefficients[i]
        place.append(c[0] + c[1] * s + c[2] * s**2 / 2)
        speed.append(c[1] + c[2] * s)
    return place[1] - place[0], speed[1] - speed[0]


def levels(centre: Array, c: Array) -> Array:
    """Place of each contact: the plate's level."""
    s = contact_times(centre, c) - centre[:-1]
    return c[:-1, 0] + c[:-1, 1] * s + c[:-1, 2] * s**2 / 2


def speeds(centre: Array, c: Array) -> tuple[Array, Array]:
    """Velocity before and after each contact."""
    times = contact_times(centre, c)
    before = c[:-1, 1] + c[:-1, 2] * (times - centre[:-1])
    return before, c[1:, 1] + c[1:, 2] * (times - centre[1:])


def from_velocities(centre: Array, c: Array) -> Array:
    """Restitution: speed after over speed before."""
    before, after = speeds(centre, c)
    return -after / before


def inner_velocities(centre: Array, c: Array) -> Array:
    """Of the contacts between two whole flights."""
    return from_velocities(centre, c)[1:-1]


def from_times(centre: Array, c: Array) -> Array:
    """Restitution T(k+1)/T(k) of the contacts between two whole flights, (m - 3,)."""
    flight = np.diff(contact_times(centre, c))
    return flight[1:] / flight[:-1]


def from_heights(centre: Array, c: Array) -> Array:
    """Eq. 3.5, over the plate's level as all contacts give it: their mean, and their line."""
    times, level = contact_times(centre, c), levels(centre, c)
    if len(times) > 2:  # the plate may drift in the picture
        plate = np.polyval(np.polyfit(times, level, 1), times)
    else:
        plate = np.full(len(times), level.mean())
    apex = c[:, 0] - c[:, 1] ** 2 / (2 * c[:, 2])
    ratio = (plate - apex[1:]) / (plate - apex[:-1])
    return np.sqrt(np.where(ratio > 0, ratio, np.nan))
