"""Connected parts of a mask by their outlines, which costs far less than a label for each pixel."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.background import Mask

Outline = NDArray[np.int32]  # (n, 1, 2) x, y of pixels


def outlines(mask: Mask) -> list[Outline]:
    """Outer outlines of all connected parts."""
    import cv2

    found: Any = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    around, tree = found
    return [one for k, one in enumerate(around) if tree[0, k, 3] < 0]  # the rest are holes


def pixels_within(outline: Outline) -> float:
    """How many pixels an outline of two and more encloses with its own (Pick's theorem)."""
    import cv2

    return cv2.contourArea(outline) + len(outline) / 2 + 1


def filled(outline: Outline, box: tuple[int, int, int, int]) -> Mask:
    """(height, width) of the box x, y, width, height; 255 within the outline."""
    import cv2

    x, y, w, h = box
    mask = np.zeros((h, w), np.uint8)
    return np.asarray(cv2.drawContours(mask, [outline], -1, 255, cv2.FILLED, offset=(-x, -y)))


def largest(mask: Mask) -> Mask | None:
    """The largest connected part, filled; None where there is nothing."""
    around = outlines(mask)
    if not around:
        return None
    height, width = mask.shape
    return filled(max(around, key=pixels_within), (0, 0, width, height))
