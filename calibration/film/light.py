"""The light of a picture as a whole: lamps that flicker, a camera that sets its own exposure."""

import numpy as np
from numpy.typing import NDArray

from calibration.film.reader import Picture

_SAMPLED = 4096  # pixels or so that tell the light; its factor is known to a thousandth by them
_DARK, _BRIGHT = 16, 250  # grey levels between which a pixel is in proportion to the light
_FEWEST = 64  # such pixels in the sample
_ALIKE = 3.0  # scatter about the middle ratio within which a pixel shows what it showed before


def gains(picture: Picture, background: Picture) -> NDArray[np.float64]:
    """(3,) brightness of each channel over that of the background, 1 where it cannot be told.

    The ratio of the sums of those pixels whose own ratio is near the median of all: things that
    move, and edges where the camera does, are not among them.
    """
    step = max(int(np.sqrt(picture[..., 0].size / _SAMPLED)), 1)
    now, was = (one[::step, ::step].reshape(-1, 3).astype(float) for one in (picture, background))
    return np.array([_gain(now[:, k], was[:, k]) for k in range(3)])


def _gain(now: NDArray[np.float64], was: NDArray[np.float64]) -> float:
    inside = (was > _DARK) & (was < _BRIGHT) & (now > 0) & (now < _BRIGHT)
    if np.count_nonzero(inside) < _FEWEST:
        return 1.0
    now, was = now[inside], was[inside]
    ratio = now / was
    middle = np.median(ratio)
    off = np.abs(ratio - middle)
    near = off <= _ALIKE * np.median(off)
    return float(now[near].sum() / was[near].sum())


def relit(picture: Picture, factors: NDArray[np.float64]) -> Picture:
    """A picture with its channels divided by these factors."""
    import cv2

    levels = np.arange(256)[:, None] / factors[None, :]
    table = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
    return np.asarray(cv2.LUT(picture, table[None, :, :]), dtype=np.uint8)
