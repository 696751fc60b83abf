"""A sum of sines, which may grow from nothing: the motion of an enclosure along its direction.

    u(t) = r(t) sum_k A_k sin(omega_k t + phi_k),    r(t) = sin^2(pi t / (2 T)) until T, then 1

One sine with A = Gamma g / omega^2, phi = 0 and T = 0 is the thesis's motion (eq. 6.2). Without a
ramp (T = 0) it begins with the velocity Gamma g / omega, at once.
"""

import math
from typing import NamedTuple

import numpy as np

from granulab.contact.jit import njit


class Sines(NamedTuple):
    """A sum of sines that may grow from nothing."""

    amplitude: np.ndarray  # (n,) [m]
    omega: np.ndarray  # (n,) [rad/s]
    phase: np.ndarray  # (n,) [rad]
    ramp_time: float  # T, over which the amplitude grows [s]; 0: it is there at once


def sine(gamma: float, frequency: float, gravity: float, ramp: float = 0.0) -> Sines:
    """Return one sine whose largest acceleration is gamma times gravity [m/s2]; frequency in Hz."""
    omega = 2.0 * math.pi * frequency
    amplitude = gamma * gravity / omega**2
    return Sines(np.array([amplitude]), np.array([omega]), np.zeros(1), float(ramp / frequency))


def at_rest() -> Sines:
    """Return no motion at all."""
    return Sines(np.zeros(1), np.zeros(1), np.zeros(1), 0.0)


@njit
def ramp_at(motion, t):
    """Return r(t) [-] and its rate [1/s]."""
    if t >= motion.ramp_time:
        return 1.0, 0.0
    rate = np.pi / motion.ramp_time
    return 0.5 - 0.5 * np.cos(rate * t), 0.5 * rate * np.sin(rate * t)


@njit
def displacement(motion, t):
    """Return u [m] at the time t >= 0 [s]."""
    total = 0.0
    for k in range(len(motion.amplitude)):
        total += motion.amplitude[k] * np.sin(motion.omega[k] * t + motion.phase[k])
    return ramp_at(motion, t)[0] * total


@njit
def velocity(motion, t):
    """Return du/dt [m/s] at the time t >= 0 [s]; the exact derivative of the displacement."""
    grown, growth = ramp_at(motion, t)
    total = 0.0
    for k in range(len(motion.amplitude)):
        angle = motion.omega[k] * t + motion.phase[k]
        total += motion.amplitude[k] * (
            grown * motion.omega[k] * np.cos(angle) + growth * np.sin(angle)
        )
    return total
