"""Pictures and masks from files."""

from pathlib import Path

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
