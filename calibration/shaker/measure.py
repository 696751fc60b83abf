"""Power that a shaken bed dissipates, from force and acceleration (thesis, eqs 7.6 to 7.12).

    P = sum_k Re(F_k V_k*)/2,     V_k = A_k/(j omega_k)      (eqs 7.9 to 7.11, one-sided, k >= 1)
    E = 2 pi P/omega,             efficiency = E/(4 V_1^2 M)  (eqs 7.7, 7.8, 6.10)

The sums run over tones: each excited frequency and its harmonics. Force is that of the shaker on
the enclosure, so that an empty one of mass m has F = m A; where the transducer points the other
way (phase pi, as in the thesis) its sign is reversed. What is left of the phase between F and A of
the empty enclosure is the error of the measuring chain, phi(frequency, amplitude): it is taken off
the phase of F (eq. 7.12). Sigma comes from the scatter of P over blocks of the record, with the
cycles' own irregularity in it, and from that of phi.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibration.shaker.record import BLOCKS, Record
from calibration.shaker.result import Dissipation, Tone
from calibration.statistics.uncertainty import Estimate
from granulab.errors import InputError

GRAVITY = 9.81  # [m/s2]
_SAME = 0.01  # of a frequency: how far that of the empty enclosure may be from it
_COUNTS = 1e-3  # of the power: a tone that could carry more is missed
_KNOWN_PHASE = 0.1  # [rad] sigma above which the empty enclosure's tone is lost in noise


def dissipation(
    loaded: Record, empty: Sequence[Record] = (), particle_mass: float | None = None
) -> Dissipation:
    """Power, energy per cycle and efficiency of a bed, from records with and without it.

    empty: of the enclosure without particles at the same frequencies, at one amplitude or several
    (the phase error is interpolated). particle_mass [kg]. Raises InputError where it is <= 0.
    """
    if particle_mass is not None and not 0.0 < particle_mass < np.inf:
        raise InputError(f"--particle-mass = {particle_mass:g} kg: expected more than 0")
    warnings = list(loaded.remarks)
    sign = np.sign(loaded.mass[:, 0].real.mean())
    tones: list[Tone] = []
    totals = np.zeros(len(loaded.force))
    for k, frequency in enumerate(loaded.frequencies):
        error, sigma = _phase_error(loaded, k, empty, warnings) or (0.0, _like(tones, frequency))
        velocity = loaded.acceleration[:, k] / (2j * np.pi * frequency)
        flow = 0.5 * sign * loaded.force[:, k] * np.exp(-1j * error) * velocity.conj()
        totals += flow.real
        tones.append(_with_efficiency(_tone(loaded, k, (error, sigma), flow),
                                      particle_mass if loaded.shaken[k] else None))  # fmt: skip
    power = _total(totals, tones)
    warnings += _warnings(loaded, tones, power)
    return _with_cycle(loaded, tones, power, empty, particle_mass, warnings)


def _like(tones: Sequence[Tone], frequency: float) -> float | None:
    """Sigma [rad] of a phase error that nobody measured: as far off as the first tone's delay."""
    if not tones or tones[0].phase_error_sigma is None:
        return None
    return abs(tones[0].phase_error_rad / tones[0].frequency_hz) * frequency


def _total(totals: NDArray[np.float64], tones: Sequence[Tone]) -> Estimate:
    """The power of all tones from that of each block (b,); its sigma with those of the phases."""
    scatter = float(totals.std(ddof=1)) / np.sqrt(BLOCKS)
    parts = [
        None if t.phase_error_sigma is None else t.reactive_power_w * t.phase_error_sigma
        for t in tones
    ]
    known = [part for part in parts if part is not None]
    sigma = float(np.hypot(scatter, np.linalg.norm(known))) if len(known) == len(parts) else None
    return Estimate(float(totals.mean()), sigma, BLOCKS)


def _warnings(loaded: Record, tones: Sequence[Tone], power: Estimate) -> list[str]:
    """Warnings about the power."""
    words = []
    if power.sigma is None:
        each = 1e-3 * float(np.linalg.norm([tone.reactive_power_w for tone in tones]))
        words.append(
            "no record of the empty enclosure at this frequency: the phase error stays in, and "
            f"sigma is not known; each mrad is {each:.2g} W"
        )
    elif power.value < -2.0 * power.sigma:
        words.append("the power is below zero: is the phase error that of this very set-up?")
    least = power.sigma if power.sigma is not None else _COUNTS * abs(power.value)
    if loaded.left_out is not None and loaded.left_out[1] > least:
        frequency, most = loaded.left_out
        words.append(
            f"a tone of {frequency:.4g} Hz is not in the sum, and could carry {most:.2g} W: give "
            f"it, too, as --frequency {frequency:.4g}"
        )
    return words


def _tone(
    loaded: Record, k: int, phase: tuple[float, float | None], flow: NDArray[np.complex128]
) -> Tone:
    """A tone from the complex power (b,) of its blocks."""
    mean = flow.mean()
    scatter = float(flow.real.std(ddof=1)) / np.sqrt(BLOCKS)
    error, sigma = phase
    return Tone(
        float(loaded.frequencies[k]),
        float(np.abs(loaded.force[:, k]).mean()),
        float(np.abs(loaded.acceleration[:, k]).mean()),
        error,
        sigma,
        float(mean.real),
        float(mean.imag),
        None if sigma is None else float(np.hypot(scatter, mean.imag * sigma)),
    )


def _with_efficiency(tone: Tone, particle_mass: float | None) -> Tone:
    """A tone with its share of what could be taken at its speed; eqs 7.8 and 6.10."""
    if particle_mass is None:
        return tone
    speed = tone.acceleration_m_s2 / (2.0 * np.pi * tone.frequency_hz)
    most = 4.0 * speed**2 * particle_mass * tone.frequency_hz  # [W]
    sigma = None if tone.sigma_w is None else tone.sigma_w / most
    return replace(tone, efficiency=tone.power_w / most, efficiency_sigma=sigma)


def _with_cycle(
    loaded: Record,
    tones: Sequence[Tone],
    power: Estimate,
    empty: Sequence[Record],
    particle_mass: float | None,
    warnings: Sequence[str],
) -> Dissipation:
    """Energy per cycle and efficiency from the power: eqs 7.7, 7.8, 6.10."""
    first = tones[0]
    speed = first.acceleration_m_s2 / (2.0 * np.pi * first.frequency_hz)

    def scaled(factor: float) -> Estimate:
        sigma = None if power.sigma is None else factor * power.sigma
        return Estimate(factor * power.value, sigma, power.trials)

    per_cycle = 1.0 / first.frequency_hz
    orders = loaded.frequencies / first.frequency_hz
    alone = np.allclose(orders, np.round(orders), rtol=1e-6)
    most = 4.0 * speed**2 * particle_mass if particle_mass is not None and alone else None
    own = [abs(record.mass[:, 0].mean()) for record in empty]
    return Dissipation(
        first.frequency_hz,
        first.acceleration_m_s2 / GRAVITY,
        power,
        scaled(per_cycle),
        None if most is None else scaled(per_cycle / most),
        float(np.mean(own)) if own else None,
        tuple(tones),
        tuple(warnings),
        loaded,
    )


def _phase_error(
    loaded: Record, k: int, empty: Sequence[Record], warnings: list[str]
) -> tuple[float, float] | None:
    """Phase error [rad] of a tone and its sigma at the loaded record's amplitude; None: unknown."""
    frequency, amplitude = loaded.frequencies[k], float(np.abs(loaded.acceleration[:, k]).mean())
    known = []
    for record in empty:
        near = int(np.argmin(np.abs(record.frequencies - frequency)))
        if abs(record.frequencies[near] - frequency) > _SAME * frequency:
            continue
        masses = record.mass[:, near] * np.sign(record.mass[:, 0].real.mean())
        sigma = float(np.angle(masses / masses.mean()).std(ddof=1) / np.sqrt(BLOCKS))
        if sigma < _KNOWN_PHASE:
            size = float(np.abs(record.acceleration[:, near]).mean())
            known.append((size, float(np.angle(masses.mean())), sigma))
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
    return float(np.interp(amplitude, sizes, errors)), float(np.interp(amplitude, sizes, sigmas))
