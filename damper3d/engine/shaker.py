"""The enclosure's motion along its direction: sines, so far; what the step loop asks at a time t.

    u(t) = r(t) sum_k A_k sin(omega_k t + phi_k),    r(t) = sin^2(pi t / (2 T)) until T, then 1

One sine with A = Gamma g / omega^2, phi = 0 and T = 0 is the thesis's motion (eq. 6.2). Without a
ramp (T = 0) it begins with the velocity Gamma g / omega, at once.
"""

import math
from typing import NamedTuple

import numpy as np

from granulab.contact.jit import njit


class Sines(NamedTuple):
    """A sum of sines that may grow from nothing; another motion is another tuple of its kind."""

    amplitude: np.ndarray  # (n,) [m]
    omega: np.ndarray  # (n,) [rad/s]
    phase: np.ndarray  # (n,) [rad]
    ramp_time: float  # T, over which the amplitude grows [s]; 0: it is there at once


def sine(gamma: float, frequency: float, gravity: float, ramp_cycles: float = 0.0) -> Sines:
    """One sine whose largest acceleration is gamma times gravity [m/s2], at a frequency [Hz]."""
    omega = 2.0 * math.pi * frequency
    amplitude = gamma * gravity / omega**2
    return Sines(
        np.array([amplitude]), np.array([omega]), np.zeros(1), float(ramp_cycles / frequency)
    )


@njit
def ramp(shaker, t):
    """r(t) [-] and its rate [1/s]."""
    if t >= shaker.ramp_time:
        return 1.0, 0.0
    rate = np.pi / shaker.ramp_time
    return 0.5 - 0.5 * np.cos(rate * t), 0.5 * rate * np.sin(rate * t)


@njit
def displacement(shaker, t):
    """u [m] at the time t >= 0 [s]."""
    total = 0.0
    for k in range(len(shaker.amplitude)):
        total += shaker.amplitude[k] * np.sin(shaker.omega[k] * t + shaker.phase[k])
    return ramp(shaker, t)[0] * total


@njit
def velocity(shaker, t):
    """du/dt [m/s] at the time t >= 0 [s]; the exact derivative of the displacement."""
    grown, growth = ramp(shaker, t)
    total = 0.0
    for k in range(len(shaker.amplitude)):
        angle = shaker.omega[k] * t + shaker.phase[k]
        total += shaker.amplitude[k] * (
            grown * shaker.omega[k] * np.cos(angle) + growth * np.sin(angle)
        )
    return total
