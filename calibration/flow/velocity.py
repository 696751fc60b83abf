"""Velocity fields of a flow: displacements between successive pictures, averaged over intervals."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibration.flow.silo import Silo
from calibration.flow.survey import Grey

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_WINDOW = 2.0  # grains across a window: a grain's own turning is not the flow
_SMALLEST = 16  # px
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
    count         (ny, nx) pairs of pictures that told
    """

    start: float
    end: float
    x: Floats
    y: Floats
    vx: Floats
    vy: Floats
    sigma: Floats
    count: NDArray[np.int64]


@dataclass
class _Sum:
    """Of velocities [px/s], their squares, and the variance that each was measured with."""

    u: Floats
    v: Floats
    squares: Floats
    variance: Floats
    count: NDArray[np.int64]


class Velocities:
    """Sums of velocities, interval by interval, of a few pairs of pictures in each."""

    def __init__(self, silo: Silo, grain: float) -> None:
        self._silo = silo
        self._window = max(2 * round(_WINDOW * grain / 2), _SMALLEST)
        self._sums: dict[int, _Sum] = {}
        self._pairs: dict[int, int] = {}
        self._grid: tuple[Floats, Floats] | None = None

    def wants(self, time: float, length: float) -> bool:
        """Whether a pair at a time [s] is one of the few that are measured in its interval [s]."""
        index = int(time / length)
        return time >= (index + (self._pairs.get(index, 0) + 0.5) / PAIRS) * length

    def add(self, interval: int, before: Grey, after: Grey, bed: Mask, step: float) -> None:
        """Add the velocities of the bed between two pictures that are `step` [s] apart.

        before, after    whole pictures; bed (rows, columns) of the silo's box
        """
        from calibration.piv import displacement

        self._pairs[interval] = self._pairs.get(interval, 0) + 1
        box = self._silo.box
        if bed.mean() < _LEAST:
            return
        found = displacement(before[box], after[box], window=self._window, mask=bed)
        if self._grid is None:
            # There (0, 0) is the middle of the box's first pixel.
            self._grid = found.x[0] + 0.5 + box[1].start, found.y[:, 0] + 0.5 + box[0].start
        u, v, sigma = (
            np.where(found.valid, a, 0.0) / step for a in (found.u, found.v, found.sigma)
        )
        u0, v0, squares, variance = (np.zeros(u.shape) for _ in range(4))
        empty = _Sum(u0, v0, squares, variance, np.zeros(u.shape, dtype=np.int64))
        total = self._sums.setdefault(interval, empty)
        total.u += u
        total.v += v
        total.squares += u**2 + v**2
        total.variance += sigma**2
        total.count += found.valid

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

    def _field(
        self, start: float, end: float, x: Floats, y: Floats, total: "_Sum"
    ) -> VelocityField:
        scale = self._silo.scale
        n = np.where(total.count > 0, total.count, np.nan)
        u, v = total.u / n, total.v / n
        about = np.maximum(total.squares / n - u**2 - v**2, 0.0) / 2  # of one component
        scatter = about / np.maximum(n - 1, 1)
        relative = (scale.sigma or 0.0) / scale.value
        own = np.maximum(scatter, total.variance / n**2) + (u**2 + v**2) / 2 * relative**2
        sigma = np.where(n >= FEWEST, np.sqrt(own), np.nan)
        vx, vy = (np.where(n >= FEWEST, speed, np.nan) for speed in (u, -v))
        k = scale.value
        return VelocityField(start, end, x, y, k * vx, k * vy, k * sigma, total.count)


def _gained(fields: list[VelocityField], k: int) -> Floats:
    """(ny, nx) by how much either component grows over an interval, root mean square [per s].

    At an interval's ends the velocity is midway between its neighbours' means; at the opening 0.
    """
    here = np.stack([fields[k].vx, fields[k].vy])

    def towards(other: VelocityField) -> Floats:
        beside = np.stack([other.vx, other.vy])
        return np.where(np.isfinite(beside), (here + beside) / 2, here)

    before = towards(fields[k - 1]) if k > 0 else np.zeros_like(here)
    after = towards(fields[k + 1]) if k + 1 < len(fields) else here
    return np.asarray(np.sqrt(np.mean(np.square(after - before), axis=0)))
