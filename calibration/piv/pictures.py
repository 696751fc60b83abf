"""Pictures and masks from files, and their texture: grey levels less their local mean.

Uneven light and the edges of layers are larger than particles and would outweigh them.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granulab.errors import InputError


def read_picture(path: Path) -> NDArray:
    """(height, width) or (height, width, 3) grey levels as they are stored, 8 or 16 bit.

    Raises InputError, one line, for what is no picture.
    """
    import cv2

    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # our own line says it
    try:
        data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    picture = None
    if len(data):
        try:
            picture = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
        except cv2.error:  # a size in the head that no memory holds
            picture = None
    if picture is None:
        raise InputError(f"{path}: no picture that can be read (bmp, png, tif, jpg, ...)")
    return np.asarray(picture)


def read_mask(path: Path) -> NDArray[np.bool_]:
    """(height, width) true where a picture is white, brighter than half of its brightest pixel."""
    levels = read_picture(path)
    if levels.ndim == 3:
        levels = levels[:, :, :3].max(axis=2)
    return np.asarray(levels > levels.max() / 2)


Pixels = NDArray[np.float32]
Flags = NDArray[np.bool_]


class Texture(NamedTuple):
    """Grey levels without structures larger than a window, and the weight of each pixel, 0 or 1."""

    grey: Pixels
    weight: Pixels


def texture(picture: NDArray, mask: Flags, window: int) -> Texture:
    """The texture of a grey picture where mask is true: less the mean over about a window.

    The mean is that of a Gaussian of standard deviation window/4: what is longer than 1.6 windows
    (2 pi window/4) is taken away, what is shorter stays.
    """
    import cv2

    weight = mask.astype(np.float32)
    grey = np.asarray(picture, dtype=np.float32) * weight
    sigma = window / 4.0
    if mask.all():
        mean = cv2.GaussianBlur(grey, (0, 0), sigma)
    else:
        area = cv2.GaussianBlur(weight, (0, 0), sigma)
        mean = cv2.GaussianBlur(grey, (0, 0), sigma) / np.maximum(area, np.float32(1e-6))
    return Texture((grey - mean) * weight, weight)


def grey_levels(picture: NDArray, name: str) -> Pixels:
    """(height, width) float32 of a grey or a blue, green, red picture; InputError for others."""
    levels = np.asarray(picture)
    if levels.dtype == bool or not np.issubdtype(levels.dtype, np.number):
        raise InputError(f"{name}: {levels.dtype} is no picture; grey levels are numbers")
    if levels.ndim == 3 and levels.shape[2] in (3, 4):
        # the luma of ITU-R BT.601, as all readers make grey of colours
        levels = levels[:, :, :3] @ np.array([0.114, 0.587, 0.299], dtype=np.float32)
    if levels.ndim != 2:
        raise InputError(f"{name}: an array of shape {levels.shape} is no picture")
    levels = levels.astype(np.float32)
    if not np.isfinite(levels).all():
        raise InputError(f"{name}: grey levels that are not finite")
    return np.asarray(levels)
