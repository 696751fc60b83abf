"""Free fall in a drop test ties scale and rate together: g = a s f^2.

a is the acceleration in units of the track per frame^2, s the scale, f the rate. With both known,
g is a check; with one, it gives the other; with none, restitution is known all the same and speeds
are not. Gravity's direction in the picture shows as well: the x of an object in flight bends where
the camera is tilted.
"""

import math

import numpy as np

from calibration.drop.bounce import STANDARD_GRAVITY, Bounces
from calibration.drop.result import Drop
from calibration.statistics.uncertainty import Estimate, through

_SIGMAS = 4.0  # by which a tilt must be known to be said
_LEAST = 1.0  # degrees: what a tripod's level shows
_CEILING = 3.0  # m: laboratories drop objects within a storey
_ROUNDED = 0.01  # share by which a rate may be rounded: 29.97 to 30 is a thousandth
_POSITIONS = 4  # of a flight, for a parabola and one more: less is hardly found
_SEEN = 5  # noises of a position: what is higher is seen to bounce
_FAR = 0.05  # share by which g may miss before scale or rate is doubted


def tilt(found: Bounces) -> Estimate:
    """Angle from the picture's vertical to gravity, clockwise from downwards [degrees]."""
    bends, powers, squares, freedom = 0.0, 0.0, 0.0, -1
    for rows in found.flights.rows:
        t, x = found.base.clock[rows], found.track.x[found.base.rows[rows]]
        line = np.stack([np.ones_like(t), t - t.mean()], axis=1)
        # what a straight path leaves of the position and of s^2/2
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
        return ["it falls upwards in the picture: the recording is upside down"]
    lies = tilt(found)
    assert lies.sigma is not None
    if abs(lies.value) < max(_LEAST, _SIGMAS * lies.sigma):
        return []
    return [
        f"gravity lies {abs(lies.value):.1f} degrees (sigma {lies.sigma:.1g}) off the picture's "
        "vertical: the camera is tilted; restitution from times does not need it"
    ]


def rate_of(found: Bounces, fps: float | None) -> float | None:
    """Frames/s of the camera [1/s]: as given, else what the time stamps say, where they do."""
    stamped = found.track.rate
    return fps or (stamped and stamped * found.base.share)


def speed_of_a_unit(found: Bounces, fps: float | None, scale: float | None) -> float | None:
    """Speed [m/s] of one unit of y a frame, by g of free fall where rate or scale lacks."""
    rate, fall = rate_of(found, fps), abs(found.flights.acceleration[0])
    if rate and scale:
        return rate * scale
    if rate:
        return STANDARD_GRAVITY.value / (fall * rate)
    return math.sqrt(STANDARD_GRAVITY.value * scale / fall) if scale else None


def with_free_fall(
    found: Bounces, fps: float | None, scale: float | None, header: float | None = None
) -> Drop:
    """Scale, rate or gravity from the acceleration, and what that says of the clip.

    fps      frames/s of the camera [1/s]; else what the time stamps say
    scale    metres per unit of y
    header   frames/s that the file says; else what the time stamps say
    """
    value, sigma = found.flights.acceleration
    fall = Estimate(abs(value), sigma, len(found.flights.rows))
    stamped, used = found.track.rate, rate_of(found, fps)
    rate = Estimate(used, 0.0, 1) if used else None
    length = Estimate(scale, 0.0, 1) if scale else None
    gravity, remarks, warnings = None, list(found.base.remarks), list(found.warnings)
    if rate and length:
        gravity = through(lambda a, f, s: a * s * f**2, fall, rate, length)
        off = _warnings(gravity, rate, length)
        if off and not fps:
            true = through(lambda g, a, s: math.sqrt(g / (a * s)), STANDARD_GRAVITY, fall, length)
            remarks.append(
                f"the file says {rate.value:.4g} frames/s, free fall over this scale "
                f"{true.value:.4g} +- {true.sigma:.2g}"
            )
        warnings += off
    elif rate:
        length = through(lambda g, a, f: g / (a * f**2), STANDARD_GRAVITY, fall, rate)
        remarks.append("no scale: free fall gives it")
        warnings += _too_high(found, rate, length)
    elif length:
        rate = through(lambda g, a, s: math.sqrt(g / (a * s)), STANDARD_GRAVITY, fall, length)
        remarks.append("no rate: free fall gives it")
    else:
        remarks.append("neither rate nor scale: times in frames, no speeds")
    warnings += nearer(found) + not_upright(found) + too_short(found)
    if found.base.lost:
        warnings.append(
            f"frames are lost or put in here and there ({found.base.lost:.2g} of a frame's time "
            "per frame): as many as hide within contacts are in the sigma"
        )
    if fps and stamped and found.base.share != 1 and abs(fps / stamped - 1) < _ROUNDED:
        warnings.append(
            f"--fps {fps:g} is what the file says, not what the camera took: see the time base"
        )
    header = found.track.rate if header is None else header
    return Drop(found, header, rate, length, gravity, tuple(remarks), tuple(warnings))


def _warnings(gravity: Estimate, rate: Estimate, scale: Estimate) -> list[str]:
    ratio = gravity.value / STANDARD_GRAVITY.value
    assert gravity.sigma is not None
    off = abs(gravity.value - STANDARD_GRAVITY.value)
    if off < 3 * gravity.sigma or abs(ratio - 1) < _FAR:
        return []
    return [
        f"free fall gives g = {gravity.value:.4g} m/s2: with this scale the rate would be "
        f"{rate.value / math.sqrt(ratio):.4g} frames/s, with this rate the scale "
        f"{1e3 * scale.value / ratio:.4g} mm/px"
    ]


def _too_high(found: Bounces, rate: Estimate, scale: Estimate) -> list[str]:
    """A warning where the fall would be higher than a storey, as slow motion makes it."""
    rows = np.concatenate(found.flights.rows)
    height = float(np.ptp(found.track.y[found.base.rows[rows]])) * scale.value
    if height < _CEILING:
        return []
    return [
        f"at {rate.value:.4g} frames/s the fall would be {height:.3g} m high: if that is slow "
        "motion, give the camera's rate with --fps; restitution does not need it"
    ]


def too_short(found: Bounces) -> list[str]:
    """A warning where the object is seen to bounce on in flights of too few positions."""
    base, (acceleration, _) = found.base, found.flights.acceleration
    last = found.flights.rows[-1][-1]
    ends = last + 1 >= len(base.rows)
    e = float(found.velocities[-1, 0])
    flight = 2 * e**2 * found.speeds[-1, 0] / abs(acceleration)  # after that last measured
    height = abs(acceleration) * flight**2 / 8
    if flight > _POSITIONS + 1 or height < _SEEN * found.flights.sigma or ends:
        return []
    number = found.track.frame[base.rows[last]]
    return [
        f"it bounces on after frame {number:g}, in flights of {flight:.1f} frames and less: too "
        f"few positions for a parabola, so these contacts are not measured; a faster camera would"
    ]


def nearer(found: Bounces) -> list[str]:
    """A warning where the object grows in the picture, or shrinks, by more than chance."""
    radius = found.track.radius
    if radius is None:
        return []
    from scipy.stats import theilslopes

    flying = np.concatenate(found.flights.rows)
    fall = np.abs(np.gradient(found.track.y[found.base.rows], found.base.clock)[flying])
    slow = fall <= np.quantile(fall, 0.3)  # the blur of motion makes objects larger
    rows = found.base.rows[flying[slow]]
    if len(rows) < 8:
        return []
    frame, size = found.track.frame[rows], np.log(radius[rows])
    slope, _, low, high = theilslopes(size, frame, alpha=0.997)
    grown = slope * np.ptp(frame)
    if low * high <= 0 or abs(grown) < _FAR:
        return []
    way = "nearer" if grown > 0 else "farther"
    return [
        f"the object comes {way}: its radius changes by {np.expm1(grown):+.0%} over the flights, "
        "and the scale with it; restitution from times does not need it"
    ]
