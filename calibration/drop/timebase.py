"""The time base of a track, checked against free fall: repeated frames, frames left out, stamps.

A flight is one parabola. Where the frames after some moment fit the parabola before it only when
they are moved in time by a whole number of frames, the recording repeated or left out that many.
Nothing can be said about what happens within a contact, or while the object is held.
"""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from calibration.statistics.repeated import pattern, repeated, still
from calibration.tracking.segments import (
    Stretch,
    is_flight,
    misfit,
    noise,
    shared_acceleration,
    speed,
    stretches,
    third_differences,
    with_acceleration,
)
from calibration.tracking.track import Array, Rows, Track

_WHOLE = 0.25  # of a frame: how near to a whole number a shift must be
_MOST = 5  # frames at one position
_AROUND = 10  # positions on either side of a frame lost that show it
_LONGEST = 10  # frames of which a converter leaves out one
_FEW = 8  # positions: a third difference takes four
_MOST_OF = 0.75  # of third differences: fewer are free of a frame lost in ten, or of a contact
_CURVED = 0.1  # sigma of a stretch's own acceleration over it, for the stretch to show anything
_REPAIRS = 20  # positions in one clip
_LIKELIER = 2 * np.log(20)  # of misfit: one in twenty by chance


@dataclass(frozen=True)
class TimeBase:
    """The clock that is used, and what was wrong with the recording's.

    clock               (n,) time of the positions that are kept [frames of the camera]
    rows                (n,) which positions of the track these are
    duplicated_frames   frame numbers that show the picture before them, or that took no time
    dropped_frames      frame numbers before which the recording left out one or more
    remarks             one line each
    lost                frames lost per frame seen, which may be lost within contacts as well
    share               camera's frames per frame of the recording; a unit of clock is one of these
    """

    clock: Array
    rows: Rows
    duplicated_frames: list[float] = field(default_factory=list)
    dropped_frames: list[float] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    lost: float = 0.0
    share: float = 1.0


def check(track: Track, clock: Array) -> TimeBase:
    """The clock of a track put right where free fall shows that it is not."""
    steps = np.maximum(np.abs(np.diff(track.y)), np.abs(np.diff(track.x)))
    found = pattern(track.frame, steps)
    if found is not None:
        return _put_right(track, _thinned(track, clock, *found))
    return _put_right(track, _decimated(track, clock) or _without_copies(track, clock))


def _thinned(track: Track, clock: Array, period: int, at: int) -> TimeBase:
    """The clock without the copies of a regular pattern, those before which a frame was lost too.

    A converter put them in (the pictures that are left are even in time), or they took the place
    of lost frames (the clock goes on): even, unless the flights are the likelier for the latter.
    """
    rows = np.flatnonzero(track.frame % period != at)
    copies = np.floor((track.frame - at) / period)  # up to each frame, but for a constant
    even = (clock[0] + track.frame - track.frame[0] - (copies - copies[0]))[rows]
    left, on = _misfits(track.y[rows], even, clock[rows])
    share = (period - 1) / period
    words = f"of every {period} pictures one repeats that before: left out"
    repeats = [float(f) for f in np.delete(track.frame, rows)]
    if left > on + _LIKELIER:
        remark = f"{words}; each took the place of a lost frame, as free fall shows"
        return TimeBase(clock[rows], rows, repeats, remarks=[remark])
    remark = f"{words}; the camera took {share:.4g} of the pictures per second that the file says"
    return TimeBase(even, rows, repeats, remarks=[remark], share=share)


def _misfits(y: Array, *clocks: Array) -> list[float]:
    """Of the same positions with each clock, by the noise of the smoothest."""
    sigma = min(noise(clock, y) for clock in clocks)
    return [misfit(clock, y, sigma) for clock in clocks]


def _without_copies(track: Track, clock: Array) -> TimeBase:
    """The clock without copies that stand here and there.

    All took no time, none did (the camera ran on), or each as the step after it says, whichever
    makes the flights likeliest: the last decides once for every copy.
    """
    repeats, late, doubtful = _repeats(track, clock)
    rows = np.setdiff1d(np.arange(len(clock)), repeats)
    if not len(repeats):
        return TimeBase(clock, rows)
    ways = [late, np.ones(len(late), dtype=bool), np.zeros(len(late), dtype=bool)]
    clocks = [(clock - np.cumsum(np.bincount(repeats[way], minlength=len(clock))))[rows]
              for way in ways]  # fmt: skip
    costs = np.array(_misfits(track.y[rows], *clocks))
    if not (late.all() or not late.any()):
        costs[0] += 2 * np.log(2) * len(late)
    best = int(np.argmin(costs))
    spent = len(late) - int(ways[best].sum())
    if ways[best].all():
        clock, rows = _without_doubtful(clocks[best], track.y, rows, doubtful)
    else:
        clock = clocks[best]
    left_out = np.setdiff1d(np.arange(len(track.y)), rows)
    lost = f", {spent} the place of a lost frame" if spent else ""
    remark = (
        f"{len(left_out)} positions repeat the one before: left out, "
        f"{len(left_out) - spent} of them took no time{lost}"
    )
    hidden = int(ways[best].sum()) / len(rows)
    return TimeBase(
        clock, rows, [float(f) for f in track.frame[left_out]], remarks=[remark], lost=hidden
    )


def _without_doubtful(clock: Array, y: Array, rows: Rows, doubtful: Rows) -> tuple[Array, Rows]:
    """Clock and rows without those copies, about an apex or a contact, that flights do not fit."""
    sigma = noise(clock, y[rows])
    for k in doubtful:
        at = int(np.searchsorted(rows, k))
        part = np.arange(max(at - _AROUND, 0), min(at + _AROUND, len(rows)))
        t, z = clock[part], y[rows[part]]
        less = np.delete(t - (part > at), at - part[0]), np.delete(z, at - part[0])
        if misfit(t, z, sigma) - misfit(*less, sigma) > _LIKELIER + 2 * np.log(len(rows)):
            clock = np.delete(clock - (np.arange(len(clock)) > at), at)
            rows = np.delete(rows, at)
    return clock, rows


def _repeats(track: Track, clock: Array) -> tuple[Rows, NDArray[np.bool_], Rows]:
    """Positions equal to the one before in flight; whether the clock ran on in vain; doubtful ones.

    In a film a repeated picture, coded again, may give a position off by its noise. That is the
    noise of the others: copies among four positions spoil their third difference.
    """
    step = np.diff(track.y)
    size = np.maximum(np.abs(step), np.abs(np.diff(track.x)))
    alike = np.isin(track.frame[1:], track.repeated)
    copy = np.concatenate([[False], still(size) & (alike | (track.radius is None))])
    without, y = (clock - np.cumsum(copy))[~copy], track.y[~copy]
    sigma = min(noise(clock[~copy], y), noise(without, y))
    same = size < np.where(alike, 3, 1e-3) * sigma
    found, late = repeated(step, same, sigma)
    return found, late, np.setdiff1d(np.flatnonzero(same) + 1, found)


def _put_right(track: Track, base: TimeBase) -> TimeBase:
    """Shifts by whole frames that make one flight of two stretches, one after the other."""
    put_back: list[float] = []
    for _ in range(_REPAIRS):
        y = track.y[base.rows]
        found = _first_shift(base.clock, y) or _gap(base.clock, y)
        if found is None:
            break
        at, frames = found
        number = float(track.frame[base.rows[at]])
        clock = base.clock + np.where(np.arange(len(base.clock)) >= at, frames, 0)
        kept = (np.arange(len(clock)) >= at) | (clock < clock[at])  # the rest are copies
        base = replace(base, clock=clock[kept], rows=base.rows[kept])
        if frames > 0:
            put_back.extend([number] * frames)
        else:
            base.duplicated_frames.extend([number] * -frames)
        what = "left out before" if frames > 0 else "too many up to"
        base.remarks.append(f"{abs(frames)} frames {what} frame {number:g}: free fall shows it")
    return _doubted(base, put_back)


def _doubted(base: TimeBase, put_back: list[float]) -> TimeBase:
    """The same with how often frames are lost: as often within contacts, where none can be seen."""
    return replace(
        base, dropped_frames=sorted([*base.dropped_frames, *put_back]),
        lost=base.lost + len(put_back) / max(len(base.clock) - 1, 1),
    )  # fmt: skip


def _decimated(track: Track, clock: Array) -> TimeBase | None:
    """The clock with a frame lost at even distances, where flights are far likelier so."""
    frame, y = track.frame, track.y
    if len(y) < 3 * _FEW or np.any(frame != np.round(frame)):
        return None
    patterns = [(period, at) for period in range(2, _LONGEST + 1) for at in range(period)]
    lost = [np.floor((frame - at) / period) for period, at in patterns]
    clocks = [clock + one - one[0] for one in lost]
    rough = [np.quantile(third_differences(one, y), _MOST_OF) for one in clocks]
    best = int(np.argmin(rough))
    as_it_is, put_back = _misfits(y, clock, clocks[best])
    if as_it_is - put_back < _LIKELIER + 2 * np.log(len(patterns)):
        return None
    period, at = patterns[best]
    share = (period + 1) / period
    numbers = np.arange(frame[0] + 1, frame[-1] + 1)
    remark = (
        f"a frame is lost before one of every {period} pictures, as free fall shows: put back; the "
        f"camera took {share:.4g} of the pictures per second that the file says"
    )
    dropped = [float(f) for f in numbers[numbers % period == at]]
    rows = np.arange(len(y))
    return TimeBase(clocks[best], rows, [], dropped, [remark], share=share)


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


def _gap(clock: Array, y: Array) -> tuple[int, int] | None:
    """Row and number of the frames lost that best make one flight across that row; None for none.

    What is gained must be more than the best of so many rows and numbers gains by chance, and half
    a frame less or more must fit worse: what bends a path otherwise asks for no whole frames.
    """
    found, sigma = stretches(clock, y), noise(clock, y)
    acceleration = shared_acceleration(found)
    if acceleration is None:
        return None
    ends = np.array([k for one in found for k in (one.i, one.j)])
    near = np.unique(ends[:, None] + np.arange(-2, 3)[None, :])
    best, gained = None, _LIKELIER + 2 * np.log(len(y) * _MOST)
    for k in near[(near > 1) & (near < len(y) - 1)]:
        part = np.arange(max(k - _AROUND, 0), min(k + _AROUND, len(y)))
        t, z, later = clock[part], y[part], part >= k
        possible = _lags(clock, y, int(k), acceleration, sigma)
        plain = misfit(t, z, sigma) if possible else 0.0
        for frames in possible:
            gain = plain - misfit(t + frames * later, z, sigma)
            if gain > gained and _flies_on(t + frames * later, z, int(k - part[0]), acceleration):
                halves = [misfit(t + (frames + h) * later, z, sigma) for h in (-0.5, 0.5)]
                if plain - min(halves) < gain - _LIKELIER:
                    best, gained = (int(k), frames), gain
    return best


def _lags(clock: Array, y: Array, k: int, acceleration: float, sigma: float) -> list[int]:
    """Numbers of frames lost before row k that three points on either side allow.

    The speed of three points one frame apart is known to sigma/sqrt(2).
    """
    speeds = []
    for part in (slice(max(k - 3, 0), k), slice(k, k + 3)):
        s = clock[part] - clock[k]
        if len(s) < 2:
            return []
        speeds.append(np.polyfit(s, y[part] - acceleration * s**2 / 2, 1)[0])
    lag = (speeds[1] - speeds[0]) / acceleration
    slack = 0.5 + 4 * sigma / abs(acceleration)
    return [frames for frames in range(1, _MOST + 1) if abs(frames - lag) < slack]


def _flies_on(t: Array, y: Array, k: int, acceleration: float) -> bool:
    """True if two points and more on either side of row k are in one flight."""
    return any(
        one.i + 1 < k < one.j - 1 and is_flight(one, acceleration) for one in stretches(t, y)
    )


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
