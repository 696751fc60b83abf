"""Stiffness of an inclined contact from load and relative displacement, branch by branch.

    F_n = F cos(alpha)    F_t = F sin(alpha)    k_n = dF_n/ddx_n    k_t = dF_t/ddx_t    (eq. 3.1)

alpha is the contact's inclination to the horizontal, F the vertical load. The unloading branches
are taken as elastic, as in sec. 3.2.1. The load is known far better than the displacement: lines
are fitted as displacement against load, one for each branch, and their mean slope is taken.
"""

from dataclasses import dataclass

import numpy as np

from calibration.bench.compression import Branch
from calibration.bench.cycles import unloadings
from calibration.statistics.robust import for_correlation
from calibration.statistics.uncertainty import student
from calibration.tracking.track import Array, Rows
from granulab.errors import InputError

_FEWEST = 4  # frames of a branch: two give its line


@dataclass(frozen=True)
class Slopes:
    """Changes per load of several displacements, in the mean over all branches.

    value        (c,) [unit of the displacement/N]
    covariances  (c, c) each: of the noise of frames, and of the scatter of several unloadings,
                 which holds that noise as far as few unloadings show it: the larger one counts
    branches     frames of each unloading that was fitted
    levels       (b, c) where a line of that slope through each branch crosses zero load
    """

    value: Array
    covariances: list[Array]
    branches: list[Rows]
    levels: Array


def slopes(load: Array, seen: Array, branch: Branch, where: str) -> Slopes:
    """Slopes of displacements (c, n) against load (n,) on all unloading branches.

    Raises InputError where the load does not fall, or few frames see it fall.
    """
    known = np.flatnonzero(np.isfinite(load) & np.all(np.isfinite(seen), axis=0))
    if len(known) < 2 * _FEWEST:
        raise InputError(f"{where}: {len(known)} frames have a load and all markers")
    rows = []
    for first, last in unloadings(load[known], branch.least):
        one = known[first : last + 1]
        share = (load[one] - load[one[-1]]) / (load[one[0]] - load[one[-1]])
        rows.append(one[(share <= branch.upper) & (share >= branch.lower)])
    if not rows:
        raise InputError(
            f"{where}: no unloading: the load never falls by {branch.least:.0%} of its range while "
            "it is filmed"
        )
    few = next((one for one in rows if len(one) < _FEWEST), None)
    if few is not None:
        raise InputError(
            f"{where}: an unloading is seen in {len(few)} frames between {branch.upper:.0%} and "
            f"{branch.lower:.0%} of its fall; {_FEWEST} are needed: unload more slowly"
        )
    return _fitted(load, seen, rows)


def _fitted(load: Array, seen: Array, rows: list[Rows]) -> Slopes:
    """The mean of the unloadings' own lines; each counts once, as they differ beyond noise."""
    lines: list[Array] = [
        np.asarray(np.polynomial.polynomial.polyfit(load[one], seen[:, one].T, 1), dtype=float)
        for one in rows
    ]
    own: Array = np.array([line[1] for line in lines])
    value = own.mean(axis=0)
    covariances = [_of_frames(load, seen, rows, lines)]
    if len(rows) > 1:
        scatter = student(len(rows) - 1) ** 2 * np.cov(own, rowvar=False) / len(rows)
        covariances.append(np.asarray(scatter, dtype=float))
    levels: Array = np.array([
        seen[:, one].mean(axis=1) - value * load[one].mean() for one in rows
    ])  # fmt: skip
    return Slopes(value, covariances, rows, levels)


def _of_frames(load: Array, seen: Array, rows: list[Rows], lines: list[Array]) -> Array:
    """(c, c) covariance of the lines' mean slope, from the residuals of the frames alone."""
    left = np.full(seen.shape, np.nan)
    variance = 0.0  # of the mean slope, for one of a frame
    for one, (level, slope) in zip(rows, lines, strict=True):
        left[:, one] = seen[:, one] - level[:, None] - slope[:, None] * load[one]
        variance += 1 / float(np.sum((load[one] - load[one].mean()) ** 2)) / len(rows) ** 2
    every = np.concatenate(rows)
    freedom = len(every) - 2 * len(rows)
    wider = np.array([student(freedom) ** 2 * for_correlation(one, rows) for one in left])
    noise = left[:, every] @ left[:, every].T / freedom
    return np.asarray(noise * np.sqrt(np.outer(wider, wider)) * variance, dtype=float)
