"""The film that a camera would take of a simulated discharge, and what is true of it.

Particles are painted where the run folder has them, layers dark and light in turn as in the paper
(Granular Matter 15 (2013) 811, sec. 4), each with a texture of its own that rotates with it.
Between stored frames positions and angles follow cubics through stored ones and velocities;
particles that have left fall freely. x counts from the silo's left side, y from the outlet upwards.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.rendered.camera import Camera, Light
from calibration.tracking.film.reader import Picture
from silo2d.measures.basics.walls import outwards
from silo2d.view.scene import Scene, read_scene

Floats = NDArray[np.float64]

_GRAVITY = 9.80665
_FINER = 2  # times, each way, in which a scene is painted before it becomes pixels
_SHIFT = 4  # OpenCV takes corners in sixteenths of a pixel
_TEXELS = 512
_MARGIN = 0.02  # m around the walls
_WALL = 0.006  # m, how thick walls are drawn


@dataclass(frozen=True)
class Look:
    """Scene before the camera.

    scale          m/px
    paint, bare    colour of the painted and of the other layers (blue, green, red), of 1
    backing        colour behind the particles; walls and surroundings have their own
    texture        standard deviation of a particle's texture, of 1
    texture_size   m over which the texture changes
    lead           s of film before the silo opens
    rest           s of film after the last particle has left, or after the last frame
    """

    scale: float = 1e-3
    paint: tuple[float, float, float] = (0.16, 0.26, 0.38)
    bare: tuple[float, float, float] = (0.58, 0.72, 0.80)
    backing: tuple[float, float, float] = (0.06, 0.06, 0.06)
    wall: tuple[float, float, float] = (0.35, 0.35, 0.33)
    around: tuple[float, float, float] = (0.12, 0.11, 0.10)
    texture: float = 0.06
    texture_size: float = 1.5e-3
    lead: float = 0.1
    rest: float = 0.15


class Poses(NamedTuple):
    """Particles that are shown (n,): which, where [m], and their angles [rad]."""

    which: NDArray[np.int64]
    x: Floats
    y: Floats
    angle: Floats


class Stage:
    """A run as a scene that can be painted at any time; time 0 is the opening."""

    def __init__(self, folder: str | Path, look: Look, seed: int = 1) -> None:
        self.scene: Scene = read_scene(folder)
        self.look = look
        left, right, bottom, top = self.scene.window
        self.left, self.top = left - _MARGIN, top + _MARGIN
        size = (right - left + 2 * _MARGIN) / look.scale, (self.top - bottom) / look.scale
        self.width, self.height = (2 * round(side / 2) for side in size)  # codecs want even sizes
        random = np.random.default_rng(seed)
        self._texture = _texture(look.texture_size / look.scale * _FINER, random)
        self._origin = random.uniform(0, _TEXELS, (2, self.scene.n_particles)).astype(np.float32)
        painted = self.scene.trajectory.static["layer"] % 2 == 0
        self._colour = np.where(painted[:, None], look.paint, look.bare).astype(np.float32)

    def pixels(self, points: Floats) -> Floats:
        """Points (..., 2) [m] in the picture [px], y down; pixel k reaches from k to k + 1."""
        return (points - (self.left, self.top)) * (1, -1) / self.look.scale

    def paint(self, time: float) -> Light:
        """The scene at a time of the run [s]."""
        import cv2

        canvas = self._surroundings(time)
        poses = poses_at(self.scene, time)
        self._fill(canvas, self.index(poses), poses)
        size = self.width, self.height
        return np.asarray(cv2.resize(canvas, size, interpolation=cv2.INTER_AREA), np.float32)

    def index(self, poses: Poses) -> NDArray[np.int32]:
        """Index of the position that each fine pixel shows (2 height, 2 width); -1 for none."""
        import cv2

        index = np.full((self.height * _FINER, self.width * _FINER), -1, np.int32)
        for k, outline in self._outlines(poses):
            cv2.fillConvexPoly(index, outline, k, cv2.LINE_8, _SHIFT)
        return index

    def _surroundings(self, time: float) -> Light:
        """Backing and walls, and the door as long as it is there."""
        import cv2

        shape = self.height * _FINER, self.width * _FINER
        canvas = np.full((*shape, 3), self.look.around, np.float32)
        walls = self.scene.walls
        inside = walls.reshape(-1, 2)
        cv2.fillPoly(canvas, [self._corners(inside)], self.look.backing, cv2.LINE_8, _SHIFT)
        frame = int(np.searchsorted(self.scene.time, time, side="right")) - 1
        door = self.scene.trajectory.static["wall_segments"][-1:]
        walls = np.concatenate([walls, door if time < 0 else self.scene.door(max(frame, 0))])
        outside = _WALL * outwards(walls)[:, None, :]
        for wall in np.concatenate([walls, (walls + outside)[:, ::-1]], axis=1):
            cv2.fillConvexPoly(canvas, self._corners(wall), self.look.wall, cv2.LINE_8, _SHIFT)
        return canvas

    def _corners(self, points: Floats) -> NDArray[np.int32]:
        """Points [m] as OpenCV takes them, whose pixel k reaches from k - 1/2 to k + 1/2."""
        return np.rint((self.pixels(points) * _FINER - 0.5) * 2**_SHIFT).astype(np.int32)

    def _outlines(self, poses: Poses) -> Iterator[tuple[int, NDArray[np.int32]]]:
        static = self.scene.trajectory.static
        points, start, kind = static["shape_points"], static["shape_start"], static["kind"]
        for k, particle in enumerate(poses.which):
            px, py = points[start[kind[particle]] : start[kind[particle] + 1]].T
            cos, sin = np.cos(poses.angle[k]), np.sin(poses.angle[k])
            around = np.column_stack([px * cos - py * sin, px * sin + py * cos])
            yield k, self._corners(around + np.array([poses.x[k], poses.y[k]]))

    def _fill(self, canvas: Light, index: NDArray[np.int32], poses: Poses) -> None:
        """Give every pixel of a particle its colour and the texture there."""
        import cv2

        row, column = np.nonzero(index >= 0)
        k = index[row, column]
        particle = poses.which[k]
        at = self.pixels(np.column_stack([poses.x, poses.y])).astype(np.float32) * _FINER
        dx, dy = column + 0.5 - at[k, 0], row + 0.5 - at[k, 1]
        cos, sin = (f(poses.angle).astype(np.float32)[k] for f in (np.cos, np.sin))
        maps = np.zeros((2, *index.shape), np.float32)
        maps[0, row, column] = np.mod(dx * cos - dy * sin + self._origin[0, particle], _TEXELS)
        maps[1, row, column] = np.mod(dx * sin + dy * cos + self._origin[1, particle], _TEXELS)
        texture = cv2.remap(
            self._texture, maps[0], maps[1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP
        )
        shade = self.look.texture * texture[row, column]
        canvas[row, column] = self._colour[particle] + shade[:, None]


def poses_at(scene: Scene, time: float) -> Poses:
    """Particles that have not been dropped, at a time of the run [s]; before it, as it began."""
    stored, frames = scene.time, scene.trajectory
    time = max(time, 0.0)
    k = int(np.clip(np.searchsorted(stored, time, side="right") - 1, 0, len(stored) - 1))
    n = min(k + 1, len(stored) - 1)
    which = np.flatnonzero(frames["inside"][k])
    step, ahead = stored[n] - stored[k], time - stored[k]
    both = frames["inside"][n][which] & (n > k)
    out = []
    for position, rate, pull in (("x", "vx", 0.0), ("y", "vy", -_GRAVITY), ("angle", "spin", 0.0)):
        p0, v0 = (frames[key][k][which].astype(float) for key in (position, rate))
        p1, v1 = (frames[key][n][which].astype(float) for key in (position, rate))
        s = ahead / step if n > k else 0.0
        cubic = (
            p0 + s * step * v0 + s * s * (3 * (p1 - p0) - step * (2 * v0 + v1))
            + s**3 * (2 * (p0 - p1) + step * (v0 + v1))
        )  # fmt: skip
        resting = (frames["y"][k][which] > 0) & (n == k)  # the run has ended: what stays, stays
        free = np.where(resting, p0, p0 + v0 * ahead + pull * ahead**2 / 2)
        out.append(np.where(both, cubic, free))
    return Poses(which, *out)


def film_of_run(stage: Stage, camera: Camera, seed: int = 1) -> tuple[Floats, Iterator[Picture]]:
    """Times of the pictures (n,) [s of the run] and the pictures of a whole discharge.

    The first picture stands `lead` before the opening, less a part of a frame drawn by chance.
    """
    out = stage.scene.trajectory["out_time"][-1]
    end = max(float(stage.scene.time[-1]), float(np.nanmax(out, initial=0.0))) + stage.look.rest
    late = np.random.default_rng(seed).uniform() / camera.rate
    count = int((stage.look.lead + end) * camera.rate) + 1
    times = np.arange(count) / camera.rate - stage.look.lead + late
    return times, camera.film(stage.paint, times, seed)


def _texture(size: float, random: np.random.Generator) -> NDArray[np.float32]:
    """Noise (512, 512) that changes over `size` texels, three times as slowly along the fibres."""
    import cv2

    noise = random.standard_normal((_TEXELS, _TEXELS)).astype(np.float32)
    smooth = cv2.GaussianBlur(noise, (0, 0), 3 * size / 2, sigmaY=size / 2,
                              borderType=cv2.BORDER_REFLECT)  # fmt: skip
    return np.asarray(smooth / smooth.std(), np.float32)


def simulated(case: str | Path, out: str | Path) -> Path:
    """Run a case file; the run folder, below `out`."""
    from silo2d.case.case import SiloCase
    from silo2d.run.protocol import run

    return Path(run(SiloCase.load(case), out=out).run_folder)


def truth(
    folder: str | Path, stage: Stage, times: Floats, camera: Camera, interval: float
) -> dict[str, Any]:
    """Truth of a film, in SI; `times` of its pictures [s of the run].

    opening_frame    number of the picture, with a part of one, at the opening
    silo_px          x, y, width, height of the silo's inside, outlet to rim
    layers           lines as in silo2d.measures.profile, x from the silo's left side
    """
    from silo2d.measures.profile import measure

    scene, look = stage.scene, stage.look
    left, right, _, _ = scene.window
    (x0, y0), (x1, y1) = stage.pixels(np.array([[left, scene.walls[..., 1].max()], [right, 0.0]]))
    lips = np.array(scene.trajectory.attributes["lips"])[:, 0] - left
    profile = measure(Path(folder), interval)
    out = np.sort(scene.trajectory["out_time"][-1])
    known = out[np.isfinite(out)]
    return {
        "frames_per_s": camera.rate,
        "scale_m_per_px": look.scale,
        "silo_px": [float(x0), float(y0), float(x1 - x0), float(y1 - y0)],
        "silo_width_m": right - left,
        "outlet_m": lips.tolist(),
        "opening_frame": float(-times[0] * camera.rate),
        "outcome": scene.summary.get("outcome"),
        "discharge_time_s": scene.summary.get("discharge_time_s"),
        "last_out_s": float(known[-1]) if len(known) else None,
        "out_times_s": known.tolist(),
        "n_grains": scene.n_particles,
        "column_edges_m": (np.array(profile["column_edges_m"]) - left).tolist(),
        "interval_s": interval,
        "times_s": profile["times_s"],
        "layers": profile["layers"],
        "mass_in_silo_kg": _mass_in_silo(scene, np.array(profile["times_s"])),
    }


def _mass_in_silo(scene: Scene, times: Floats) -> list[float]:
    out, mass = scene.trajectory["out_time"][-1], scene.trajectory.static["mass"]
    return [float(mass[~(out <= time)].sum()) for time in times]


def packing_truth(stage: Stage) -> dict[str, Any]:
    """Truth of a picture before the opening, in SI, heights over the floor.

    silo_px    x, y, width, height of the silo's inside, floor to rim
    height     mean over the silo's width of the highest point of any particle there
    layers     mean height of the particles' centroids, by their mass
    """
    scene, look = stage.scene, stage.look
    left, right, _, _ = scene.window
    (x0, y0), (x1, y1) = stage.pixels(np.array([[left, scene.walls[..., 1].max()], [right, 0.0]]))
    filled = stage.index(poses_at(scene, 0.0)) >= 0
    columns = filled[:, round(x0 * _FINER) : round(x1 * _FINER)]
    highest = y1 - columns.argmax(axis=0) / _FINER
    static, y = scene.trajectory.static, scene.trajectory["y"][0]
    layer, mass = static["layer"], static["mass"]
    return {
        "silo_px": [float(x0), float(y0), float(x1 - x0), float(y1 - y0)],
        "height_m": float(highest.mean() * look.scale),
        "layers_m": [
            float(np.average(y[layer == k], weights=mass[layer == k])) for k in np.unique(layer)
        ],
    }
