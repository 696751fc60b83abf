"""The arc that an object on a string describes: pivot and length, and whether it is one at all."""

from dataclasses import dataclass

import numpy as np

from calibration.statistics.robust import for_correlation, robust_fit
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.track import Array, Rows

_CURVED = 5  # sigma by which a path must be curved for its circle to be known
_NOISY = 3  # times the noise: what lies nearer to the circle is on it
HEIGHTS_OFF = 0.02  # of the highest rise: a restitution from heights is then off by a hundredth


@dataclass(frozen=True)
class Arc:
    """The circle through a path.

    pivot      x, y [px]
    down       1 where y counts downwards, else -1
    length     of the string, to the point that is tracked, with sigma [px]
    curvature  1/length, with sigma [1/px]
    deviation  root mean square distance of the path from the circle, 0 where that is noise [px]
    rise       of the highest point over the lowest of the circle [px]
    apart      path back from path out at the lowest point, in the widest swing [px]; sigma
    """

    pivot: tuple[float, float]
    down: int
    length: Estimate
    curvature: Estimate
    deviation: float
    rise: float
    apart: Estimate

    @property
    def known(self) -> bool:
        """True if the path is seen to be curved."""
        assert self.curvature.sigma is not None
        return self.curvature.value > _CURVED * self.curvature.sigma

    @property
    def planar(self) -> bool | None:
        """True if heights can be read off the path to two hundredths of the highest.

        None where the path is straight within the noise: nothing is seen of its plane.
        """
        if not self.known:
            return None if self.deviation == 0 else False
        return self.deviation < HEIGHTS_OFF * self.rise

    def along(self, x: Array, y: Array) -> Array:
        """Arc length from below the pivot [px]."""
        below = self.down * (y - self.pivot[1])
        return np.asarray(self.length.value * np.arctan2(x - self.pivot[0], below))


def planar(arcs: tuple[Arc, ...]) -> bool | None:
    """Of all objects: False where one is not, None where nothing is seen of it."""
    seen = [arc.planar for arc in arcs if arc.planar is not None]
    return all(seen) if seen else None


def arc_through(x: Array, y: Array, swings: list[Rows], noise: float) -> Arc:
    """The arc of the points in `swings`, the first of which may go one way only.

    noise   standard deviation of a position [px]
    """
    every = np.concatenate(swings)
    if np.ptp(y[every]) == 0:  # a table of x alone
        unknown = Estimate(0.0, np.inf, 1)
        return Arc((float(np.mean(x)), -np.inf), 1, unknown, unknown, 0.0, 0.0, unknown)
    everywhere = np.full(len(x), np.nan)

    def with_correlation(residual: Array, covariance: Array) -> float:
        everywhere[every] = residual
        return float(np.sqrt(covariance[2, 2] * for_correlation(everywhere, swings)))

    found, covariance, residual = _parabola(x[every], y[every])
    sigma = with_correlation(residual, covariance)
    if abs(found[2]) > _CURVED * sigma:
        found, covariance, residual = _circle(found, x[every], y[every])
        sigma = with_correlation(residual, covariance)
    low, level, curvature = map(float, found)
    deviation = float(np.sqrt(np.mean(residual**2)))
    across = min(float(np.abs(x[every] - low).max() * abs(curvature)), 1.0)
    return Arc(
        (low, level + 1 / curvature),
        -1 if curvature > 0 else 1,
        Estimate(1 / abs(curvature), sigma / curvature**2, 1),
        Estimate(abs(curvature), sigma, 1),
        deviation if deviation > _NOISY * noise else 0.0,
        (1 - float(np.sqrt(1 - across**2))) / abs(curvature),
        _apart(x, everywhere, max(swings[1:], key=lambda one: float(np.ptp(x[one])))),
    )


def _parabola(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Lowest point (x, y), curvature there; covariance, right in the last alone; residuals."""
    middle, size = float(np.mean(x)), float(np.ptp(x))
    u = (x - middle) / size
    design = np.stack([u**0, u, u**2], axis=1)
    beta, covariance, _, _ = robust_fit(design, y)
    bend = beta[2] or 1e-12 * max(float(np.ptp(y)), size)  # never straight to the last bit
    turn = -beta[1] / (2 * bend)
    found = np.array([middle + size * turn, beta[0] + beta[1] * turn / 2, 2 * bend / size**2])
    return found, covariance * 4 / size**4, y - design @ beta


def _circle(start: Array, x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Lowest point and curvature by robust Gauss-Newton; covariance; distances from the circle."""
    p, scale = start, np.array([1.0, 1.0, abs(start[2])])
    for _ in range(20):
        r = _distance(p, x, y)
        steps = 1e-6 * scale * max(1.0, float(np.ptp(x)))
        steps[2] = 1e-6 * scale[2]
        slopes = [(_distance(p + d, x, y) - r) / d.sum() for d in np.diag(steps)]
        move, covariance, _, _ = robust_fit(np.stack(slopes, axis=1) * scale, -r)
        p = p + move * scale
        if np.all(np.abs(move * scale) < 1e-6 * np.maximum(np.abs(p), scale)):
            break
    return p, covariance * np.outer(scale, scale), _distance(p, x, y)


def _distance(p: Array, x: Array, y: Array) -> Array:
    """From the circle through (p0, p1), its lowest point, with signed curvature p2 [px]."""
    u, w = x - p[0], y - p[1]
    excess = p[2] * (u**2 + w**2) - 2 * w
    return np.asarray(excess / (1 + np.sqrt(np.maximum(1 + p[2] * excess, 0.0))))


def _apart(x: Array, off: Array, swing: Rows) -> Estimate:
    """Distance of the path out from the path back, as in an ellipse: with the speed along x."""
    speed = np.gradient(x[swing])
    u = (x[swing] - x[swing].mean()) / np.ptp(x[swing])
    design = np.stack([u**0, u, u**2, speed / np.abs(speed).max() / 2], axis=1)
    beta, covariance, _, _ = robust_fit(design, off[swing])
    everywhere = off.copy()
    everywhere[swing] -= design @ beta
    factor = for_correlation(everywhere, [swing])
    return Estimate(float(beta[3]), float(np.sqrt(covariance[3, 3] * factor)), 1)
