"""Drop tests of known truth: balls that fall on a plate and bounce, as a camera would see them.

Picture coordinates: x to the right, y down, whole numbers in the middle of a pixel [px].
Contacts take no time. Restitution is e = restitution (v/v1)^exponent, v1 the first impact's speed,
and at most 1.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.rendered.backdrop import Backdrop, Colour, blend, disc, hand
from calibration.rendered.camera import Camera, Light, write_film

_G = 9.80665  # m/s2

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ball:
    """A ball and its fall; see the module for restitution.

    diameter     [m]
    fall         height of the lowest point over the plate until `release` [m]
    release      when it is let go [s]
    position     x where it hangs, as a share of the picture's width
    aside        speed along x once it is let go [m/s]
    rotation     of its texture [rad/s]
    bounces      contacts; it lies still after the flight from the last
    """

    diameter: float = 0.04
    fall: float = 0.35
    restitution: float = 0.8
    exponent: float = 0.0
    release: float = 0.1234
    position: float = 0.45
    aside: float = 0.02
    colour: Colour = (0.15, 0.45, 0.85)
    texture: float = 0.15
    rotation: float = 0.0
    bounces: int = 20

    def contacts(self) -> tuple[Array, Array, Array]:
        """Times [s], restitutions and speeds before [m/s] of all its contacts."""
        speed = first = math.sqrt(2 * _G * self.fall)
        time = self.release + first / _G
        found = np.empty((3, self.bounces))
        for k in range(self.bounces):
            e = min(self.restitution * (speed / first) ** self.exponent, 1.0)
            found[:, k] = time, e, speed
            speed *= e
            time += 2 * speed / _G
        return found[0], found[1], found[2]

    def height(self, time: float) -> float:
        """Height of the lowest point over the plate [m]."""
        times, restitutions, speeds = self.contacts()
        k = int(np.searchsorted(times, time, side="right")) - 1
        if k < 0:
            return self.fall - _G * max(time - self.release, 0.0) ** 2 / 2
        s = time - times[k]
        return max(restitutions[k] * speeds[k] * s - _G * s**2 / 2, 0.0)


@dataclass(frozen=True)
class Truth:
    """Truth of a film, for the contacts within it; times from its first frame on, at true speed.

    contacts      (n,) times [s]
    restitution   (n,) at each
    speeds        (n,) before each [m/s]
    frame         (n,) of each contact, counted as the camera did (no frame lost or repeated)
    path          (frames, 2) x, y of the ball's centre in the middle of each exposure [px]
    radius        (frames,) [px]
    rate          frames/s of the camera
    scale         m/px
    """

    contacts: Array
    restitution: Array
    speeds: Array
    frame: Array
    path: Array
    radius: Array
    rate: float
    scale: float


@dataclass(frozen=True)
class DropScene:
    """Balls over a plate, before a backdrop.

    width, height   of the picture [px]
    scale           m/px, where the ball hangs
    plate           y of the plate's edge, where balls touch down, as a share of the height
    approach        speed of the balls towards the camera, over its distance [1/s]
    plate_drift     of plate and ball before the backdrop, downwards [px/s]
    camera_drift    of all that is seen, x and y [px/s]
    shadow          light that a ball takes from the plate below it [share]
    with_hand       whether a hand holds the first ball, and stays in the picture
    """

    balls: tuple[Ball, ...] = (Ball(),)
    width: int = 240
    height: int = 480
    scale: float = 1e-3
    plate: float = 0.9
    approach: float = 0.0
    plate_drift: float = 0.0
    camera_drift: tuple[float, float] = (0.0, 0.0)
    shadow: float = 0.4
    with_hand: bool = False
    backdrop: Backdrop = field(default_factory=Backdrop)

    def position(self, ball: Ball, time: float) -> tuple[float, float, float]:
        """Centre x, y and radius of a ball in the picture at a time [px]."""
        aside = ball.aside * max(time - ball.release, 0.0)
        x = ball.position * self.width + aside / self.scale
        y = self.plate * self.height - (ball.height(time) + ball.diameter / 2) / self.scale
        nearer = 1 / (1 - self.approach * time)
        middle = self.width / 2, self.height / 2
        return (
            middle[0] + (x - middle[0]) * nearer + self.camera_drift[0] * time,
            middle[1] + (y - middle[1]) * nearer
            + (self.plate_drift + self.camera_drift[1]) * time,
            ball.diameter / 2 / self.scale * nearer,
        )  # fmt: skip

    def paint(self, time: float) -> Light:
        """Light of the scene at a time [s], (height, width, 3)."""
        edge = self.plate * self.height
        light = self.backdrop.paint(
            self.width, self.height, edge, self.plate_drift * time,
            (self.camera_drift[0] * time, self.camera_drift[1] * time),
        )  # fmt: skip
        for ball in self.balls:
            self._shade(light, ball, time)
        for ball in self.balls:
            x, y, radius = self.position(ball, time)
            blend(light, disc(x, y, radius, ball.colour, ball.texture, ball.rotation * time))
        if self.with_hand:
            self._paint_hand(light, self.balls[0], time)
        return light

    def _shade(self, light: Light, ball: Ball, time: float) -> None:
        """The shadow on the plate: wider and weaker the higher the ball."""
        x, y, radius = self.position(ball, time)
        high = ball.height(time) / self.scale
        touch = y + high / (1 - self.approach * time) + radius
        wide, strong = radius + 0.3 * high, self.shadow * radius / (radius + high)
        first = max(math.ceil(touch), 0)
        down = (np.arange(first, light.shape[0]) - touch) / (0.4 * wide)
        across = (np.arange(light.shape[1]) - x) / wide
        dark = strong * np.exp(-(down[:, None] ** 2 + across[None, :] ** 2))
        light[first:] *= 1 - dark[:, :, None].astype(np.float32)

    def _paint_hand(self, light: Light, ball: Ball, time: float) -> None:
        """It holds the ball from above, opens to the side, and sways there."""
        x, y, radius = self.position(ball, min(time, ball.release))
        since = max(time - ball.release, 0.0)
        away = 1.5 * radius * (1 - math.exp(-since / 0.1)) + 2 * math.sin(9 * since)
        blend(light, hand(x + away, y - 0.8 * radius, 0.9 * radius))


def film_drop(
    scene: DropScene, camera: Camera, path: Path, *, duration: float = 1.5, seed: int = 1,
    repeated: Sequence[int] = (), dropped: Sequence[int] = (), header: float | None = None,
    codec: str = "mp4v",
) -> Truth:  # fmt: skip
    """Write the film of a scene, and what it shows of the first ball.

    repeated   frames of the camera that the file shows twice
    dropped    frames of the camera that the file lacks
    header     frames/s that the file says, where not the camera's
    """
    n = int(duration * camera.rate)
    shown = [k for k in range(n) for _ in range(1 + (k in repeated)) if k not in dropped]
    pictures = camera.film(scene.paint, [k / camera.rate for k in range(n)], seed)
    again = (picture for k, picture in enumerate(pictures) for _ in range(shown.count(k)))
    write_film(again, path, header or camera.rate, codec)
    return truth(scene, camera, shown)


def truth(scene: DropScene, camera: Camera, shown: Sequence[int]) -> Truth:
    """Truth of a film of these frames of the camera, of the first ball; empty without one."""
    if not scene.balls:
        none = np.empty(0)
        return Truth(none, none, none, none, np.empty((0, 2)), none, camera.rate, scene.scale)
    ball = scene.balls[0]
    times, restitutions, speeds = ball.contacts()
    kept = times < max(shown) / camera.rate
    positions = np.array([scene.position(ball, k / camera.rate) for k in shown])
    return Truth(
        times[kept], restitutions[kept], speeds[kept], times[kept] * camera.rate,
        positions[:, :2], positions[:, 2], camera.rate, scene.scale,
    )  # fmt: skip


def sharp(scene: DropScene, camera: Camera) -> Camera:
    """The camera with so many moments that a ball's blur has no steps above an eighth of it."""
    fastest = max(
        (math.sqrt(2 * _G * ball.fall) / ball.diameter for ball in scene.balls), default=0
    )
    steps = 8 * fastest * camera.exposure / camera.rate
    return replace(camera, moments=max(camera.moments, math.ceil(steps)))
