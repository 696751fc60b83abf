"""The time stamps of a film: whether they can be used, and what they say."""

import numpy as np

from calibration.tracking.track import Array

_ABSURD = 1e4  # frames/s: what a header says beyond it is a clock's ticks, no camera of this use
_EVEN = 0.05  # of a step: stamps that stray by less are even; files round them to 1 ms or a tick
_BROKEN = 0.2  # share of stamps that do not go on, from which none is believed


def clean_stamps(
    numbers: list[int], stamps: list[float | None], rate: float | None
) -> tuple[Array | None, list[str]]:
    """(n,) time of each frame [s] or None, and remarks.

    Stamps that do not go on are those of players and cut files: they are put where the steps
    before them say. Even stamps are frame numbers over the rate.
    """
    frame = np.array(numbers, dtype=float)
    known = None if rate is None or not 1 / _ABSURD < rate <= _ABSURD else rate
    remarks = []
    if rate is not None and known is None:
        remarks.append(f"the header's {rate:g} frames/s are not believed; --fps says the camera's")
    even = None if known is None else frame / known
    time = np.array([np.nan if stamp is None else stamp for stamp in stamps], dtype=float)
    if np.isnan(time).any() or known is None or len(time) < 3:
        return even, remarks
    good = _going_on(time)
    if not good.all():
        what = "left aside" if good.mean() < 1 - _BROKEN else "set from the others"
        remarks.append(f"{int((~good).sum())} time stamps do not go on: {what}")
    if good.mean() < 1 - _BROKEN:
        return even, remarks
    step = float(np.median(np.diff(time[good]) / np.diff(frame[good])))
    time = _filled(frame, time, good, step)
    jitter = np.abs(np.diff(time) - step * np.diff(frame))
    if jitter.max() <= max(_EVEN * step, 1.01e-3):
        return even, remarks
    low, high = 1e3 * np.diff(time).min(), 1e3 * np.diff(time).max()
    remarks.append(f"variable time stamps: {low:.4g} to {high:.4g} ms from frame to frame; used")
    return time, remarks


def _going_on(time: Array) -> np.ndarray:
    """Marks of the stamps later than all before them (but for one far ahead of the rest)."""
    good = np.ones(len(time), dtype=bool)
    highest = time[0]
    for k in range(1, len(time)):
        good[k] = time[k] > highest
        highest = max(highest, time[k])
    return good


def _filled(frame: Array, time: Array, good: np.ndarray, step: float) -> Array:
    filled = np.interp(frame, frame[good], time[good])
    last = np.flatnonzero(good)[-1]
    after = np.arange(len(frame)) > last
    filled[after] = time[last] + step * (frame[after] - frame[last])
    return filled
