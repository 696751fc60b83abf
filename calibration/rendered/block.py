"""Films of a block on a plate: a plate that tilts until the block slips, or one that stands.

A block at rest on a plate of inclination alpha slips where tan(alpha) exceeds mu (Granular Matter
15 (2013) 811, sec. 3.1.1). From then on its position s down the plate follows

    s'' = g (sin(alpha) - mu_k cos(alpha)) - gamma_t s'        (eq. 3.11a)

with the friction mu_k while it slides. Picture coordinates: x to the right, y down, the centre of
the first pixel is 0, 0.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.rendered.backdrop import Backdrop, Colour
from calibration.rendered.camera import Camera, Light, write_film

Array = NDArray[np.float64]

_G = 9.80665  # m/s2
_MARGIN = 4  # px around a patch, in which its cover falls to zero


@dataclass(frozen=True)
class Tilt:
    """Inclination against time, and the friction.

    start      inclination of the plate in the first frame [deg]
    rate       of the inclination, from `lead` on [deg/s]; 0 for a plate that stands
    lead       s of film before the plate tilts, or before the block of a standing plate is released
    friction   mu, at the first slip
    sliding    mu_k / mu, the friction while it slides over that of the first slip
    damping    gamma_t [1/s]
    topple     rate at which the block rotates about its lower edge once it slips [deg/s]
    """

    start: float = 5.0
    rate: float = 4.0
    lead: float = 0.3
    friction: float = 0.4
    sliding: float = 0.9
    damping: float = 0.0
    topple: float = 0.0

    @property
    def slip(self) -> float:
        """Time of the first slip [s]."""
        if self.rate == 0:
            return self.lead
        return self.lead + (math.degrees(math.atan(self.friction)) - self.start) / self.rate

    def angle(self, time: float) -> float:
        """Inclination [rad]."""
        return math.radians(self.start + self.rate * max(time - self.lead, 0.0))

    @cached_property
    def _solved(self) -> Callable[[float], Array]:
        from scipy.integrate import solve_ivp

        mu = self.friction * self.sliding

        def rates(time: float, y: Array) -> list[float]:
            pull = math.sin(self.angle(time)) - mu * math.cos(self.angle(time))
            return [y[1], _G * max(pull, 0.0) - self.damping * y[1]]

        span = (self.slip, self.slip + 10.0)
        found = solve_ivp(rates, span, [0.0, 0.0], rtol=1e-9, atol=1e-12, dense_output=True)
        solution: Callable[[float], Array] = found.sol
        return solution

    def position(self, time: float) -> float:
        """Distance that the block has slid [m]."""
        return float(self._solved(time)[0]) if time > self.slip else 0.0


class Textured(NamedTuple):
    """A rectangle: its light, (h, w, 3), with a margin, and its cover (h, w)."""

    light: Light
    cover: NDArray[np.float32]


@dataclass(frozen=True)
class BlockScene:
    """A plate with its lower end at the pivot, and a block on it; it slides to the left.

    width, height   of the picture [px]
    scale           m/px
    pivot           x, y of the plate's lower end, on its upper side [px]
    plate, block    length and thickness, length and height [px]
    at              position of the block's middle along the plate, from the pivot [px]
    roll            rotation of the camera about its axis [deg]
    texture         spread of light on plate and block
    """

    width: int = 400
    height: int = 300
    scale: float = 1e-3
    pivot: tuple[float, float] = (40.3, 250.6)
    plate: tuple[int, int] = (330, 14)
    block: tuple[int, int] = (44, 30)
    at: float = 220.0
    roll: float = 0.0
    texture: float = 0.05
    colours: tuple[Colour, Colour] = ((0.2, 0.3, 0.42), (0.45, 0.62, 0.78))
    backdrop: Backdrop = field(default_factory=Backdrop)
    seed: int = 1

    def pose(self, tilt: Tilt, time: float) -> tuple[float, float]:
        """Inclination [rad], and position of the block's middle along the plate [px]."""
        return tilt.angle(time), self.at - tilt.position(time) / self.scale

    def paint(self, tilt: Tilt, time: float) -> Light:
        """Light of the scene at a time [s], (height, width, 3)."""
        light = self.backdrop.paint(self.width, self.height, self.pivot[1] + 30.0, 0.0, (0.0, 0.0))
        angle, along = self.pose(tilt, time)
        axes = _frame(self.pivot, angle + math.radians(self.roll))
        _put(light, self._plate, axes @ _shift(0.0, 0.0))
        topple = math.radians(tilt.topple) * max(time - tilt.slip, 0.0)
        length, height = self.block
        low = _shift(along - length / 2, 0.0)  # its lower edge
        _put(light, self._block, axes @ low @ _rotation(topple) @ _shift(0.0, -height))
        return light

    @cached_property
    def _plate(self) -> Textured:
        return _textured(self.plate, self.colours[0], self.texture, self.seed)

    @cached_property
    def _block(self) -> Textured:
        return _textured(self.block, self.colours[1], self.texture, self.seed + 1)


def _textured(size: tuple[int, int], colour: Colour, spread: float, seed: int) -> Textured:
    """A rectangle (length, height) [px] with spots three pixels across, shaded downwards."""
    import cv2

    length, height = size
    shape = height + 2 * _MARGIN, length + 2 * _MARGIN
    spots = np.random.default_rng(seed).standard_normal(shape).astype(np.float32)
    spots = np.asarray(cv2.GaussianBlur(spots, (0, 0), 1.5), np.float32)
    spots *= spread / max(float(spots.std()), 1e-9)
    light = np.clip(np.array(colour, np.float32) + spots[:, :, None], 0, 1)
    cover = np.zeros(shape, np.float32)
    cover[_MARGIN:-_MARGIN, _MARGIN:-_MARGIN] = 1.0
    return Textured(light.astype(np.float32), cover)


def _frame(pivot: tuple[float, float], angle: float) -> Array:
    """(3, 3) from along the plate, upwards, and away from its upper side, down, to the picture."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, sin, pivot[0]], [-sin, cos, pivot[1]], [0.0, 0.0, 1.0]])


def _rotation(angle: float) -> Array:
    return _frame((0.0, 0.0), angle)


def _shift(x: float, y: float) -> Array:
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


def _put(light: Light, patch: Textured, pose: Array) -> None:
    """Blend in a patch whose upper left corner, without its margin, is the pose's origin."""
    import cv2

    # Pixel k of a patch reaches from k - 1/2 to k + 1/2 about its centre.
    matrix = pose @ _shift(0.5 - _MARGIN, 0.5 - _MARGIN)
    rows, columns = patch.cover.shape
    corners = np.array([[0, columns, 0, columns], [0, 0, rows, rows], [1, 1, 1, 1]])
    x, y = (matrix @ corners)[:2]
    left, top = max(math.floor(x.min()), 0), max(math.floor(y.min()), 0)
    part = light[top : max(math.ceil(y.max()), 0), left : max(math.ceil(x.max()), 0)]
    if not part.size:
        return
    matrix = (_shift(-left, -top) @ matrix)[:2]
    size = part.shape[1], part.shape[0]
    cover = cv2.warpAffine(patch.cover, matrix, size, flags=cv2.INTER_LINEAR)
    seen = cv2.warpAffine(
        patch.light, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    part += np.asarray(cover)[:, :, None] * (np.asarray(seen) - part)


@dataclass(frozen=True)
class Truth:
    """Truth of a film, times from its first frame on.

    slip        time of the first slip, or of the release [s]
    angle       inclination then [rad], towards the horizontal
    position    (frames,) way of the block down the plate in the middle of each exposure [m]
    """

    slip: float
    angle: float
    position: Array


def film_block(
    scene: BlockScene, tilt: Tilt, camera: Camera, path: Path, *, duration: float, seed: int = 1,
    codec: str = "mp4v",
) -> Truth:  # fmt: skip
    """Write the film of a scene, s long, and what it shows."""
    times = np.arange(0, duration, 1 / camera.rate)
    way = np.array([tilt.position(t) for t in times])
    fastest = np.abs(np.diff(way)).max(initial=0.0) / scene.scale * camera.exposure
    sharp = replace(camera, moments=max(camera.moments, math.ceil(fastest)))
    write_film(
        sharp.film(lambda time: scene.paint(tilt, time), times, seed), path, camera.rate, codec
    )
    return Truth(tilt.slip, tilt.angle(tilt.slip), way)


class Made(NamedTuple):
    """A film drawn by chance: scene, motion, camera, and its length [s]."""

    scene: BlockScene
    tilt: Tilt
    camera: Camera
    duration: float


def tilt_by_chance(seed: int, size: tuple[int, int] = (400, 300)) -> Made:
    """A plate that tilts by 1 to 8 deg/s, over friction, sizes, colours, lens and noise."""
    random = np.random.default_rng(seed)
    scene = _scene_by_chance(random, size)
    friction, rate = random.uniform(0.2, 0.7), float(np.exp(random.uniform(0, np.log(8))))
    lead = random.uniform(0.2, 0.5)
    start = math.degrees(math.atan(friction)) - rate * random.uniform(1.5, 3.0)
    tilt = Tilt(max(start, 0.5), rate, lead, friction, random.uniform(0.75, 1.0))
    far = tilt.slip
    while tilt.position(far) < 30 * scene.scale:
        far += 0.02
    camera = _camera_by_chance(random, random.choice([25.0, 30.0, 50.0, 60.0]))
    return Made(_raised(scene, tilt.angle(far)), tilt, camera, far)


def slide_by_chance(seed: int, size: tuple[int, int] = (480, 360)) -> Made:
    """A block that slides down a plate at 15 to 40 deg, with gamma_t from 1.5 to 6 1/s."""
    random = np.random.default_rng(seed)
    scene = _scene_by_chance(random, size)
    angle, damping = random.uniform(15, 40), random.uniform(1.5, 6.0)
    friction = math.tan(math.radians(angle)) * random.uniform(0.6, 0.9)
    tilt = Tilt(angle, 0.0, random.uniform(0.1, 0.4), friction, 1.0, damping)
    end = tilt.lead + random.uniform(3.0, 5.0) / damping
    # From the upper end of the plate to its lower one, in the time that the film lasts.
    length, block = scene.plate[0], scene.block[0]
    way = length - 2.2 * block
    scene = replace(scene, scale=tilt.position(end) / way, at=length - 1.1 * block)
    camera = _camera_by_chance(random, random.choice([60.0, 100.0, 120.0]))
    return Made(_raised(scene, tilt.angle(0.0)), tilt, camera, end)


def _scene_by_chance(random: np.random.Generator, size: tuple[int, int]) -> BlockScene:
    plate = int(random.uniform(0.72, 0.82) * size[0]), int(random.integers(10, 20))
    wall = random.uniform(0.5, 0.8) * np.ones(3) + random.uniform(-0.04, 0.04, 3)
    backdrop = Backdrop(tuple(wall), tuple(0.6 * wall), seed=int(random.integers(1000)))
    dark, light = random.uniform(0.15, 0.35, 3), random.uniform(0.35, 0.95, 3)
    return BlockScene(
        *size, scale=random.uniform(0.4e-3, 1.5e-3), plate=plate,
        block=(int(random.integers(28, 56)), int(random.integers(22, 36))),
        at=plate[0] * random.uniform(0.55, 0.8), texture=random.uniform(0.03, 0.08),
        colours=(tuple(dark), tuple(light)), backdrop=backdrop, seed=int(random.integers(1000)),
    )  # fmt: skip


def _raised(scene: BlockScene, angle: float) -> BlockScene:
    """The scene with the plate, at this inclination, in the middle of the picture."""
    length = scene.plate[0]
    x = (scene.width - length * math.cos(angle)) / 2
    y = (scene.height + length * math.sin(angle)) / 2
    return replace(scene, pivot=(x, min(y, scene.height - 40.0)))


def _camera_by_chance(random: np.random.Generator, rate: float) -> Camera:
    return Camera(
        float(rate), exposure=random.uniform(0.05, 0.5), blur=random.uniform(0.5, 1.2),
        noise=random.uniform(1.0, 5.0), falloff=random.uniform(0.0, 0.3), moments=2,
    )  # fmt: skip
