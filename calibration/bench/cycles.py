"""Load-unload cycles: where a load reverses, and the stiffness of each unloading branch."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.statistics.uncertainty import Estimate, student
from granulab.errors import InputError


@dataclass(frozen=True)
class Cycle:
    """One unloading branch: its highest load, stiffness, and how far the stiffness bends.

    bend    stiffness of the upper half of what was fitted over that of the lower; 1 is straight
    points  measured points that were fitted
    """

    peak_load: float  # [N]
    stiffness: Estimate  # [N/m]
    bend: float | None
    points: int
    fitted: tuple[NDArray[np.float64], NDArray[np.float64]]  # displacement [m], load [N]


def oriented(
    displacement: NDArray[np.float64], load: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Both with compression positive, (n,) each: some machines write it negative.

    The larger loads are compression, and the specimen is shorter at the highest than at the lowest.
    """
    if -np.min(load) > np.max(load):
        load = -load
    if displacement[np.argmax(load)] < displacement[np.argmin(load)]:
        displacement = -displacement
    return displacement, load


def unloadings(load: NDArray[np.float64], least: float) -> list[tuple[int, int]]:
    """(first, last) of every fall of the load [N], (n,), from a peak to the lowest before the next.

    A peak stands above the valleys on both sides by at least `least` of the whole range of the
    load, so that noise and small slips are no cycles.
    """
    from scipy.signal import find_peaks

    # The record's ends count as valleys: find_peaks sees no peak at an edge.
    low, high = float(np.min(load)), float(np.max(load))
    framed = np.concatenate([[low], load, [low]])
    peaks = find_peaks(framed, prominence=least * (high - low))[0] - 1
    branches = []
    for k, peak in enumerate(peaks):
        end = peaks[k + 1] if k + 1 < len(peaks) else len(load)
        valley = peak + int(np.argmin(load[peak:end]))
        if load[peak] - load[valley] >= least * (high - low):
            branches.append((int(peak), valley))
    return branches


def unloading_stiffness(
    displacement: NDArray[np.float64],
    load: NDArray[np.float64],
    *,
    upper: float,
    lower: float,
    least: float,
) -> list[Cycle]:
    """Every cycle's slope dF/dx between `upper` and `lower` shares of the fall of its load.

    Signs as in `oriented`. Load in N and displacement in m, (n,), in the order in which they were
    measured. Raises InputError where no load falls, or too few points lie in the range.
    """
    displacement, load = oriented(displacement, load)
    found = []
    for first, last in unloadings(load, least):
        branch = slice(first, last + 1)
        x, force = _in_range(displacement[branch], load[branch], upper, lower)
        peak = float(load[first])
        found.append(Cycle(peak, line(x, force), _bend(x, force), len(x), (x, force)))
    if not found:
        raise InputError(
            f"no unloading: the load never falls by {least:.0%} of its range; see --least-cycle"
        )
    return found


def _in_range(
    x: NDArray[np.float64], force: NDArray[np.float64], upper: float, lower: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The points of one unloading between two shares of its fall."""
    share = (force - force[-1]) / (force[0] - force[-1])
    used = (share <= upper) & (share >= lower)
    if used.sum() < 4 or np.ptp(x[used]) == 0:
        raise InputError(
            f"the unloading from {force[0]:g} N has {used.sum()} points between {upper:.0%} and "
            f"{lower:.0%} of its fall; at least 4 with unlike displacements: widen --range"
        )
    return x[used], force[used]


def line(x: NDArray[np.float64], y: NDArray[np.float64]) -> Estimate:
    """Slope of a straight line when both x and y are noisy, (n,) each.

    Least squares of y(x) makes it too small, of x(y) too large: their geometric mean is taken, and
    their distance, as a rectangular distribution, is part of sigma, as is Student's factor for few
    points.
    """
    dx, dy = x - x.mean(), y - y.mean()
    xx, yy, xy = dx @ dx, dy @ dy, dx @ dy
    if xy <= 0:
        raise InputError(
            "the displacement does not fall with the load; both stand in the order in which they "
            "were measured"
        )
    r2 = min(xy**2 / (xx * yy), 1.0)
    slope = np.sqrt(yy / xx)
    freedom = len(x) - 2
    error = student(freedom) * slope * np.sqrt((1 - r2) / freedom)
    apart = (yy / xy - xy / xx) / 2 / np.sqrt(3)
    return Estimate(float(slope), float(np.hypot(error, apart)), 1)


def _bend(x: NDArray[np.float64], y: NDArray[np.float64]) -> float | None:
    high = y >= np.median(y)
    if high.sum() < 3 or (~high).sum() < 3:
        return None
    try:
        return line(x[high], y[high]).value / line(x[~high], y[~high]).value
    except (InputError, ZeroDivisionError):
        return None
