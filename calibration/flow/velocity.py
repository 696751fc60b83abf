"""Velocity fields of a flow: displacements between successive pictures, averaged over intervals."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibration.flow.silo import Silo
from calibration.flow.survey import Grey
from calibration.flow.tracers import Steps

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_WINDOW = 2.0  # particles across a window: a particle's own rotation is not the flow
_SMALLEST = 16  # px
_COVERED = 0.5  # of a window, by the bed
_LEAST = 0.01  # of the silo that is filled, below which no field is sought
PAIRS = 10  # of pictures in an interval: their scatter is known to a quarter
FEWEST = 3  # of them that make a mean with a scatter


@dataclass(frozen=True)
class VelocityField:
    """Mean velocities over an interval, on a grid along the silo's axes, in its unit.

    start, end    s from the opening
    x, y          (nx,), (ny,)
    vx, vy        (ny, nx) per s, y upwards; NaN where no displacement was found
    sigma         (ny, nx) of either component: scatter between pairs, scale, and the opening's time
    count         (ny, nx) pairs of pictures that gave one
    """

    start: float
    end: float
    x: Floats
    y: Floats
    vx: Floats
    vy: Floats
    sigma: Floats
    count: NDArray[np.int64]


class _Sum:
    """Velocities (ny, nx) of an interval's pairs, summed: the latest [px/s], and how they change.

    A flow that changes steadily does so in all pairs. The noise of their differences follows from
    those of successive ones, half of whose mean square is the variance (von Neumann 1941).
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.count, self._changes = (np.zeros(shape, dtype=np.int64) for _ in range(2))
        self.u, self.v, self._squares, self._variance = (np.zeros(shape) for _ in range(4))
        self._last = np.full((2, *shape), np.nan)

    def add(self, u: Floats, v: Floats, variance: Floats) -> None:
        """Velocities and the variance of either component, NaN where none was found."""
        known = np.isfinite(u)
        self.count += known
        for total, one in ((self.u, u), (self.v, v), (self._variance, variance)):
            total += np.where(known, one, 0.0)
        change = np.square(np.stack([u, v]) - self._last).mean(axis=0)
        self._changes += np.isfinite(change)
        self._squares += np.nan_to_num(change)
        self._last = np.where(known, np.stack([u, v]), self._last)

    def variance(self, seconds: float, particle: float) -> Floats:
        """Variance of the means over an interval [s], by the scatter of pairs and that of each.

        What is wrong of a window is so by its particles [px]: it is another error when they have
        gone on by one, and the same in all pairs as long as they have not.
        """
        n, changes = np.maximum(self.count, 1), np.maximum(self._changes, 1)
        passed = np.hypot(self.u, self.v) / n * seconds / particle
        others = np.minimum(1 + passed, n)
        return np.asarray((self._squares / changes / 2 + self._variance / others) / n)


class Velocities:
    """Sums of velocities, interval by interval, of a few pairs of pictures in each."""

    def __init__(self, silo: Silo, particle: float) -> None:
        self._silo, self._particle = silo, particle
        self._window = max(2 * round(_WINDOW * particle / 2), _SMALLEST)
        self._sums: dict[int, _Sum] = {}
        self._pairs: dict[int, int] = {}
        self._grid: tuple[Floats, Floats] | None = None

    def wants(self, time: float, length: float) -> bool:
        """True where a pair at a time [s] is one of the few measured in its interval [s]."""
        index = int(time / length)
        return time >= (index + (self._pairs.get(index, 0) + 0.5) / PAIRS) * length

    def add(
        self, interval: int, pictures: tuple[Grey, Grey], beds: tuple[Mask, Mask], steps: Steps,
        step: float,
    ) -> None:  # fmt: skip
        """Add the velocities of the bed between two pictures that are `step` [s] apart.

        pictures    whole ones; beds (rows, columns) of the silo's box
        """
        from calibration.piv import displacement

        self._pairs[interval] = self._pairs.get(interval, 0) + 1
        box, bed = self._silo.box, beds[0] & beds[1]
        if bed.mean() < _LEAST:
            return
        found = displacement(pictures[0][box], pictures[1][box], window=self._window, mask=bed)
        # There (0, 0) is the middle of the box's first pixel.
        x, y = found.x[0] + 0.5 + box[1].start, found.y[:, 0] + 0.5 + box[0].start
        self._grid = x, y
        by_tracers = steps.means(x, y, self._window)
        by_pattern = found.u, found.v, found.sigma**2
        u, v, variance = (
            np.where(found.valid, one, other)
            for one, other in zip(by_pattern, by_tracers, strict=True)
        )
        bare = _covered(beds, found.x, found.y, self._window) <= _COVERED
        u, v, variance = (np.where(bare, np.nan, one) for one in (u, v, variance))
        total = self._sums.setdefault(interval, _Sum(u.shape))
        total.add(u / step, v / step, variance / step**2)

    def fields(self, length: float, late: float) -> list[VelocityField]:
        """The mean velocities of all intervals of a length [s], the opening known to `late` [s]."""
        if self._grid is None:
            return []
        x = self._silo.metres(np.column_stack([self._grid[0], np.zeros(len(self._grid[0]))]))[:, 0]
        y = self._silo.metres(np.column_stack([np.zeros(len(self._grid[1])), self._grid[1]]))[:, 1]
        found = [
            self._field(index * length, (index + 1) * length, x, y, total)
            for index, total in sorted(self._sums.items())
        ]
        gained = [_gained(found, k) for k in range(len(found))]
        return [
            replace(one, sigma=np.hypot(one.sigma, late * gain / length))
            for one, gain in zip(found, gained, strict=True)
        ]

    def _field(self, start: float, end: float, x: Floats, y: Floats, total: _Sum) -> VelocityField:
        scale = self._silo.scale
        n = np.where(total.count >= FEWEST, total.count, np.nan)
        u, v = total.u / n, total.v / n
        relative = (scale.sigma or 0.0) / scale.value
        sigma = np.sqrt(
            total.variance(end - start, self._particle) + (u**2 + v**2) / 2 * relative**2
        )
        k = scale.value
        return VelocityField(start, end, x, y, k * u, -k * v, k * sigma, total.count)


def _covered(beds: tuple[Mask, Mask], x: Floats, y: Floats, side: int) -> Floats:
    """(ny, nx) share of the windows about pixels x, y that the bed covers, midway."""
    import cv2

    share = cv2.boxFilter(
        (beds[0].astype(np.float32) + beds[1]) / 2, -1, (side, side), borderType=cv2.BORDER_CONSTANT
    )
    at = x.astype(np.float32), y.astype(np.float32)
    return np.asarray(cv2.remap(share, *at, cv2.INTER_LINEAR), np.float64)


def _gained(fields: list[VelocityField], k: int) -> Floats:
    """(ny, nx) by how much either component grows over an interval, root mean square [per s].

    At an interval's ends the velocity is midway between its neighbours' means; at the opening 0.
    """
    here = np.stack([fields[k].vx, fields[k].vy])

    def towards(other: VelocityField) -> Floats:
        there = np.stack([other.vx, other.vy])
        return np.where(np.isfinite(there), (here + there) / 2, here)

    before = towards(fields[k - 1]) if k > 0 else np.zeros_like(here)
    after = towards(fields[k + 1]) if k + 1 < len(fields) else here
    return np.asarray(np.sqrt(np.mean(np.square(after - before), axis=0)))
