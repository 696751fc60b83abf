"""Markers: dots drawn on the two blocks, found in the first frame and followed through the film.

A dot is darker than what is around it. Its position is the centroid of the darkness against the
median of a ring around it, from a quarter of its depth on: to some hundredths of a pixel.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.film.reader import Film, Picture, Progress
from calibration.tracking.track import Array
from granulab.errors import InputError

_SIZES = 1.5 * 2 ** (np.arange(7) / 2)  # px: standard deviations of the filter; dots of 2 to 17 px
_CLEAR = 0.5  # of the darkest dots, which others must have
_LEVELS = 12.0  # grey levels by which a dot is darker than what is around it, at least
_ROUND = 0.6  # least over largest standard deviation of a dot's darkness
_LOW = 0.25  # of a dot's depth, from which its pixels count
_RING = 2.0  # radii: outer edge of the ring that says how bright it is around a dot
_LOST = 0.5  # of a dot's depth in the first frame, below which it is not seen
_SEEN = 0.9  # share of the frames in which a marker is seen that is used
_MOST = 0.5  # radii that a dot may move from one frame to the next


@dataclass(frozen=True)
class Dots:
    """Markers through a film.

    frame      (n,) frame numbers
    time       (n,) time stamps [s]; NaN where the film has none
    x, y       (n, m) positions, y down [px]; NaN where a dot is not seen
    radius     (m,) [px]
    """

    frame: Array
    time: Array
    x: Array
    y: Array
    radius: Array


def find(picture: Picture) -> Array:
    """(m, 3) x, y and radius of the dots of a picture, from left to right; may be empty.

    Largest responses of the scale-normalised Laplacian of a Gaussian (Lindeberg 1998, doi
    10.1023/A:1008045108935): a dot of radius r has its own at the standard deviation r/sqrt(2).
    """
    import cv2

    grey = _grey(picture)
    stack = np.array([
        size**2 * np.asarray(cv2.Laplacian(cv2.GaussianBlur(grey, (0, 0), size), cv2.CV_32F))
        for size in _SIZES
    ])  # fmt: skip
    best = stack.max(axis=0)
    top = best == np.asarray(cv2.dilate(best, np.ones((9, 9), np.uint8)))
    rows, columns = np.nonzero(top & (best > _LEVELS))
    found = []
    for row, column in zip(rows, columns, strict=True):
        radius = float(_SIZES[stack[:, row, column].argmax()] * np.sqrt(2))
        dot = _centroid(grey, float(column), float(row), radius)
        if dot is not None and dot[3] > _ROUND:
            found.append((dot[0], dot[1], radius, dot[2]))
    if not found:
        return np.empty((0, 3))
    dots = np.array(found)
    dots = dots[dots[:, 3] > _CLEAR * np.quantile(dots[:, 3], 0.9)]
    return _one_each(dots[np.argsort(dots[:, 0])])


def _one_each(dots: Array) -> Array:
    """Dots without a second mention of the same, x, y, radius."""
    kept: list[Array] = []
    for one in dots:
        if all(np.hypot(*(one[:2] - other[:2])) > max(one[2], other[2]) for other in kept):
            kept.append(one)
    return np.array(kept)[:, :3]


def follow(film: Film, progress: Progress | None = None) -> Dots:
    """All dots of the first frame through a film.

    Raises InputError where there is none, or none is seen to the end.
    """
    numbers, stamps, places = [], [], []
    dots: Array | None = None
    depth: Array = np.empty(0)
    last: Array = np.empty((0, 2))
    for frame in film.frames():
        grey = _grey(frame.picture)
        if dots is None:
            dots = find(frame.picture)
            if not len(dots):
                raise InputError(
                    f"{film.path}: no markers: no dark round dots of 4 to 34 px across in the "
                    "first frame; draw them on both blocks"
                )
            last = dots[:, :2].copy()
            depth = np.full(len(dots), np.nan)
        now = np.full((len(dots), 2), np.nan)
        for k in range(len(dots)):
            x, y = float(last[k, 0]), float(last[k, 1])
            one = _centroid(grey, x, y, float(dots[k, 2]))
            if one is None:
                continue
            depth[k] = one[2] if np.isnan(depth[k]) else depth[k]
            near = np.hypot(one[0] - x, one[1] - y) < max(_MOST * dots[k, 2], 1.0)
            if near and one[2] > _LOST * depth[k]:
                now[k] = last[k] = one[:2]
        numbers.append(frame.number)
        stamps.append(np.nan if frame.stamp is None else frame.stamp)
        places.append(now)
        if progress is not None and film.count:
            progress(frame.number / film.count, f"frame {frame.number} of {film.count}")
    assert dots is not None
    at = np.array(places)
    kept = np.isfinite(at[:, :, 0]).mean(axis=0) > _SEEN
    if not kept.any():
        raise InputError(f"{film.path}: none of {len(kept)} markers is seen to the end")
    at = at[:, kept]
    return Dots(
        np.array(numbers, dtype=float), np.array(stamps), at[:, :, 0], at[:, :, 1], dots[kept, 2]
    )


def _grey(picture: Picture) -> NDArray[np.float32]:
    import cv2

    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), dtype=np.float32)


def _centroid(
    grey: NDArray[np.float32], near_x: float, near_y: float, radius: float
) -> tuple[float, float, float, float] | None:
    """x, y, depth [grey levels] and roundness of the dot near a position; None where none is."""
    x, y = near_x, near_y
    for _ in range(2):
        reach = int(np.ceil(_RING * radius))
        column, row = round(x), round(y)
        top = row - reach
        left = column - reach
        if top < 0 or left < 0 or row + reach >= grey.shape[0] or column + reach >= grey.shape[1]:
            return None
        part = grey[top : row + reach + 1, left : column + reach + 1]
        ys: Array = np.arange(top, row + reach + 1, dtype=float)[:, None]
        xs: Array = np.arange(left, column + reach + 1, dtype=float)[None, :]
        away = np.hypot(xs - x, ys - y)
        around = float(np.median(part[(away > 1.5 * radius) & (away <= _RING * radius)]))
        dark = np.where(away <= 1.5 * radius, around - part, 0.0)
        depth = float(np.quantile(dark[away <= 0.7 * radius], 0.8))
        if depth < _LEVELS / 2:
            return None
        weight = np.clip(dark / depth - _LOW, 0.0, 1 - _LOW)
        whole = float(weight.sum())
        x = float((weight * xs).sum() / whole)
        y = float((weight * ys).sum() / whole)
    dx, dy = xs - x, ys - y
    spread = np.array([
        [(weight * dx * dx).sum(), (weight * dx * dy).sum()],
        [(weight * dx * dy).sum(), (weight * dy * dy).sum()],
    ])  # fmt: skip
    small, large = np.linalg.eigvalsh(spread)
    return x, y, depth, float(np.sqrt(max(small, 0.0) / large))
