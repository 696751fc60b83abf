"""A motion given at even times, and cubic polynomials between them.

    u(t) = h00(s) x_k + h10(s) h v_k + h01(s) x_{k+1} + h11(s) h v_{k+1},    s = t/h - k

with Hermite's h00 = (1 + 2 s)(1 - s)^2, h10 = s (1 - s)^2, h01 = s^2 (3 - 2 s), h11 = s^2 (s - 1).
The velocity is the exact derivative of that. A sine with n points a cycle is met to
(2 pi/n)^4/384 of its amplitude. After the last point the motion goes on at the last velocity.
"""

from typing import NamedTuple

import numpy as np

from granulab.contact.jit import njit


class Table(NamedTuple):
    """A motion at even times from 0 on."""

    place: np.ndarray  # (n,) x [m], n >= 2
    rate: np.ndarray  # (n,) v [m/s]
    spacing: float  # h [s]


@njit
def displacement(motion, t):
    """Return u [m] at the time t >= 0 [s]."""
    h, last = motion.spacing, len(motion.place) - 1
    k = int(t / h)
    if k >= last:
        return motion.place[last] + motion.rate[last] * (t - last * h)
    s = t / h - k
    rest = 1.0 - s
    before = rest * rest * ((1.0 + 2.0 * s) * motion.place[k] + s * h * motion.rate[k])
    after = (3.0 - 2.0 * s) * motion.place[k + 1] - rest * h * motion.rate[k + 1]
    return before + s * s * after


@njit
def velocity(motion, t):
    """Return du/dt [m/s] at the time t >= 0 [s]; the exact derivative of the displacement."""
    h, last = motion.spacing, len(motion.place) - 1
    k = int(t / h)
    if k >= last:
        return motion.rate[last]
    s = t / h - k
    rest = 1.0 - s
    across = 6.0 * s * rest * (motion.place[k + 1] - motion.place[k]) / h
    before = rest * (1.0 - 3.0 * s) * motion.rate[k]
    return across + before + s * (3.0 * s - 2.0) * motion.rate[k + 1]
