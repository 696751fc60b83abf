"""Motion of one block relative to the other at their contact, from the markers on both.

Each block's markers give its translation and rotation (least squares, Kabsch 1976, doi
10.1107/S0567739476001873). The relative displacement is that of the two rigid motions at the middle
of the contact: rotation of a block moves its markers, but does not count as approach or slip there.
Strain of the blocks between contact and markers is in it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.track import Array
from calibration.triaxial.markers import Dots
from granulab.errors import InputError

_FEWEST = 2  # markers that give a block's rotation


@dataclass(frozen=True)
class Line:
    """Contact in the first frame: its ends (2, 2) x, y [px], y down."""

    ends: Array

    @property
    def middle(self) -> Array:
        """(2,) of the contact."""
        return np.asarray(self.ends.mean(axis=0))

    @property
    def length(self) -> float:
        """[px]."""
        return float(np.hypot(*np.diff(self.ends, axis=0)[0]))

    @property
    def inclination(self) -> float:
        """Angle to the horizontal, 0 to pi/2 [rad]."""
        dx, dy = np.abs(np.diff(self.ends, axis=0)[0])
        return float(np.arctan2(dy, dx))

    def axes(self, inclination: float) -> Array:
        """Rows: down the slope, and across into the lower block, for an inclination; y down."""
        dx, dy = np.diff(self.ends, axis=0)[0]
        side = 1.0 if dx * dy >= 0 else -1.0  # downhill to the right, where y counts down
        c, s = np.cos(inclination), np.sin(inclination)
        return np.array([[side * c, s], [-side * s, c]])

    def above(self, x: Array, y: Array) -> NDArray[np.bool_]:
        """True for what lies on the upper block's side."""
        (x0, y0), (x1, y1) = self.ends
        across = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
        return np.asarray(across * np.sign(x1 - x0) < 0)


@dataclass(frozen=True)
class Relative:
    """Motion of the upper block relative to the lower one at the middle of the contact.

    x, y       (n,) displacement since the first frame, y down [px]
    rotation   (n,) since then, from x to y [rad]
    mean_x, mean_y   (n,) difference of the markers' mean displacements: with rotation left in [px]
    upper      (m,) which markers are on the upper block
    scatter    rms of the markers about the rigid motions [px]
    """

    x: Array
    y: Array
    rotation: Array
    mean_x: Array
    mean_y: Array
    upper: NDArray[np.bool_]
    scatter: float


def relative(dots: Dots, line: Line, where: str) -> Relative:
    """Relative motion in every frame; NaN where fewer than two markers of a block are seen.

    Raises InputError where a block has fewer than two markers.
    """
    x, y = dots.x[0], dots.y[0]
    upper = line.above(x, y)
    for name, mine in (("upper", upper), ("lower", ~upper)):
        if mine.sum() < _FEWEST:
            raise InputError(
                f"{where}: {mine.sum()} markers on the {name} block, {(~mine).sum()} on the other; "
                f"each needs {_FEWEST} and more on its side of --contact"
            )
    top, top_left = _moved(dots.x[:, upper], dots.y[:, upper], line.middle)
    low, low_left = _moved(dots.x[:, ~upper], dots.y[:, ~upper], line.middle)
    apart = top - low
    left = np.concatenate([top_left, low_left])
    freedom = 1 - 3 / len(dots.radius)  # of the two coordinates of a marker, three of each block
    scatter = float(np.sqrt(np.nanmean(left**2) / max(freedom, 0.25)))
    mean = [
        np.mean(one[:, upper] - one[0, upper], axis=1)
        - np.mean(one[:, ~upper] - one[0, ~upper], axis=1)
        for one in (dots.x, dots.y)
    ]
    return Relative(apart[:, 0], apart[:, 1], apart[:, 2], mean[0], mean[1], upper, scatter)


def _moved(x: Array, y: Array, middle: Array) -> tuple[Array, Array]:
    """(n, 3) displacement of a point that goes with markers (n, m), and rotation; what is left."""
    found = np.full((len(x), 3), np.nan)
    left = []
    start = x[0] + 1j * y[0]
    for k in range(len(x)):
        now = x[k] + 1j * y[k]
        seen = np.isfinite(now)
        if seen.sum() < _FEWEST:
            continue
        a, b = start[seen], now[seen]
        turn = np.sum((b - b.mean()) * (a - a.mean()).conj())
        turn /= abs(turn)
        point = complex(middle[0], middle[1])
        to = b.mean() + turn * (point - a.mean()) - point
        off = b - b.mean() - turn * (a - a.mean())
        left += [off.real, off.imag]
        found[k] = to.real, to.imag, np.angle(turn)
    return found, np.concatenate(left) if left else np.empty(0)
