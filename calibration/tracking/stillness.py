"""Whether a picture shows that the camera moved as its corners say, rather than stood still.

The background moved so predicts what each pixel should differ by. The picture's own difference,
regressed on that, has slope 1 where the camera moved so and 0 where it stood; noise of the
background, which is in both, adds up to a half to it. What moves in front of the background is
explained by neither, and left out.
"""

import numpy as np

from calibration.tracking.film.reader import Picture
from calibration.tracking.track import Array

_SMOOTH = 1.5  # px: texture is coarser than noise
_SLOPE = 0.75  # halfway between what noise of the background alone gives, and motion
_SIGMAS = 4.0  # by which the slope must be known
_QUIET = 3.0  # medians of the difference that something explains


def shows_motion(picture: Picture, background: Picture, motion: Array) -> bool:
    """Whether `motion` (3, 3), from background to picture, explains how they differ."""
    import cv2

    seen, stood = (
        cv2.GaussianBlur(cv2.cvtColor(one, cv2.COLOR_BGR2GRAY).astype(np.float32), (0, 0), _SMOOTH)
        for one in (picture, background)
    )
    size = (seen.shape[1], seen.shape[0])
    moved = cv2.warpAffine(stood, motion[:2], size, borderMode=cv2.BORDER_REPLICATE)
    still, left = np.abs(seen - stood), np.abs(seen - moved)
    explained = np.minimum(still, left)
    quiet = explained <= _QUIET * float(np.median(explained))
    by = (moved - stood)[quiet]
    power = float(by @ by)
    if power == 0:
        return False
    difference = (seen - stood)[quiet]
    slope = float(by @ difference) / power
    variance = float(np.mean((difference - slope * by) ** 2)) * 4 * np.pi * _SMOOTH**2
    return slope > _SLOPE and slope > _SIGMAS * np.sqrt(variance / power)
