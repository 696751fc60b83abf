"""Way of a block down a plate against time, by the integral of eq. 3.11b, and its fit.

    x = x0 + v0 (s - (1 - exp(-gamma_t s))/gamma_t),   s = t - t0 > 0, from rest at t0
    x = x0 + v0 t + (v_s - v0) (1 - exp(-gamma_t t))/gamma_t,   with the velocity v_s at t = 0

Positions are fitted as they are: velocities that are their differences would have noise that is not
white. A film does not say when its block was released: t0 is fitted, too.
"""

import warnings
from collections.abc import Callable

import numpy as np

from calibration.statistics.shared_noise import covariances, of_parameters
from calibration.tracking.track import Array
from granulab.errors import InputError

_FEWEST = 8  # positions: twice the unknowns
_BEGUN = 0.02  # of the way, by which a block has begun to slide: where t0 is looked for at first


def from_rest(t: Array, v0: float, gamma: float, t0: float, x0: float) -> Array:
    """Position of a block at rest until t0."""
    s = np.maximum(t - t0, 0.0)
    return x0 + v0 * (s + np.expm1(-gamma * s) / gamma)


def from_any(t: Array, v0: float, gamma: float, v_s: float, x0: float) -> Array:
    """Position of a block that has the velocity v_s at t = 0."""
    return x0 + v0 * t - (v_s - v0) * np.expm1(-gamma * t) / gamma


def fit_way(time: Array, position: Array, start: str) -> tuple[Array, Array]:
    """(v0, gamma_t, t0 or v_s, x0) of x(t) in (n,) s and m, and their covariance.

    start: "rest" or "any". The covariance is that of the residuals, and wider where neighbours go
    together. Raises InputError where the positions leave gamma_t open.
    """
    from scipy.optimize import OptimizeWarning, curve_fit

    if len(time) < _FEWEST or np.ptp(time) == 0:
        raise InputError(f"{len(time)} positions: at least {_FEWEST} at unlike times")
    order = np.argsort(time)
    t, x = time[order], position[order]
    model = from_rest if start == "rest" else from_any
    begun = float(t[np.searchsorted(np.maximum.accumulate(x - x[0]), _BEGUN * np.ptp(x))])
    late = t >= (begun + t[-1]) / 2
    speed = float(np.polyfit(t[late], x[late], 1)[0]) if late.sum() > 2 else np.ptp(x) / np.ptp(t)
    third = begun if start == "rest" else speed / 2
    guess = [speed, 3 / (t[-1] - begun or np.ptp(t)), third, float(x[0])]
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("error", OptimizeWarning)
            p, covariance = curve_fit(model, t, x, p0=guess, maxfev=4000)
    except (RuntimeError, OptimizeWarning):
        p, covariance = np.full(4, np.nan), np.full((4, 4), np.nan)
    if np.all(np.isfinite(p)):
        covariance = _covariance(model, t, x, p)
    if not np.all(np.isfinite(p)) or p[1] <= 0 or not covariance[1, 1] < p[1] ** 2:
        raise InputError(
            f"the positions over {np.ptp(t):g} s leave gamma_t open: their velocity does not bend "
            "towards a terminal one; film longer"
        )
    return p, covariance


def _covariance(model: Callable[..., Array], t: Array, x: Array, p: Array) -> Array:
    """(k, k) of the k parameters of least squares, with noise that near positions share.

    The lamp, and what is behind the block's outline, move all positions nearby alike.
    """
    steps = np.abs(p) * 1e-6 + 1e-9
    slopes = np.column_stack([
        (model(t, *(p + move)) - model(t, *(p - move))) / (2 * step)
        for step, move in zip(steps, np.diag(steps), strict=True)
    ])  # fmt: skip
    size = np.linalg.norm(slopes, axis=0)
    noise = covariances(x - model(t, *p), x, t, [np.arange(len(t))], slopes / size)
    return of_parameters(slopes / size, noise, np.empty((0, len(p)))) / np.outer(size, size)
