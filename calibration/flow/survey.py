"""A first look at a film, frame by frame: how it begins and ends, its noise, repeated frames."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.statistics.robust import MEDIAN_TO_SIGMA
from calibration.tracking.film.reader import Film, Picture
from granulab.errors import InputError

Grey = NDArray[np.uint8]

CLEAR = 5.0  # standard deviations of the noise that make a change
_FEWEST = 5  # frames of a film in which something flows
_EVEN = 0.25  # of a frame: how far time stamps may stray from an even clock


@dataclass(frozen=True)
class Survey:
    """count       frames that can be read
    first, last   pictures
    noise         standard deviation of a pixel from frame to frame [grey levels]
    repeated      frames equal to the one before
    uneven        whether the time stamps are not those of an even clock
    """

    count: int
    first: Picture
    last: Picture
    noise: float
    repeated: int
    uneven: bool


def survey(film: Film, tell: Callable[[float], None] = lambda part: None) -> Survey:
    """Read a film once; InputError where it has too few frames for a flow."""
    first = last = None
    deviations, stamps, repeated = [], [], 0
    for frame in film.frames():
        grey = to_grey(frame.picture)
        if last is not None:
            counts = _differences(grey, last[1])
            repeated += int(counts[0] == grey.size)
            deviations.append(_deviation(counts))
        else:
            first = frame.picture
        last = frame.picture, grey
        if frame.stamp is not None:
            stamps.append((frame.number, frame.stamp))
        tell(frame.number / film.count if film.count else 0.0)
    if first is None or last is None or len(deviations) + 1 < _FEWEST:
        count = len(deviations) + (last is not None)
        raise InputError(f"{film.path}: {count} frames; a flow takes {_FEWEST} at least")
    # Codecs leave pixels alone where nothing moves; a grey level is what they round to.
    noise = max(float(np.median(deviations)), 1.0)
    return Survey(len(deviations) + 1, first, last[0], noise, repeated, _uneven(stamps))


def clock_warnings(film: Film, seen: Survey) -> list[str]:
    """What is wrong with a film's frames and their times, a line each."""
    told = []
    if seen.uneven:
        told.append("the time stamps are uneven; an even clock was used")
    if seen.repeated:
        told.append(f"{seen.repeated} frames repeat the one before")
    if film.corrupt:
        told.append(f"{len(film.corrupt)} frames could not be decoded and were left out")
    return told


def to_grey(picture: Picture) -> Grey:
    """Brightness (height, width) of a picture in blue, green and red."""
    import cv2

    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)


def _differences(one: Grey, other: Grey) -> NDArray[np.float64]:
    """How many pixels differ by 0, 1, ... 255 grey levels."""
    import cv2

    apart = cv2.absdiff(one, other)
    return np.asarray(cv2.calcHist([apart], [0], None, [256], [0, 256]).ravel(), np.float64)


def _deviation(counts: NDArray[np.float64]) -> float:
    """Of one picture's pixels, from the differences of two, counted by grey level."""
    below = np.cumsum(counts)
    k = int(np.searchsorted(below, below[-1] / 2))
    under = below[k - 1] if k else 0
    # Grey levels are whole numbers: where in its bin the median lies is told by the counts.
    median = k - 0.5 + (below[-1] / 2 - under) / max(counts[k], 1)
    return MEDIAN_TO_SIGMA * max(median, 0.0) / np.sqrt(2)


def _uneven(stamps: list[tuple[int, float]]) -> bool:
    if len(stamps) < _FEWEST:
        return False
    number, stamp = np.array(stamps, dtype=float).T
    step, start = np.polyfit(number, stamp, 1)
    return bool(step > 0 and np.abs(stamp - start - step * number).max() > _EVEN * step)
