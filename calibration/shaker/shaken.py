"""Tones of force and acceleration in a record of a shaken enclosure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.bench.sections import Input
from calibration.files.signals import clock_of
from calibration.files.tables import read_table
from calibration.shaker.tones import amplitudes, remainder, strongest, tuned
from granulab.errors import InputError

INPUTS = (
    Input("force", "N", "of the shaker on the enclosure"),
    Input("acceleration", "m/s2", "of the enclosure"),
)
BLOCKS = 16  # of a record, whose scatter gives sigma
_STANDS_OUT = 10.0  # sigmas of its mean over blocks, for a tone that is shaken and not noise
_LEAST_CYCLES = 2.0  # of the lowest tone, or the lowest difference of two, in a block


@dataclass(frozen=True)
class Record:
    """Force [N] and acceleration [m/s2] at tones (k,) [Hz] in each of b blocks: (b, k) complex.

    shaken (k,) tells the tones that the shaker was given from their harmonics; samples (2, n) are
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
