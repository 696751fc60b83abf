"""Points of the material that are followed from picture to picture.

Each is followed by the flow of its surroundings (pyramidal Lucas and Kanade, as OpenCV has it),
forwards and back again. One that does not come back to where it was, or that moves otherwise than
its neighbours (median test: Westerweel and Scarano, Exp. Fluids 39 (2005) 1096), is carried on by
the median of its neighbours. So all points are kept, and with them where they began.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.flow.silo import Silo, changes
from calibration.flow.survey import Grey, Labels, Survey, Tones, to_grey
from granulab.errors import InputError

Points = NDArray[np.float32]

_RETURN = 1.0  # px by which a point may miss its beginning after there and back
_WINDOW = 2 / 3  # of a particle: what a window sees should mostly be of one particle
_SMALLEST = 7  # px
_NEIGHBOURS = 8
_MEDIAN_LIMIT = 3.0  # residuals over the neighbours' median residual
_FLOOR = 0.1  # px of noise that is allowed in addition (as in the reference)
_LEVELS = 3  # halvings of the picture: steps of eight times half a window are found
_STOP = (3, 20, 0.03)  # iterations or px


class Tracers:
    """Points (n, 2) [px, pixel k from k to k + 1], and the variance of each [px^2]."""

    def __init__(self, start: Points, particle: float) -> None:
        self.start = start.astype(np.float32)
        self.position = self.start.copy()
        self.variance = np.zeros(len(start))
        self.alive = np.ones(len(start), dtype=bool)
        self._window = max(round(_WINDOW * particle) | 1, _SMALLEST)

    def follow(self, before: Grey, after: Grey) -> None:
        """Move all points that are alive as the picture does."""
        import cv2

        live = np.flatnonzero(self.alive)
        if len(live) <= _NEIGHBOURS:
            self.alive[:] = False
            return
        at = (self.position[live] - np.float32(0.5))[:, None]  # OpenCV counts from pixels' middles
        size = self._window, self._window
        there, found, _ = cv2.calcOpticalFlowPyrLK(
            before, after, at, at.copy(), winSize=size, maxLevel=_LEVELS, criteria=_STOP
        )
        back, again, _ = cv2.calcOpticalFlowPyrLK(
            after, before, there, at.copy(), winSize=size, maxLevel=_LEVELS, criteria=_STOP
        )
        miss = np.hypot(*(back - at)[:, 0].T)
        good = (found[:, 0] > 0) & (again[:, 0] > 0) & (miss < _RETURN)
        step, variance = _carried((there - at)[:, 0], self.position[live], miss, good)
        self.position[live] += step
        self.variance[live] = np.square(np.sqrt(self.variance[live]) + np.sqrt(variance))

    def drop(self, gone: NDArray[np.bool_]) -> None:
        """Follow these points (n,) no longer."""
        self.alive &= ~gone


def _carried(
    step: Points, position: Points, miss: NDArray[np.float32], good: NDArray[np.bool_]
) -> tuple[Points, NDArray[np.float64]]:
    """Steps with those that are bad replaced by their neighbours' median, and their variance.

    A good step's error is half of what there and back is off, in each direction a root of two less.
    """
    from scipy.spatial import cKDTree

    known = np.flatnonzero(good)
    if len(known) <= _NEIGHBOURS:
        return np.zeros_like(step), np.full(len(step), _RETURN**2)
    _, near = cKDTree(position[known]).query(position, k=_NEIGHBOURS + 1)
    around = step[known][near]
    median = np.median(around, axis=1)
    residual = np.median(np.linalg.norm(around - median[:, None], axis=2), axis=1)
    off = np.linalg.norm(step - median, axis=1)
    bad = ~good | (off > _MEDIAN_LIMIT * (residual + _FLOOR))
    variance = np.where(bad, np.square(residual + _FLOOR), np.square(miss) / 4)
    return np.where(bad[:, None], median, step).astype(np.float32), variance


Floats = NDArray[np.float64]

_FEWEST = 3  # tracers that make a mean with a scatter


class Steps(NamedTuple):
    """Tracers between two pictures [px, px^2]: midway (n, 2), steps (n, 2), variances (n,)."""

    midway: Floats
    step: Floats
    variance: Floats

    def means(self, x: Floats, y: Floats, side: float) -> tuple[Floats, Floats, Floats]:
        """(ny, nx) mean steps along x and y, and the variance of either, in windows about x and y.

        The tracers of a window are those of a few particles: they err together. How the window is
        covered by them is chance: that part of the variance is their scatter over their number.
        """
        count = self._sums(np.ones(len(self.step)), x, y, side)
        n = np.where(count >= _FEWEST, count, np.nan)
        u, v = (self._sums(part, x, y, side) / n for part in self.step.T)
        squares = self._sums(np.square(self.step).sum(axis=1), x, y, side) / n
        scatter = np.maximum(squares - u**2 - v**2, 0.0) / 2
        return u, v, self._sums(self.variance, x, y, side) / n + scatter / n

    def _sums(self, values: Floats, x: Floats, y: Floats, side: float) -> Floats:
        """(ny, nx) sums over windows, which overlap by half: two cells of half a side each way."""
        edges = [np.append(at - side / 2, at[-1] + np.array([0.0, side / 2])) for at in (y, x)]
        down, across = self.midway[:, 1], self.midway[:, 0]
        cells, _, _ = np.histogram2d(down, across, bins=edges, weights=values)
        return np.asarray(cells[1:, 1:] + cells[:-1, 1:] + cells[1:, :-1] + cells[:-1, :-1])


Mask = NDArray[np.bool_]

_ROUGH = 0.5  # of the usual roughness of moving material: walls and doors are plain
_PER_PARTICLE = 3  # tracers across a particle
_CLOSEST = 2.0  # px between tracers


def material_mask(seen: Survey, silo: Silo, tones: Tones, labels: Labels, particle: float) -> Mask:
    """Pixels (height, width) of the silo's inside where there is material or it passes.

    What changes from the first picture to the last; and what is as rough as that in the tones of
    the material and lies still in patches larger than a particle.
    """
    import cv2

    _, moved = changes(seen, tones.limit(seen.noise))
    inside = np.zeros(moved.shape, dtype=bool)
    inside[silo.box] = True
    moved &= inside
    side = max(round(particle / 2), 3)
    grey = to_grey(seen.first).astype(np.float32)
    mean = cv2.blur(grey, (side, side))
    rough = np.sqrt(np.maximum(cv2.blur(grey * grey, (side, side)) - mean * mean, 0))
    material = moved & (labels != 2)
    if not material.any():
        return moved
    still = inside & ~moved & (labels != 2) & (rough > _ROUGH * np.median(rough[material]))
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (round(particle) | 1,) * 2)
    patches = cv2.morphologyEx(still.astype(np.uint8), cv2.MORPH_OPEN, kernel).astype(bool)
    closing = np.ones((side, side), np.uint8)
    whole = cv2.morphologyEx((moved | patches).astype(np.uint8), cv2.MORPH_CLOSE, closing)
    return np.asarray(whole.astype(bool) & inside)


def seeds(
    mask: Mask, labels: Labels, silo: Silo, particle: float
) -> tuple[Points, NDArray[np.int64]]:
    """Tracers (n, 2) [px] on a grid over the first picture's material, and the tone of each."""
    step = max(particle / _PER_PARTICLE, _CLOSEST)
    x, y = np.meshgrid(
        np.arange(silo.left + step / 2, silo.left + silo.width, step),
        np.arange(silo.top + step / 2, silo.outlet, step),
    )
    points = np.column_stack([x.ravel(), y.ravel()])
    column, row = np.floor(points).astype(np.int64).T
    tone = labels[row, column]
    use = mask[row, column] & (tone != 2)
    return points[use].astype(np.float32), tone[use]


def outlet_columns(mask: Mask, silo: Silo, particle: float) -> tuple[int, int]:
    """First column and end of what moves or stands in the lowest half particle above the outlet."""
    rows, columns = silo.box
    lowest = mask[rows.stop - max(round(particle / 2), 2) : rows.stop, columns]
    there = np.flatnonzero(lowest.mean(axis=0) > 0.5)
    if len(there) == 0:
        raise InputError("no material stands at the outlet's level: is --roi the silo's inside?")
    return columns.start + int(there[0]), columns.start + int(there[-1]) + 1
