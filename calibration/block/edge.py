"""The straight edge of a plate in a picture: where brightness changes most across it.

Brightness is averaged over short stretches along the edge; across it, the place of the steepest
change is that of a parabola through its largest three values. A straight line through all places is
fitted robustly, its sigma from how they scatter. The picture is the mean of many, turned back to
where the plate is in the first: noise and what passes behind the plate go out of it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.statistics.robust import MEDIAN_TO_SIGMA, robust_fit
from calibration.statistics.shared_noise import covariances, of_parameters
from calibration.tracking.track import Array

_TURN = np.radians(3.0)  # by which the direction expected may be off
_STEPS = 61  # of directions within it: one pixel over 600
_STRETCH = 8  # px along the edge in which brightness is averaged: a few spots of its texture
_NEAR = 4  # px about a line in which the edge is looked for
_UPPER = 0.5  # of the clearest row's change, by which a row above it is the plate's upper edge
_CLEAR = 6.0  # standard deviations of a median of stretches that make an edge, of 1000 tried
_OF_MEDIAN = 1.2533  # sqrt(pi/2): of a median, in those of a mean
_LEVEL = 0.5  # grey levels a pixel: no change is known better
_FEWEST = 4  # stretches of a line
_STRAIGHT = 1.5  # px from the line within which a stretch shows it
_MOST = 0.5  # share of the stretches that must


class Edge(NamedTuple):
    """A straight line in a picture.

    angle   of its direction, from x to y [rad], within half a turn about the direction expected
    sigma   of it [rad]
    ends    (2, 2) its first and last point [px]
    """

    angle: float
    sigma: float
    ends: Array


def find_edge(
    picture: Array, origin: Array, direction: float, along: tuple[float, float], depth: float
) -> Edge | None:
    """The clearest edge nearly along a direction [rad] from x to y; None where there is none.

    picture   (h, w) brightness
    origin    (2,) x, y from which `along`, from and to, and `depth`, downwards, count [px]; the
              edge is followed on beyond `along`
    """
    steps = np.linspace(-_TURN, _TURN, _STEPS)
    strips = [_Strip(picture, origin, direction + step, along, depth) for step in steps]
    best = max(strips, key=_Strip.change)
    return best.line() if best.clear() else None


class _Strip:
    """Part of a picture, turned so that its rows run along a direction."""

    def __init__(
        self, picture: Array, origin: Array, direction: float, along: tuple[float, float],
        depth: float,
    ) -> None:  # fmt: skip
        import cv2

        self.direction = direction
        x = np.array([np.cos(direction), np.sin(direction)])
        y = np.array([-x[1], x[0]]) * (1.0 if x[0] >= 0 else -1.0)  # downwards
        count = max(int((along[1] - along[0]) / _STRETCH), _FEWEST)
        more = count // 2  # stretches on either side, as far as which the edge may go on
        self._known = more, more + count
        self._axes = np.column_stack([x, y, origin + (along[0] - more * _STRETCH) * x])
        size = (count + 2 * more) * _STRETCH, max(int(depth), 2 * _NEAR + 3)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        strip = cv2.warpAffine(
            picture.astype(np.float32), self._axes, size, flags=flags,
            borderMode=cv2.BORDER_CONSTANT, borderValue=float("nan"),
        )  # fmt: skip
        parts = np.asarray(strip).reshape(size[1], -1, _STRETCH)
        smooth = cv2.GaussianBlur(parts.mean(axis=2), (0, 0), 0.01, sigmaY=1.0)
        self._change = np.gradient(np.asarray(smooth, dtype=float), axis=0)  # (rows, stretches)

    def change(self) -> float:
        """Change across the clearest row [grey levels a pixel]; 0 where none is in the picture."""
        return float(np.nan_to_num(np.abs(self._rows())).max())

    def clear(self) -> bool:
        """True if the clearest row's change is beyond what stretches without an edge scatter by."""
        rows = np.abs(np.nan_to_num(self._rows()))
        row = self._change[int(rows.argmax()), slice(*self._known)]
        row = row[np.isfinite(row)]
        if not len(row):
            return False
        scatter = MEDIAN_TO_SIGMA * float(np.median(np.abs(row - np.median(row))))
        return bool(rows.max() > _CLEAR * _OF_MEDIAN * max(scatter, _LEVEL) / np.sqrt(len(row)))

    def _rows(self) -> Array:
        """(rows,) the median change of the stretches, NaN where most are out of the picture."""
        known = self._change[:, slice(*self._known)]
        few = np.isfinite(known).mean(axis=1) < _MOST
        change = np.where(few[:, None], 0.0, known)
        return np.where(few, np.nan, np.nanmedian(change, axis=1))

    def line(self) -> Edge | None:
        """The line along the clearest row; None where too few stretches show it."""
        x = (np.arange(self._change.shape[1]) + 0.5) * _STRETCH - 0.5
        y = self._offsets()
        first, end = self._known
        inside = np.arange(first, end)[np.isfinite(y[first:end])]
        if len(inside) < _FEWEST:
            return None
        beta, sigma, off = _straight(x[inside], y[inside])
        if np.sum(np.abs(off) < _STRAIGHT) < _MOST * (end - first):
            return None
        whole = self._as_far(np.abs(y - beta[0] - beta[1] * x) < _STRAIGHT, inside)
        beta, sigma, off = _straight(x[whole], y[whole])
        ends = np.array([[at, beta[0] + beta[1] * at] for at in x[whole[[0, -1]]]])
        side = 1.0 if np.cos(self.direction) >= 0 else -1.0
        return Edge(
            float(self.direction + side * np.arctan(beta[1])),
            sigma,
            ends @ self._axes[:, :2].T + self._axes[:, 2],
        )

    def _offsets(self) -> Array:
        """(stretches,) row of the steepest change near the uppermost clear row, NaN for none."""
        rows = self._rows()
        size = np.nan_to_num(np.abs(rows))
        top = int(np.flatnonzero(size > _UPPER * size.max())[0])  # over a plate's lower edge
        row = top + int(np.argmax(size[top : top + _NEAR]))
        low, high = max(row - _NEAR, 1), min(row + _NEAR + 1, len(rows) - 1)
        change = self._change * np.sign(rows[row])
        offset = np.full(change.shape[1], np.nan)
        for k in np.flatnonzero(np.isfinite(change[low - 1 : high + 1]).all(axis=0)):
            offset[k] = _peak(change[:, k], low, high)
        return offset

    def _as_far(self, good: NDArray[np.bool_], inside: NDArray[np.int64]) -> NDArray[np.int64]:
        """The stretches inside, and beyond them those that go on in the same line."""
        first, end = int(inside[0]), int(inside[-1])
        while first > 0 and good[first - 1]:
            first -= 1
        while end < len(good) - 1 and good[end + 1]:
            end += 1
        beyond = [k for k in range(first, end + 1) if k < inside[0] or k > inside[-1]]
        return np.array(sorted([*inside.tolist(), *beyond]))


def _straight(x: Array, y: Array) -> tuple[Array, float, Array]:
    """Offset and slope of a line through points, sigma of the slope, and residuals.

    The texture of the plate, and what is behind it, move the edge alike in stretches nearby. An
    edge that is bent has slopes of which any may be that under the block.
    """
    design = np.column_stack([np.ones_like(x), x])
    beta, _, weights, _ = robust_fit(design, y, least=1e-3)
    off, good = y - design @ beta, weights > 0
    at = (x[good] - x[good].mean()) / max(np.ptp(x[good]), 1e-9)
    bent = np.column_stack([np.ones_like(at), at, at**2 - np.mean(at**2)])
    bow = np.linalg.lstsq(bent, y[good], rcond=None)[0]
    left = y[good] - bent @ bow
    noise = covariances(left, x[good], x[good], [np.arange(good.sum())], bent)
    covariance = of_parameters(bent, noise, np.empty((0, 3)))
    # Its slope is 2 bow at, at from -1/2 to 1/2, besides: a rectangular distribution (GUM 4.3.7).
    bend = max(bow[2] ** 2 - covariance[2, 2], 0.0) / 3
    sigma = np.sqrt(covariance[1, 1] + bend) / max(np.ptp(x[good]), 1e-9)
    return beta, float(sigma), off


def _peak(change: Array, low: int, high: int) -> float:
    """Row of the largest value in rows low to high - 1, NaN where it lies at their ends."""
    k = low + int(np.argmax(change[low:high]))
    before, at, after = change[k - 1 : k + 2]
    bend = before - 2 * at + after
    if k in (low, high - 1) or bend >= 0:
        return np.nan
    return float(k + (before - after) / (2 * bend))
