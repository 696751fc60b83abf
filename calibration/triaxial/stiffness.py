"""Stiffness of an inclined contact from load and relative displacement, branch by branch.

    F_n = F cos(alpha)    F_t = F sin(alpha)    k_n = dF_n/ddx_n    k_t = dF_t/ddx_t    (eq. 3.1)

alpha is the contact's inclination to the horizontal, F the vertical load. The unloading branches
are taken as elastic, as in sec. 3.2.1. The load is known far better than the displacement: lines
are fitted as displacement against load, one slope, a level of its own for each branch.
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
    """Changes per load of several displacements, one slope for all branches.

    value        (c,) [unit of the displacement/N]; covariance (c, c)
    branches     frames of each unloading that was fitted
    levels       (b, c) where the lines of each branch cross zero load
    noise        (c,) of one frame
    """

    value: Array
    covariance: Array
    branches: list[Rows]
    levels: Array
    noise: Array


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
    every = np.concatenate(rows)
    design = np.zeros((len(every), 1 + len(rows)))
    design[:, 0] = load[every]
    first = 0
    for k, one in enumerate(rows):
        design[first : first + len(one), 1 + k] = 1.0
        first += len(one)
    found: Array = np.asarray(np.linalg.lstsq(design, seen[:, every].T, rcond=None)[0], dtype=float)
    left = seen[:, every].T - design @ found
    freedom = len(every) - design.shape[1]
    inverse = float(np.linalg.inv(design.T @ design)[0, 0])
    noise: Array = np.asarray(left.T @ left / freedom, dtype=float)
    residuals = np.full(seen.shape, np.nan)
    residuals[:, every] = left.T
    wider = np.array([student(freedom) ** 2 * for_correlation(one, rows) for one in residuals])
    covariance = np.asarray(noise * np.sqrt(np.outer(wider, wider)) * inverse, dtype=float)
    return Slopes(found[0], covariance, rows, found[1:], np.sqrt(np.diag(noise)))
