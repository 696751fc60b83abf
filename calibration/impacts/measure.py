"""A signal with impacts to their times and the restitution, with what has to be said about it."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.files.signals import Signal, read_signal
from calibration.impacts.onset import edge_of, onsets_of, with_shape
from calibration.impacts.ratios import Restitution, first_restitution, restitution
from calibration.impacts.result import Impacts
from calibration.impacts.search import RISE, WINDOW, Search, search
from calibration.impacts.sequence import bouncing, weakness
from calibration.result import checked
from calibration.statistics.uncertainty import Estimate
from granulab.contact.material import Measured
from granulab.errors import InputError

_MOST_LISTED = 6  # events that a warning names


def measure_impacts(
    path: str | Path,
    *,
    rate: float | None = None,
    column: str | None = None,
    window: float = WINDOW,
    drop_height: float | Measured | None = None,
    units: Mapping[str, str] | None = None,
) -> Impacts:
    """Impact times and restitution from force, acceleration or sound against time (WAV, CSV).

    rate         samples per second [Hz] of a table without times
    column       the only channel wanted of a table
    window       time [s] over which energy is taken: longer than a contact, shorter than a flight
    drop_height  [m] of the fall before the first impact, best with its standard uncertainty; a
                 check, and with two impacts the measurement
    units        of the columns of a table: {"time": "ms"}

    Raises InputError for what is no signal, and where there are fewer than two impacts.
    """
    signal = read_signal(path, rate=rate, column=column, units=units)
    found = measure_signal(signal, window=window, drop_height=drop_height)
    checked(found.to_dict(), [path])
    return found


def measure_signal(
    signal: Signal, *, window: float = WINDOW, drop_height: float | Measured | None = None
) -> Impacts:
    """The same of a signal that has been read; see measure_impacts."""
    height = _height(drop_height)
    found = search(signal, _checked(window, signal))
    starts, ends = found.begins * found.block, found.peaks * found.block
    row = bouncing(starts / signal.rate, found.level[found.peaks])
    chosen = row or list(range(len(starts)))
    problem = None if row else _no_row(signal.path, len(starts), height)
    events = starts / signal.rate
    times, sigmas = _timed(signal, found, [(int(starts[k]), int(ends[k])) for k in chosen])
    events[chosen] = times
    if row:
        problem = weakness(row, events, found.level[found.peaks])
    others = np.delete(events, chosen) + signal.start
    value, first = _restitution(times, sigmas, height, problem is None)
    remarks = [problem] if problem else []
    if height is not None and not height.sigma:
        remarks.append(
            f"--drop-height = {height.value:g} m counts as exact: write what it is known to, such "
            "as '1.5 m +- 5 mm'"
        )
    remarks += [*signal.remarks, *_said(found, signal), *_remarks(value, first, others)]
    return Impacts(
        signal, found, times + signal.start, sigmas, tuple(map(float, others)), value, first,
        tuple(remarks),
    )  # fmt: skip


def _height(given: float | Measured | None) -> Estimate | None:
    """A drop height; InputError for none."""
    if given is None:
        return None
    known = given if isinstance(given, Measured) else Measured(given)
    if not 0.0 < known.value < 1e3:
        raise InputError(
            f"--drop-height = {known.value:g} m: expected more than 0, such as '1.5 m +- 5 mm'"
        )
    return Estimate(known.value, known.sigma or 0.0, 1)


def _timed(
    signal: Signal, found: Search, spans: list[tuple[int, int]]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times (m,) [s] from the first sample and their sigmas, of events that rise in these spans."""
    clearest = _clearest(found)
    x, white = signal.channels[:, clearest], found.white[:, clearest]
    onsets = onsets_of([edge_of(x, white, span, found.window) for span in spans])
    return np.array([one.time for one in onsets]) / signal.rate, with_shape(x, onsets) / signal.rate


def _clearest(found: Search) -> int:
    """The channel in which the sharpest event stands highest over the noise."""
    return int(np.argmax(np.abs(found.white).max(axis=0)))


def _checked(window: float, signal: Signal) -> float:
    length = len(signal.channels) / signal.rate
    if not 0.0 < window <= length / 10:
        raise InputError(
            f"--window = {window:g} s: expected more than 0 and up to a tenth of the signal "
            f"({length / 10:.3g} s)"
        )
    return window


def _said(found: Search, signal: Signal) -> list[str]:
    """Warnings of a signal that begins within an event, and of three largest samples running."""
    words = ["the signal begins within an event, which was left out"] if found.late else []
    for name, x in zip(signal.names, signal.channels.T, strict=True):
        full = np.abs(x) >= np.abs(x).max() * (1.0 - 1e-12)
        if x.any() and (full[2:] & full[1:-1] & full[:-2]).any():
            words.append(f"{name}: {int(full.sum())} samples clipped at {np.abs(x).max():g}")
    return words


def _no_row(path: Path, n: int, drop_height: Estimate | None) -> str:
    """Warning where no three events make a row; InputError for fewer than two events."""
    if n == 0:
        raise InputError(f"{path}: no impact: nothing rises by {RISE:g} dB out of the noise")
    if n == 1:
        raise InputError(
            f"{path}: one impact alone; a restitution needs three, one after the other"
        )
    if n > 2:
        return f"none of the {n} events make a row of shrinking flights: no restitution"
    if drop_height is None:
        return "two impacts make one flight: no restitution without a third or --drop-height"
    return "two impacts: the restitution is that of the drop height and the one flight"


def _restitution(
    times: NDArray[np.float64],
    sigmas: NDArray[np.float64],
    drop_height: Estimate | None,
    believed: bool,
) -> tuple[Restitution, Estimate | None]:
    """The restitution of a row, and that of its first impact from the drop height."""
    first = None
    if drop_height is not None:
        flight = Estimate(float(times[1] - times[0]), float(np.hypot(*sigmas[:2])), 1)
        first = first_restitution(flight, drop_height)
    if believed:
        return restitution(times, sigmas), first
    if len(times) == 2 and first is not None:
        return Restitution(first.value, first.sigma), first
    return Restitution(None, None), first


def _remarks(found: Restitution, first: Estimate | None, others: NDArray[np.float64]) -> list[str]:
    """Warnings about the value."""
    words = []
    if len(found.per_pair) == 1:
        words.append("three impacts give one ratio: nothing shows whether they are of one body")
    if found.constant_within_noise is False:
        low, high = min(found.per_pair), max(found.per_pair)
        words.append(
            f"one number does not describe the pairs ({low:.4f} to {high:.4f}, p = {found.p:.2g}): "
            "the value is their mean, its sigma from their scatter"
        )
    if len(others):
        listed = ", ".join(f"{t:.4f}" for t in others[:_MOST_LISTED])
        more = ", ..." if len(others) > _MOST_LISTED else ""
        words.append(f"{len(others)} events left out that fit no row of flights: {listed}{more} s")
    if first is not None and found.value is not None and found.per_pair:
        missed = np.log(first.value / found.value) / np.log(found.value)
        if abs(missed) >= 0.5:
            words.append(
                f"drop height and first flight give {first.value:.3f}, not {found.value:.3f}: as "
                f"if {missed:.1f} impacts more came before the first one here (or air slowed the "
                "fall)"
            )
    return words
