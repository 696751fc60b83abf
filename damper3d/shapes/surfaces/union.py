"""Volume and surface of overlapping spheres taken together."""

import math

import numpy as np

LATITUDES = 400  # of each sphere; some 1e-4 of volume and surface are left (tests)
# The poles lie in no direction in which spheres are likely to stand in a row, so that their free
# parts are no bands along the latitudes: a rotation by one radian about (1, 2, 3).
_AXIS = np.array([1.0, 2.0, 3.0]) / math.sqrt(14.0)
_CROSS = np.cross(np.eye(3), _AXIS)
_TURN = np.eye(3) + math.sin(1.0) * _CROSS + (1.0 - math.cos(1.0)) * _CROSS @ _CROSS


def of_row(x: np.ndarray, radii: np.ndarray) -> tuple[float, float]:
    """Exact volume [m3] and surface [m2] of spheres at rising positions x (k,) of one axis [m].

    Each one must reach the surface, between the planes in which it meets its neighbours.
    """
    meet = _meeting(x, radii)
    low = np.concatenate([[x[0] - radii[0]], meet]) - x
    high = np.concatenate([meet, [x[-1] + radii[-1]]]) - x
    volume = math.pi * np.sum(radii**2 * (high - low) - (high**3 - low**3) / 3.0)
    return float(volume), float(2.0 * math.pi * np.sum(radii * (high - low)))


def _meeting(x: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Positions in which each sphere of a row meets the next one, (k - 1,) [m]."""
    return 0.5 * (x[1:] + x[:-1] + (radii[:-1] ** 2 - radii[1:] ** 2) / np.diff(x))


def of_ring(distance: float, radius: float, number: int) -> tuple[float, float]:
    """Exact volume [m3] and surface [m2] of equal spheres on a circle that they do not fill.

    distance: of the centres from the middle [m], above the radius [m]. Each is cut where it meets
    its two neighbours, half of their distance d (eq. 4.30) away: a sphere less two caps.
    """
    d = 2.0 * distance * math.sin(math.pi / number)
    volume = number * math.pi * d * (radius**2 - d**2 / 12.0)
    return volume, number * 2.0 * math.pi * radius * d


def of_any(
    centres: np.ndarray, radii: np.ndarray, latitudes: int = LATITUDES
) -> tuple[float, float]:
    """Volume [m3] and surface [m2] of any spheres, centres (k, 3), radii (k,) [m].

    Of each circle of latitude the part outside of all other spheres is known exactly; the sum over
    the latitudes, equally far apart in height, is a midpoint rule. The volume is the flow of x/3
    through the surface.
    """
    volume = area = 0.0
    centres = centres @ _TURN
    for i, (centre, radius) in enumerate(zip(centres, radii, strict=True)):
        solid_angle, flow = _exposed(i, centres, radii, latitudes)
        area += radius**2 * solid_angle
        volume += (radius**3 * solid_angle + radius**2 * float(centre @ flow)) / 3.0
    return volume, area


def _exposed(
    i: int, centres: np.ndarray, radii: np.ndarray, latitudes: int
) -> tuple[float, np.ndarray]:
    """Integrals of 1 and of the normal (3,) over the directions in which sphere i is free."""
    to_others = np.delete(centres, i, axis=0) - centres[i]
    others = np.delete(radii, i)
    apart = np.linalg.norm(to_others, axis=1)
    towards = to_others / apart[:, None]
    # a direction lies in another sphere where its cosine towards it is above this
    limit = (apart**2 + radii[i] ** 2 - others**2) / (2.0 * apart * radii[i])
    near = limit < 1.0
    u = (np.arange(latitudes) + 0.5) * (2.0 / latitudes) - 1.0
    starts, ends = _free(u, towards[near], limit[near])
    height = np.broadcast_to(u[:, None], starts.shape)
    across = np.sqrt(1.0 - height**2)
    normal = [
        across * (np.sin(ends) - np.sin(starts)),
        across * (np.cos(starts) - np.cos(ends)),
        height * (ends - starts),
    ]
    step = 2.0 / latitudes
    return step * float((ends - starts).sum()), step * np.array([part.sum() for part in normal])


def _free(u: np.ndarray, towards: np.ndarray, limit: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Begin and end of the free parts of each circle, (latitudes, parts) [rad]."""
    across = np.sqrt(1.0 - u**2)[:, None] * np.hypot(towards[:, 0], towards[:, 1])
    margin = limit - u[:, None] * towards[:, 2]
    half = np.where(margin < 0.0, math.pi, 0.0)  # of a circle that lies all inside or all outside
    cut = np.abs(margin) < across
    half[cut] = np.arccos(margin[cut] / across[cut])
    begin = (np.arctan2(towards[:, 1], towards[:, 0]) - half) % (2.0 * math.pi)
    begin = np.concatenate([begin, begin - 2.0 * math.pi], axis=1)
    end = begin + 2.0 * np.concatenate([half, half], axis=1)
    order = np.argsort(begin, axis=1)
    begin, end = (np.take_along_axis(part, order, axis=1) for part in (begin, end))
    zero = np.zeros((len(u), 1))
    covered = np.maximum.accumulate(np.concatenate([zero, end], axis=1), axis=1)
    starts = np.minimum(covered, 2.0 * math.pi)
    following = np.concatenate([begin, zero + 2.0 * math.pi], axis=1)
    return starts, np.clip(following, starts, 2.0 * math.pi)
