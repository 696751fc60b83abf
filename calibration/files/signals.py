"""Signals against time as instruments write them: WAV, or CSV with a time column or a rate."""

import struct
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.files.tables import Table, read_table
from granulab.contact.files.units import nearest
from granulab.errors import InputError

_TIME_NAMES = ("time", "t", "zeit")
_LEAST_SAMPLES = 16
_FASTEST = 1e12  # samples per second of the fastest recorders; and one in 30,000 years
_LARGEST = 1e30  # of a sample, in any unit: its fourth power is a number still
_UNREADABLE = (  # what scipy raises, depending on which byte of the head is wrong
    ValueError, TypeError, ArithmeticError, struct.error, EOFError, MemoryError, UnboundLocalError,
)  # fmt: skip


@dataclass(frozen=True)
class Signal:
    """Samples at even steps of time.

    path      where it was read
    channels  (n, c), with the names of the c channels; WAV: of full scale, CSV: as written
    rate      samples per second [Hz]
    start     time of the first sample [s]
    remarks   what was taken for granted
    """

    path: Path
    channels: NDArray[np.float64]
    names: tuple[str, ...]
    rate: float
    start: float = 0.0
    remarks: tuple[str, ...] = ()


def read_signal(
    path: str | Path, *, rate: float | None = None, column: str | None = None,
    units: Mapping[str, str] | None = None,
) -> Signal:  # fmt: skip
    """The signal of a WAV file, else of a table of numbers.

    rate    samples per second [Hz] of a table without a column of times
    column  the only channel wanted of a table
    units   of its columns, where the head has none: {"time": "ms"}

    Raises InputError, one line, for what is neither, for gaps, and for too few samples.
    """
    path = Path(path)
    if _head(path) in (b"RIFF", b"RIFX", b"RF64") or path.suffix.lower() in (".wav", ".wave"):
        if rate is not None or column is not None or units:
            raise InputError(
                f"{path}: --rate, --column and --unit are for tables; a WAV has its own rate"
            )
        signal = _wav(path)
    else:
        signal = _table(read_table(path).with_units(units or {}), rate, column)
    if len(signal.channels) < _LEAST_SAMPLES:
        raise InputError(f"{path}: {len(signal.channels)} samples; at least {_LEAST_SAMPLES}")
    if not np.isfinite(signal.channels).all():
        raise InputError(f"{path}: a sample is missing or not finite; cut the signal around it")
    size = np.abs(signal.channels).max()
    if not (size < _LARGEST and (size > 1 / _LARGEST or size == 0)):
        raise InputError(
            f"{path}: a sample of {size:.3g}: no instrument writes numbers as large or small; "
            "check the unit, or cut the signal around it"
        )
    return signal


def _head(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(4)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None


def _wav(path: Path) -> Signal:
    """A WAV of 8 to 64 bit, integers or floats, any rate and number of channels."""
    from scipy.io import wavfile

    try:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always", wavfile.WavFileWarning)
            rate, raw = wavfile.read(path)
    except _UNREADABLE as error:
        raise InputError(f"{path}: not a WAV that can be read ({error})") from None
    early = next((str(one.message) for one in said if "EOF" in str(one.message)), None)
    if early is not None:
        raise InputError(f"{path}: truncated: {early[0].lower()}{early[1:]}")
    if rate <= 0:
        raise InputError(f"{path}: its head gives {rate} samples per second")
    channels = raw.reshape(len(raw), -1).astype(np.float64)
    if raw.dtype.kind in "iu":
        full = 2.0 ** (8 * raw.dtype.itemsize - 1)
        channels = (channels - (full if raw.dtype.kind == "u" else 0.0)) / full
    names = tuple(f"channel {k + 1}" for k in range(channels.shape[1]))
    return Signal(path, channels, names, float(rate))


def _table(table: Table, rate: float | None, column: str | None) -> Signal:
    """Channels of a table: all but the column of times, or the one that is named."""
    clock = clock_of(table, rate)
    names = [name for name in table.columns if name != clock.column]
    if column is not None:
        names = [name for name in names if name.lower() == column.lower()]
        if not names:
            raise InputError(
                f"{table.path}: no column {column!r}; {nearest(column, table.columns)}"
            )
    if not names:
        raise InputError(f"{table.path}: one column alone, and it holds times; no signal")
    channels = np.column_stack([table.columns[name] for name in names])
    return Signal(table.path, channels, tuple(names), clock.rate, clock.start, clock.remarks)


@dataclass(frozen=True)
class Clock:
    """Times of the samples of a table: rate [Hz], start [s], and the column of times."""

    rate: float
    start: float
    column: str | None
    remarks: tuple[str, ...]


def clock_of(table: Table, rate: float | None) -> Clock:
    """The clock of a table, from a rate [Hz] or from its column of times.

    Raises InputError where there is neither, and where the times do not grow evenly.
    """
    if rate is not None and not 1 / _FASTEST < rate < _FASTEST:
        raise InputError(f"--rate = {rate:g}: samples per second, such as 200000")
    timed = next((key for name in _TIME_NAMES if (key := _called(table, name))), None)
    if rate is not None:
        unused = () if timed is None else (f"--rate was used, not the column {timed!r}",)
        return Clock(rate, 0.0, timed, table.remarks + unused)
    if timed is None and _counts_up(table):
        timed = next(iter(table.columns))
    if timed is None:
        raise InputError(
            f"{table.path}: no column called 'time'; give --rate, such as --rate 200000"
        )
    times, remarks = _times(table, timed)
    rate = (len(times) - 1) / (times[-1] - times[0])
    if not 1 / _FASTEST < rate < _FASTEST:
        raise InputError(
            f"{table.path}: the column {timed!r} gives {rate:.3g} samples per second; check its "
            "unit: --unit time=ms, or write it into the head"
        )
    return Clock(rate, float(times[0]), timed, table.remarks + remarks)


def _called(table: Table, name: str) -> str | None:
    """The column of a name, alone or with a unit of time behind it: time, time_ms."""
    if not table.has(name, "s"):
        return None
    if table.has(name) and name not in map(str.lower, table.columns):
        table.column(name, "s", "s")  # says which of its fields is no number
    low = [key for key in table.columns if key.lower() == name]
    return next(iter([*low, *(k for k in table.columns if k.lower().startswith(f"{name}_"))]), None)


def _counts_up(table: Table) -> bool:
    """True if the first of several columns without names grows from line to line, as times do."""
    first = next(iter(table.columns.values()))
    nameless = next(iter(table.columns)).startswith("column ")
    return nameless and len(table.columns) > 1 and bool((np.diff(first) > 0).all())


def _times(table: Table, name: str) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """The times [s]; InputError where they do not grow evenly, rounding left aside."""
    short = name if name.lower() in _TIME_NAMES else name.split("_")[0]
    known = table.units[name] or short != name
    remarks = () if known else (f"the column {name!r} was taken to be in seconds",)
    times = table.column(short if table.has(short, "s") else name, "s", "s")
    n = len(times)
    if n < _LEAST_SAMPLES:
        raise InputError(f"{table.path}: {n} samples; at least {_LEAST_SAMPLES}")
    steps = np.diff(times)
    if not (steps >= 0).all() or not times[-1] > times[0]:  # rounded times may stand still
        raise InputError(f"{table.path}: the column {name!r} does not grow from line to line")
    even = np.linspace(times[0], times[-1], n)
    usual = float(np.median(steps))
    lost = steps.min() > 0.5 * usual and steps.max() > 1.5 * usual  # rounding makes short steps too
    if lost or np.abs(times - even).max() > even[1] - even[0]:
        raise InputError(
            f"{table.path}: the column {name!r} has gaps or an uneven rate: steps of "
            f"{steps.min():.3g} to {steps.max():.3g} s, the longest at {times[steps.argmax()]:.6g} "
            "s; cut or resample the signal, or give --rate where the times alone are rounded"
        )
    return times, remarks
