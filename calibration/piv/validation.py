"""Vectors that cannot be: unlike their neighbours, and what replaces them.

Universal outlier detection (Westerweel and Scarano 2005, Exp. Fluids 39, 1096): the distance of a
vector from the median of its eight neighbours, over the median of the neighbours' own distances
from it plus eps, may be no more than 2. Here the neighbours are first moved to the vector's
position along the local gradient: at the border of a sheared field they all lie on one side of it.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

_EPS = 0.1  # px, the noise that vectors have anyway (sec. 3 there)
_LIMIT = 2.0  # of the normalised residual (sec. 4 there)
_LEAST = 3  # neighbours that must be there to judge by
_ROUNDS = 6  # at most; a few are enough unless most vectors are strange


def neighbours(values: Array) -> Array:
    """(8, rows, columns) the values around each; NaN beyond the border."""
    padded = np.pad(values, 1, constant_values=np.nan)
    rows, columns = values.shape
    shifts = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    return np.stack([padded[i : i + rows, j : j + columns] for i, j in shifts])


def outliers(u: Array, v: Array) -> Flags:
    """(rows, columns) which vectors are unlike their neighbours; NaN are no vectors.

    All are judged again, by the neighbours that were not found strange: one that is spoils the
    median of its neighbours, and they may be good.
    """
    strange = np.zeros(u.shape, dtype=bool)
    for _ in range(_ROUNDS):
        parts = [_residual(values, np.where(strange, np.nan, values)) for values in (u, v)]
        residual = np.hypot(*parts)
        new = np.where(np.isnan(residual), strange, residual > _LIMIT) & np.isfinite(u)
        if (new == strange).all():
            break
        strange = new
    return strange


def _residual(values: Array, trusted: Array) -> Array:
    """Normalised residual of one component; NaN where too few trusted neighbours are there."""
    around = neighbours(trusted)
    spread = _median(np.abs(around - _median(around)))
    middle = _median(around - _trend(trusted))
    few = np.isfinite(around).sum(axis=0) < _LEAST
    return np.asarray(np.where(few, np.nan, np.abs(values - middle) / (spread + _EPS)))


def _trend(values: Array) -> Array:
    """(8, rows, columns) what a neighbour differs by where the displacement is linear."""
    down, right = _slope(values), _slope(values.T).T
    offsets = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]
    return np.stack([i * down + j * right for i, j in offsets])


def _slope(values: Array) -> Array:
    """(rows, columns) slope along the rows: the median of six differences about each vector."""
    step = np.diff(values, axis=0)
    above, below = (np.insert(step, at, np.nan, axis=0) for at in (0, len(step)))
    around = [one for both in (above, below) for one in (both, *neighbours(both)[3:5])]
    return np.nan_to_num(_median(np.stack(around)))


def _median(stack: Array) -> Array:
    """Median along the first axis without NaN; NaN where there is nothing."""
    ordered = np.sort(stack, axis=0)  # NaN last
    count = np.isfinite(stack).sum(axis=0)
    low = np.take_along_axis(ordered, np.maximum(count - 1, 0)[None] // 2, axis=0)[0]
    high = np.take_along_axis(ordered, (count // 2)[None].clip(max=len(stack) - 1), axis=0)[0]
    return np.asarray(np.where(count > 0, (low + high) / 2, np.nan))


def filled(values: Array) -> Array:
    """NaN replaced by the median of the neighbours, gaps from their border inwards; else 0."""
    values = values.copy()
    while (gaps := np.isnan(values)).any():
        if gaps.all():
            return np.zeros_like(values)
        values[gaps] = _median(neighbours(values))[gaps]
    return values


def smoothed(values: Array) -> Array:
    """The binomial mean over 3 x 3, without which windows that overlap amplify short waves.

    (Schrijer and Scarano 2008, Exp. Fluids 45, 927.)
    """
    from scipy.ndimage import convolve1d

    kernel = np.array([0.25, 0.5, 0.25])
    return np.asarray(convolve1d(convolve1d(values, kernel, 0, mode="nearest"), kernel, 1,
                                 mode="nearest"))  # fmt: skip
