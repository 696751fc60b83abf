"""Bodies of one look in a row: more than two of them are a chain, whose impulses pass through.

In Newton's cradle the ball that strikes comes to rest and another one leaves, without the two ever
having met: neither Newton's restitution of two bodies nor eq. 3.6 describes that. A body that
swings is compared with its frame, at the moment at which it moves least: what hangs beside it with
the same look is a body of the same kind.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.film.reader import Film, Picture
from calibration.tracking.track import Track
from granulab.errors import InputError

_MOST = 12  # tracks whose look is searched for, of those that go farthest
_ALIKE = 0.8  # coefficient of correlation of pictures of one look: two thirds of their variance
_LEAST = 4.0  # px of a radius: a smaller body has no look
_USUAL = 10  # weight of an unusual size: a tenth off is as bad as the usual speed
_APART = 1.5  # radii: two matches that are nearer are one body
_LEVEL = 1.0  # radii by which bodies that hang side by side may differ in height
_FEWEST = 12  # positions of a body: two swings and a contact, as in objects.py
_MOVES = 0.05  # of the widest range: what moves less is no body that swings, as there
_LINEAR = 0.98  # of the variance of x that another x explains where the two are on one body
_TWO = 2  # bodies that the laws of this test are about


class _Seen(NamedTuple):
    """Frame, x, y and radius [px] of a body where it moves least."""

    frame: int
    x: float
    y: float
    radius: float


def refuse_chain(film: Film, tracks: Sequence[Track]) -> None:
    """InputError where more than two bodies of one look hang side by side in a film."""
    count = bodies_alike(film, tracks)
    if count > _TWO:
        raise InputError(f"{film.path}: {_words(count)}; film two of them alone")


def refuse_more_than_two(tracks: Sequence[Track]) -> None:
    """InputError where more than two of these tracks are bodies that move, each in its own way.

    A shadow or another point of a body moves with it: x of one is linear in x of the other.
    """
    own: list[Track] = []
    for track in sorted((one.seen() for one in tracks), key=_width, reverse=True):
        if len(track.frame) < _FEWEST or _width(track) < _MOVES * _width((own or [track])[0]):
            continue
        if not any(_as_one(track, other) for other in own):
            own.append(track)
    if len(own) > _TWO:
        names = ", ".join(sorted(repr(one.name) for one in own))
        raise InputError(f"{_words(len(own))} ({names}); name two that meet with --track")


def _words(count: int) -> str:
    return (
        f"at least {count} bodies swing side by side (a Newton's cradle?): restitution is that of "
        "two, or of a ball and a wall, and an impulse that passes through a chain is neither"
    )


def _width(track: Track) -> float:
    return float(np.subtract(*np.percentile(track.x, [99.5, 0.5]))) if len(track.x) else 0.0


def _as_one(one: Track, other: Track) -> bool:
    """True if two are never seen together, or x of one is linear in x of the other."""
    _, here, there = np.intersect1d(one.frame, other.frame, return_indices=True)
    x, z = one.x[here], other.x[there]
    if len(here) < _FEWEST or np.ptp(x) == 0 or np.ptp(z) == 0:
        return True
    return bool(np.corrcoef(x, z)[0, 1] ** 2 > _LINEAR)


def bodies_alike(film: Film, tracks: Sequence[Track]) -> int:
    """The most bodies of one look, side by side or swinging from there, in any of a few frames."""
    seen = [one for track in tracks[:_MOST] if (one := _slowest(track)) is not None]
    if not seen:
        return 0
    pictures = {f.number: f.picture.copy() for f in film.some({one.frame for one in seen})}
    return max(
        (_in_a_row(pictures[one.frame], one) for one in seen if one.frame in pictures), default=0
    )


def _slowest(track: Track) -> _Seen | None:
    """At the end of a swing, where it turns: neither blurred nor touching its neighbour."""
    if track.radius is None or len(track.frame) < 3:
        return None
    usual = float(np.median(track.radius))
    if usual < _LEAST:
        return None
    speed = np.hypot(np.gradient(track.x, track.frame), np.gradient(track.y, track.frame))
    off = np.abs(np.log(track.radius / usual))
    k = int(np.argmin(speed / max(float(np.median(speed)), 1e-9) + _USUAL * off))
    camera = (0.0, 0.0) if track.camera is None else track.camera[k]
    return _Seen(
        int(track.frame[k]), float(track.x[k] + camera[0]), float(track.y[k] + camera[1]),
        float(track.radius[k]),
    )  # fmt: skip


def _in_a_row(picture: Picture, body: _Seen) -> int:
    """The number of bodies like this one, with those that hang level; 0 for a part of a string.

    A part of a string is like the parts above and below it.
    """
    import cv2

    half = round(body.radius)
    row, column = round(body.y), round(body.x)
    look = picture[max(row - half, 0) : row + half + 1, max(column - half, 0) : column + half + 1]
    if look.shape[:2] != (2 * half + 1, 2 * half + 1):
        return 0
    found = _peaks(np.asarray(cv2.matchTemplate(picture, look, cv2.TM_CCOEFF_NORMED)), half)
    down, across = (found - [row - half, column - half]).T / body.radius
    above = (np.abs(down) > _LEVEL) & (np.abs(down) < 2 * _APART) & (np.abs(across) < _APART)
    if above.any() or len(down) < 2:
        return 0 if above.any() else 1
    level = np.abs(down[1:, None] - down[None, 1:]) <= _LEVEL
    return 1 + int(level.sum(axis=1).max())


def _peaks(match: NDArray[np.float32], half: int) -> NDArray[np.intp]:
    """(n, 2) rows and columns of the matches, the best first."""
    found: list[tuple[int, int]] = []
    left, reach = match.copy(), round(_APART * half)
    while True:
        row, column = np.unravel_index(int(left.argmax()), left.shape)
        if left[row, column] < _ALIKE:
            return np.array(found, dtype=np.intp).reshape(-1, 2)
        found.append((int(row), int(column)))
        left[max(row - reach, 0) : row + reach + 1, max(column - reach, 0) : column + reach + 1] = 0
