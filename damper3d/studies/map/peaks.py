"""Peaks of the efficiency along Gamma: which stand out of the noise, where they lie, how surely.

All of it looks at eta against ln Gamma at one frequency, each eta with the half width of its
interval, which stands for the noise (0 or NaN: none known).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

DIGITS = 4  # to which a new Gamma is rounded: it names runs


@dataclass(frozen=True)
class Peak:
    """A local maximum of eta along Gamma.

    gamma, efficiency    the vertex of the parabola
    low, high            between which Gamma lies by the noise of the parabola's points, cut at the
                         bracket; the noise also chooses the points, so of 95 % intervals that
                         stand for the noise 80 to 93 % hold the peak (tried on made data)
    bracket              the nearest points on both sides that lie below the largest eta by more
                         than noise: a peak with one maximum lies between, whatever its shape
    half_width           of the efficiency: that of the largest eta, or the median
    prominence           how far the largest eta stands over the higher of the two lowest points
                         towards the next higher peak or the end on each side
    index                of the largest eta
    """

    gamma: float
    low: float
    high: float
    efficiency: float
    half_width: float
    prominence: float
    index: int
    bracket: tuple[float, float]


def highest(peaks: Iterable[Peak]) -> Peak | None:
    """The peak of the largest efficiency; None where there is none."""
    return max(peaks, key=lambda peak: peak.efficiency, default=None)


def find_peaks(gamma: ArrayLike, efficiency: ArrayLike, half_width: ArrayLike) -> list[Peak]:
    """Local maxima above noise, from the least Gamma up; arrays (n,), Gamma rising.

    A maximum counts where its prominence exceeds the noise of a difference: the root of the sum
    of the squares of the half widths of the maximum and of that lowest point. A half width below
    the median is not believed: of three packings, some agree by chance. The first and the last
    point are no maxima: what rises to the end of a grid has its peak beyond it.
    """
    if len(np.asarray(gamma)) < 3:
        return []  # of a map stopped early: an answer without seconds of imports
    from scipy.signal import find_peaks as maxima
    from scipy.signal import peak_prominences

    gamma, eta = np.asarray(gamma, float), np.asarray(efficiency, float)
    noise = np.nan_to_num(np.asarray(half_width, float))
    noise = np.maximum(noise, np.median(noise)) if noise.size else noise
    tops, _ = maxima(eta)
    prominences, left, right = peak_prominences(eta, tops)
    lowest = np.where(eta[left] > eta[right], left, right)
    found = []
    for top, prominence, low in zip(tops, prominences, lowest, strict=True):
        if prominence > np.hypot(noise[top], noise[low]):
            found.append(_located(gamma, eta, noise, int(top), float(prominence)))
    return found


def between(gamma: ArrayLike, efficiency: ArrayLike, half_width: ArrayLike) -> list[float]:
    """The Gammas at which to compute next, so that each peak is bracketed twice as closely.

    The middles, in ln Gamma, of the intervals on both sides of each peak's largest eta, rounded
    to DIGITS digits; none where rounding leaves nothing between. Of a function with one maximum
    between the neighbours of the largest point, n such rounds leave both intervals 2^-n of what
    they were, with the maximum in them.
    """
    gamma = np.asarray(gamma, float)
    added = []
    for peak in find_peaks(gamma, efficiency, half_width):
        for low in (peak.index - 1, peak.index):
            middle = float(f"{np.sqrt(gamma[low] * gamma[low + 1]):.{DIGITS}g}")
            if gamma[low] < middle < gamma[low + 1]:
                added.append(middle)
    return sorted(set(added))


def _located(gamma: Floats, eta: Floats, noise: Floats, top: int, prominence: float) -> Peak:
    """A peak by the least-squares parabola through the points about its top.

    They are those within its bracket: with closer ones alone, the noise would bend the parabola.
    Without noise these are the three best points.
    """
    first, last = (_below(eta, noise, top, side) for side in (-1, 1))
    chosen = slice(first, last + 1)
    x = np.log(gamma[chosen] / gamma[top])
    vertex, error, height = _vertex(x, eta[chosen], noise[chosen])
    vertex = float(np.clip(vertex, x[0], x[-1]))
    limits = np.clip([vertex - error, vertex + error], x[0], x[-1])
    low, high = (float(gamma[top] * np.exp(limit)) for limit in limits)
    return Peak(
        float(gamma[top] * np.exp(vertex)), low, high, height, float(noise[top]), prominence, top,
        (float(gamma[first]), float(gamma[last])),
    )  # fmt: skip


def _below(eta: Floats, noise: Floats, top: int, side: int) -> int:
    """The nearest point on a side that is below the top by more than noise; else the lowest met."""
    for k in _walk(top, side, len(eta)):
        if eta[k] > eta[top]:  # another peak begins
            return k - side
        if eta[top] - eta[k] > np.hypot(noise[top], noise[k]):
            return k
    return 0 if side < 0 else len(eta) - 1


def _walk(top: int, side: int, n: int) -> Iterator[int]:
    k = top + side
    while 0 <= k < n:
        yield k
        k += side


def _vertex(x: Floats, y: Floats, noise: Floats) -> tuple[float, float, float]:
    """Vertex of the least-squares parabola, its half width from the noise of y, its height.

    y = a + b x + c x^2 has its vertex at -b/2c; the coefficients are linear in y, so its
    derivatives to y follow. Where the parabola opens upwards nothing is known: infinite.
    """
    design = np.vander(x, 3, increasing=True)
    solve = np.linalg.pinv(design)
    a, b, c = solve @ y
    if c >= 0:
        return 0.0, np.inf, float(y.max())
    to_y = -solve[1] / (2 * c) + b * solve[2] / (2 * c**2)
    vertex = -b / (2 * c)
    return float(vertex), float(np.linalg.norm(to_y * noise)), float(a - b**2 / (4 * c))
