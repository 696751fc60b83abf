"""Words for what is no drop test: what falls sideways, rolls, flies past, stays, or does not fall.

Free fall is a straight line across and a parabola down. What rolls or slides along a plane has its
acceleration along its path, g sin(alpha) or less; what is thrown turns in the air; what is filmed
at a rate that shows no acceleration does not say how fast time passes.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from calibration.drop.bounce import STANDARD_GRAVITY, Bounces, find_bounces
from calibration.drop.fall import tilt
from calibration.tracking.segments import Stretch, noise, speed, stretches
from calibration.tracking.track import Array, Track
from granulab.errors import InputError

_TILTED = 20.0  # degrees off the vertical: more than a camera held by hand, or put on a table, is
_SURE = 5.0  # sigma by which an acceleration is seen
_FEWEST = 8  # positions that show how something moves
_ROOM = 10.0  # m across: a wider picture shows no laboratory
_STRAIGHT = 0.02  # of the way: what a path may bend whose acceleration says nothing
_STAYS = 0.05  # of the way: what moves less after it came down has no rebound to be seen
_REBOUNDS = 0.3  # of the speed on one side of a contact: that on the other, in a bounce
_NO_FALL = "nothing falls"  # the refusal of find_bounces to which there is something to add


def refuse_what_falls_sideways(tracks: Sequence[Track], where: str) -> None:
    """InputError where an object bounces along x as objects do."""
    for track in tracks:
        if np.ptp(track.y) > np.ptp(track.x):
            continue
        try:
            found = find_bounces(replace(track, x=track.y, y=track.x, covariance=None))
        except InputError:
            continue
        if not 0 <= found.pooled.value <= 1 or _off_vertical(tilt(found).value) > _TILTED:
            continue  # swings against something, or on a plane: seen_instead has the words
        side = "right" if found.flights.acceleration[0] > 0 else "left"
        raise InputError(
            f"{where}it falls to the {side}, along x, with a restitution of "
            f"{found.pooled.value:.3f}: the recording is rotated by 90 degrees; rotate it upright "
            "(or it rolls to and fro, or swings: calibrate pendulum)"
        )


def _off_vertical(angle: float) -> float:
    """Degrees off up or down: upside down is said as a warning."""
    return min(abs(angle), 180 - abs(angle))


def refuse_what_does_not_fall(found: Bounces, where: str) -> None:
    """InputError where the acceleration of the flights is no gravity that a level camera shows."""
    lies = tilt(found)
    assert lies.sigma is not None
    off = _off_vertical(lies.value)
    if off - _SURE * lies.sigma > _TILTED:
        raise InputError(
            f"{where}its acceleration lies {off:.0f} degrees off the picture's vertical: it rolls "
            "or slides along a plane and meets a stop, which is no free fall, or the recording is "
            "tilted; rotate it upright"
        )


def seen_instead(tracks: Sequence[Track], why: str) -> str:
    """Words, to be put after the reason `why`, on how that moves which goes down or up farthest."""
    if _NO_FALL not in why:
        return ""
    best, longest = None, 0.0
    kept = [one.seen() for one in tracks]
    kept = [one for one in kept if len(one.frame) >= _FEWEST and np.isfinite(one.x).all()]
    widest = max(kept, key=lambda one: float(np.ptp(one.x)), default=None)
    if widest is not None and _reversals(widest.x) > 1 and np.ptp(widest.x) > np.ptp(widest.y):
        return "; it moves to and fro along x: for what swings on a string see calibrate pendulum"
    for track in kept:
        for piece in stretches(track.clock, track.y):
            way = float(np.ptp(track.y[piece.i : piece.j]))
            if piece.j - piece.i >= _FEWEST and way > longest:
                best, longest = (track, piece), way
    return f"; {_words(*best)}" if best is not None else ""


def _words(track: Track, piece: Stretch) -> str:
    """Words on how a track moves in its longest stretch, and what comes after."""
    rows = np.arange(piece.i, piece.j)
    t = track.clock[rows] - track.clock[rows].mean()
    (x, y), sigma = (
        (np.polyfit(t, one, 2) for one in (track.x[rows], track.y[rows])),
        piece.acceleration_sigma * _share(track),
    )
    pull, way = np.array([2 * x[0], 2 * y[0]]), np.array([_end(x, t), _end(y, t)])
    speed = math.hypot(*way) / float(np.ptp(t))
    bent = math.hypot(*pull) * float(np.ptp(t)) ** 2 / 8  # sagitta of its path against time
    if math.hypot(*pull) < _SURE * sigma or bent < _STRAIGHT * math.hypot(*way):
        return _straight(track, speed, math.hypot(*pull) + _SURE * sigma)
    if few := _too_few(track, piece):
        return few
    if _turns(track, y, track.clock[rows].mean(), abs(way[1])):
        return (
            "it turns in the air, and meets no plate: it is thrown, or it swings (calibrate "
            "pendulum)"
        )
    off = _between(way, np.array([0.0, 1.0]))
    if off > _TILTED and _between(way, pull) < _TILTED:
        return (
            f"it rolls or slides along a plane, {90 - off:.0f} degrees off the horizontal, and "
            "does not bounce; for friction see calibrate incline or slide"
        )
    after = track.y[piece.j :]
    if len(after) >= _FEWEST and np.ptp(after[len(after) // 2 :]) < _STAYS * abs(way[1]):
        return "it falls and stays where it lands: no rebound is seen"
    return "it falls and is not seen to come back: the film must show its rebounds"


def _too_few(track: Track, piece: Stretch) -> str:
    """Words on a bounce of which one side shows too few positions for a parabola; "" for none.

    Next to the stretch the object moves the other way, in the steps that lead to the contact or
    from it, by a good part of the speed that the stretch has there.
    """
    side = float(np.sign(piece.coefficients[2]))
    step, y = float(np.median(np.diff(track.clock))), side * track.y
    least = _SURE * noise(track.clock, track.y)
    ends = (
        ("fall", -speed(piece, piece.start), np.diff(y[: piece.i])[::-1]),
        ("rebound", speed(piece, piece.end), -np.diff(y[piece.j :])),
    )
    for name, fast, steps in ends:
        other = side * fast * step  # upwards as the stretch begins, downwards as it ends
        along = steps > 0
        n = len(along) if along.all() else int(np.argmin(along))
        if other > 0 and 0 < n < _FEWEST - 1 and steps[0] > max(least, _REBOUNDS * other):
            return (
                f"it bounces, but its {name} shows too few positions ({n + 1}) for a parabola: "
                "film at a higher rate or with a shorter exposure, or drop it from higher up"
            )
    return ""


def _turns(track: Track, down: Array, middle: float, way: float) -> bool:
    """True if the parabola y(t - middle) has its apex in the track, which rises to it before."""
    apex = middle - down[1] / (2 * down[0])
    near = np.abs(np.polyval(down, track.clock - middle) - track.y) < _STAYS * way
    rising = near & (track.clock < apex)
    if rising.sum() < _FEWEST:
        return False
    return bool(np.ptp(track.y[rising]) > _STAYS * way)


def _share(track: Track) -> float:
    """Noise along x and y together over that along y."""
    down, across = (max(noise(track.clock, one), 1e-9) for one in (track.y, track.x))
    return math.hypot(1.0, across / down)


def _straight(track: Track, speed: float, most: float) -> str:
    """Words on motion without an acceleration of more than `most` [px/frame2], and its rate."""
    words = f"it moves by {speed:.3g} px a frame, and no acceleration of gravity is seen in that"
    rate = track.rate
    if rate is None:
        return words
    pixel = STANDARD_GRAVITY.value / (most * rate**2)
    across = pixel * max(float(np.ptp(track.x)), float(np.ptp(track.y)))
    if across < _ROOM:
        return words
    return (
        f"{words}: in free fall at {rate:.4g} frames/s its way would be {across:.2g} m or more, so "
        "the camera ran far faster; give its rate with --fps, and film more of the fall"
    )


def _end(coefficients: Array, t: Array) -> float:
    """From the first to the last position of a fitted path."""
    return float(np.polyval(coefficients, t[-1]) - np.polyval(coefficients, t[0]))


def _between(one: Array, other: Array) -> float:
    """Angle between the directions of two vectors, their senses left aside [degrees]."""
    cross, along = one[0] * other[1] - one[1] * other[0], one @ other
    return math.degrees(math.atan2(abs(cross), abs(along)))


def _reversals(x: Array) -> int:
    """Number of times that a path turns back by a quarter of its range."""
    turns, far, side = 0, float(x[0]), 0
    for value in x:
        if side * (value - far) >= 0 and side:
            far = float(value)
        elif abs(value - far) > np.ptp(x) / 4:
            turns, side, far = turns + (side != 0), 1 if value > far else -1, float(value)
    return turns
