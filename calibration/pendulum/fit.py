"""All swings of one or two objects on equal strings in one robust fit (Gauss-Newton on robust.py).

Common to all are omega, beta and kappa of motion.Law; each object has its position of rest, and
each of its swings a position and a speed at the swing's middle. sigma comes from the residuals
alone, widened where neighbouring residuals agree.
"""

from dataclasses import dataclass

import numpy as np

from calibration.pendulum.motion import Law, across, swung
from calibration.statistics.robust import for_correlation, robust_fit
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.track import Array, Rows
from granulab.errors import InputError

_LAW = 3  # parameters of Law, first in the vector
_ROUNDS = 12
_SETTLED = 1e-3  # of the scale of the residuals: what a round moves the fit by when it is done


@dataclass(frozen=True)
class Seen:
    """Data of the fit, of b objects.

    t          (n,) time [frames]
    z          (b, n) position: arc length where `angles`, else horizontal [px]
    rows       points of each of the s swings, the same for all objects
    curvature  1/length of the strings [1/px]; None for isochronous swings
    """

    t: Array
    z: Array
    rows: list[Rows]
    angles: bool
    curvature: Estimate | None

    @property
    def centre(self) -> Array:
        """(s,) the middle of each swing [frames]."""
        return np.array([self.t[one[[0, -1]]].mean() for one in self.rows])


@dataclass(frozen=True)
class Fit:
    """parameters  (p,) omega, beta, kappa, rest of each object, position and speed of each swing
    covariance   (p, p)
    residuals    (b, n) NaN in no swing
    weights      (b, n) 0 where the fit took a point for an outlier
    sigma        scale of the residuals [px]
    """

    seen: Seen
    parameters: Array
    covariance: Array
    residuals: Array
    weights: Array
    sigma: float

    @property
    def law(self) -> Law:
        """The motion of all swings."""
        return law_of(self.parameters)

    @property
    def damping(self) -> Estimate:
        """beta, of which the amplitude is exp(-beta t) [1/frame]."""
        return Estimate(float(self.parameters[1]), float(np.sqrt(self.covariance[1, 1])), 1)


def law_of(p: Array) -> Law:
    """The law in a vector of parameters."""
    return Law(*map(float, p[:_LAW]))


def rests(p: Array, objects: int) -> Array:
    """(b,) position of rest of each object."""
    return p[_LAW : _LAW + objects]


def starts(p: Array, objects: int) -> Array:
    """(b, s, 2) position from rest and speed in the middle of each swing."""
    return p[_LAW + objects :].reshape(objects, -1, 2)


def states(p: Array, seen: Seen, swings: Rows, times: Array) -> tuple[Array, Array]:
    """Position from rest and speed of each object, (b, k), in swing swings[k] at times[k]."""
    start = starts(p, len(seen.z))[:, swings]
    s = np.broadcast_to(times - seen.centre[swings], start.shape[:2])
    return swung(law_of(p), start[..., 0], start[..., 1], s)


def fit(seen: Seen, *, damped: bool = True) -> Fit:
    """The fit of all swings; damped = False holds beta at zero. InputError where none converges."""
    free = np.ones(_LAW + len(seen.z) * (1 + 2 * len(seen.rows)), dtype=bool)
    free[1], free[2] = damped, seen.curvature is not None and bool(seen.curvature.sigma)
    y = _stacked(seen, seen.z)
    p = _start(seen)
    for _ in range(_ROUNDS):
        model = _model(p, seen)
        slopes = _slopes(p, seen, model)[:, free]
        size = np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
        off = np.zeros(len(p))  # kappa is fitted as what it differs by from what the arc says
        off[2] = 0.0 if seen.curvature is None else p[2] - seen.curvature.value
        found, covariance, weights, sigma = robust_fit(
            slopes / size, y - model + slopes @ off[free], _lean(seen, free, size)
        )
        with np.errstate(over="ignore"):
            move = found / size - off[free]
        if not np.isfinite(move).all():
            raise InputError("the swings are no pendulum's: no period and length fit them")
        p = p.copy()
        p[free] += move
        if np.abs(slopes @ move).max() < _SETTLED * sigma:
            break
    residuals = _unstacked(seen, y - _model(p, seen))
    factor = for_correlation(*_in_a_row(residuals, seen.rows))
    whole = np.zeros((len(p), len(p)))
    whole[np.ix_(free, free)] = covariance * factor / np.outer(size, size)
    return Fit(seen, p, whole, residuals, _unstacked(seen, weights), sigma)


def _start(seen: Seen) -> Array:
    """Isochronous swings of the best period, by linear fits."""
    longest = max(float(np.ptp(seen.t[one])) for one in seen.rows)
    trials = np.geomspace(0.3, 2.0, 60) * np.pi / longest
    omega = min(trials, key=lambda w: float(np.abs(_isochronous(seen, float(w))[1]).sum()))
    beta, _ = _isochronous(seen, float(omega))
    start = beta[:, :-1].reshape(len(seen.z), -1, 2) * [1.0, omega]
    kappa = 0.0 if seen.curvature is None else seen.curvature.value
    return np.concatenate([[omega, 0.0, kappa], beta[:, -1], start.ravel()])


def _isochronous(seen: Seen, omega: float) -> tuple[Array, Array]:
    """(b, 2s + 1) coefficients of cosine and sine of each swing and of rest; residuals."""
    columns = []
    for one, centre in zip(seen.rows, seen.centre, strict=True):
        s = omega * (seen.t[one] - centre)
        columns.append(np.stack([np.cos(s), np.sin(s)], axis=1))
    design = np.zeros((sum(map(len, seen.rows)), 2 * len(columns) + 1))
    design[:, -1] = 1.0
    first = 0
    for k, block in enumerate(columns):
        design[first : first + len(block), 2 * k : 2 * k + 2] = block
        first += len(block)
    every = np.concatenate(seen.rows)
    beta = np.linalg.lstsq(design, seen.z[:, every].T, rcond=None)[0]
    return np.asarray(beta.T, dtype=float), np.asarray(seen.z[:, every].T - design @ beta)


def _model(p: Array, seen: Seen) -> Array:
    """Positions by p of every point: objects one after another, swing by swing."""
    which = np.repeat(np.arange(len(seen.rows)), [len(one) for one in seen.rows])
    q, _ = states(p, seen, which, seen.t[np.concatenate(seen.rows)])
    position = q if seen.angles else across(law_of(p), q)
    return np.asarray((rests(p, len(seen.z))[:, None] + position).ravel())


def _slopes(p: Array, seen: Seen, model: Array) -> Array:
    """(points, p) by forward differences; swings are independent, so all are moved at once."""
    objects, lengths = len(seen.z), [len(one) for one in seen.rows]
    slopes = np.zeros((len(model), len(p)))
    for k, step in enumerate([1e-6 * p[0], 1e-6 * p[0], 1e-6 * max(p[2], 1e-9)]):
        slopes[:, k] = (_model(p + step * np.eye(len(p))[k], seen) - model) / step
    size = float(np.ptp(seen.z)) or 1.0
    object = np.repeat(np.arange(objects), sum(lengths))
    swing = np.tile(np.repeat(np.arange(len(lengths)), lengths), objects)
    slopes[np.arange(len(model)), _LAW + object] = 1.0
    for k, step in enumerate([1e-6 * size, 1e-6 * size * p[0]]):
        moved = p.copy()
        moved[_LAW + objects + k :: 2] += step
        column = _LAW + objects + 2 * (object * len(lengths) + swing) + k
        slopes[np.arange(len(model)), column] = (_model(moved, seen) - model) / step
    return slopes


def _lean(seen: Seen, free: Array, size: Array) -> Array | None:
    """One row that holds kappa to what the arc says."""
    if not free[2]:
        return None
    assert seen.curvature is not None
    assert seen.curvature.sigma
    row = np.zeros((1, len(free)))
    row[0, 2] = 1 / seen.curvature.sigma
    return np.asarray(row[:, free] / size)


def _stacked(seen: Seen, values: Array) -> Array:
    return np.asarray(values[:, np.concatenate(seen.rows)].ravel())


def _unstacked(seen: Seen, values: Array) -> Array:
    whole = np.full(seen.z.shape, np.nan)
    whole[:, np.concatenate(seen.rows)] = values.reshape(len(seen.z), -1)
    return whole


def _in_a_row(residuals: Array, rows: list[Rows]) -> tuple[Array, list[Rows]]:
    """Residuals of all objects one after another, and the rows of each object's swings in them."""
    objects, n = residuals.shape
    return residuals.ravel(), [one + k * n for k in range(objects) for one in rows]
