"""Shape of a particle from its silhouette: radius of gyration, and the point that touches a plate.

Both are those of a prism that is seen along its axis; for another body the radius of gyration is
given. Lengths in pixels.
"""

from typing import NamedTuple

import numpy as np

from calibration.rebound.impact import Arm
from calibration.tracking.track import Array

EDGE = 0.2  # px by which an edge is found elsewhere: see calibration.tracking.orientation
_PATCH = 10.0  # px of an outline over which an edge errs alike: some spots of what is behind it
_FINE = 1440  # directions of the outline: a quarter of a degree
_NEAR, _FAR = 30, 90  # of these from a corner: 7 degrees, to which blur reaches, and 22
_FLAT = np.radians(15)  # between two sides that are one
_REACH = 0.2  # of the radius: a corner that ends farther out is none


class Touch(NamedTuple):
    """The point of an outline nearest to a plate, and how well it is known along it [px]."""

    arm: Arm
    sigma_t: float
    sigma_n: float


def outline(profile: Array) -> Array:
    """(k, 2) points of an outline, x to the right, y up, from radii in directions from x to y down.

    Between the directions its Fourier series.
    """
    spectrum = np.fft.rfft(profile)
    padded = np.zeros(_FINE // 2 + 1, dtype=complex)
    padded[: len(spectrum)] = spectrum
    radius = np.fft.irfft(padded, _FINE) * _FINE / len(profile)
    angle = -2 * np.pi * np.arange(_FINE) / _FINE
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def gyration(profile: Array) -> tuple[float, float]:
    """Radius of gyration of a prism with this outline about its axis, and its sigma."""
    value = float(np.sqrt(np.mean(profile**4) / 2 / np.mean(profile**2)))
    radius = float(np.sqrt(np.mean(profile**2)))
    patches = max(2 * np.pi * radius / _PATCH, 1.0)
    return value, value * EDGE / radius / float(np.sqrt(patches))


def touch(points: Array, angle: float, sigma: float, plane: float) -> Touch:
    """The point that touches a plate, for a particle at an angle; both counter-clockwise [rad].

    Blur rounds a corner: it ends between where the outline does and where the sides next to it
    meet, a rectangular distribution (GUM 4.3.7). Points as near to the plate as an edge is known
    may all be it; so may those at angles that differ by its sigma.
    """
    turned = _rotated(points, angle - plane)
    seen = int(np.argmin(turned[:, 1]))
    tip, end = turned[seen], _corner(turned, seen)
    near = turned[turned[:, 1] < tip[1] + EDGE, 0]
    others = [_rotated(points, angle + by - plane) for by in (sigma, -sigma)]
    high, low = (float(one[np.argmin(one[:, 1]), 0]) for one in others)
    arm = (tip + end) / 2
    spread = np.hypot(np.abs(end - tip) / 12**0.5, EDGE)
    along = float(np.sqrt(spread[0] ** 2 + np.ptp(near) ** 2 / 12 + (high - low) ** 2 / 4))
    return Touch(Arm(float(arm[0]), float(arm[1])), along, float(spread[1]))


def _corner(turned: Array, tip: int) -> Array:
    """(2,) where the straight sides to either side of the lowest point meet; it, if they do not."""
    lines = []
    for way in (1, -1):
        side = turned[(tip + way * np.arange(_NEAR, _FAR)) % len(turned)]
        middle = side.mean(axis=0)
        along = np.linalg.svd(side - middle)[2][0]
        lines.append((middle, along))
    (a, u), (b, v) = lines
    cross = u[0] * v[1] - u[1] * v[0]
    if abs(cross) < np.sin(_FLAT):
        return np.asarray(turned[tip])
    at = ((b - a)[0] * v[1] - (b - a)[1] * v[0]) / cross
    end = a + at * u
    beyond = end[1] < turned[tip, 1]
    near = np.hypot(*(end - turned[tip])) < _REACH * np.hypot(*turned[tip])
    return np.asarray(end if beyond and near else turned[tip])


def _rotated(points: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))
