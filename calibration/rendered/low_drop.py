"""Drop tests as the paper did them: blocks that fall by centimetres and rotate as they bounce.

A prism falls from rest, hits a plate with a corner, and turns. Between contacts it flies freely.
A contact is a plane impulse at the lowest corner, with a restitution and Coulomb friction of its
own (Stronge 2000, Impact mechanics, sec. 3): the restitution of the centroid, sqrt(H1/H0), follows.
Heights count upwards from the plate; picture coordinates as in calibration.rendered.drop.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.rendered.backdrop import Backdrop, Colour, Patch, blend
from calibration.rendered.camera import Camera, Light, write_film

_G = 9.80665  # m/s2
_STEP = 1e-4  # s between looks for a corner's contact
_REST = 2e-3  # s: contacts that follow one another faster are rest
_FINE = 4  # rows and columns of a pixel in which its cover is looked at

Array = NDArray[np.float64]


class Flight(NamedTuple):
    """Free motion of a block from a time on; without `gravity` it lies still."""

    time: float  # s
    centre: Array  # (2,) x, height [m]
    velocity: Array  # (2,) [m/s]
    angle: float  # counterclockwise [rad]
    spin: float  # [rad/s]
    gravity: float = _G

    def pose(self, time: float) -> tuple[Array, float]:
        """Centroid (2,) [m] and angle [rad] at a time."""
        s = time - self.time
        fall = np.array([0.0, self.gravity * s**2 / 2])
        return self.centre + self.velocity * s - fall, self.angle + self.spin * s


@dataclass(frozen=True)
class Block:
    """A convex prism of uniform density, and how it falls.

    outline       (n, 2) of its section, counterclockwise [m]
    fall          of its centroid until the first contact: H0 [m]
    angle, spin   when it is let go [rad, rad/s]
    release       when it is let go [s]
    restitution, friction   of a corner's contact
    contacts      at most; it lies still then
    """

    outline: Array
    fall: float = 0.03
    angle: float = 0.3
    spin: float = 0.0
    release: float = 0.1
    restitution: float = 0.7
    friction: float = 0.3
    contacts: int = 12

    @cached_property
    def corners(self) -> Array:
        """(n, 2) about the centroid [m]."""
        return np.asarray(self.outline - _moments(self.outline)[1])

    @cached_property
    def gyration(self) -> float:
        """Radius of gyration squared [m2]."""
        area, _, polar = _moments(self.corners)
        return polar / area

    @cached_property
    def flights(self) -> list[Flight]:
        """Before the release, from it and from each contact on; the last lies still."""
        first = math.sqrt(2 * self.fall / _G)
        low = self._lowest(np.array([self.angle + self.spin * first]))[0]
        start, still = np.array([0.0, self.fall - low]), np.zeros(2)
        found = [
            Flight(0.0, start, still, self.angle, 0.0, 0.0),
            Flight(self.release, start, still, self.angle, self.spin),
        ]
        time = self.release + first
        while len(found) < self.contacts + 2 and time - found[-1].time > _REST:
            found.append(self._after(found[-1], time))
            time = self._next(found[-1])
        centre, angle = found[-1].pose(time)
        return [*found, Flight(time, centre, still, angle, 0.0, 0.0)]

    @property
    def size(self) -> float:
        """Root of the area of its section [m]."""
        return math.sqrt(_moments(self.outline)[0])

    @property
    def rebound(self) -> float:
        """Restitution of the centroid at the first contact, sqrt(H1/H0) (eq. 3.5)."""
        return float(self.flights[2].velocity[1] / math.sqrt(2 * _G * self.fall))

    @property
    def contact_times(self) -> Array:
        """(n,) [s]."""
        return np.array([one.time for one in self.flights[2:]])

    def pose(self, time: float) -> tuple[Array, float]:
        """Centroid (2,) [m] and angle [rad]."""
        times = [one.time for one in self.flights]
        return self.flights[max(bisect_right(times, time) - 1, 0)].pose(time)

    def _lowest(self, angle: Array) -> Array:
        """Height of the lowest corner over the centroid, at each angle (n,)."""
        return np.asarray(np.min(self.corners @ np.stack([np.sin(angle), np.cos(angle)]), axis=0))

    def _after(self, before: Flight, time: float) -> Flight:
        """The flight after the impulse at the lowest corner."""
        centre, angle = before.pose(time)
        velocity = before.velocity - np.array([0.0, before.gravity * (time - before.time)])
        c, s = math.cos(angle), math.sin(angle)
        turned = self.corners @ np.array([[c, s], [-s, c]])
        x, y = turned[np.argmin(turned[:, 1])]
        slip, sink = velocity[0] - before.spin * y, velocity[1] + before.spin * x
        # change of the corner's velocity by an impulse per mass along x, and upwards
        cross = -x * y / self.gyration
        softness = np.array([[1 + y**2 / self.gyration, cross], [cross, 1 + x**2 / self.gyration]])
        wanted = np.array([-slip, -(1 + self.restitution) * sink])
        across, up = np.linalg.solve(softness, wanted)
        if abs(across) > self.friction * up:
            side = -math.copysign(self.friction, slip)
            up = wanted[1] / (softness[1, 1] + side * softness[1, 0])
            across = side * up
        spin = before.spin + (x * up - y * across) / self.gyration
        return Flight(time, centre, velocity + np.array([across, up]), angle, spin)

    def _next(self, one: Flight) -> float:
        """Time of the next contact, to a step [s]; a second later at most."""
        for some in np.split(np.arange(1, 10_001) * _STEP, 20):
            height = one.centre[1] + one.velocity[1] * some - _G * some**2 / 2
            below = height + self._lowest(one.angle + one.spin * some) < 0
            if below.any():
                return one.time + float(some[np.argmax(below)])
        return one.time + 1.0


def _moments(outline: Array) -> tuple[float, Array, float]:
    """Area, centroid and polar second moment about the origin of a polygon."""
    a, b = outline, np.roll(outline, -1, axis=0)
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    area = cross.sum() / 2
    centroid = np.sum((a + b) * cross[:, None], axis=0) / (6 * area)
    polar = np.sum(cross * np.sum(a * a + a * b + b * b, axis=1)) / 12
    return float(area), centroid, float(polar)


@dataclass(frozen=True)
class LowDrop:
    """A block over a plate, before a backdrop.

    scale    m/px
    margin   about the block, left, right and above [px]
    below    of the plate that is seen [px]
    tongs    whether the block is held from both sides until it is let go
    """

    block: Block
    scale: float = 5e-4
    margin: int = 25
    below: int = 12
    tongs: bool = False
    colour: Colour = (0.3, 0.5, 0.65)
    grain: float = 0.1
    backdrop: Backdrop = field(default_factory=Backdrop)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture [px], whole even numbers."""
        reach = float(np.abs(self.block.corners).max()) / self.scale
        high = float(self.block.flights[0].centre[1]) / self.scale
        width, height = 8 * reach + 2 * self.margin, high + reach + self.margin + self.below
        return 2 * math.ceil(width / 2), 2 * math.ceil(height / 2)

    def place(self, time: float) -> tuple[float, float, float]:
        """Centroid x, y [px] and angle [rad] in the picture."""
        (x, y), angle = self.block.pose(time)
        width, height = self.size
        return width / 2 + x / self.scale, height - self.below - y / self.scale, angle

    def paint(self, time: float) -> Light:
        """Light of the scene at a time [s], (height, width, 3)."""
        width, height = self.size
        light = self.backdrop.paint(width, height, height - self.below, 0.0, (0.0, 0.0))
        x, y, angle = self.place(time)
        if self.tongs:
            self._hold(light, time)
        c, s = math.cos(angle), math.sin(angle)
        corners = self.block.corners / self.scale
        blend(light, polygon(x, y, corners @ np.array([[c, s], [-s, c]]) * [1, -1], self.colour,
                             self.grain, angle))  # fmt: skip
        return light

    def _hold(self, light: Light, time: float) -> None:
        """Two rods that meet the block's sides, and part at 0.5 m/s once it is let go."""
        x, y, _ = self.place(0.0)
        reach = 0.7 * float(np.abs(self.block.corners).max()) / self.scale
        away = reach + 0.5 * max(time - self.block.release, 0.0) / self.scale
        for side in (-1, 1):
            ends = np.array([away, away + light.shape[1]])
            rod = np.array([[ends[0], -1.5], [ends[1], -1.5], [ends[1], 1.5], [ends[0], 1.5]])
            blend(light, polygon(x, y, rod * [side, 1], (0.25, 0.25, 0.25), 0.0, 0.0))


def polygon(
    x: float, y: float, corners: Array, colour: Colour, grain: float, angle: float
) -> Patch:
    """A convex polygon, (n, 2) corners about x, y [px], with stripes of wood along its own axis."""
    column, row = math.floor(x + corners[:, 0].min()), math.floor(y + corners[:, 1].min())
    width = math.ceil(x + corners[:, 0].max()) - column + 1
    height = math.ceil(y + corners[:, 1].max()) - row + 1
    fine = (np.arange(_FINE) + 0.5) / _FINE - 0.5
    px = (np.arange(column, column + width)[:, None] + fine).ravel() - x
    py = (np.arange(row, row + height)[:, None] + fine).ravel() - y
    inside = np.ones((len(py), len(px)), dtype=bool)
    order = np.sign(_moments(corners)[0])
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        across = (b[0] - a[0]) * (py[:, None] - a[1]) - (b[1] - a[1]) * (px[None, :] - a[0])
        inside &= order * across >= 0
    cover = inside.reshape(height, _FINE, width, _FINE).mean(axis=(1, 3)).astype(np.float32)
    u = np.arange(column, column + width) - x
    v = np.arange(row, row + height) - y
    along = u[None, :] * math.sin(angle) + v[:, None] * math.cos(angle)
    light = np.clip((1 + grain * np.sin(along))[:, :, None] * np.array(colour), 0, 1)
    return Patch(row, column, light.astype(np.float32), cover)


def film_low_drop(
    scene: LowDrop, camera: Camera, path: Path, *, duration: float, seed: int = 1,
    codec: str = "mp4v",
) -> Path:  # fmt: skip
    """Write the film of a drop; its truth is in scene.block."""
    times = np.arange(int(duration * camera.rate)) / camera.rate
    return write_film(camera.film(scene.paint, times.tolist(), seed), path, camera.rate, codec)
