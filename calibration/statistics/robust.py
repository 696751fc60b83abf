"""A robust linear fit, its covariance from the residuals, and what the residuals say of it.

Tukey's bisquare with the scale of the median absolute residual; covariance of an M-estimator (Huber
and Ronchetti 2009, Robust Statistics, sec. 7.6).
"""

import numpy as np

from calibration.tracking.track import Array, Rows

_TUKEY = 4.685  # 95 % efficient for normal residuals
MEDIAN_TO_SIGMA = 1.4826  # of a normal distribution


def robust_fit(
    design: Array, y: Array, lean: Array | None = None, least: float = 0.0
) -> tuple[Array, Array, Array, float]:
    """Coefficients, covariance, weights (0 to 1) and scale of a bisquare fit.

    lean    rows whose product with the coefficients is a standard normal deviate
    least   scale of the residuals below which it is not taken to be
    """
    n, p = design.shape
    lean = np.empty((0, p)) if lean is None else lean
    nothing = np.zeros(len(lean))
    # not below what numbers without noise leave
    floor = max(least, 1e-9 * max(float(np.ptp(y)), 1e-100))
    beta = np.linalg.lstsq(design, y, rcond=None)[0]
    sigma = np.inf
    for k in range(50):
        residual = y - design @ beta
        scale = np.median(np.abs(residual)) * MEDIAN_TO_SIGMA * np.sqrt(n / max(n - p, 1))
        sigma = max(min(sigma, scale) if k > 10 else scale, floor)  # settles, whatever comes
        root = np.sqrt(_bisquare(residual / sigma))
        rows = np.concatenate([design * root[:, None], sigma * lean])
        new = np.linalg.lstsq(rows, np.concatenate([y * root, nothing]), rcond=None)[0]
        moved, beta = np.abs(design @ (new - beta)).max(), new
        if moved < 1e-6 * sigma:
            break
    residual = y - design @ beta
    variance = max(_variance(residual, sigma, p), floor**2)
    information = design.T @ design / variance + lean.T @ lean
    covariance = np.asarray(np.linalg.pinv(information), dtype=float)
    return np.asarray(beta, dtype=float), covariance, _bisquare(residual / sigma), float(sigma)


def _bisquare(deviate: Array) -> Array:
    u = deviate / _TUKEY
    return np.where(np.abs(u) < 1, (1 - u**2) ** 2, 0.0)


def _variance(residual: Array, sigma: float, p: int) -> float:
    """Of one point, as it enters the covariance of the fit's coefficients."""
    n, u = len(residual), residual / (_TUKEY * sigma)
    inside = np.abs(u) < 1
    slope = np.where(inside, (1 - u**2) * (1 - 5 * u**2), 0.0)
    psi = np.where(inside, residual * (1 - u**2) ** 2, 0.0)
    correction = 1 + p / n * np.var(slope) / np.mean(slope) ** 2
    return float(correction**2 * np.sum(psi**2) / max(n - p, 1) / np.mean(slope) ** 2)


def influence(residual: Array, sigma: float) -> Array:
    """Effect of each residual on the coefficients: those that least squares would see so.

    psi/mean(psi'); their variance is that of the covariance of robust_fit.
    """
    u = residual / (_TUKEY * sigma)
    inside = np.abs(u) < 1
    slope = np.where(inside, (1 - u**2) * (1 - 5 * u**2), 0.0)
    return np.asarray(np.where(inside, residual * (1 - u**2) ** 2, 0.0) / np.mean(slope))


def for_correlation(residuals: Array, rows: list[Rows]) -> float:
    """A factor for variances where neighbouring residuals agree (pixel locking, smoothing).

    (1 + r)/(1 - r), as for a first-order process, r the correlation of neighbours where it is more
    than twice what chance gives.
    """
    pairs = [np.stack([residuals[one[:-1]], residuals[one[1:]]]) for one in rows]
    first, second = np.concatenate(pairs, axis=1)
    limit = 4 * np.median(np.abs(first)) * MEDIAN_TO_SIGMA  # outliers say nothing about it
    near = (np.abs(first) < limit) & (np.abs(second) < limit)
    if near.sum() < 8 or not np.any(first[near]):
        return 1.0
    r = float(np.sum(first[near] * second[near]) / np.sum(first[near] ** 2))
    r = min(r, 0.9)
    return (1 + r) / (1 - r) if r > 2 / np.sqrt(near.sum()) else 1.0


def run_left_out(residuals: Array, weights: Array) -> bool:
    """True if three points in a row were left out that lie on one side and off by about as much.

    Bad points come alone, and lie anywhere; a row of them, each off by less than twice its
    neighbour, says that the path is no parabola there (perspective, a lens, drag, blur). They then
    belong to the noise of the fit rather than out of it.
    """
    off = np.where(weights == 0, residuals, 0.0)
    pairs = off[:-1] * off[1:] > 0
    sizes = np.abs(off)
    alike = np.maximum(sizes[:-1], sizes[1:]) < 2 * np.minimum(sizes[:-1], sizes[1:])
    linked = pairs & alike
    return bool(np.any(linked[:-1] & linked[1:]))
