"""Noise that neighbouring positions share: its share and length from residuals.

What lies behind the rim of an object moves the position at which it is found, alike in frames
between which it moves by less than a length. Residuals r of one flight then have the covariance

    v ((1 - q) 1 + q exp(-|y_i - y_j|/l))

of the share q that is common at one position. The restricted likelihood (Patterson and Thompson
1971, doi 10.1093/biomet/58.3.545) of the residuals about each flight's own parabola (or about the
slopes of whatever was fitted), flat in q and ln l, is set against that of white noise, q = 0. Where
it is less likely the noise is taken as white; else the covariance is the mean over q and l with
these weights: what few residuals do not show counts as not known.
"""

from functools import lru_cache

import numpy as np

from calibration.statistics.uncertainty import student
from calibration.tracking.track import Array, Rows

_SHARES = np.arange(0.05, 0.96, 0.05)
_LONGEST = 200  # points of a stretch whose likelihood is taken as a whole


def covariances(
    residuals: Array, position: Array, time: Array, rows: list[Rows], slopes: Array | None = None
) -> list[Array]:
    """(k, k) covariance of the k points of each flight, Student's factor for few residuals in it.

    residuals, position, time   (n,) of all points; position of the object, in one unit
    rows                     the points of each flight
    slopes                   (n, p) by the parameters of what was fitted [parabolas in time]
    """
    lengths = _lengths(position, rows)
    own = 3 if slopes is None else slopes.shape[1]
    pieces = [part for one in rows for part in _pieces(one) if len(part) > own]
    freedom = sum(len(part) - own for part in pieces)
    if not freedom:  # three points in every flight: the fit's own residuals are all there is
        every = np.concatenate(rows)
        freedom = max(len(every) - 2 * len(rows) - 1, 1)
        alone, common = float(np.sum(residuals[every] ** 2)) / freedom, np.zeros(len(lengths))
    else:
        fitted = [_parabola(time[i]) if slopes is None else slopes[i] for i in pieces]
        alone, common = _parts(residuals, position, fitted, pieces, lengths, freedom)
    alike = [_alike(position[one], lengths) for one in rows]
    return [
        student(freedom) ** 2 * (alone * np.eye(len(one)) + np.tensordot(common, near, 1))
        for one, near in zip(rows, alike, strict=True)
    ]


def of_parameters(design: Array, noise: list[Array], lean: Array) -> Array:
    """Covariance of least squares' coefficients where points have the covariance `noise`.

    The sandwich estimator. lean: rows whose product with the coefficients is a normal deviate.
    """
    variance = float(np.mean(np.concatenate([np.diag(one) for one in noise])))
    bread = np.linalg.pinv(design.T @ design / variance + lean.T @ lean, hermitian=True)
    meat, first = lean.T @ lean, 0
    for one in noise:
        part = design[first : first + len(one)] / variance
        meat = meat + part.T @ one @ part
        first += len(one)
    return np.asarray(bread @ meat @ bread, dtype=float)


def _parts(
    residuals: Array, position: Array, fitted: list[Array], pieces: list[Rows], lengths: Array,
    freedom: int,
) -> tuple[float, Array]:  # fmt: skip
    """Variance that is each point's own, and that which is common, (lengths,) by its length."""
    log_weight = np.empty((len(lengths), len(_SHARES)))
    variance = np.empty_like(log_weight)
    spectra = [
        _spectra(residuals[i], position[i], slopes, lengths)
        for i, slopes in zip(pieces, fitted, strict=True)
    ]
    for k in range(len(lengths)):
        spread = np.concatenate([one[0][k] for one in spectra])
        square = np.concatenate([one[1][k] for one in spectra])
        d = 1 - _SHARES[:, None] + _SHARES[:, None] * spread
        total = np.maximum(np.sum(square / d, axis=1), 1e-300)
        log_weight[k] = -(np.sum(np.log(d), axis=1) + freedom * np.log(total)) / 2
        variance[k] = total / freedom
    white = max(sum(float(np.sum(one[1][0])) for one in spectra), 1e-300)
    weight = np.exp(log_weight - log_weight.max())
    odds = np.log(weight.mean()) + log_weight.max() + freedom * np.log(white) / 2
    if odds < 0:
        return white / freedom, np.zeros(len(lengths))
    weight *= variance / weight.sum()
    return float(np.sum(weight @ (1 - _SHARES))), weight @ _SHARES


def _lengths(position: Array, rows: list[Rows]) -> Array:
    """From the step between frames at which half of the neighbours differ to an eighth of a flight.

    A flight's own parabola takes up longer ones.
    """
    step = np.median(np.abs(np.concatenate([np.diff(position[one]) for one in rows])))
    range_ = max(float(np.ptp(position[one])) for one in rows)
    step = max(float(step), 1e-6 * range_, 1e-300)
    octaves = int(np.log2(max(range_ / 8 / step, 1)))
    return step * 2.0 ** np.arange(octaves + 1, dtype=np.float64)


def _pieces(one: Rows) -> list[Rows]:
    return np.array_split(one, -(-len(one) // _LONGEST))


def _alike(position: Array, lengths: Array) -> Array:
    """(lengths, k, k) correlation of the common part."""
    apart = np.abs(position[:, None] - position[None])
    return np.asarray(np.exp(-apart / lengths[:, None, None]), dtype=float)


def _parabola(time: Array) -> Array:
    s = time - time.mean()
    return np.stack([s**0, s, s**2], axis=1)


def _spectra(
    residual: Array, position: Array, slopes: Array, lengths: Array
) -> tuple[Array, Array]:  # fmt: skip
    """Eigenvalues of the common part across what was fitted, and squares of residuals along them.

    Each (lengths, k - p).
    """
    known = (np.asarray(one, dtype=np.float64).tobytes() for one in (position, slopes, lengths))
    spread, across = _basis(*known)
    return spread, (across @ residual) ** 2


@lru_cache(maxsize=32)  # a fit with one acceleration, and one with each flight's own, share it
def _basis(position: bytes, slopes: bytes, lengths: bytes) -> tuple[Array, Array]:
    """Eigenvalues (lengths, k - p) of the common part and its directions across the slopes."""
    at, fitted, length = (np.frombuffer(one) for one in (position, slopes, lengths))
    fitted = fitted.reshape(len(at), -1)
    across = np.linalg.qr(fitted, mode="complete")[0][:, fitted.shape[1] :]
    spread, axes = np.linalg.eigh(across.T @ _alike(at, length) @ across)
    return np.maximum(spread, 0.0), np.swapaxes(axes, 1, 2) @ across.T
