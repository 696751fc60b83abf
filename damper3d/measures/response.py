"""What an engineer designs with: loss factor, equivalent damper, effective mass, forces.

Functions of samples as records.cut gives them. Signs: the enclosure moves with x = X e^(j omega t),
its acceleration is a, and the bed pushes it with F = -M_eff a. A mass M that rides along has
M_eff = M; a bed that dissipates has an imaginary part below zero,

    M_eff = in phase - j out of phase,      out of phase = E/(pi V^2) >= 0,

with E the energy that the enclosure gives the bed in a cycle and V its peak speed: the fundamental
alone does work on a sine. It is what a force transducer and an accelerometer measure (thesis,
eqs 7.8-7.12), the enclosure's own mass taken off.
"""

import math

import numpy as np

from damper3d.engine.records import Samples


def dissipated_power(energy: float, period: float) -> float:
    """Mean power [W] of an energy per cycle [J] (eq. 7.8)."""
    return energy / period


def loss_factor(energy: float, peak_speed: float, mass: float) -> float:
    """Loss factor of the bed, E/(2 pi E_max) [-] (eq. 2.5).

    E_max is M V^2/2, the most kinetic energy that the bed has if it rides along; with eq. 6.10 it
    is 4/pi times the efficiency. A structure of modal mass m_s with the damper where its mode has
    the speed V has the loss factor loss_factor M/(m_s + in-phase effective mass).
    """
    return energy / (2.0 * math.pi * 0.5 * mass * peak_speed**2)


def equivalent_damping(energy: float, peak_speed: float, omega: float) -> float:
    """Constant c [N s/m] of the viscous damper between enclosure and ground that takes as much.

    It takes E = pi c omega X^2 = pi c V^2/omega a cycle.
    """
    return energy * omega / (math.pi * peak_speed**2)


def effective_mass(samples: Samples, direction: np.ndarray, omega: float) -> complex:
    """M_eff [kg] at omega [rad/s], F = -M_eff a, by Fourier projection over whole cycles.

    direction (3,) is that of the motion. Forces are means over a sample, which takes sinc of half
    the sample's angle off their fundamental; that is put back.
    """
    end = samples["time"][1:]
    step = end[-1] - end[-2]
    middle = end - 0.5 * step
    half_angle = 0.5 * omega * step
    smoothed = math.sin(half_angle) / half_angle
    force = _project(along(samples, direction)[1:], middle, omega) / smoothed
    acceleration = -(omega**2) * _project(samples["displacement"][1:], end, omega)
    return complex(-force / acceleration)


def _project(signal: np.ndarray, time: np.ndarray, omega: float) -> complex:
    """Complex amplitude of a signal at omega, over whole cycles."""
    return complex(2.0 * np.mean(signal * np.exp(-1j * omega * time)))


def along(samples: Samples, direction: np.ndarray) -> np.ndarray:
    """Force of the bed on the enclosure along a direction, all walls (n,) [N]."""
    return samples["wall_force"].sum(axis=1) @ direction


def peak_wall_force(samples: Samples, direction: np.ndarray) -> float:
    """Largest force [N], either way, on the enclosure along the motion; means over a sample."""
    return float(np.abs(along(samples, direction)[1:]).max())


def bed_height(samples: Samples, up: np.ndarray, lowest: float) -> float:
    """Height [m] of the bed's centre of mass over the enclosure's lowest point, mean in time.

    up (3,) is the unit vector against gravity, lowest the least of up . x in the enclosure [m].
    """
    return float((samples["mean_position"][1:] @ up).mean() - lowest)
