"""Impacts of known truth: a rounded polygonal prism that falls on a plate, rotates and rebounds.

Picture coordinates: x to the right, y down [px]; of the motion x to the right, y up [m]. Contacts
take no time and follow the equations of plane rigid-body impact (calibration.rebound.impact).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.rebound.impact import Arm, Motion, after_impact, at_contact
from calibration.rendered.backdrop import Backdrop, Colour, Patch, blend
from calibration.rendered.camera import Camera, Light, write_film

_G = 9.80665  # m/s2
_SUPER = 8  # parts of a pixel's side in which a polygon's edge is drawn
_ARC = 12  # points of a rounded corner

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Prism:
    """A prism of uniform density that is seen along its axis.

    vertices    (n, 2) of a convex polygon, counter-clockwise [m]; moved to its centroid
    rounding    radius that is added all around [m]
    """

    vertices: tuple[tuple[float, float], ...]
    rounding: float = 0.0
    colour: Colour = (0.2, 0.45, 0.75)

    def outline(self) -> Array:
        """(k, 2) points of its outline about its centroid, counter-clockwise [m]."""
        corners = np.array(self.vertices, dtype=float)
        if self.rounding > 0:
            edges = np.roll(corners, -1, axis=0) - corners
            normal = np.arctan2(-edges[:, 0], edges[:, 1])  # outwards
            first = np.roll(normal, 1)
            span = (normal - first) % (2 * np.pi)
            arc = first[:, None] + span[:, None] * np.linspace(0, 1, _ARC)
            circle = np.stack([np.cos(arc), np.sin(arc)], axis=2)
            corners = (corners[:, None] + self.rounding * circle).reshape(-1, 2)
        return np.asarray(corners - moments(corners)[1])

    def gyration(self) -> float:
        """Radius of gyration about the axis through the centroid [m]."""
        return moments(self.outline())[2]


def moments(outline: Array) -> tuple[float, Array, float]:
    """Area, centroid and radius of gyration of a polygon (Green's theorem)."""
    x, y = outline.T
    u, v = np.roll(outline, -1, axis=0).T
    cross = x * v - u * y
    area = float(cross.sum() / 2)
    centroid = np.array([np.sum((x + u) * cross), np.sum((y + v) * cross)]) / (6 * area)
    polar = float(np.sum((x * x + x * u + u * u + y * y + y * v + v * v) * cross) / 12)
    return area, centroid, math.sqrt(polar / area - float(centroid @ centroid))


class Contact(NamedTuple):
    """Truth of one contact: when [s], the point from the centroid, the motion before and after."""

    time: float
    arm: Arm
    before: Motion
    after: Motion

    @property
    def restitution(self) -> float:
        """Newton's, at the point of contact."""
        return -at_contact(self.after, self.arm)[1] / at_contact(self.before, self.arm)[1]

    @property
    def apparent(self) -> float:
        """Ratio of the centroid's normal velocities."""
        return -self.after.n / self.before.n


class _Flight(NamedTuple):
    """Free flight from a moment on: position, angle and velocities there [m, rad, s]."""

    time: float
    position: Array
    angle: float
    velocity: Array
    omega: float

    def at(self, time: float) -> tuple[Array, float]:
        """Position of the centroid, and the angle."""
        s = time - self.time
        fall = np.array([0.0, -_G * s * s / 2])
        return self.position + self.velocity * s + fall, self.angle + self.omega * s


@dataclass(frozen=True)
class PrismScene:
    """A prism that falls on a plate through the origin, before a backdrop.

    height        of its centroid above the plate at the start [m]
    velocity      then, x and y [m/s]
    omega         angular velocity then, counter-clockwise [rad/s]
    angle         then [rad]
    restitution, tangential, friction   of the contact; see after_impact
    tilt          of the plate, counter-clockwise [rad]
    scale         m/px
    plate         y of the plate's edge below the prism at the start, as a share of the height
    position      x at the start, as a share of the width
    """

    prism: Prism
    height: float = 0.06
    velocity: tuple[float, float] = (0.05, -0.3)
    omega: float = 8.0
    angle: float = 0.3
    restitution: float = 0.6
    tangential: float = 0.0
    friction: float = 0.3
    tilt: float = 0.0
    width: int = 320
    image_height: int = 320
    scale: float = 0.4e-3
    plate: float = 0.88
    position: float = 0.4
    backdrop: Backdrop = field(default_factory=Backdrop)

    def flights(self, duration: float) -> tuple[list[_Flight], list[Contact]]:
        """Flights and contacts until a time [s]."""
        start = np.array([0.0, self.height])
        flights = [_Flight(0.0, start, self.angle, np.array(self.velocity), self.omega)]
        contacts: list[Contact] = []
        while (time := self._touches(flights[-1], duration)) is not None:
            last = flights[-1]
            position, angle = last.at(time)
            arm = self._lowest(angle)
            velocity = last.velocity + np.array([0.0, -_G * (time - last.time)])
            t, n = self._axes() @ velocity
            before = Motion(float(t), float(n), last.omega)
            after = after_impact(
                before, arm, self.prism.gyration(), self.restitution, self.tangential,
                self.friction,
            )  # fmt: skip
            contacts.append(Contact(time, arm, before, after))
            velocity = self._axes().T @ np.array([after.t, after.n])
            flights.append(_Flight(time, position, angle, velocity, after.omega))
        return flights, contacts

    def _axes(self) -> Array:
        """Rows: tangent and normal of the plate."""
        c, s = math.cos(self.tilt), math.sin(self.tilt)
        return np.array([[c, s], [-s, c]])

    def _lowest(self, angle: float) -> Arm:
        """The outline's point nearest to the plate, from the centroid."""
        points = rotated(self.prism.outline(), angle) @ self._axes().T
        t, n = points[np.argmin(points[:, 1])]
        return Arm(float(t), float(n))

    def _gap(self, flight: _Flight, time: float) -> float:
        position, angle = flight.at(time)
        return float(self._axes()[1] @ position) + self._lowest(angle).n

    def _touches(self, flight: _Flight, until: float) -> float | None:
        """Time of the next contact; None before `until`."""
        from scipy.optimize import brentq

        times = np.arange(flight.time + 1e-4, until, 5e-4)
        gaps = [self._gap(flight, time) for time in times]
        for k in range(1, len(times)):
            if gaps[k] <= 0 < gaps[k - 1]:
                return float(brentq(lambda t: self._gap(flight, t), times[k - 1], times[k]))
        return None

    def placed(self, flights: Sequence[_Flight], time: float) -> tuple[Array, float]:
        """Centroid in the picture [px], and angle [rad] at a time."""
        flight = [one for one in flights if one.time <= time or one is flights[0]][-1]
        position, angle = flight.at(time)
        return self._in_picture(position), angle

    def _in_picture(self, point: Array) -> Array:
        origin = np.array([self.position * self.width, self.plate * self.image_height])
        return np.asarray(origin + point * np.array([1, -1]) / self.scale)

    def paint(self, flights: Sequence[_Flight], time: float) -> Light:
        """Light of the scene at a time [s], (height, width, 3)."""
        edge = self.plate * self.image_height
        light = self.backdrop.paint(self.width, self.image_height, 2 * self.image_height, 0, (0, 0))
        slope, far = math.tan(self.tilt), 2.0 * self.width
        middle = self.position * self.width
        ends = [(middle - far, edge + slope * far), (middle + far, edge - slope * far)]
        ground = [*ends, (middle + far, edge + far), (middle - far, edge + far)]
        blend(light, polygon(np.array(ground), self.backdrop.plate, light.shape[:2]))
        centre, angle = self.placed(flights, time)
        points = rotated(self.prism.outline(), angle) * np.array([1, -1]) / self.scale
        blend(light, polygon(centre + points, self.prism.colour, light.shape[:2]))
        return light


def rotated(points: Array, angle: float) -> Array:
    """(k, 2) points rotated counter-clockwise where y counts upwards."""
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def polygon(points: Array, colour: Colour, shape: tuple[int, ...]) -> Patch:
    """A polygon of one colour; its cover of each pixel from parts of the pixel.

    points   (k, 2) x, y [px]
    shape    of the picture; what lies beyond it is cut off
    """
    import cv2

    low = np.clip(np.floor(points.min(axis=0)).astype(int) - 1, -1, [shape[1], shape[0]])
    high = np.clip(np.ceil(points.max(axis=0)).astype(int) + 2, 0, [shape[1] + 1, shape[0] + 1])
    columns, rows = np.maximum(high - low, 1)
    fine = np.zeros((rows * _SUPER, columns * _SUPER), np.uint8)
    shift = 8
    # the middle of pixel 0 is 0; of its parts the first one's middle is (1 - 1/_SUPER)/2 below it
    inner = (points - low + 0.5) * _SUPER - 0.5
    cv2.fillPoly(fine, [np.rint(inner * 2**shift).astype(np.int32)], 255, shift=shift)
    cover = cv2.resize(fine, (int(columns), int(rows)), interpolation=cv2.INTER_AREA) / np.float32(
        255
    )
    light = np.broadcast_to(np.array(colour, dtype=np.float32), (*cover.shape, 3))
    return Patch(int(low[1]), int(low[0]), light, np.asarray(cover, dtype=np.float32))


@dataclass(frozen=True)
class Truth:
    """Truth of a film.

    contacts    within it
    path        (frames, 2) centroid [px]
    angle       (frames,) counter-clockwise [rad]
    gyration    [m]
    rate, scale  frames/s, m/px
    """

    contacts: tuple[Contact, ...]
    path: Array
    angle: Array
    gyration: float
    rate: float
    scale: float


def film_prism(
    scene: PrismScene, camera: Camera, path: Path, *, duration: float = 0.25, seed: int = 1,
    codec: str = "mp4v", header: float | None = None,
) -> Truth:  # fmt: skip
    """Write the film of a scene, and what it shows.

    header   frames/s that the file says, where not the camera's
    """
    flights, contacts = scene.flights(duration)
    times = [k / camera.rate for k in range(int(duration * camera.rate))]
    pictures = camera.film(lambda time: scene.paint(flights, time), times, seed)
    write_film(pictures, path, header or camera.rate, codec)
    placed = [scene.placed(flights, time) for time in times]
    return Truth(
        tuple(contacts), np.array([one[0] for one in placed]), np.array([one[1] for one in placed]),
        scene.prism.gyration(), camera.rate, scene.scale,
    )  # fmt: skip
