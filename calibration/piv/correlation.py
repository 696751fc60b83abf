"""Cross-correlation of windows by FFT, and where its peak is.

C(s) = sum a(x) b(x + s) over windows padded with zeros (no wrap-around), of zero mean and scaled to
unit energy, so that C(0) is the correlation coefficient. At a shift s the windows share a part f(s)
of their pixels; C is divided by the root of f, which makes chance peaks equally high everywhere:
the highest peak is then the most significant one, and not the one of least shift.

Between pixels the peak is that of a Gaussian through three points (Willert and Gharib 1991).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Pixels = NDArray[np.float32]


class Peaks(NamedTuple):
    """The highest peak of each window's correlation.

    u, v     (...,) its shift along x and y [px]; NaN where a window has no texture
    height   (...,) correlation coefficient at the peak's pixel
    ratio    (...,) height of the peak over that of the second
    at_edge  (...,) whether it lies at the limit of the shifts that were searched
    """

    u: Array
    v: Array
    height: Array
    ratio: Array
    at_edge: NDArray[np.bool_]


def correlate(a: Pixels, b: Pixels, weight: Pixels, reach: int) -> Pixels:
    """(..., 2 reach + 1, 2 reach + 1) correlation for shifts up to `reach` along both axes.

    a, b, weight are (..., n, n); pixels of weight 0 do not count. A window without texture gives
    zeros.
    """
    from scipy import fft

    n = a.shape[-1]
    size = fft.next_fast_len(n + reach, real=True)
    shape = (size, size)
    front = fft.rfft2(_standard(a, weight), shape)
    back = fft.rfft2(_standard(b, weight), shape)
    plane = _centre(fft.irfft2(np.conj(front) * back, shape), reach)
    plane /= np.sqrt(_shared(weight, shape, reach))
    return plane


def _standard(window: Pixels, weight: Pixels) -> Pixels:
    """Zero mean, unit energy; zeros where there is nothing but one grey level."""
    area = np.maximum(weight.sum(axis=(-2, -1), keepdims=True), 1.0)
    mean = (window * weight).sum(axis=(-2, -1), keepdims=True) / area
    rest = (window - mean) * weight
    energy = (rest**2).sum(axis=(-2, -1), keepdims=True)
    return np.asarray(rest / np.sqrt(np.maximum(energy, np.finfo(np.float32).tiny)))


def _shared(weight: Pixels, shape: tuple[int, int], reach: int) -> Pixels:
    """Share of the pixels that both windows have at each shift; one plane where all are whole."""
    from scipy import fft

    n = weight.shape[-1]
    if weight.min() > 0:
        line = 1 - np.abs(np.arange(-reach, reach + 1)) / n
        return np.asarray(np.maximum(line[:, None] * line[None, :], 1 / n**2), dtype=np.float32)
    spectrum = fft.rfft2(weight, shape)
    both = _centre(fft.irfft2(np.abs(spectrum) ** 2, shape), reach)
    whole = np.maximum(both[..., reach, reach, None, None], 1.0)
    # a shift at which a fraction of the least useful part is left says nothing
    return np.asarray(np.maximum(both / whole, 1.0 / 16.0), dtype=np.float32)


def _centre(plane: Pixels, reach: int) -> Pixels:
    """Shifts from -reach to reach of a plane that begins at shift 0."""
    centred = np.roll(plane, (reach, reach), axis=(-2, -1))
    return centred[..., : 2 * reach + 1, : 2 * reach + 1]


def find_peaks(plane: Pixels) -> Peaks:
    """The highest peak of (..., m, m) correlations, m odd, shift 0 in the middle."""
    m = plane.shape[-1]
    flat = plane.reshape(-1, m, m)
    inner = np.where(_is_peak(flat), flat[:, 1:-1, 1:-1], 0.0).reshape(len(flat), -1)
    which = np.arange(len(flat))
    best = inner.argmax(axis=1)
    height = inner[which, best]
    inner[which, best] = 0.0
    second = inner.max(axis=1)
    i, j = np.divmod(best, m - 2)
    i, j = i + 1, j + 1
    nothing = height <= 0
    dy = _gauss(flat[which, i - 1, j], height, flat[which, i + 1, j])
    dx = _gauss(flat[which, i, j - 1], height, flat[which, i, j + 1])
    middle = m // 2
    v, u = np.where(nothing, np.nan, i - middle + dy), np.where(nothing, np.nan, j - middle + dx)
    ratio = np.where(second > 0, height / np.maximum(second, 1e-12), np.where(nothing, 1.0, np.inf))
    edge = flat.reshape(len(flat), -1).max(axis=1) > height
    lead = plane.shape[:-2]
    return Peaks(*(one.reshape(lead) for one in (u, v, height, ratio, edge)))


def _is_peak(flat: Pixels) -> NDArray[np.bool_]:
    """(n, m - 2, m - 2) whether a value is above its eight neighbours (or as high as some)."""
    m = flat.shape[-1]
    rows = np.maximum(np.maximum(flat[:, :, :-2], flat[:, :, 1:-1]), flat[:, :, 2:])
    around = np.maximum(np.maximum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])
    return np.asarray(flat[:, 1 : m - 1, 1 : m - 1] >= around)


def _gauss(left: Pixels, middle: Pixels, right: Pixels) -> Array:
    """Offset of the peak of a Gaussian through three points, within half a pixel.

    Where a neighbour is not positive, a parabola takes the place of the Gaussian.
    """
    values = np.stack([left, middle, right]).astype(float)
    positive = values.min(axis=0) > 0
    curve = np.where(positive, np.log(np.where(positive, values, 1.0)), values)
    below = 2 * (2 * curve[1] - curve[0] - curve[2])
    offset = np.where(below > 0, (curve[2] - curve[0]) / np.where(below > 0, below, 1.0), 0.0)
    return np.asarray(np.clip(offset, -0.5, 0.5))
