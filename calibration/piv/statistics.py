"""The uncertainty of a displacement from the statistics of its correlation.

Wieneke 2015 (Meas. Sci. Technol. 26, 074002): where a displacement was found, the correlation is
as high one pixel before its peak as one behind it. The two differ by a sum over a window's pixels,

    Delta C = sum d(x),   d(x) = a(x) b(x + 1) - a(x + 1) b(x),

which is zero only as a whole: its standard deviation, with the covariance of near pixels, is

    s^2 = sum_x sum_y d(x) d(y),   y within the length over which d is correlated,

and the peak of the Gaussian through three points moves with it by

    sigma = s/(4 C1 ln(C0/C1)),

C1 the mean of both neighbours of the peak's C0. This holds noise, lost particles and what the
deformation of the window does not follow; an error that all pixels share is not seen.
"""

import numpy as np
from numpy.typing import NDArray

from calibration.piv.pictures import Pixels, Texture
from calibration.piv.validation import smoothed
from calibration.piv.windows import Grid

Array = NDArray[np.float64]

_SMALL = 0.05  # covariance over variance below which pixels are taken as independent (sec. 2.2)


def sigmas(a: Texture, b: Texture, where: Grid) -> tuple[Array, Array]:
    """(rows, columns) sigma of u and of v [px] from two pictures deformed onto each other.

    Infinite where the correlation has no peak at shift 0.
    """
    return _sigma(a, b, where, axis=1), _sigma(a, b, where, axis=0)


def _sigma(a: Texture, b: Texture, where: Grid, axis: int) -> Array:
    first, second = np.moveaxis(a.grey, axis, 0), np.moveaxis(b.grey, axis, 0)
    weight = np.moveaxis(a.weight * b.weight, axis, 0)
    both = weight[:-1] * weight[1:]
    forwards, backwards = first[:-1] * second[1:] * both, first[1:] * second[:-1] * both
    at_peak = (first[:-1] * second[:-1] + first[1:] * second[1:]) * both / 2
    # a pixel and its next one; the last has none
    peak, next_to, difference = (
        np.moveaxis(np.pad(one, ((0, 1), (0, 0))), 0, axis)
        for one in (at_peak, (forwards + backwards) / 2, forwards - backwards)
    )
    s, high, near = _spread(difference, where), where.sums(peak), where.sums(next_to)
    with np.errstate(divide="ignore", invalid="ignore"):
        # where C1 is not positive, the parabola's: its peak is then narrower than a pixel
        slope = np.where(near > 0, near * np.log(high / near), high - near)
        return np.asarray(np.where((high > 0) & (slope > 0), s / (4 * slope), np.inf))


def _spread(difference: Pixels, where: Grid) -> Array:
    """(rows, columns) standard deviation of the sum of d over a window.

    What covariance adds to the variance is pooled with the neighbours: one window shows it badly.
    """
    # a sum over a window is a difference of sums over all: it may round to below zero
    alone = np.maximum(where.sums(difference**2), 0.0)
    correlated = where.sums(difference * _near(difference))
    tiny = np.finfo(float).tiny
    factor = smoothed(correlated) / np.maximum(smoothed(alone), tiny)
    return np.asarray(np.sqrt(np.where(factor > 0, factor, 1.0) * alone))  # 1: as if independent


def _near(d: Pixels) -> Pixels:
    """Sum at each pixel of d over those near enough to be correlated with it."""
    import cv2

    width, height = (2 * _length(d, axis) + 1 for axis in (1, 0))
    return np.asarray(cv2.boxFilter(d, -1, (width, height), normalize=False))


def _length(d: Pixels, axis: int) -> int:
    """Pixels along an axis until the covariance of d is small, in the mean of the picture."""
    moved = np.moveaxis(d, axis, 0)
    least = _SMALL * float(np.vdot(d, d))
    longest = max(2, len(moved) // 8)
    for lag in range(1, longest):
        if abs(float(np.vdot(moved[lag:], moved[:-lag]))) < least:
            return lag - 1
    return longest


def noise_gain(window: int, step: int) -> float:
    """Factor by which the deformation raises the noise of a vector, after many passes.

    A pass adds what is left in the mean of the window to what the deformation has at its middle.
    Where a wave has k [rad per step], the window sees m = sinc(k window/(2 pi step)) of it and the
    smoothing between passes leaves s = (1 + cos k)/2, both as products over x and y: what is left
    converges to 1/(1 - s (1 - m)) of the noise, whose spectrum is that of windows which overlap.
    """
    waves = 64
    k = 2 * np.pi * np.fft.fftfreq(waves)
    seen = np.sinc(window / step * k / (2 * np.pi))
    left = (1 + np.cos(k)) / 2
    shared = np.maximum(1 - np.abs(np.fft.fftfreq(waves) * waves) * step / window, 0)
    noise = np.fft.fft(shared).real
    gain = 1 / (1 - np.outer(left, left) * (1 - np.outer(seen, seen)))
    spectrum = np.outer(noise, noise)
    return float(np.sqrt((gain**2 * spectrum).sum() / spectrum.sum()))
