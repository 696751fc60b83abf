"""The light of a picture as a whole: lamps that flicker, a camera that sets its own exposure."""

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.film.reader import Picture

_SAMPLED = 1024  # pixels or so that tell the light: to a thousandth, where each does to 3 %
_DARK, _BRIGHT = 16, 250  # grey levels between which a pixel is in proportion to the light
_FEWEST = 64  # such pixels in the sample
_ALIKE = 3.0  # scatter about the middle ratio within which a pixel shows what it showed before


def gains(picture: Picture, background: Picture) -> NDArray[np.float64]:
    """(3,) brightness of each channel over that of the background, 1 where it cannot be told.

    The ratio of the sums of those pixels whose own ratio is near the median of all: things that
    move, and edges where the camera does, are not among them.
    """
    step = max(int(np.sqrt(picture[..., 0].size / _SAMPLED)), 1)
    now, was = (
        np.ascontiguousarray(one[::step, ::step].reshape(-1, 3).T) for one in (picture, background)
    )
    return np.array([_gain(now[k], was[k]) for k in range(3)])


def _gain(levels: NDArray[np.uint8], before: NDArray[np.uint8]) -> float:
    inside = (before > _DARK) & (before < _BRIGHT) & (levels > 0) & (levels < _BRIGHT)
    rows = np.flatnonzero(inside)
    if len(rows) < _FEWEST:
        return 1.0
    now, was = (one[rows].astype(np.float32) for one in (levels, before))
    ratio = now / was
    off = np.abs(ratio - _middle(ratio))
    near = np.asarray(off <= _ALIKE * _middle(off), dtype=np.float32)
    return float(now @ near) / float(was @ near)


def _middle(values: NDArray[np.float32]) -> np.float32:
    """The upper median; numpy's own costs several times more."""
    half = len(values) // 2
    return np.float32(np.partition(values, half)[half])


def relit(picture: Picture, factors: NDArray[np.float64]) -> Picture:
    """A picture with its channels divided by these factors."""
    import cv2

    return np.asarray(cv2.transform(picture, np.diag(1 / factors)), dtype=np.uint8)
