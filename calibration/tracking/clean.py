"""The background of a film without the object that moves in it, from pictures of all its length.

An object that moves by less than its own size uncovers what is behind it only in part, and where it
lay first it lies no longer: no single picture shows the background. Each pixel of several pictures
shows one colour, or two: the object and what is behind it. The one nearer to what stands beside the
object in the same row is the background (a wall, a plate, level edges). What is never uncovered is
taken from there, too, where it has rather the object's colour.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.film.reader import Film, Picture, Region

_BYTES = 2e8  # of the pictures that are looked at together
_APART = 6.0  # noise by which two colours of a pixel differ, as of an object in background.py
_MEDIAN_OF_LARGEST = 1.26  # of the sizes of three normal deviates
_CODED = 8  # grey levels by which coding may change a pixel that stands still
_BESIDE = 8  # px beside what moves that show what is behind it
_ABOUT = 2  # px by which blur widens an object
_FEWEST = 3  # pictures in which a pixel shows its other colour
_SEVERAL = 8  # pictures at least

Mask = NDArray[np.bool_]
Colours = NDArray[np.float32]  # (h, w, 3)


class _Two(NamedTuple):
    """Colours of each pixel: the one it shows most, the other one; and whether it has two."""

    often: Colours
    seldom: Colours
    two: Mask


def clean_background(film: Film, region: Region) -> Picture | None:
    """(height, width, 3) of the region; None where too few pictures show it, or nothing moves."""
    pictures = _sampled(film, region)
    if pictures is None:
        return None
    seen = _two_colours(pictures)
    found = seen.often.copy()
    for box in _boxes(seen.two):
        part = _Two(seen.often[box], seen.seldom[box], seen.two[box])
        beside = _beside(seen, box)
        if beside is not None:
            found[box] = _uncovered(part, beside)
    return np.asarray(np.rint(found), dtype=np.uint8) if seen.two.any() else None


def _sampled(film: Film, region: Region) -> NDArray[np.uint8] | None:
    """(k, h, w, 3) pictures evenly spaced over the film; None where there are too few."""
    most = int(_BYTES / (3 * region.width * region.height))
    every = max(-(-film.count // max(most, 1)), 1)
    y, x = slice(region.y, region.y + region.height), slice(region.x, region.x + region.width)
    found = []
    for frame in film.frames():
        if frame.number % every == 0:
            found.append(frame.picture[y, x].copy())
        if len(found) > 2 * most:  # the header does not know how many there are
            return None
    return np.stack(found) if len(found) >= _SEVERAL else None


def _two_colours(pictures: NDArray[np.uint8]) -> _Two:
    often = np.median(pictures, axis=0).astype(np.float32)
    middle = often.astype(np.int16)
    off = np.stack([np.abs(one - middle).max(axis=2).astype(np.uint8) for one in pictures])
    noise = float(np.median(off)) / _MEDIAN_OF_LARGEST
    farthest = np.partition(off, -_FEWEST, axis=0)[-_FEWEST]
    two = np.asarray(farthest > max(_APART * noise, _CODED))
    other = off > farthest / 2  # bright pixels have more noise, which is no colour of its own
    seldom = often.copy()
    shown = pictures[:, two].astype(np.float32)  # (k, pixels, 3)
    shown[~other[:, two]] = np.nan
    seldom[two] = np.nanmedian(shown, axis=0)
    return _Two(often, seldom, two)


def _boxes(two: Mask) -> list[tuple[slice, slice]]:
    """Rows and columns of each connected part of what moves, and what blur adds to it."""
    import cv2

    wide = 2 * _ABOUT + 1
    mask = cv2.dilate(two.astype(np.uint8), np.ones((wide, wide), np.uint8))
    _, _, parts, _ = cv2.connectedComponentsWithStats(mask)
    return [(slice(y, y + h), slice(x, x + w)) for x, y, w, h, _ in parts[1:].tolist()]


def _beside(seen: _Two, box: tuple[slice, slice]) -> Colours | None:
    """Colours of a box as they go on from its left to its right side; None without either.

    Where it reaches the picture's edge, they are those at the edge; a row that something crosses
    there is as the rows above and below it.
    """
    rows, columns = box
    width = columns.stop - columns.start
    left, right = max(columns.start, _BESIDE), min(columns.stop, seen.two.shape[1] - _BESIDE)
    sides = (slice(left - _BESIDE, left), slice(right, right + _BESIDE))
    known = (np.where(seen.two[rows, x, None], np.nan, seen.often[rows, x]) for x in sides)
    there = [one for one in map(_of_rows, known) if one is not None]
    if not there:
        return None
    left, right = there[0], there[-1]
    share = ((np.arange(width) + 0.5) / width)[None, :, None]
    return np.asarray(left[:, None] * (1 - share) + right[:, None] * share, dtype=np.float32)


def _of_rows(known: Colours) -> Colours | None:
    """(h, 3) median of each row's pixels that are known; None where no row has one."""
    has = np.isfinite(known[:, :, 0]).any(axis=1)
    if not has.any():
        return None
    at = np.flatnonzero(has)
    level = np.nanmedian(known[at], axis=1)
    every = np.arange(len(known))
    return np.stack([np.interp(every, at, level[:, k]) for k in range(3)], axis=1)


def _uncovered(part: _Two, beside: Colours) -> Colours:
    """Background of a box: of two colours the one that goes on from beside it.

    Where both are near to that, the object's own colour, as the others show it, decides.
    """
    swapped = part.two & (_off(part.seldom, beside) < _off(part.often, beside))
    for _ in range(2):
        other = np.where(swapped[:, :, None], part.often, part.seldom)
        object_ = np.median(other[part.two], axis=0)
        as_they_are = _off(part.often, beside) + _off(part.seldom, object_)
        swapped = part.two & (_off(part.seldom, beside) + _off(part.often, object_) < as_they_are)
    background = np.where(swapped[:, :, None], part.seldom, part.often)
    hidden = _off(background, object_) < _off(background, beside)
    return np.asarray(np.where(hidden[:, :, None], beside, background), dtype=np.float32)


def _off(one: Colours, other: Colours) -> Colours:
    """(h, w) squares of the distances between two colours."""
    return np.asarray(np.sum((one - other) ** 2, axis=2), dtype=np.float32)
