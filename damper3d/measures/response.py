"""Design numbers of a damper: loss factor, equivalent damper, effective mass, forces.

Functions of samples as records.cut gives them. Signs: the enclosure moves with x = X e^(j omega t),
its acceleration is a, and the bed pushes it with F = -M_eff a. A mass M that rides along has
M_eff = M; a bed that dissipates has an imaginary part below zero,

    M_eff = in phase - j out of phase,      out of phase = E/(pi V^2) >= 0,

with E the energy that the enclosure gives the bed in a cycle and V its peak speed: the fundamental
alone does work on a sine. It is what a force transducer and an accelerometer measure (thesis,
eqs 7.8-7.12), the enclosure's own mass taken off.
"""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.engine.records import Samples
from damper3d.measures.counted import Cycles, read_cycles
from damper3d.measures.efficiency import efficiencies, lost, reference_energy, settling
from granulab.campaign.output.figure import BLUE, GREY, headline
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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


def effective_mass(
    samples: Samples, direction: np.ndarray, omega: float, time_step: float = 0.0
) -> complex:
    """M_eff [kg] at omega [rad/s], F = -M_eff a, by Fourier projection over whole cycles.

    direction (3,) is that of the motion. A force is the mean of those at the beginnings of the n
    time steps [s] of its sample: half a step before the sample's middle, and of a sine's amplitude
    sin(n a)/(n sin a), a = omega time_step/2. Both are put back, exactly; without the first, a
    rigid mass M would show the loss a M. time_step 0: means over all of the sample.
    """
    end = samples["time"][1:]
    step = end[-1] - end[-2]
    middle = end - 0.5 * (step + time_step)
    half_angle, of_step = 0.5 * omega * step, 0.5 * omega * time_step
    smoothed = math.sin(half_angle) / half_angle
    if of_step:
        smoothed *= of_step / math.sin(of_step)
    force = _project(along(samples, direction)[1:], middle, omega) / smoothed
    acceleration = -(omega**2) * _project(samples["displacement"][1:], end, omega)
    return complex(-force / acceleration)


def _project(signal: np.ndarray, time: np.ndarray, omega: float) -> complex:
    """Complex amplitude of a signal at omega, over whole cycles."""
    return complex(2.0 * np.mean(signal * np.exp(-1j * omega * time)))


def along(samples: Samples, direction: np.ndarray) -> np.ndarray:
    """Force of the bed on the enclosure along a direction, all walls (n,) [N]."""
    return samples["wall_force"].sum(axis=1) @ direction


def peak_wall_force(
    samples: Samples, direction: np.ndarray, second: np.ndarray | None = None
) -> float:
    """Largest force [N], either way, on the enclosure along the motion; means over a sample.

    Of a motion of two directions in their plane; second: the other one, across the first.
    """
    force = np.abs(along(samples, direction)[1:])
    if second is not None:
        force = np.hypot(force, along(samples, second)[1:])
    return float(force.max())


def bed_height(samples: Samples, up: np.ndarray, lowest: float) -> float:
    """Height [m] of the bed's centre of mass over the enclosure's lowest point, mean in time.

    up (3,) is the unit vector against gravity, lowest the least of up . x in the enclosure [m].
    """
    return float((samples["mean_position"][1:] @ up).mean() - lowest)


def numbers(cycles: Cycles) -> dict[str, Any]:
    """Design numbers of the counted cycles, by the names of a run's Result."""
    case, counted = cycles.case, cycles.counted
    if case.excitation is not None or case.arc is not None:
        second = None if case.excitation is None else case.excitation.second
        return _without_a_frequency(counted, case.direction, second)
    omega, speed = 2.0 * math.pi / case.period, cycles.peak_speed
    reference = reference_energy(speed, case.mass)
    eta = efficiencies(counted, cycles.per_cycle, reference)
    energy = float(eta["efficiency"].mean()) * reference  # that a cycle dissipates [J]
    mass = effective_mass(counted, case.direction, omega, case.time_step)
    note = settling(float(eta["efficiency"].mean()), float(eta["wall_work"].mean()))
    settles = note is not None or case.is_decay
    return {
        "dissipated_power_w": dissipated_power(energy, case.period),
        "loss_factor": None if settles else loss_factor(energy, speed, case.mass),
        "equivalent_damping_n_s_per_m": (
            None if settles else equivalent_damping(energy, speed, omega)
        ),
        "effective_mass": {"in_phase_kg": mass.real, "out_of_phase_kg": -mass.imag},
        "peak_wall_force_n": peak_wall_force(counted, case.direction),
    }


def _without_a_frequency(
    counted: Samples, direction: np.ndarray, second: np.ndarray | None
) -> dict[str, Any]:
    """The same under an excitation that is no sine: what goes by one frequency is None."""
    length = float(counted["time"][-1] - counted["time"][0])
    return {
        "dissipated_power_w": float(lost(counted)[-1]) / length,
        "loss_factor": None,
        "equivalent_damping_n_s_per_m": None,
        "effective_mass": {"in_phase_kg": None, "out_of_phase_kg": None},
        "peak_wall_force_n": peak_wall_force(counted, direction, second),
    }


def measure(folder: Path) -> dict[str, Any]:
    """Design numbers of a run; FolderError as read_cycles."""
    return numbers(read_cycles(folder))


def draw(folder: Path) -> "Figure":
    """Force of the bed on the enclosure over its displacement, and that of the effective mass.

    The area of a loop is the energy that the enclosure gives the bed in a cycle.
    """
    from matplotlib.figure import Figure

    cycles = read_cycles(folder)
    case, counted = cycles.case, cycles.counted
    if case.excitation is not None:
        raise InputError(
            f"{folder}: its motion has no one frequency, by which an effective mass goes; "
            "damper3d observe RUN excitation draws it"
        )
    omega = 2.0 * math.pi / case.period
    mass = effective_mass(counted, case.direction, omega, case.time_step)
    figure = Figure(figsize=(6.4, 4.8), layout="constrained")
    headline(figure, f"{case.name}: effective mass {mass.real:.4g} kg in phase, "
             f"{-mass.imag:.4g} kg out of phase")  # fmt: skip
    axes = figure.subplots()
    # A force is a mean over the time since the sample before.
    middle = 0.5 * (counted["displacement"][1:] + counted["displacement"][:-1])
    axes.plot(1e3 * middle, along(counted, case.direction)[1:], color=GREY, lw=0.6, label="bed")
    phase = np.linspace(0.0, 2.0 * math.pi, 200)
    fundamental = mass * omega**2 * cycles.amplitude * np.exp(1j * phase)
    axes.plot(1e3 * cycles.amplitude * np.cos(phase), fundamental.real, color=BLUE,
              label="effective mass")  # fmt: skip
    axes.set(xlabel="displacement of the enclosure [mm]", ylabel="force of the bed on it [N]")
    axes.legend()
    return figure
