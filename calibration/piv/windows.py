"""Interrogation windows: where they lie in a picture, and their pixels as one array."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.float32]

_CHUNK_PIXELS = 2**18  # of the windows that are worked on at once: they stay in the cache


@dataclass(frozen=True)
class Grid:
    """Square windows on a regular grid.

    size    side of a window [px]
    top, left   (rows,), (columns,) first pixel of each row and column of windows
    """

    size: int
    top: NDArray[np.intp]
    left: NDArray[np.intp]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return len(self.top), len(self.left)

    @property
    def y(self) -> NDArray[np.float64]:
        """(rows,) middle of the windows [px]."""
        return np.asarray(self.top + (self.size - 1) / 2.0, dtype=float)

    @property
    def x(self) -> NDArray[np.float64]:
        """(columns,) middle of the windows [px]."""
        return np.asarray(self.left + (self.size - 1) / 2.0, dtype=float)

    def chunks(self) -> Iterator[slice]:
        """Rows of windows, a few at a time."""
        step = max(1, _CHUNK_PIXELS // (self.size**2 * len(self.left)))
        for start in range(0, len(self.top), step):
            yield slice(start, start + step)

    def cut(self, picture: NDArray, rows: slice) -> NDArray:
        """(rows, columns, size, size) a copy of the windows of some rows."""
        view = np.lib.stride_tricks.sliding_window_view(picture, (self.size, self.size))
        return view[self.top[rows][:, None], self.left[None, :]]

    def sums(self, picture: NDArray) -> NDArray[np.float64]:
        """(rows, columns) sum of a picture's pixels over each window."""
        table = np.zeros((picture.shape[0] + 1, picture.shape[1] + 1))
        np.cumsum(np.cumsum(picture, axis=0, dtype=float), axis=1, out=table[1:, 1:])
        high, low = table[self.top + self.size], table[self.top]
        right, left = self.left + self.size, self.left
        return np.asarray(high[:, right] - high[:, left] - low[:, right] + low[:, left])

    def means(self, picture: NDArray) -> NDArray[np.float64]:
        """(rows, columns) mean of a picture's pixels over each window."""
        return self.sums(picture) / self.size**2

    def weighted(self, picture: NDArray, weight: NDArray) -> NDArray[np.float64]:
        """(rows, columns) mean over each window of the pixels that count; 0 where none does."""
        area = self.sums(weight)
        return np.asarray(self.sums(picture * weight) / np.where(area > 0, area, 1.0))

    def middles(self, picture: NDArray) -> NDArray[np.float64]:
        """(rows, columns) a picture's value at the middle of each window."""
        i, j = self.top + (self.size - 1) // 2, self.left + (self.size - 1) // 2
        even = 1 - self.size % 2  # then the middle lies between four pixels
        near = [picture[np.ix_(i + k, j + m)] for k in (0, even) for m in (0, even)]
        return np.asarray(np.mean(near, axis=0, dtype=float))

    @property
    def step(self) -> int:
        """Distance of neighbouring windows [px]; the size where there is but one."""
        steps = [int(one[1] - one[0]) for one in (self.top, self.left) if len(one) > 1]
        return steps[0] if steps else self.size


def grid(shape: tuple[int, int], size: int, overlap: float) -> Grid:
    """Windows, as many as fit, overlapping by that share of their side, centred in the picture."""
    step = max(1, round(size * (1 - overlap)))
    first = []
    for length in shape:
        count = (length - size) // step + 1
        first.append((length - size - (count - 1) * step) // 2 + step * np.arange(count))
    return Grid(size, first[0], first[1])
