"""Velocity fields of a flow: displacements between successive pictures, summed over intervals."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.flow.silo import Silo
from calibration.flow.survey import Grey

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_WINDOW = 2.0  # grains across a window: a grain's own turning is not the flow
_SMALLEST = 16  # px


@dataclass(frozen=True)
class VelocityField:
    """Mean velocities over an interval, on a grid along the silo's axes, in its unit.

    start, end    s from the opening
    x, y          (nx,), (ny,)
    vx, vy        (ny, nx) per s, y upwards; NaN where no displacement was found
    sigma         (ny, nx) of either component
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
    time: Floats
    u: Floats
    v: Floats
    variance: Floats
    count: NDArray[np.int64]


class Velocities:
    """Sums of displacements, interval by interval."""

    def __init__(self, silo: Silo, grain: float) -> None:
        self._silo = silo
        self._window = max(2 * round(_WINDOW * grain / 2), _SMALLEST)
        self._sums: dict[int, _Sum] = {}
        self._grid: tuple[Floats, Floats] | None = None

    def add(self, interval: int, before: Grey, after: Grey, bed: Mask, step: float) -> None:
        """Add the displacements of the bed between two pictures that are `step` [s] apart.

        before, after    whole pictures; bed (rows, columns) of the silo's box
        """
        from calibration.piv import displacement

        box = self._silo.box
        found = displacement(before[box], after[box], window=self._window, mask=bed)
        u, v, sigma = (np.where(found.valid, a, 0.0) for a in (found.u, found.v, found.sigma))
        shape = found.u.shape
        if self._grid is None:
            # There (0, 0) is the middle of the box's first pixel.
            self._grid = found.x[0] + 0.5 + box[1].start, found.y[:, 0] + 0.5 + box[0].start
        total = self._sums.setdefault(
            interval, _Sum(*(np.zeros(shape) for _ in range(4)), np.zeros(shape, dtype=np.int64))
        )
        total.time += step * found.valid
        total.u += u
        total.v += v
        total.variance += sigma**2
        total.count += found.valid

    def fields(self, length: float) -> list[VelocityField]:
        """The mean velocities of all intervals of a length [s]."""
        if self._grid is None:
            return []
        scale = self._silo.scale
        x = self._silo.metres(np.column_stack([self._grid[0], np.zeros(len(self._grid[0]))]))[:, 0]
        y = self._silo.metres(np.column_stack([np.zeros(len(self._grid[1])), self._grid[1]]))[:, 1]
        out = []
        for index, total in sorted(self._sums.items()):
            seen = total.count > 0
            over = np.where(seen, total.time, np.nan) / scale.value
            vx, vy, own = total.u / over, -total.v / over, np.sqrt(total.variance) / over
            relative = (scale.sigma or 0.0) / scale.value
            sigma = np.hypot(own, relative * np.hypot(vx, vy) / np.sqrt(2))
            start = index * length
            out.append(VelocityField(start, start + length, x, y, vx, vy, sigma, total.count))
        return out
