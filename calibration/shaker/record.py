"""Tones of force and acceleration in a record of a shaken enclosure.

Complex amplitudes come block by block, by least squares, without leakage:
x(t) = c + d t + Re sum_k X_k e^(j 2 pi f_k t). Tones need no whole number of cycles in a block, and
do not leak into one another; thesis, eqs 7.10 and 7.11 are the same sums where they have one, with
the factor 2/N that is not printed (errata). Amplifiers drift: without d t, a slope would leak alike
into all blocks of whole cycles, and no scatter would show it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.bench.sections import Input
from calibration.files.signals import clock_of
from calibration.files.tables import read_table
from granulab.errors import InputError

_MOST_ROUNDS = 5
_LARGEST = 1e12  # [N, m/s2] of a sample
INPUTS = (
    Input("force", "N", "of the shaker on the enclosure"),
    Input("acceleration", "m/s2", "of the enclosure"),
)
BLOCKS = 16  # of a record, whose scatter gives sigma
_STANDS_OUT = 10.0  # sigmas of its mean over blocks, for a tone that is shaken and not noise
_LEAST_CYCLES = 2.0  # of the lowest tone, or the lowest difference of two, in a block


def amplitudes(
    x: NDArray[np.float64], rate: float, frequencies: NDArray[np.float64], blocks: int
) -> NDArray[np.complex128]:
    """X (blocks, k) of samples (n,) at tones (k,) [Hz]; phases count from the first sample."""
    length = len(x) // blocks
    angle = 2.0 * np.pi * np.outer(np.arange(length) / rate, frequencies)
    line = np.column_stack([np.ones(length), np.linspace(-1.0, 1.0, length)])
    terms = np.hstack([line, np.cos(angle), -np.sin(angle)])
    pieces = x[: blocks * length].reshape(blocks, length)
    solved, *_ = np.linalg.lstsq(terms, pieces.T, rcond=None)
    n = len(frequencies)
    found = (solved[2 : n + 2] + 1j * solved[n + 2 :]).T
    begin = np.arange(blocks) * length / rate
    return found * np.exp(-2j * np.pi * np.outer(begin, frequencies))


def remainder(
    x: NDArray[np.float64],
    rate: float,
    frequencies: NDArray[np.float64],
    found: NDArray[np.complex128],
) -> NDArray[np.float64]:
    """Samples (n,) less tones (k,) [Hz] of amplitudes (blocks, k), drift taken off."""
    from scipy.signal import detrend

    blocks = len(found)
    pieces = x[: len(x) // blocks * blocks].reshape(blocks, -1)
    t = np.arange(pieces.size).reshape(pieces.shape) / rate
    left = pieces - sum(
        (found[:, k, None] * np.exp(2j * np.pi * f * t)).real for k, f in enumerate(frequencies)
    )
    return np.asarray(detrend(left, axis=1)).ravel()


def strongest(x: NDArray[np.float64], rate: float) -> float:
    """The frequency [Hz] of the largest line of samples (n,), to about a tenth of a line."""
    spectrum = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x))))
    k = int(np.argmax(spectrum[1:-1])) + 1
    low, middle, high = np.log(np.maximum(spectrum[k - 1 : k + 2], 1e-300))
    bend = low - 2.0 * middle + high  # 0 where all lines are alike
    return float((k + (0.5 * (low - high) / bend if bend else 0.0)) * rate / len(x))


def tuned(x: NDArray[np.float64], rate: float, frequency: float, blocks: int) -> float:
    """A frequency [Hz] close to one given, at which the phase stands still from block to block."""
    span = len(x) // blocks / rate
    for _ in range(_MOST_ROUNDS):
        found = amplitudes(x, rate, np.array([frequency]), blocks)[:, 0]
        phase = np.unwrap(np.angle(found))
        change = np.polyfit(np.arange(blocks) * span, phase, 1)[0] / (2.0 * np.pi)
        frequency += float(change)
        if abs(change) < 1e-9 * frequency:
            break
    return frequency


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
        """F/A (b, k) [kg]: what rides along, and the phase between them."""
        return self.force / self.acceleration


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
    given = list(frequencies) or [strongest(moved, clock.rate)]
    block = len(moved) // BLOCKS / clock.rate
    for frequency in given:
        _check(path, frequency, clock.rate, block)
    first = [tuned(moved, clock.rate, frequency, BLOCKS) for frequency in given]
    tones = _with_harmonics(path, first, harmonics, 0.5 * clock.rate, block)
    moves = amplitudes(moved, clock.rate, tones, BLOCKS)
    for frequency in first:
        _check_tone(path, frequency, moves[:, int(np.argmin(np.abs(tones - frequency)))])
    forces = amplitudes(force, clock.rate, tones, BLOCKS)
    return Record(
        Path(path), tones, forces, moves, np.isin(tones, first), np.stack([force, moved]),
        clock.rate, _left_out(force, moved, clock.rate, tones, forces, moves), clock.remarks,
    )  # fmt: skip


def _left_out(
    force: NDArray[np.float64], moved: NDArray[np.float64], rate: float,
    tones: NDArray[np.float64], forces: NDArray[np.complex128], moves: NDArray[np.complex128],
) -> tuple[float, float] | None:  # fmt: skip
    """The strongest steady tone that is left of the acceleration, and |F| |V|/2 there [W]."""
    rest = remainder(moved, rate, tones, moves)
    if not np.ptp(rest) > 0:
        return None
    frequency = strongest(rest, rate)
    if frequency * len(rest) / BLOCKS / rate < _LEAST_CYCLES:
        return None
    tone = np.array([tuned(rest, rate, frequency, BLOCKS)])
    sizes = amplitudes(rest, rate, tone, BLOCKS)
    if abs(sizes.mean()) < _STANDS_OUT * float(sizes.std()) / np.sqrt(BLOCKS):
        return None
    push = amplitudes(remainder(force, rate, tones, forces), rate, tone, BLOCKS)
    most = 0.5 * abs(push.mean()) * abs(sizes.mean()) / (2.0 * np.pi * float(tone[0]))
    return float(tone[0]), float(most)


def _with_harmonics(
    path: str | Path, first: Sequence[float], harmonics: int, highest: float, block: float
) -> NDArray[np.float64]:
    """Each tone and its harmonics below the highest [Hz]; InputError where two are too close."""
    tones = np.array([k * f for f in first for k in range(1, harmonics + 1) if k * f < highest])
    apart = np.diff(np.sort(tones)).min(initial=np.inf)
    if apart * block < _LEAST_CYCLES:
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


def _check(path: str | Path, frequency: float, rate: float, block: float) -> None:
    """InputError where a tone cannot be seen in the record."""
    if not 0.0 < frequency < 0.5 * rate:
        raise InputError(
            f"{path}: {frequency:g} Hz: expected more than 0 and less than half the rate, "
            f"{0.5 * rate:g} Hz"
        )
    if frequency * block < _LEAST_CYCLES:
        raise InputError(
            f"{path}: {BLOCKS * block:.3g} s hold {BLOCKS * block * frequency:.3g} cycles of "
            f"{frequency:g} Hz; at least {BLOCKS * _LEAST_CYCLES:g}"
        )


def _check_tone(path: str | Path, frequency: float, moves: NDArray[np.complex128]) -> None:
    """InputError where the blocks (b,) of the acceleration hold no steady tone."""
    scatter = float(moves.std()) / np.sqrt(BLOCKS)
    if abs(moves.mean()) < _STANDS_OUT * scatter:
        raise InputError(
            f"{path}: no steady tone of {frequency:g} Hz stands out of the acceleration's noise"
        )
