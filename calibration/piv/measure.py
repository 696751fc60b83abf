"""Displacement by either method, and what both refuse."""

import math

import numpy as np
from numpy.typing import NDArray

from calibration.piv.field import Field, Flags
from calibration.piv.pictures import Pixels, grey_levels
from granulab.errors import InputError

LEAST_WINDOW, MOST_OVERLAP = 8, 0.75  # windows that overlap more add nothing, and amplify noise
METHODS = ("piv", "flow")
_LEAST_OF_FLOW = 12  # px of a side, for the patches of OpenCV's DIS


def displacement(
    a: NDArray, b: NDArray, *, window: int = 32, overlap: float = 0.5, mask: NDArray | None = None,
    method: str = "piv",
) -> Field:  # fmt: skip
    """Displacement of the texture of picture a in picture b, on a grid of square windows.

    a, b      (height, width) grey or (height, width, 3) blue, green, red; of one size
    window    side of a window [px]; at least four particles should fit across it, and it
              is the largest displacement along x or y that is found
    overlap   share of its side by which a window overlaps the next, 0 to 0.75
    mask      (height, width) true where the bed is: what does not move with it, such as walls and
              background, must be false; None for everything. A window that is by less than half
              inside it is not measured
    method    'piv', correlation of windows in passes, or 'flow', dense optical flow

    Raises InputError for what is no pair of pictures.
    """
    first, second = grey_levels(a, "a"), grey_levels(b, "b")
    if first.shape != second.shape:
        raise InputError(f"b: {_size(second)} pixels, and a {_size(first)}: not of one size")
    if method not in METHODS:
        raise InputError(f"method = {method!r}: there are {', '.join(METHODS)}")
    _check_windows(first, window, overlap)
    inside = _inside(mask, first)
    if method == "flow":
        if min(first.shape) < _LEAST_OF_FLOW:
            raise InputError(
                f"method = 'flow': {_size(first)} pixels are too few for optical flow, which takes "
                f"{_LEAST_OF_FLOW} x {_LEAST_OF_FLOW} at least; take method 'piv'"
            )
        from calibration.piv.optical_flow import optical_flow

        return optical_flow(first, second, window, overlap, inside)
    from calibration.piv.passes import piv

    return piv(first, second, window, overlap, inside)


def _check_windows(picture: Pixels, window: int, overlap: float) -> None:
    if not LEAST_WINDOW <= window <= min(picture.shape):
        raise InputError(
            f"window = {window} px: must be from {LEAST_WINDOW} to the lesser side of the picture, "
            f"which has {_size(picture)} pixels"
        )
    if not (math.isfinite(overlap) and 0 <= overlap <= MOST_OVERLAP):
        raise InputError(f"overlap = {overlap}: must be from 0 to {MOST_OVERLAP}, 0.5 for half")


def _inside(mask: NDArray | None, picture: Pixels) -> Flags:
    if mask is None:
        return np.ones(picture.shape, dtype=bool)
    inside = np.asarray(mask, dtype=bool)
    if inside.shape != picture.shape:
        raise InputError(f"mask: shape {inside.shape}, and the pictures have {picture.shape}")
    if not inside.any():
        raise InputError("mask: leaves nothing to measure")
    return inside


def _size(picture: Pixels) -> str:
    return f"{picture.shape[1]} x {picture.shape[0]}"
