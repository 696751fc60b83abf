"""How far the tracers in windows went between two pictures: what stands where correlation fails.

Grains that turn and part leave little of a window's pattern from one picture to the next, the less
the faster they are. If only vectors of slow pairs of pictures were found, their mean would be slow.
A tracer sees a part of one grain, and is carried on by its neighbours (calibration.flow.tracers).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_FEWEST = 3  # tracers that make a mean with a scatter


class Steps(NamedTuple):
    """Tracers between two pictures [px, px^2]: midway (n, 2), steps (n, 2), variances (n,)."""

    midway: Floats
    step: Floats
    variance: Floats

    def means(self, x: Floats, y: Floats, side: float) -> tuple[Floats, Floats, Floats]:
        """(ny, nx) mean steps along x and y, and the variance of either, in windows about x and y.

        The tracers of a window are those of a few grains: they err together. How the window is
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
