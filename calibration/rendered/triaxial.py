"""Triaxial tests of known truth: two blocks with dots, pressed together at an inclined contact.

Picture coordinates: x to the right, y down, whole numbers in the middle of a pixel [px]. The upper
block moves as a rigid body relative to the lower one: approach, slip and rotation about the middle
of the contact, each a softening function of the load as it grows and a line as it falls.
"""

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.rendered.backdrop import Backdrop, Colour, blend
from calibration.rendered.camera import Camera, Light, write_film
from calibration.rendered.particle import polygon

_WOOD: Colour = (0.45, 0.62, 0.75)
_SHADE = 0.93  # light of the lower block in that of the upper
_DOT: Colour = (0.08, 0.08, 0.1)
_LASTING = 0.4  # share of a first loading's displacement that stays, as asperities flatten
_CORNERS = 24  # of a dot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TriaxialScene:
    """Two blocks between platens; lengths in m, angles in rad.

    kn, kt         of the contact as the load falls [N/m]
    inclination    of the contact to the horizontal, downhill to the right
    eccentricity   of the load's line to the right of the contact's middle
    k_rotation     rotational stiffness [N m/rad]
    load           highest of the cycles [N]
    cycles         of loading and unloading to a tenth
    period         of one cycle [s]
    dots           of each block
    dot            radius of a dot [px]
    tremble        of both blocks together [px], as a press does
    """

    kn: float = 2e7
    kt: float = 4e6
    inclination: float = math.radians(15)
    eccentricity: float = 0.5e-3
    k_rotation: float = 300.0
    load: float = 2000.0
    cycles: int = 3
    period: float = 4.0
    dots: int = 4
    dot: float = 4.0
    tremble: float = 0.2
    width: int = 240
    height: int = 240
    scale: float = 0.08e-3
    seed: int = 1
    backdrop: Backdrop = field(default_factory=Backdrop)

    @property
    def middle(self) -> Array:
        """(2,) of the contact [px]."""
        return np.array([self.width / 2, self.height / 2])

    @property
    def half(self) -> float:
        """Half the blocks' width [px]."""
        return 0.36 * self.width

    @property
    def contact(self) -> tuple[float, float, float, float]:
        """Ends of the contact in the first frame [px]."""
        (x, y), rise = self.middle, self.half * math.tan(self.inclination)
        return x - self.half, y - rise, x + self.half, y + rise

    @property
    def load_line(self) -> float:
        """Position along x of the line of load [px]."""
        return float(self.middle[0]) + self.eccentricity / self.scale

    def force(self, time: Array) -> Array:
        """Load at times [s], up and down between its highest and a tenth of it [N]."""
        phase = np.asarray(time) / self.period
        share = 1 - np.abs(2 * (phase % 1) - 1)
        low = np.where(phase < 0.5, 0.0, 0.1)
        over = phase >= self.cycles
        return np.where(over, 0.1, low + (1 - low) * share) * self.load

    def _effective(self, time: Array) -> Array:
        """Load for which the contact is as it is: what flattened in the first loading stays [N]."""
        force = self.force(time)
        first = np.asarray(time) < self.period / 2
        soft = force + _LASTING * self.load * np.sqrt(np.clip(force / self.load, 0, 1))
        return np.where(first, soft, force + _LASTING * self.load)

    def motion(self, time: float) -> tuple[Array, float]:
        """Displacement of the upper block at the contact's middle [px], and rotation, clockwise."""
        force = float(self._effective(np.array(time)))
        c, s = math.cos(self.inclination), math.sin(self.inclination)
        along, across = force * s / self.kt, force * c / self.kn
        moved = along * np.array([c, s]) + across * np.array([-s, c])
        return moved / self.scale, force * self.eccentricity / self.k_rotation

    def _blocks(self) -> tuple[Array, Array]:
        """Corners of the upper and the lower block in the first frame."""
        x0, y0, x1, y1 = self.contact
        top, bottom = 0.04 * self.height, 0.96 * self.height
        return (
            np.array([[x0, top], [x1, top], [x1, y1], [x0, y0]]),
            np.array([[x0, y0], [x1, y1], [x1, bottom], [x0, bottom]]),
        )

    def _dots(self) -> tuple[Array, Array]:
        """Dots of the upper and the lower block in the first frame, on two rows, irregular."""
        random = np.random.default_rng(self.seed)
        rows = []
        for side in (-1, 1):
            across = np.linspace(-0.75, 0.75, self.dots) * self.half
            near = side * (3 * self.dot + 12 + 14 * (np.arange(self.dots) % 2))
            spots = np.stack([across, near + across * math.tan(self.inclination)], axis=1)
            rows.append(self.middle + spots + random.uniform(-2, 2, spots.shape))
        return rows[0], rows[1]

    def paint(self, time: float) -> Light:
        """Light of the scene at a time [s], (height, width, 3)."""
        light = self.backdrop.paint(self.width, self.height, 2 * self.height, 0, (0, 0))
        shake = self.tremble * np.array([math.sin(7 * time), math.cos(5.3 * time) - 1])
        moved, turn = self.motion(time)
        upper, lower = self._blocks()
        upper_dots, lower_dots = self._dots()
        c, s = math.cos(turn), math.sin(turn)
        rotation = np.array([[c, s], [-s, c]])  # of row vectors, from x to y

        def placed(points: Array) -> Array:
            return np.asarray((points - self.middle) @ rotation + self.middle + moved + shake)

        shaded = tuple(_SHADE * one for one in _WOOD)
        blend(light, polygon(lower + shake, (shaded[0], shaded[1], shaded[2]), light.shape[:2]))
        blend(light, polygon(placed(upper), _WOOD, light.shape[:2]))
        angles = 2 * np.pi * np.arange(_CORNERS) / _CORNERS
        circle = self.dot * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        for spot in [*placed(upper_dots), *(lower_dots + shake)]:
            blend(light, polygon(spot + circle, _DOT, light.shape[:2]))
        return light


def film_triaxial(
    scene: TriaxialScene, camera: Camera, path: Path, record: Path, *, noise: float = 0.002,
    late: float = 0.0, seed: int = 1, codec: str = "mp4v",
) -> None:  # fmt: skip
    """Write the film of a scene and the record of its load, with columns time and load.

    noise   of the load cell, in the highest load
    late    time of the film when the record begins [s]
    """
    duration = scene.cycles * scene.period
    times = [k / camera.rate for k in range(int(duration * camera.rate))]
    write_film(camera.film(scene.paint, times, seed), path, camera.rate, codec)
    clock = np.arange(0.0, duration - late, 0.05)
    random = np.random.default_rng(seed)
    load = scene.force(clock + late) + noise * scene.load * random.standard_normal(len(clock))
    lines = [f"{t:.3f},{f:.3f}" for t, f in zip(clock, load, strict=True)]
    record.write_text(
        "time [s],load [N]\n" + "\n".join(lines) + "\n", encoding="utf-8", newline="\n"
    )
