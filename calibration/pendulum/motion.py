"""The motion of an object on a string, without collisions: a damped pendulum in its arc length.

    q'' = -omega^2 sin(kappa q)/kappa - 2 beta q'

q [px] along the arc from where it hangs at rest, kappa = 1/length of the string [1/px]; kappa = 0
is the isochronous swing. The damping is linear in the speed, as of a slow object in air.
"""

from typing import NamedTuple

import numpy as np

from calibration.tracking.track import Array

_STEPS = 64  # of a quarter to half a period: the error of RK4 is below 1e-6 of the amplitude


class Law(NamedTuple):
    """omega [1/frame], beta [1/frame], kappa [1/px]."""

    omega: float
    beta: float
    kappa: float


def across(law: Law, q: Array) -> Array:
    """sin(kappa q)/kappa: the horizontal distance from the position of rest [px]."""
    return q if law.kappa == 0 else np.asarray(np.sin(law.kappa * q) / law.kappa)


def acceleration(law: Law, q: Array, v: Array) -> Array:
    """q'' [px/frame^2]."""
    return np.asarray(-(law.omega**2) * across(law, q) - 2 * law.beta * v)


def swung(law: Law, q: Array, v: Array, s: Array) -> tuple[Array, Array]:
    """Position and speed a time s [frames] after (q, v), each element by itself (Runge-Kutta)."""
    h = s / _STEPS
    for _ in range(_STEPS):
        k1, a1 = v, acceleration(law, q, v)
        k2, a2 = v + h / 2 * a1, acceleration(law, q + h / 2 * k1, v + h / 2 * a1)
        k3, a3 = v + h / 2 * a2, acceleration(law, q + h / 2 * k2, v + h / 2 * a2)
        k4, a4 = v + h * a3, acceleration(law, q + h * k3, v + h * a3)
        q = q + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return q, v


def amplitude(law: Law, q: Array, v: Array) -> Array:
    """Arc length from rest to the turning point of the undamped swing through (q, v) [px]."""
    if law.kappa == 0:
        return np.asarray(np.hypot(q, v / law.omega))
    half = np.sin(law.kappa * q / 2) ** 2 + (law.kappa * v / (2 * law.omega)) ** 2
    return np.asarray(2 * np.arcsin(np.sqrt(np.minimum(half, 1.0))) / law.kappa)


def root_of_height(law: Law, arc: Array) -> Array:
    """sqrt(2 H/kappa) [px], H = (1 - cos theta)/kappa the height; the arc itself for kappa = 0.

    Times omega it is the speed at the lowest point.
    """
    return np.asarray(arc * np.sinc(law.kappa * arc / (2 * np.pi)))
