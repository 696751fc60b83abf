"""First look at a film: how it begins and ends, its noise, repeated frames; and its three tones.

The tones are two of the material, painted and bare, and that of the backing that it uncovers.
"""

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


def survey(film: Film, report: Callable[[float], None] = lambda part: None) -> Survey:
    """Read a film once; InputError where it has too few frames."""
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
        report(frame.number / film.count if film.count else 0.0)
    if first is None or last is None or len(deviations) + 1 < _FEWEST:
        count = len(deviations) + (last is not None)
        raise InputError(f"{film.path}: {count} frames; this takes {_FEWEST} at least")
    # Codecs leave pixels alone where nothing moves; a grey level is what they round to.
    noise = max(float(np.median(deviations)), 1.0)
    return Survey(len(deviations) + 1, first, last[0], noise, repeated, _uneven(stamps))


def clock_warnings(film: Film, seen: Survey) -> list[str]:
    """Lines on what is wrong with a film's frames and their times."""
    warnings = []
    if seen.uneven:
        warnings.append("the time stamps are uneven; an even clock was used")
    if seen.repeated:
        warnings.append(f"{seen.repeated} frames repeat the one before")
    if film.corrupt:
        warnings.append(f"{len(film.corrupt)} frames could not be decoded and were left out")
    return warnings


def to_grey(picture: Picture) -> Grey:
    """Brightness (height, width) of a picture in blue, green and red."""
    import cv2

    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)


def _differences(one: Grey, other: Grey) -> NDArray[np.float64]:
    """Number of pixels that differ by 0, 1, ... 255 grey levels."""
    import cv2

    apart = cv2.absdiff(one, other)
    return np.asarray(cv2.calcHist([apart], [0], None, [256], [0, 256]).ravel(), np.float64)


def _deviation(counts: NDArray[np.float64]) -> float:
    """Standard deviation of a pixel from the differences of two pictures, by grey level."""
    below = np.cumsum(counts)
    k = int(np.searchsorted(below, below[-1] / 2))
    under = below[k - 1] if k else 0
    # Grey levels are whole numbers: where in its bin the median lies follows from the counts.
    median = k - 0.5 + (below[-1] / 2 - under) / max(counts[k], 1)
    return MEDIAN_TO_SIGMA * max(median, 0.0) / np.sqrt(2)


def _uneven(stamps: list[tuple[int, float]]) -> bool:
    if len(stamps) < _FEWEST:
        return False
    number, stamp = np.array(stamps, dtype=float).T
    step, start = np.polyfit(number, stamp, 1)
    return bool(step > 0 and np.abs(stamp - start - step * number).max() > _EVEN * step)


Labels = NDArray[np.int64]

_SAMPLE = 20_000  # pixels of each picture that are looked at
_GROWTH = 0.02  # of the inside that must be uncovered for the backing to be known
_MEDIAN = 5  # px over which a picture is smoothed before its tones are found


@dataclass(frozen=True)
class Tones:
    """colours (3, 3), blue, green, red: dark and light material, backing; backing None if unseen.

    spread    of the colours of a tone about it [grey levels], root mean square
    """

    colours: NDArray[np.float32]
    backing: int | None
    spread: float

    @property
    def contrast(self) -> float:
        """Difference of the backing and the nearer tone of the material [grey levels]."""
        apart = np.linalg.norm(self.colours[:2] - self.colours[2], axis=1)
        return float(apart.min())

    def limit(self, noise: float) -> float:
        """Difference of colours [grey levels] that are of different objects: half of the contrast.

        Five standard deviations of the difference of two pictures with `noise` at least. The noise
        alone will not do: a codec leaves still pixels alone, and about a strong edge it is off by
        many times what changes there from frame to frame.
        """
        clear = CLEAR * noise * np.sqrt(2)
        return clear if self.backing is None else max(self.contrast / 2, clear)

    def stands(self, rows: Picture, behind: Picture, noise: float) -> NDArray[np.bool_]:
        """Columns (width,) in most of whose rows material hides what is behind it.

        Pixel by pixel, by half of the contrast there: at the outlet the backing ends, and what is
        seen below may be of any tone; by the spread of a tone at least, by which particles differ.
        """
        back = behind.astype(np.float32)
        half = np.linalg.norm(back[..., None, :] - self.colours[:2], axis=-1).min(axis=-1) / 2
        limit = np.maximum(half, max(self.spread, CLEAR * noise * np.sqrt(2)))
        differs = np.linalg.norm(rows.astype(np.float32) - back, axis=-1) > limit
        return np.asarray(np.median(differs, axis=0) > 0.5)

    def labels(self, picture: Picture) -> Labels:
        """Tone of each pixel (height, width): the nearest; 0 dark, 1 light, 2 backing."""
        import cv2

        smooth = cv2.medianBlur(picture, _MEDIAN).astype(np.float32)
        apart = [np.square(smooth - colour).sum(axis=2) for colour in self.colours]
        return np.argmin(apart, axis=0)


def find_tones(seen: Survey, box: tuple[slice, slice]) -> Tones:
    """Three tones in a part of the first and last picture; the one that grows is the backing."""
    import cv2

    rows, columns = box
    parts = [
        cv2.medianBlur(p, _MEDIAN)[rows, columns].reshape(-1, 3) for p in (seen.first, seen.last)
    ]
    random = np.random.default_rng(0)
    pick = [random.choice(len(p), min(len(p), _SAMPLE), replace=False) for p in parts]
    sample = np.concatenate([p[k] for p, k in zip(parts, pick, strict=True)]).astype(np.float32)
    cv2.setRNGSeed(0)
    none = np.zeros((len(sample), 1), np.int32)  # to begin with
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 50, 0.1)
    inertia, label, centres = cv2.kmeans(sample, 3, none, stop, 5, cv2.KMEANS_PP_CENTERS)
    half = len(pick[0])
    share = [np.bincount(part, minlength=3) / len(part) for part in np.split(label.ravel(), [half])]
    growth = share[1] - share[0]
    grown = int(growth.argmax())
    others = sorted((k for k in range(3) if k != grown), key=lambda k: float(centres[k].sum()))
    backing = 2 if growth[grown] > _GROWTH else None
    order = [*others, grown]
    return Tones(
        np.asarray(centres[order], np.float32), backing, float(np.sqrt(inertia / len(sample)))
    )
