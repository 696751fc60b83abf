"""Tones of force and acceleration in a record of a shaken enclosure.

Complex amplitudes come block by block, by least squares, without leakage:
x(t) = c + Re sum_k X_k e^(j 2 pi f_k t). Tones need no whole number of cycles in a block, and do
not leak into one another; thesis, eqs 7.10 and 7.11 are the same sums where they have one, with the
factor 2/N that is not printed (errata). Blocks of one tone are whole cycles all the same: impacts
have more harmonics than are counted, and only whole cycles keep those out.

Amplifiers drift, and a slope would leak alike into all blocks of whole cycles, where no scatter
would show it. It is taken off as the line through the means of the cycles, which no harmonic tilts.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.bench.sections import Input
from calibration.files.signals import clock_of
from calibration.files.tables import read_table
from calibration.statistics.uncertainty import student
from granulab.errors import InputError

_MOST_ROUNDS = 5
_LARGEST = 1e12  # [N, m/s2] of a sample
INPUTS = (
    Input("force", "N", "of the shaker on the enclosure"),
    Input("acceleration", "m/s2", "of the enclosure"),
)
BLOCKS = 16  # at most, of a record, whose scatter gives sigma; of one tone each is whole cycles
_FEWEST_CYCLES = 4  # of which each is a block then: fewer have no scatter to speak of
_STANDS_OUT = 10.0  # sigmas of its mean over blocks, for a tone that is shaken and not noise
_LEAST_CYCLES = 2.0  # in a block, of a tone among several, or of the lowest difference of two


def amplitudes(
    x: NDArray[np.float64], rate: float, frequencies: NDArray[np.float64], length: int
) -> NDArray[np.complex128]:
    """X (blocks, k) of samples (n,) at tones (k,) [Hz], in blocks of so many samples.

    Phases count from the first sample; what is left at the end is no block.
    """
    blocks = len(x) // length
    angle = 2.0 * np.pi * np.outer(np.arange(length) / rate, frequencies)
    terms = np.hstack([np.ones((length, 1)), np.cos(angle), -np.sin(angle)])
    pieces = x[: blocks * length].reshape(blocks, length)
    solved, *_ = np.linalg.lstsq(terms, pieces.T, rcond=None)
    n = len(frequencies)
    found = (solved[1 : n + 1] + 1j * solved[n + 1 :]).T
    begin = np.arange(blocks) * length / rate
    return found * np.exp(-2j * np.pi * np.outer(begin, frequencies))


def remainder(
    x: NDArray[np.float64],
    rate: float,
    frequencies: NDArray[np.float64],
    found: NDArray[np.complex128],
    length: int,
) -> NDArray[np.float64]:
    """Samples (n,) less tones (k,) [Hz] of amplitudes (blocks, k), drift taken off."""
    from scipy.signal import detrend

    pieces = x[: len(found) * length].reshape(len(found), length)
    t = np.arange(pieces.size).reshape(pieces.shape) / rate
    left = pieces - sum(
        (found[:, k, None] * np.exp(2j * np.pi * f * t)).real for k, f in enumerate(frequencies)
    )
    return np.asarray(detrend(left, axis=1)).ravel()


def level(x: NDArray[np.float64], rate: float, frequency: float) -> NDArray[np.float64]:
    """Samples (n,) less the line through the means of the whole cycles of a tone [Hz]."""
    n = int(len(x) * frequency / rate)
    edges = np.round(np.arange(n + 1) * rate / frequency).astype(int)
    sums = np.diff(np.concatenate([[0.0], np.cumsum(x)])[edges])
    middles = 0.5 * (edges[1:] + edges[:-1] - 1)
    return x - np.polyval(np.polyfit(middles, sums / np.diff(edges), 1), np.arange(len(x)))


def strongest(x: NDArray[np.float64], rate: float) -> float:
    """The frequency [Hz] of the largest line of samples (n,), to about a tenth of a line."""
    spectrum = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x))))
    k = int(np.argmax(spectrum[1:-1])) + 1
    low, middle, high = np.log(np.maximum(spectrum[k - 1 : k + 2], 1e-300))
    bend = low - 2.0 * middle + high  # 0 where all lines are alike
    return float((k + (0.5 * (low - high) / bend if bend else 0.0)) * rate / len(x))


def tuned(x: NDArray[np.float64], rate: float, frequency: float, length: int) -> float:
    """A frequency [Hz] close to one given, at which the phase stands still from block to block."""
    for _ in range(_MOST_ROUNDS):
        found = amplitudes(x, rate, np.array([frequency]), length)[:, 0]
        phase = np.unwrap(np.angle(found))
        turns = np.polyfit(np.arange(len(found)), phase, 1)[0] / (2.0 * np.pi)
        change = float(turns) * rate / length
        frequency += change
        if abs(change) < 1e-9 * frequency:
            break
    return frequency


def block_length(n: int, rate: float, tones: Sequence[float]) -> int:
    """Samples of a block of a record of n: whole cycles of one tone, a sixteenth for several.

    Of 8 to 16 blocks of one tone, the number that leaves the fewest cycles out.
    """
    if len(tones) > 1:
        return n // BLOCKS
    cycles = whole_cycles(n, rate, tones[0])
    blocks = min(range(min(cycles, BLOCKS), min(cycles, BLOCKS // 2) - 1, -1), key=cycles.__mod__)
    return round(cycles // blocks * rate / tones[0])


def whole_cycles(n: int, rate: float, frequency: float) -> int:
    """Whole cycles of a tone [Hz] in n samples, of which the last may lack half a hundredth."""
    return int(n * frequency / rate + 0.005)


def of_mean(blocks: NDArray[np.generic]) -> float:
    """Half the 68.3 % interval of the mean of blocks (b,), from their scatter."""
    n = len(blocks)
    return student(n - 1) * float(blocks.std(ddof=1)) / math.sqrt(n)


@dataclass(frozen=True)
class Record:
    """Force [N] and acceleration [m/s2] at tones (k,) [Hz] in each of b blocks: (b, k) complex.

    shaken (k,) marks the tones that the shaker was given, not their harmonics; samples (2, n) are
    force and acceleration as read, `rate` [Hz] of them a second. left_out is the strongest steady
    tone that is not among them, and the power [W] it could carry at most; None where there is none.
    """

    path: Path
    frequencies: NDArray[np.float64]
    force: NDArray[np.complex128]
    acceleration: NDArray[np.complex128]
    shaken: NDArray[np.bool_]
    samples: NDArray[np.float64]
    rate: float
    left_out: tuple[float, float] | None = None
    remarks: tuple[str, ...] = ()

    @property
    def mass(self) -> NDArray[np.complex128]:
        """F/A (b,) [kg] at the first tone: what rides along, and the phase between them."""
        return self.force[:, 0] / self.acceleration[:, 0]

    @property
    def sense(self) -> float:
        """1 where force and acceleration count in the same direction, -1 where they do not."""
        return float(np.sign(self.mass.real.mean()))


def read_record(
    path: str | Path,
    *,
    rate: float | None = None,
    frequencies: Sequence[float] = (),
    harmonics: int = 5,
    columns: Mapping[str, str] | None = None,
) -> Record:
    """Tones in the columns 'force' and 'acceleration' of a table, their units in the head.

    frequencies [Hz] are those that the shaker was given (each is tuned to the signal); without
    any, the strongest line of the acceleration. Each is followed by its harmonics 2 to `harmonics`.
    columns {"force": "Kraft [kN]"} are those that are called otherwise in the table.
    Raises InputError for a table without these columns, and a record too short for the tones.
    """
    table = read_table(path).renamed(columns or {})
    clock = clock_of(table, rate)
    force = _finite(path, "force", table.column("force", "N"))
    moved = _finite(path, "acceleration", table.column("acceleration", "m/s2"))
    if not np.ptp(moved) > 0:
        raise InputError(f"{path}: the acceleration does not change: nothing is shaken")
    if not np.ptp(force) > 0:
        raise InputError(f"{path}: the force does not change: no transducer is connected")
    given = list(frequencies) or [strongest(moved, clock.rate)]
    for frequency in given:
        _check(path, frequency, clock.rate, len(moved))
    samples = np.stack([level(x, clock.rate, given[0]) for x in (force, moved)])
    length = block_length(len(moved), clock.rate, given)
    first = [tuned(samples[1], clock.rate, frequency, length) for frequency in given]
    length = block_length(len(moved), clock.rate, first)
    tones = _with_harmonics(path, first, harmonics, clock.rate, length)
    if length < 2 * len(tones) + 2:
        raise InputError(
            f"{path}: a block of {length} samples is too short for the tones counted "
            f"({len(tones)}); fewer --harmonics, or a longer record, would do"
        )
    forces, moves = (amplitudes(x, clock.rate, tones, length) for x in samples)
    for frequency in first:
        _check_tone(path, frequency, moves[:, int(np.argmin(np.abs(tones - frequency)))])
    left_out = _left_out(samples, clock.rate, tones, (forces, moves), length)
    shaken = np.isin(tones, first)
    return Record(
        Path(path), tones, forces, moves, shaken, samples, clock.rate, left_out, clock.remarks
    )


def _left_out(
    samples: NDArray[np.float64], rate: float, tones: NDArray[np.float64],
    found: tuple[NDArray[np.complex128], NDArray[np.complex128]], length: int,
) -> tuple[float, float] | None:  # fmt: skip
    """The strongest steady tone that is left of the acceleration, and |F| |V|/2 there [W]."""
    force, rest = (
        remainder(x, rate, tones, own, length) for x, own in zip(samples, found, strict=True)
    )
    if not np.ptp(rest) > 0:
        return None
    frequency = strongest(rest, rate)
    if frequency * length / rate < _LEAST_CYCLES:
        return None
    tone = np.array([tuned(rest, rate, frequency, length)])
    sizes = amplitudes(rest, rate, tone, length)[:, 0]
    if abs(sizes.mean()) < _STANDS_OUT * of_mean(sizes):
        return None
    push = amplitudes(force, rate, tone, length)
    most = 0.5 * abs(push.mean()) * abs(sizes.mean()) / (2.0 * np.pi * float(tone[0]))
    return float(tone[0]), float(most)


def _with_harmonics(
    path: str | Path, first: Sequence[float], harmonics: int, rate: float, length: int
) -> NDArray[np.float64]:
    """Each tone and its harmonics below half the rate; InputError where two are too close."""
    highest = 0.5 * rate
    tones = np.array([k * f for f in first for k in range(1, harmonics + 1) if k * f < highest])
    apart = np.diff(np.sort(tones)).min(initial=np.inf)
    if len(first) > 1 and apart * length / rate < _LEAST_CYCLES:
        raise InputError(
            f"{path}: two tones or harmonics are {apart:.3g} Hz apart; a record of "
            f"{BLOCKS * _LEAST_CYCLES / max(apart, 1e-9):.3g} s or fewer --harmonics would do"
        )
    return tones


def _finite(path: str | Path, name: str, x: NDArray[np.float64]) -> NDArray[np.float64]:
    if not np.isfinite(x).all():
        raise InputError(f"{path}: column {name!r}: a sample is missing or not finite")
    if (size := float(np.abs(x).max(initial=0.0))) > _LARGEST:
        raise InputError(
            f"{path}: column {name!r}: a sample of {size:.3g} in SI: no shaker does that; check "
            "the unit in the head"
        )
    return x


def _check(path: str | Path, frequency: float, rate: float, n: int) -> None:
    """InputError where a tone cannot be seen in the record."""
    if not 0.0 < frequency < 0.5 * rate:
        raise InputError(
            f"{path}: {frequency:g} Hz: expected more than 0 and less than half the rate, "
            f"{0.5 * rate:g} Hz"
        )
    if whole_cycles(n, rate, frequency) < _FEWEST_CYCLES:
        raise InputError(
            f"{path}: {n / rate:.3g} s hold {n / rate * frequency:.3g} cycles of "
            f"{frequency:g} Hz; at least {_FEWEST_CYCLES}"
        )


def _check_tone(path: str | Path, frequency: float, moves: NDArray[np.complex128]) -> None:
    """InputError where the blocks (b,) of the acceleration hold no steady tone."""
    if abs(moves.mean()) < _STANDS_OUT * of_mean(moves):
        raise InputError(
            f"{path}: no steady tone of {frequency:g} Hz stands out of the acceleration's noise"
        )
