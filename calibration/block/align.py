"""A block's shift in each frame, from all of its picture.

A corner of the block is seen with what is behind it, which stays: while the block has moved by less
than a pixel the corner seems to lag. So its picture as a whole, down to the plate's edge, is
compared with its mean over many frames, in which noise, and what is behind its outline, go out:

    seen(x) = gain mean(x) + light(x) - gain d.grad mean(x)

by least squares, until the shift d that remains is nothing (Baker and Matthews 2004, doi
10.1023/B:VISI.0000011205.11775.fd). light(x) is linear: a lamp lights some parts of a plate more.
"""

import numpy as np
from numpy.typing import NDArray

from calibration.block.edge import Edge
from calibration.flow.survey import to_grey
from calibration.tracking.film.reader import Film
from calibration.tracking.track import Array
from granulab.errors import InputError

_STEPS = 4
_FEWEST = 50  # pixels of a block, for six unknowns in noise
_LEAST_GAIN = 0.5  # of a block's contrast, by which a picture shows it
_FARTHEST = 4.0  # px by which a block may be off its guess: twice a blurred outline
_OUTLINE = 2  # px about the corners, in which the block's outline is blurred
_OFF_PLATE = 3.0  # px over the plate's edge, as far as a lens blurs it: 2.5 of 1.2 px


def mean_picture(film: Film, number: Array, motion: Array) -> Array:
    """(h, w) mean brightness of these frames, each moved back to the first by motion (n, 3, 3).

    NaN where most frames show nothing.
    """
    total = np.zeros((film.height, film.width))
    count = np.zeros_like(total)
    rows = {int(n): k for k, n in enumerate(number)}
    for frame in film.some(rows):
        grey = to_grey(frame.picture).astype(np.float32)
        seen = _back(grey, motion[rows[frame.number]], (0, 0, film.width, film.height))
        there = np.isfinite(seen)
        total[there] += seen[there]
        count += there
    return np.where(count > len(number) / 2, total / np.maximum(count, 1), np.nan)


def block_shifts(
    film: Film, number: Array, motion: Array, expected: Array, picture: Array, corners: Array,
    edge: Edge,
) -> Array:  # fmt: skip
    """(n, 2) x, y by which the block has moved on its plate, along the first picture [px].

    number     (n,) of the frames
    motion     (n, 3, 3) of the plate since the first picture
    expected   (n, 2) the shift but for a pixel or two; where it is NaN, it goes on as before
    picture    (h, w) mean of the block, moved back to where it is in the first picture
    corners    (c, 2) of the block in the first picture
    NaN where the block is not seen as a whole.
    """
    mask = _mask(picture, corners, edge)
    if mask.sum() < _FEWEST:
        raise InputError(f"{film.path}: the block is too small, or lies below its plate's edge")
    block = _Block(picture, mask)
    out = np.full((len(number), 2), np.nan)
    rows = {int(n): k for k, n in enumerate(number)}
    last, step = np.zeros(2), np.zeros(2)
    for frame in film.some(rows):
        k = rows[frame.number]
        guess = expected[k] if np.isfinite(expected[k]).all() else last + step
        grey = to_grey(frame.picture).astype(np.float32)
        out[k] = block.shift(grey, motion[k], guess)
        if np.isfinite(out[k]).all():
            last, step = out[k], out[k] - last
        else:
            last = guess
    return out


class _Block:
    """The mean picture of a block, and what of it is compared."""

    def __init__(self, picture: Array, mask: NDArray[np.bool_]) -> None:
        y, x = np.nonzero(mask)
        self._box = int(x.min()), int(y.min()), int(np.ptp(x)) + 1, int(np.ptp(y)) + 1
        self._inside = y - self._box[1], x - self._box[0]
        slopes: list[Array] = list(np.gradient(picture))
        down, across = (slope[mask] for slope in slopes)
        light = [np.ones(len(x)), x - x.mean(), y - y.mean()]
        self._solve = np.linalg.pinv(np.column_stack([across, down, picture[mask], *light]))

    def shift(self, grey: NDArray[np.float32], motion: Array, guess: Array) -> Array:
        """(2,) shift in a picture from a guess on; NaN where the block is not seen."""
        shift = guess.copy()
        for _ in range(_STEPS):
            moved = motion.copy()
            moved[:2, 2] += moved[:2, :2] @ shift
            seen = _back(grey, moved, self._box)[self._inside]
            if not np.isfinite(seen).all():
                return np.full(2, np.nan)
            across, down, gain = (self._solve @ seen)[:3]
            if not _LEAST_GAIN < gain < 1 / _LEAST_GAIN:
                return np.full(2, np.nan)
            shift = shift - np.array([across, down]) / gain
        return shift if np.linalg.norm(shift - guess) < _FARTHEST else np.full(2, np.nan)


def _mask(picture: Array, corners: Array, edge: Edge) -> NDArray[np.bool_]:
    """(h, w) the block: the hull of its corners, with its outline, but for the plate."""
    import cv2

    mask = np.zeros(picture.shape, np.uint8)
    hull = cv2.convexHull(np.rint(corners).astype(np.int32))
    cv2.fillConvexPoly(mask, hull, 1)
    size = 2 * _OUTLINE + 1
    mask = np.asarray(cv2.dilate(mask, np.ones((size, size), np.uint8)))
    along = edge.ends[1] - edge.ends[0]
    y, x = np.mgrid[: picture.shape[0], : picture.shape[1]]
    below = along[0] * (y - edge.ends[0, 1]) - along[1] * (x - edge.ends[0, 0])
    over = -np.sign(along[0]) * below / np.hypot(*along)
    mask[over < _OFF_PLATE] = 0
    for side in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):  # no gradient there
        mask[side] = 0
    return (mask > 0) & np.isfinite(np.hypot(*np.gradient(picture)))


def _back(grey: NDArray[np.float32], motion: Array, box: tuple[int, int, int, int]) -> Array:
    """(h, w) part of the first picture, x, y, w, h, as a frame shows it; NaN beyond the frame."""
    import cv2

    x, y, w, h = box
    matrix = motion[:2].copy()
    matrix[:, 2] += matrix[:, :2] @ [x, y]
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    seen = cv2.warpAffine(grey, matrix, (w, h), flags=flags, borderMode=cv2.BORDER_CONSTANT,
                          borderValue=float("nan"))  # fmt: skip
    return np.asarray(seen, dtype=float)
