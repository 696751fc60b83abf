"""The time base of a track, checked against free fall: repeated frames, frames left out, stamps.

A flight is one parabola. Where the frames after some moment fit the parabola before it only when
they are moved in time by a whole number of frames, the recording repeated or left out that many.
Nothing can be said about what happens within a contact, or while the object is held.
"""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from calibration.statistics.repeated import repeated
from calibration.tracking.segments import (
    Stretch,
    is_flight,
    noise,
    shared_acceleration,
    speed,
    stretches,
    with_acceleration,
)
from calibration.tracking.track import Array, Rows, Track

_WHOLE = 0.25  # of a frame: how near to a whole number a shift must be
_MOST = 5  # frames at one position
_CURVED = 0.1  # sigma of a stretch's own acceleration over it, for the stretch to show anything
_REPAIRS = 20  # positions in one clip


@dataclass(frozen=True)
class TimeBase:
    """The clock that is used, and what was wrong with the recording's.

    clock               (n,) time of the positions that are kept [frames of the recording]
    rows                (n,) which positions of the track these are
    duplicated_frames   frame numbers that show the picture before them, or that took no time
    dropped_frames      frame numbers before which the recording left out one or more
    remarks             one line each
    """

    clock: Array
    rows: Rows
    duplicated_frames: list[float] = field(default_factory=list)
    dropped_frames: list[float] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def check(track: Track, clock: Array) -> TimeBase:
    """The clock of a track put right where free fall shows that it is not."""
    repeats, late = _repeats(track, clock)
    rows = np.setdiff1d(np.arange(len(clock)), repeats)
    shift = np.zeros(len(clock))
    for k in repeats[late]:
        shift[k:] -= 1
    base = TimeBase((clock + shift)[rows], rows, [float(f) for f in track.frame[repeats]])
    if len(repeats):
        base.remarks.append(
            f"{len(repeats)} positions repeat the one before: left out, "
            f"{int(late.sum())} of them took no time"
        )
    return _put_right(track, base)


def _repeats(track: Track, clock: Array) -> tuple[Rows, NDArray[np.bool_]]:
    """Positions equal to the one before, in flight; and whether the clock ran on in vain.

    In a film a repeated picture, coded again, may give a position off by its noise.
    """
    sigma = noise(clock, track.y)
    step = np.diff(track.y)
    still = np.maximum(np.abs(step), np.abs(np.diff(track.x)))
    alike = np.isin(track.frame[1:], track.repeated)
    return repeated(step, still < np.where(alike, 3, 1e-3) * sigma, sigma)


def _put_right(track: Track, base: TimeBase) -> TimeBase:
    """Shifts by whole frames that make one flight of two stretches, one after the other."""
    for _ in range(_REPAIRS):
        found = _first_shift(base.clock, track.y[base.rows])
        if found is None:
            break
        at, frames = found
        number = float(track.frame[base.rows[at]])
        clock = base.clock + np.where(np.arange(len(base.clock)) >= at, frames, 0)
        kept = (np.arange(len(clock)) >= at) | (clock < clock[at])  # the rest are copies
        base = replace(base, clock=clock[kept], rows=base.rows[kept])
        if frames > 0:
            base.dropped_frames.extend([number] * frames)
        else:
            base.duplicated_frames.extend([number] * -frames)
        what = "left out before" if frames > 0 else "too many up to"
        base.remarks.append(f"{abs(frames)} frames {what} frame {number:g}: free fall shows it")
    return base


def _first_shift(clock: Array, y: Array) -> tuple[int, int] | None:
    """Row and frames of the first position where time was not what the clock says."""
    found = stretches(clock, y)
    acceleration = shared_acceleration(found)
    if acceleration is None:
        return None
    sigma = noise(clock, y)
    for last, one in pairwise(found):
        if is_flight(last, acceleration) and is_flight(one, acceleration):
            frames = _shift(clock, y, last, one, acceleration, sigma)
            if frames:
                return one.i, frames
    return None


def _shift(
    clock: Array, y: Array, last: Stretch, one: Stretch, acceleration: float, sigma: float
) -> int:
    """Whole frames by which the later stretch is late, if that makes one parabola of both.

    It does where one parabola then fits both as well as two do, by the Bayesian criterion for the
    three coefficients that are saved (or but for a thousandth of the misfit that it cures), and
    fits them far worse on the clock as it is.
    """
    if max(last.acceleration_sigma, one.acceleration_sigma) > _CURVED * abs(acceleration):
        return 0
    a = with_acceleration(clock, y, last, acceleration)
    b = with_acceleration(clock, y, one, acceleration)
    middle = (last.end + one.start) / 2
    lag = (speed(b, middle) - speed(a, middle)) / acceleration
    frames = round(lag)
    if frames == 0 or abs(frames) > _MOST or abs(lag - frames) > _WHOLE:
        return 0
    first, then = np.arange(last.i, last.j), np.arange(one.i, one.j)
    both = np.concatenate([first, then])
    moved = np.concatenate([clock[first], clock[then] + frames])
    apart = _squares(clock[first], y[first]) + _squares(clock[then], y[then])
    variance = max(sigma**2, apart / max(len(both) - 6, 1))
    allowed = 3 * np.log(len(both)) * variance
    cured = _squares(clock[both], y[both]) - apart
    left = _squares(moved, y[both]) - apart
    return frames if cured > 4 * allowed and left < max(allowed, 1e-3 * cured) else 0


def _squares(t: Array, y: Array) -> float:
    """Sum of squares about the parabola of points."""
    s = t - t.mean()
    return float(np.sum((y - np.polyval(np.polyfit(s, y, 2), s)) ** 2))
