"""Pendulum tests of known truth, as a camera would see them: a ball and a wall, or two blocks.

Strings hang as far apart as the blocks are wide, two to a block, so that blocks do not rotate. A
camera that looks down sees what comes nearer lower in the picture, and larger.
"""

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.rendered.backdrop import Backdrop, Colour, Patch, blend, disc
from calibration.rendered.camera import Camera, Light, write_film
from calibration.rendered.strings import Strings, Swinging, swing

Array = NDArray[np.float64]

_STRING = (0.25, 0.3, 0.3)
_WALL = (0.45, 0.5, 0.5)


@dataclass(frozen=True)
class Truth:
    """Truth of a film; times from its first frame on.

    contacts      (n,) times [s]
    frame         (n,) of each contact
    restitution   of all
    path          (b, frames, 2) x, y of the objects' centres in the middle of each exposure [px]
    rate          frames/s
    planar        whether the swing is in one plane
    """

    contacts: Array
    frame: Array
    restitution: float
    path: Array
    rate: float
    planar: bool


@dataclass(frozen=True)
class PendulumScene:
    """Objects on strings before a backdrop.

    width, height   of the picture [px]
    scale           m/px
    size            of an object, its diameter or edge [m]
    pivot           y of the strings' upper ends [px]; they may be above the picture
    tilt            of the camera, downwards [deg]
    distance        of the camera [m]
    colours         of the objects
    """

    strings: Strings = field(default_factory=Strings)
    width: int = 320
    height: int = 240
    scale: float = 1.5e-3
    size: float = 0.04
    pivot: float = -130.0
    tilt: float = 0.0
    distance: float = 2.0
    colours: tuple[Colour, ...] = ((0.15, 0.2, 0.75), (0.15, 0.2, 0.75))
    backdrop: Backdrop = field(default_factory=Backdrop)

    def hung(self, k: int) -> float:
        """x of object k at its lowest point [px]."""
        return self.width * (0.6 if self.strings.objects == 1 else 0.5) + k * self.size / self.scale

    def positions(self, motion: Swinging, times: Array) -> tuple[Array, Array]:
        """(b, n, 2) centres [px], and (b, n) px per metre there, of objects at (n,) times [s]."""
        theta, tau = motion.angles(times), motion.out_of_plane(times)
        length = self.strings.length
        nearer = length * np.sin(tau)
        tilt = math.radians(self.tilt)
        down = length * np.cos(theta) * np.cos(tau) * math.cos(tilt) + nearer * math.sin(tilt)
        zoom = np.broadcast_to(1 / (1 - nearer / self.distance), theta.shape)
        hung = np.array([self.hung(k) for k in range(self.strings.objects)])[:, None]
        x = self.width / 2 + zoom * (
            hung - self.width / 2 + length * np.sin(theta) * np.cos(tau) / self.scale
        )
        y = self.height / 2 + zoom * (self.pivot + down / self.scale - self.height / 2)
        return np.stack([x, y], axis=-1), zoom / self.scale

    def paint(self, motion: Swinging, time: float) -> Light:
        """Light of the scene at a time [s], (height, width, 3)."""
        light = self.backdrop.paint(self.width, self.height, 2 * self.height, 0.0, (0.0, 0.0))
        positions, zoom = self.positions(motion, np.array([time]))
        if self.strings.objects == 1:
            self._wall(light)
        for k, (position, per_metre) in enumerate(zip(positions[:, 0], zoom[:, 0], strict=True)):
            half = self.size / 2 * per_metre
            for side in (-0.7, 0.7) if self.strings.objects == 2 else (0.0,):
                _string(
                    light,
                    (self.hung(k) + side * half, self.pivot),
                    (position[0] + side * half, position[1]),
                )
            x, y = map(float, position)
            if self.strings.objects == 1:
                blend(light, disc(x, y, half, self.colours[k], 0.1))
            else:
                blend(light, _block(x, y, half, self.colours[k]))
        return light

    def _wall(self, light: Light) -> None:
        """It stands where the ball's edge is at a contact."""
        edge = self.hung(0) + (self.strings.offset + self.size / 2) / self.scale
        cover = np.clip(np.arange(self.width) + 0.5 - edge, 0, 1)[None, :, None]
        light += cover.astype(np.float32) * (np.array(_WALL, dtype=np.float32) - light)


def _string(light: Light, pivot: tuple[float, float], end: tuple[float, float]) -> None:
    """A thread one pixel wide."""
    import cv2

    first, last = (tuple(round(16 * v) for v in point) for point in (pivot, end))
    cv2.line(light, first, last, _STRING, 1, cv2.LINE_AA, 4)


def _block(x: float, y: float, half: float, colour: Colour) -> Patch:
    """An upright square, lit from above."""
    reach = math.ceil(half) + 2
    row, column = math.floor(y) - reach, math.floor(x) - reach
    dy = np.arange(row, row + 2 * reach + 2) - y
    dx = np.arange(column, column + 2 * reach + 2) - x
    cover = np.outer(*(np.clip(half - np.abs(d) + 0.5, 0, 1) for d in (dy, dx)))
    lit = 1 - 0.15 * np.clip(dy / half, -1, 1)
    light = lit[:, None, None] * np.array(colour) * np.ones((1, len(dx), 1))
    return Patch(row, column, light.astype(np.float32), cover.astype(np.float32))


def film_pendulum(
    scene: PendulumScene, camera: Camera, path: Path, *, after: float = 0.25, seed: int = 1,
    codec: str = "mp4v",
) -> Truth:  # fmt: skip
    """Write the film of a scene until a time [s] `after` its last contact, and what it shows."""
    motion = swing(scene.strings)
    times = np.arange(0, motion.contacts[-1] + after, 1 / camera.rate)
    centres, _ = scene.positions(motion, times)
    fastest = np.abs(np.diff(centres[..., 0], axis=1)).max() * camera.exposure
    sharp = replace(camera, moments=max(camera.moments, math.ceil(fastest)))
    pictures = sharp.film(lambda time: scene.paint(motion, time), times, seed)
    write_film(pictures, path, camera.rate, codec)
    return Truth(
        motion.contacts, motion.contacts * camera.rate, scene.strings.restitution, centres,
        camera.rate, scene.strings.aside == 0,
    )  # fmt: skip
