"""How gravity lies in the picture: the x of a thing in flight bends where the camera is tilted."""

import math

import numpy as np

from calibration.drop.bounce import Bounces
from calibration.statistics.uncertainty import Estimate

_SIGMAS = 4.0  # by which a tilt must be known to be said
_LEAST = 1.0  # degrees: what a tripod's level shows


def tilt(found: Bounces) -> Estimate:
    """Angle from the picture's vertical to gravity, clockwise from downwards [degrees]."""
    bends, powers, squares, freedom = 0.0, 0.0, 0.0, -1
    for rows in found.flights.rows:
        t, x = found.base.clock[rows], found.track.x[found.base.rows[rows]]
        line = np.stack([np.ones_like(t), t - t.mean()], axis=1)
        # what a straight path leaves of the place and of s^2/2
        left, bend = (
            one - line @ np.linalg.lstsq(line, one, rcond=None)[0]
            for one in (x, (t - t.mean()) ** 2 / 2)
        )
        bends, powers = bends + float(bend @ left), powers + float(bend @ bend)
        squares, freedom = squares + float(left @ left), freedom + len(rows) - 2
    across = bends / powers
    variance = max(squares - across**2 * powers, 0.0) / max(freedom, 1) / powers
    down, sigma = found.flights.acceleration
    angle = math.degrees(math.atan2(-across, down))
    size = math.hypot(across, down)
    spread = math.hypot(math.sqrt(variance) * down, across * sigma) / size**2
    return Estimate(angle, math.degrees(spread), len(found.flights.rows))


def not_upright(found: Bounces) -> list[str]:
    """A warning where a film shows gravity to point elsewhere than down."""
    if found.track.radius is None:
        return []
    if found.flights.acceleration[0] < 0:
        return ["it falls upwards in the picture: the recording is turned over"]
    lies = tilt(found)
    assert lies.sigma is not None
    if abs(lies.value) < max(_LEAST, _SIGMAS * lies.sigma):
        return []
    return [
        f"gravity lies {abs(lies.value):.1f} degrees (sigma {lies.sigma:.1g}) off the picture's "
        "vertical: the camera is tilted; restitution from times does not need it"
    ]
