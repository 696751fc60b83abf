"""Signals and densities from files: CSV tables, WAV files, and how signals are integrated."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from damper3d.case.excitation.forms import quantity
from damper3d.engine.motions import Table
from granulab.contact.files.datafile import csv_rows, is_file
from granulab.contact.files.units import nearest
from granulab.errors import InputError

COPY = "signal.csv"  # in a run folder
_QUANTITIES = {"m/s2": "acceleration", "m/s": "velocity", "m": "displacement", "N": "force"}
_MOST_POWER = 0.999
_WANTED = "the measured signal, CSV or WAV"
_EVEN = 1e-3  # of a step, by which even times may differ from even


@dataclass(frozen=True, eq=False)
class Signal:
    """A signal at even times."""

    values: np.ndarray  # (n,) in its unit
    unit: str  # m/s2, m/s, m or N
    spacing: float  # [s]

    @property
    def length(self) -> float:
        """From first to last [s]."""
        return self.spacing * (len(self.values) - 1)

    def as_csv(self) -> str:
        """A table for the run folder."""
        head = f"time [s],{_QUANTITIES[self.unit]} [{self.unit}]"
        rows = zip(
            (self.spacing * np.arange(len(self.values))).tolist(), self.values.tolist(), strict=True
        )
        return "\n".join([head, *(f"{time!r},{value!r}" for time, value in rows)]) + "\n"


def read_signal(path: Path, column: str | None, full_scale: str | None) -> Signal:
    """A signal from a CSV table or a WAV file.

    column: name of the table's column, where it has several; full_scale: what the largest number of
    a WAV file stands for. Raises InputError, one line that names file, line and column.
    """
    if not is_file(path):
        raise InputError(f"{path}: no such file; give {_WANTED}")
    if path.suffix.lower() == ".wav":
        return _wav(path, full_scale)
    if full_scale is not None:
        raise InputError(f"[excitation] full_scale goes with a WAV file, not with {path.name}")
    return _csv(path, column)


def _wav(path: Path, full_scale: str | None) -> Signal:
    from scipy.io import wavfile

    if full_scale is None:
        raise InputError(
            f"{path}: [excitation] full_scale is missing; a WAV file has no unit: give what its "
            "largest number stands for, such as '10 g'"
        )
    scale = quantity(full_scale, "full_scale")
    try:
        rate, numbers = wavfile.read(path)
    except Exception as error:  # scipy's own, struct's, of every kind of damage
        raise InputError(f"{path}: no WAV file that can be read: {error}") from None
    if numbers.ndim != 1:
        raise InputError(f"{path}: has {numbers.shape[1]} channels; give a file of one")
    values = numbers.astype(float)
    if numbers.dtype == np.uint8:
        values -= 128.0
    largest = 1.0 if numbers.dtype.kind == "f" else float(2 ** (8 * numbers.dtype.itemsize - 1))
    return _checked(path, scale.value * values / largest, scale.unit, 1.0 / rate)


def _csv(path: Path, column: str | None) -> Signal:
    rows = csv_rows(path, _WANTED)
    if len(rows) < 4:
        raise InputError(f"{path}: {max(len(rows) - 1, 0)} values; a signal has three at least")
    head = [cell.strip() for cell in rows[0][1]]
    if "time [s]" not in head:
        raise InputError(f"{path}: column 'time [s]' is missing; its head is {', '.join(head)}")
    place = _chosen(path, head, column)
    unit = head[place].partition("[")[2].rstrip("] ")
    factor = quantity(f"1 {unit}", f"{path}: column {head[place]!r}")
    found = []
    for line, row in rows[1:]:
        try:
            found.append([float(row[head.index("time [s]")]), float(row[place])])
        except (ValueError, IndexError):
            raise InputError(f"{path}: line {line}: no two numbers: {','.join(row)}") from None
    time, values = np.array(found).T
    step = float(time[-1] - time[0]) / (len(time) - 1)
    off = np.abs(np.diff(time) - step) > _EVEN * abs(step) + 1e-12
    if not step > 0 or not np.isfinite(time).all() or off.any():
        line = rows[1 + int(np.argmax(off)) + 1][0] if off.any() else rows[1][0]
        raise InputError(
            f"{path}: line {line}: the times are not even (steps of {step:.4g} s in the mean); "
            "give a signal sampled at one rate"
        )
    return _checked(path, factor.value * values, factor.unit, step)


def _chosen(path: Path, head: list[str], column: str | None) -> int:
    """Place of the column that is meant."""
    names = [cell.partition("[")[0].strip() for cell in head]
    others = [k for k, name in enumerate(names) if name != "time"]
    if column is None and len(others) == 1:
        return others[0]
    if column is None:
        raise InputError(
            f"{path}: {len(others)} columns besides the time; [excitation] column names one of "
            f"{', '.join(names[k] for k in others)}"
        )
    if column not in names:
        raise InputError(f"{path}: [excitation] column = {column!r}: {nearest(column, names)}")
    return names.index(column)


def _checked(path: Path, values: np.ndarray, unit: str, spacing: float) -> Signal:
    if len(values) < 3 or not np.isfinite(values).all() or not np.any(values != values[0]):
        raise InputError(
            f"{path}: nothing but one value, or values that are no finite numbers; a signal has "
            "three at least that change"
        )
    return Signal(values, unit, spacing)


def motion_of(signal: Signal, balanced: bool) -> Table:
    """A measured signal as a motion [m] or force [N], by sums of the trapezoidal rule.

    balanced: the mean of an acceleration and of the velocity that it gives, or of a measured
    velocity, is taken off first, so that the enclosure ends near where it began; else it starts
    from rest. The displacement begins at 0.
    """
    values, h, off = signal.values, signal.spacing, means_of(signal, balanced)
    if signal.unit in ("m", "N"):
        moved = values - values[0] if signal.unit == "m" else values
        return Table(moved, np.gradient(moved, h), h)
    velocity = _integral(values - off.acceleration, h) if signal.unit == "m/s2" else values
    velocity = velocity - off.velocity
    return Table(_integral(velocity, h), velocity, h)


class Means(NamedTuple):
    """Means in time that are taken off a measured signal."""

    acceleration: float  # [m/s2]
    velocity: float  # [m/s]


def means_of(signal: Signal, balanced: bool) -> Means:
    """Means that `balanced` takes off an acceleration and its velocity, or a velocity; else 0.

    An enclosure begins at the velocity that is taken off, the other way round.
    """
    if not balanced or signal.unit in ("m", "N"):
        return Means(0.0, 0.0)
    acceleration, velocity = 0.0, signal.values
    if signal.unit == "m/s2":
        acceleration = _mean(signal.values)
        velocity = _integral(signal.values - acceleration, signal.spacing)
    return Means(acceleration, _mean(velocity))


def _mean(values: np.ndarray) -> float:
    """Mean in time."""
    return float(np.trapezoid(values) / (len(values) - 1))


def _integral(values: np.ndarray, h: float) -> np.ndarray:
    return h * np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))])


def highest_frequency(signal: Signal) -> float:
    """Frequency [Hz] below which 99.9 % of the signal's power lies, and no more than a fifth of
    its rate: what the samples of a run must show.
    """
    power = np.abs(np.fft.rfft(signal.values - signal.values.mean())) ** 2
    upto = np.cumsum(power) / power.sum()
    found = float(np.argmax(upto >= _MOST_POWER)) / (signal.spacing * len(signal.values))
    return min(max(found, 1.0 / signal.length), 0.2 / signal.spacing)


def breakpoints(psd: Any, folder: Path, of: str) -> np.ndarray:
    """Breakpoints (k, 2) of a density of g^2/Hz or N^2/Hz, given or from a CSV file.

    of: "g" or "N", which the head of a file must have where it has a unit. InputError for others.
    """
    if isinstance(psd, str):
        psd = _density_file(folder / psd if is_file(folder / psd) else Path(psd), of)
    found = np.array(psd if all(len(row) == 2 for row in psd) else [[0.0, 0.0]], float)
    if found.ndim != 2 or len(found) < 2:
        raise InputError("psd: give two breakpoints at least, [frequency in Hz, density]")
    for frequency, height in found:
        if not (0 < frequency < math.inf):
            raise InputError(f"psd: frequency = {frequency:g} Hz: must be above 0")
        if not (0 < height < math.inf):
            raise InputError(f"psd: density = {height:g} at {frequency:g} Hz: must be above 0")
    if np.any(np.diff(found[:, 0]) <= 0):
        raise InputError("psd: frequencies must rise from one breakpoint to the next")
    return found


def _density_file(path: Path, of: str) -> list[list[float]]:
    """The two columns of a CSV file of breakpoints, with a head or without one."""
    rows: list[list[float]] = []
    for line, cells in csv_rows(path, "one, or breakpoints: psd = [[20, 0.01], [200, 0.01]]"):
        try:
            rows.append([float(cell) for cell in cells])
        except ValueError:
            if rows:
                text = ",".join(cells)
                raise InputError(f"{path}: line {line}: no two numbers: {text}") from None
            _check_head(path, cells, ("Hz", f"{of}^2/Hz"))
    return rows


def _check_head(path: Path, cells: list[str], units: tuple[str, ...]) -> None:
    """Raise InputError where a column has another unit; one without a unit has this one."""
    for cell, unit in zip(cells, units, strict=False):
        name, _, said = (part.strip() for part in cell.rstrip("] ").partition("["))
        if said and said.replace("²", "2").replace("^", "") != unit.replace("^", ""):
            raise InputError(
                f"{path}: column {cell.strip()!r}: the unit is {said!r}; {unit} is needed here: "
                f"write '{name} [{unit}]' above numbers in it"
            )
