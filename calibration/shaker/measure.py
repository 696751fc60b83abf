"""Power that a shaken bed dissipates, from force and acceleration (thesis, eqs 7.6 to 7.12).

    P = sum_k Re(F_k V_k*)/2,     V_k = A_k/(j omega_k)      (eqs 7.9 to 7.11, one-sided, k >= 1)
    E = 2 pi P/omega,             efficiency = E/(4 V_1^2 M)  (eqs 7.7, 7.8, 6.10)

The sums run over tones: each excited frequency and its harmonics. Force is that of the shaker on
the enclosure, so that an empty one of mass m has F = m A; where the transducer points the other
way (phase pi, as in the thesis) its sign is reversed. What is left of the phase between F and A of
the empty enclosure is the error of the measuring chain, phi(frequency, amplitude): it is taken off
the phase of F (eq. 7.12). Sigma comes from the scatter of P over blocks of the record, with the
cycles' own irregularity in it, and from that of phi. Where nobody measured phi, every one up to a
limit is as likely as any other.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibration.shaker.phases import GRAVITY, bed_phase
from calibration.shaker.record import Record, of_mean
from calibration.shaker.result import Dissipation, PhaseError, Power, Tone
from calibration.statistics.uncertainty import student
from granulab.campaign.output.statistics import quantile
from granulab.errors import InputError

_SAME = 0.01  # of a frequency: how far that of the empty enclosure may be from it
_COUNTS = 1e-3  # of the power: a tone that could carry more is missed
_KNOWN_PHASE = 0.1  # [rad] sigma above which the empty enclosure's tone is lost in noise
# [rad] at most, of a chain that nobody measured: transducers and amplifiers are sold with that, and
# the thesis calls its own, which Fig. 7.9 draws, "very small".
PHASE_ERROR = math.radians(1.0)
_OF_LIMIT = 0.6827  # of an even distribution's half width: holds 68.27 % of it


def dissipation(
    loaded: Record, empty: Sequence[Record] = (), particle_mass: float | None = None,
    phase_error: float = PHASE_ERROR, gravity: float = GRAVITY,
) -> Dissipation:  # fmt: skip
    """Power, energy per cycle, efficiency and phase of a bed, from records with and without it.

    empty: of the enclosure without particles at the same frequencies, at one amplitude or several
    (the phase error is interpolated). particle_mass [kg]. phase_error [rad] is the largest there
    may be at the first tone where no empty record has it; at others it grows as a delay's does.
    gravity [m/s2] along the motion, 0 across it. Raises InputError for a mass that is not above 0
    and a phase error that is not from 0 to 1.
    """
    if particle_mass is not None and not 0.0 < particle_mass < np.inf:
        raise InputError(f"--particle-mass = {particle_mass:g} kg: expected more than 0")
    if not 0.0 <= phase_error < 1.0:  # NaN, too; beyond it the sine is no angle any more
        raise InputError(f"--phase-error = {phase_error:g} rad: expected 0 to 1 rad")
    warnings = list(loaded.remarks)
    tones: list[Tone] = []
    totals = np.zeros(len(loaded.force))
    for k, frequency in enumerate(loaded.frequencies):
        known = _phase_error(loaded, k, empty, warnings)
        error = known or _unknown(tones, frequency, phase_error)
        velocity = loaded.acceleration[:, k] / (2j * np.pi * frequency)
        flow = 0.5 * loaded.sense * loaded.force[:, k] * np.exp(-1j * error.value) * velocity.conj()
        totals += flow.real
        tones.append(_with_efficiency(_tone(loaded, k, error, flow),
                                      particle_mass if loaded.shaken[k] else None))  # fmt: skip
    power = _total(totals, tones)
    warnings += _warnings(loaded, tones, power)
    return _with_cycle(loaded, tones, power, empty, particle_mass, gravity, warnings)


def _unknown(tones: Sequence[Tone], frequency: float, most: float) -> PhaseError:
    """The phase error of a tone that nobody measured: none, and how far off that may be.

    As far as the first tone's delay, where that was measured.
    """
    if tones and tones[0].phase_error_limit is None:
        delay = abs(tones[0].phase_error_rad / tones[0].frequency_hz)
        return PhaseError(0.0, delay * frequency)
    most *= frequency / tones[0].frequency_hz if tones else 1.0
    return PhaseError(0.0, _OF_LIMIT * most, most)


def _total(totals: NDArray[np.float64], tones: Sequence[Tone]) -> Power:
    """The power of all tones from that of each block (b,); its sigma with those of the phases.

    Phase errors that were measured are independent; those of one unknown delay go one way.
    """
    measured = [
        tone.reactive_power_w * tone.phase_error_sigma
        for tone in tones
        if tone.phase_error_limit is None
    ]
    off = sum(abs(tone.reactive_power_w) * (tone.phase_error_limit or 0.0) for tone in tones)
    scatter = math.hypot(of_mean(totals), *measured)
    freedom = len(totals) - 1
    wide = quantile(freedom) / student(freedom)  # of a 95 % interval over one of 68.3 %
    value, half = float(totals.mean()), float(off + wide * scatter)
    sigma = math.hypot(scatter, _OF_LIMIT * off)
    return Power(value, sigma, len(totals), interval=(value - half, value + half))


def _warnings(loaded: Record, tones: Sequence[Tone], power: Power) -> list[str]:
    """Warnings about the power."""
    words, most = [], tones[0].phase_error_limit
    sigma = power.sigma or 0.0
    if most is not None:
        each = 1e-3 * float(np.linalg.norm([tone.reactive_power_w for tone in tones]))
        words.append(
            "no record of the empty enclosure at this frequency: the phase error stays in, taken "
            f"to be {math.degrees(most):.3g} deg at most; each mrad is {each:.2g} W"
        )
    elif power.value < -2.0 * sigma:
        words.append("the power is below zero: is the phase error that of this very set-up?")
    least = sigma if most is None else _COUNTS * abs(power.value)
    if loaded.left_out is not None and loaded.left_out[1] > least:
        frequency, most = loaded.left_out
        words.append(
            f"a tone of {frequency:.4g} Hz is not in the sum, and could carry {most:.2g} W: give "
            f"it, too, as --frequency {frequency:.4g}"
        )
    return words


def _tone(loaded: Record, k: int, error: PhaseError, flow: NDArray[np.complex128]) -> Tone:
    """A tone from the complex power (b,) of its blocks."""
    mean = flow.mean()
    return Tone(
        float(loaded.frequencies[k]),
        float(np.abs(loaded.force[:, k]).mean()),
        float(np.abs(loaded.acceleration[:, k]).mean()),
        error.value,
        error.sigma,
        error.limit,
        float(mean.real),
        float(mean.imag),
        math.hypot(of_mean(flow.real), mean.imag * error.sigma),
    )


def _with_efficiency(tone: Tone, particle_mass: float | None) -> Tone:
    """A tone with its share of what could be taken at its speed; eqs 7.8 and 6.10."""
    if particle_mass is None:
        return tone
    speed = tone.acceleration_m_s2 / (2.0 * np.pi * tone.frequency_hz)
    most = 4.0 * speed**2 * particle_mass * tone.frequency_hz  # [W]
    return replace(tone, efficiency=tone.power_w / most, efficiency_sigma=tone.sigma_w / most)


def _with_cycle(
    loaded: Record,
    tones: Sequence[Tone],
    power: Power,
    empty: Sequence[Record],
    particle_mass: float | None,
    gravity: float,
    warnings: Sequence[str],
) -> Dissipation:
    """Energy per cycle and efficiency from the power: eqs 7.7, 7.8, 6.10; the motional phase."""
    first = tones[0]
    speed = first.acceleration_m_s2 / (2.0 * np.pi * first.frequency_hz)

    per_cycle = 1.0 / first.frequency_hz
    orders = loaded.frequencies / first.frequency_hz
    alone = np.allclose(orders, np.round(orders), rtol=1e-6)
    most = 4.0 * speed**2 * particle_mass if particle_mass is not None and alone else None
    own = [float(abs(record.mass.mean())) for record in empty]
    enclosure = float(np.mean(own)) if own else None
    phase = None
    if enclosure is not None and particle_mass is not None and alone:
        phase = bed_phase(loaded, enclosure, particle_mass, first.phase_error_rad, gravity)
    return Dissipation(
        first.frequency_hz,
        first.acceleration_m_s2 / GRAVITY,
        power,
        power.times(per_cycle),
        None if most is None else power.times(per_cycle / most),
        enclosure,
        phase,
        tuple(tones),
        tuple(warnings),
        loaded,
    )


def _phase_error(
    loaded: Record, k: int, empty: Sequence[Record], warnings: list[str]
) -> PhaseError | None:
    """Phase error of a tone at the loaded record's amplitude; None where no empty one has it."""
    frequency, amplitude = loaded.frequencies[k], float(np.abs(loaded.acceleration[:, k]).mean())
    known = []
    for record in empty:
        near = int(np.argmin(np.abs(record.frequencies - frequency)))
        if abs(record.frequencies[near] - frequency) > _SAME * frequency:
            continue
        moved = record.acceleration[:, near]
        if not moved.any():  # a harmonic that is not there, not even as noise, has no phase
            continue
        turned = record.sense * record.force[:, near] * moved.conj()
        sigma = of_mean(np.angle(turned * turned.mean().conj()))
        if sigma < _KNOWN_PHASE:
            known.append((float(np.abs(moved).mean()), float(np.angle(turned.mean())), sigma))
    if not known:
        if k > 0 and empty and loaded.shaken[k]:
            warnings.append(
                f"{frequency:g} Hz: no record of the empty enclosure; its phase error stays in"
            )
        return None
    sizes, errors, sigmas = np.array(sorted(known)).T
    if not sizes[0] * 0.95 <= amplitude <= sizes[-1] * 1.05:
        warnings.append(
            f"{frequency:g} Hz: {amplitude:.3g} m/s2 lies outside the empty enclosure's "
            f"{sizes[0]:.3g} to {sizes[-1]:.3g}: the nearest phase error was taken off"
        )
    error, sigma = (float(np.interp(amplitude, sizes, y)) for y in (errors, sigmas))
    return PhaseError(error, sigma)
