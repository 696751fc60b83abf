"""Where material is in the first picture: what moves later, and grains that stay in dead zones."""

import numpy as np
from numpy.typing import NDArray

from calibration.flow.silo import Silo, changes
from calibration.flow.survey import Survey, to_grey
from calibration.flow.tones import Labels, Tones
from calibration.flow.tracers import Points

Mask = NDArray[np.bool_]

_ROUGH = 0.5  # of the usual roughness of moving material: walls and doors are plain
_PER_GRAIN = 3  # tracers across a grain
_CLOSEST = 2.0  # px between tracers


def material_mask(seen: Survey, silo: Silo, tones: Tones, labels: Labels, grain: float) -> Mask:
    """Pixels (height, width) of the silo's inside where there is material or it passes.

    What changes from the first picture to the last; and what is as rough as that in the tones of
    the material and lies still in patches larger than a grain.
    """
    import cv2

    _, moved = changes(seen, tones.limit(seen.noise))
    inside = np.zeros(moved.shape, dtype=bool)
    inside[silo.box] = True
    moved &= inside
    side = max(round(grain / 2), 3)
    grey = to_grey(seen.first).astype(np.float32)
    mean = cv2.blur(grey, (side, side))
    rough = np.sqrt(np.maximum(cv2.blur(grey * grey, (side, side)) - mean * mean, 0))
    material = moved & (labels != 2)
    if not material.any():
        return moved
    still = inside & ~moved & (labels != 2) & (rough > _ROUGH * np.median(rough[material]))
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (round(grain) | 1,) * 2)
    patches = cv2.morphologyEx(still.astype(np.uint8), cv2.MORPH_OPEN, kernel).astype(bool)
    closing = np.ones((side, side), np.uint8)
    whole = cv2.morphologyEx((moved | patches).astype(np.uint8), cv2.MORPH_CLOSE, closing)
    return np.asarray(whole.astype(bool) & inside)


def seeds(mask: Mask, labels: Labels, silo: Silo, grain: float) -> tuple[Points, NDArray[np.int64]]:
    """Tracers (n, 2) [px] on a grid over the first picture's material, and the tone of each."""
    step = max(grain / _PER_GRAIN, _CLOSEST)
    x, y = np.meshgrid(
        np.arange(silo.left + step / 2, silo.left + silo.width, step),
        np.arange(silo.top + step / 2, silo.outlet, step),
    )
    points = np.column_stack([x.ravel(), y.ravel()])
    column, row = np.floor(points).astype(np.int64).T
    tone = labels[row, column]
    use = mask[row, column] & (tone != 2)
    return points[use].astype(np.float32), tone[use]


def outlet_columns(mask: Mask, silo: Silo, grain: float) -> tuple[int, int]:
    """First column and end of what moves or stands in the lowest half grain above the outlet."""
    rows, columns = silo.box
    lowest = mask[rows.stop - max(round(grain / 2), 2) : rows.stop, columns]
    there = np.flatnonzero(lowest.mean(axis=0) > 0.5)
    if len(there) == 0:
        return columns.start, columns.stop
    return columns.start + int(there[0]), columns.start + int(there[-1]) + 1
