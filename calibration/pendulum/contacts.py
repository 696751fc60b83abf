"""Contacts of an object that swings against another: where its velocity reverses at once.

The gap between the two, against time, is cut into parabolas (segments.stretches). At a turning
point of a swing the velocity passes through zero; in a contact it reverses within a frame.
"""

from dataclasses import dataclass

import numpy as np

from calibration.tracking.segments import Stretch, noise, position, speed, stretches
from calibration.tracking.track import Array, Rows
from granulab.errors import InputError

FEWEST = 4  # points of a swing: its position and speed, and two to see noise by
_SEEN = 8  # times the noise that the object must move within a frame's width about a contact
_SHORT = 0.25  # of its neighbours' duration: a stretch that is a contact that takes time
_GAINS = 1.1  # times the speed: less may be the noise of positions that speeds are taken from
SHARE = 0.5  # of the speed of impact: a hand, or another contact, may be nearer to the ends


@dataclass(frozen=True)
class Swings:
    """rows    points of each swing
    before  (n,) swing before each contact
    after   (n,) swing after each contact; the one before the next where nothing came between
    """

    rows: list[Rows]
    before: Rows
    after: Rows


def contacts(t: Array, gap: Array) -> tuple[Array, int]:
    """(n,) rough times of the contacts, and the sign of the speed before them.

    Raises InputError where there is none.
    """
    found = stretches(t, gap)
    step, sigma = float(np.median(np.diff(t))), noise(t, gap)
    contacts = []
    for k, last in enumerate(found[:-1]):
        for one in found[k + 1 : k + 3]:
            if one is not found[k + 1] and not _brief(found[k + 1], last, one):
                continue
            contact = _reversal(last, one, step, sigma)
            if contact is not None:
                contacts.append(contact)
                break
    if not contacts:
        raise InputError(
            "no contact: the velocity reverses within no frame; a swing against a wall, or two "
            "objects on strings, are needed"
        )
    jumps = np.array([jump for _, jump in contacts])
    side = int(np.sign(jumps.sum()))
    times = np.array([time for time, jump in contacts if jump * side > 0])
    return _once(times, step), -side


def _brief(middle: Stretch, last: Stretch, one: Stretch) -> bool:
    return middle.duration < _SHORT * min(last.duration, one.duration)


def _reversal(last: Stretch, one: Stretch, step: float, sigma: float) -> tuple[float, float] | None:
    """Time and jump of the velocity of a contact between two stretches; None where it is none."""
    middle = (last.end + one.start) / 2
    jump = speed(one, middle) - speed(last, middle)
    if jump == 0:
        return None
    time = middle - (position(one, middle) - position(last, middle)) / jump
    if not last.end - 2 * step <= time <= one.start + 2 * step:
        return None
    before, after = speed(last, time), speed(one, time)
    swing = max(abs(last.coefficients[2]), abs(one.coefficients[2])) * step
    least = max(swing, sigma / min(last.duration, one.duration))
    seen = abs(jump) * step > _SEEN * sigma / np.sqrt(min(last.j - last.i, one.j - one.i))
    if before * after < 0 and min(abs(before), abs(after)) > least and seen:
        return time, after - before
    return None


def _once(times: Array, step: float) -> Array:
    """Times that are no nearer than a swing of few points lasts."""
    kept: list[float] = []
    for time in np.sort(times):
        if not kept or time - kept[-1] > (FEWEST + 1) * step:
            kept.append(float(time))
    return np.array(kept)


def found_swings(t: Array, gap: Array) -> tuple[Array, Swings]:
    """The contacts (n,) and the swings about them.

    A first or last contact whose outer swing has too few points is left out.
    Raises InputError where none is left.
    """
    times, sign = contacts(t, gap)
    while len(times):
        found = _swings(t, gap, times, sign)
        few = [k for k, one in enumerate(found.rows) if len(one) < FEWEST]
        if not few:
            return times, found
        times = times[1:] if few[0] == 0 else times[:-1]
    raise InputError(
        f"a swing of {FEWEST} positions before a contact and one after it are needed, and there "
        "are none"
    )


def _swings(t: Array, gap: Array, times: Array, sign: int) -> Swings:
    """The swings before the first contact, between neighbours, and after the last.

    sign   of the speed before a contact
    Points nearer to a contact than half a frame are left out: an exposure may see both swings.
    """
    half = float(np.median(np.diff(t))) / 2
    ends = [-np.inf, *times, np.inf]
    between = [
        np.flatnonzero((t > ends[k] + half) & (t < ends[k + 1] - half))
        for k in range(len(times) + 1)
    ]
    rows, before, after = [_approach(t, gap, between[0], sign)], [0], []
    for k, one in enumerate(between[1:-1]):
        after.append(len(rows))
        if _broken(np.diff(times), k) or _driven(t, gap, one):
            rows += [_fast(t, -sign * gap, one), _approach(t, gap, one, sign)]
        else:
            rows.append(one)
        before.append(len(rows) - 1)
    after.append(len(rows))
    rows.append(_departure(t, gap, between[-1], sign))
    return Swings(rows, np.array(before), np.array(after))


def _broken(durations: Array, k: int) -> bool:
    """True if the object was caught between contacts k and k + 1: far longer than before and after.

    A swing against a wall lasts between half a period and less than one, so less than twice.
    """
    if not 0 < k < len(durations) - 1:
        return False
    return bool(durations[k] > 1.5 * max(durations[k - 1], durations[k + 1]))


def _driven(t: Array, gap: Array, rows: Rows) -> bool:
    """True if the object comes back faster than it left: a swing alone cannot do that."""
    if len(rows) <= 2 * FEWEST:
        return False
    left, back = np.abs(_speed(t, gap, rows)[[0, -1]])
    return bool(back > _GAINS * left and back - left > _SEEN * noise(t, gap) / FEWEST)


def _approach(t: Array, gap: Array, rows: Rows, sign: int) -> Rows:
    """The part before a contact: from half the speed of impact on."""
    return _fast(t, sign * gap, rows[::-1])[::-1]


def _departure(t: Array, gap: Array, rows: Rows, sign: int) -> Rows:
    """The part after a contact: until it comes back with half the speed that it left with."""
    if len(rows) <= FEWEST:
        return rows
    speed = sign * _speed(t, gap, rows)
    back = np.flatnonzero(speed > -SHARE * speed[0])
    return rows[: back[0] + 1] if len(back) and speed[0] < 0 else rows


def _fast(t: Array, gap: Array, rows: Rows) -> Rows:
    """Rows from the contact away, as long as the speed is above half of that at the contact."""
    if len(rows) <= FEWEST:
        return rows
    speed = _speed(t, gap, rows)
    slow = np.flatnonzero(speed < SHARE * speed[0])
    return rows[: slow[0]] if len(slow) else rows


def _speed(t: Array, gap: Array, rows: Rows) -> Array:
    """Slopes of the gap, each over a twentieth of the rows and no fewer than a swing's fewest."""
    m = max(FEWEST, len(rows) // 20) // 2
    i = np.clip(np.arange(len(rows)), m, len(rows) - 1 - m)
    return np.asarray((gap[rows[i + m]] - gap[rows[i - m]]) / (t[rows[i + m]] - t[rows[i - m]]))
