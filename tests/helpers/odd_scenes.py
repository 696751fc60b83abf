"""Films of what is no experiment of this project: chains of balls, drops, balls that roll or stay.

Each scene is a function of time [s] to where bodies are; `film_of` paints and writes it.
"""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from calibration.rendered.backdrop import Backdrop, blend, disc
from calibration.rendered.camera import Camera, write_film

WIDTH, HEIGHT, RADIUS = 240, 160, 9.0
GRAVITY = 600.0  # px/s2: the fall of a ball over the picture takes 0.6 s
RATE = 100.0
Places = Callable[[float], list[tuple[float, float]]]


def chain(count: int, restitution: float = 0.96, period: float = 0.8, out: int = 1) -> Places:
    """Newton's cradle: `out` of `count` balls swing at each end in turn, the others hang."""
    length, first = 110.0, WIDTH / 2 - RADIUS * (count - 1)

    def places(time: float) -> list[tuple[float, float]]:
        half = int(time / (period / 2))  # half a swing on the right, then one on the left
        side, share = 1 - 2 * (half % 2), (time / (period / 2)) % 1
        angle = 0.4 * side * restitution**half * math.sin(math.pi * share)
        swings = range(count - out, count) if side > 0 else range(out)
        turned = [angle if k in swings else 0.0 for k in range(count)]
        return [
            (first + 2 * RADIUS * k + length * math.sin(a), 10 + length * math.cos(a))
            for k, a in enumerate(turned)
        ]

    return places


def rolling(slope: float, *, stop: float | None = None, restitution: float = 0.6) -> Places:
    """A ball on a plane at `slope` [deg]: out of the picture, or on to a `stop` [px]."""
    alpha = math.radians(slope)
    pull = GRAVITY * math.sin(alpha) * 5 / 7  # a ball that rolls, at 2/5 m r2

    def places(time: float) -> list[tuple[float, float]]:
        way = _bounced(time, pull, stop, restitution) if stop else pull * time**2 / 2
        return [(20 + way * math.cos(alpha), 30 + way * math.sin(alpha))]

    return places


def _bounced(time: float, pull: float, stop: float, restitution: float) -> float:
    """Way from the start under a constant pull, against a stop."""
    fall = math.sqrt(2 * stop / pull)
    if time < fall:
        return pull * time**2 / 2
    time, speed = time - fall, restitution * pull * fall
    while speed > 1 and time > 2 * speed / pull:
        time, speed = time - 2 * speed / pull, restitution * speed
    return stop - (speed * time - pull * time**2 / 2 if speed > 1 else 0.0)


def falls(*, plate: float | None) -> Places:
    """A ball that falls and stays on a plate at `plate` [px], or falls out of the picture."""

    def places(time: float) -> list[tuple[float, float]]:
        y = 20 + GRAVITY * max(time - 0.1, 0.0) ** 2 / 2
        return [(WIDTH / 2, y if plate is None else min(y, plate))]

    return places


def thrown(time: float) -> list[tuple[float, float]]:
    """A ball thrown up aside, which flies through the picture and out of it."""
    return [(20 + 160 * time, 130 - 330 * time + GRAVITY * time**2 / 2)]


def slow_motion(time: float) -> list[tuple[float, float]]:
    """Down and up at even speed: so a bounce looks at ten thousand frames a second."""
    turn = 0.6
    return [(WIDTH / 2, 130 - (150 if time < turn else 110) * abs(time - turn))]


def film_of(places: Places, path: Path, *, seconds: float = 1.6, strings: bool = False) -> Path:
    """Write a film of discs at these places."""
    import cv2

    def paint(time: float):
        light = Backdrop().paint(WIDTH, HEIGHT, 2 * HEIGHT, 0.0, (0.0, 0.0))
        for k, (x, y) in enumerate(places(time)):
            if strings:
                top = WIDTH / 2 + 2 * RADIUS * (k - (len(places(0.0)) - 1) / 2), -8.0
                ends = [tuple(round(16 * v) for v in end) for end in (top, (x, y))]
                cv2.line(light, *ends, (0.25, 0.3, 0.3), 1, cv2.LINE_AA, 4)
            blend(light, disc(x, y, RADIUS, (0.6, 0.25, 0.15), 0.15))
        return light

    times = np.arange(0, seconds, 1 / RATE)
    return write_film(Camera(RATE, moments=3).film(paint, times, 1), path, RATE, "MJPG")
