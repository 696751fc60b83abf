"""The page that plays a damper's run: particles in their enclosure, forces, velocities."""

from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damper3d.engine.enclosures import Enclosure, nearest_of
from damper3d.shapes.surfaces.skin import OF_A_CELL, skin
from damper3d.view.charts import COLOURS, WALL_COLOURS
from damper3d.view.colouring import power
from damper3d.view.scene import Scene, read_scene
from granulab.campaign.output.figure import BLUE, VERMILION
from granulab.campaign.output.page.packing import Quantised, counted, linear
from granulab.campaign.output.page.player import (
    Colour,
    Line,
    Recording,
    Touching,
    colours_of,
    player,
)
from granulab.campaign.runs.ragged import Tables
from granulab.campaign.runs.trajectory import stored_tables
from granulab.errors import FolderError

Floats = NDArray[np.float64]

_PLACES = 2**14  # steps of a position in the enclosure's longest side
_TURNS = 2.0**-12  # of a component of a unit quaternion
_CYCLES = 3  # that a curve shows at once
_LAYERS = 2, 12  # of the bed at the start, at least and at most
# Of all particles' surfaces together: twice as many take twice the time without a graphics card.
_TRIANGLES = 50_000
_CELLS = 7, 20  # along a particle, at least and at most
_SHARP = 0.87  # cosine between two faces, below which the edge between them is always drawn
_LONG = 20.0  # [s] of a run whose times are in seconds
_KEPT_WHOLE = 'run it with output.keep = "all" and output.frames above 0'


def player_page(run_folder: str | Path, most_bytes: float) -> tuple[str, str]:
    """The page of a finished run, and a remark where frames were left out.

    Raises FolderError where the run cannot be read, is not finished or kept no frames.
    """
    scene = read_scene(run_folder)
    if not scene.summary:
        cure = "wait until it is finished, or go on with it: damper3d run --resume"
        raise FolderError(f"{run_folder}: unfinished; {cure}")
    if not len(scene.tables):
        raise FolderError(f"{run_folder}: kept no particles (output.frames = 0); {_KEPT_WHOLE}")
    contacts = stored_tables(run_folder).get("contacts")
    recorder = _Recorder(Path(run_folder), scene, contacts)
    return player(recorder.record, scene.time[scene.frame_sample], most_bytes)


class _Recorder:
    """Recordings of a run; what they share is made once."""

    def __init__(self, folder: Path, scene: Scene, contacts: Tables | None) -> None:
        self.folder, self.scene, self.contacts = folder, scene, contacts
        self.frames = len(scene.tables)
        particles = [scene.particles(frame) for frame in range(self.frames)]
        self.position = np.array([p.position for p in particles])
        self.velocity = np.array([p.velocity for p in particles])
        self.dissipated = np.array([p.dissipated for p in particles])

    def record(self, frames: NDArray[np.int64]) -> Recording:
        """What a page shows of some frames."""
        scene, n = self.scene, len(self.scene.radius)
        recording = Recording(self._data())
        recording.arrays |= {**self._places(frames), **self._shapes(frames), **_walls(scene.enclosure)}
        self._colour(recording, frames)
        time = scene.time[scene.frame_sample]
        taken = recording.add_contacts(self.touching, time, frames, n, colours_of("YlOrRd"))
        if taken and not scene.of_many_spheres:
            recording.add_decades(
                "stress (pressure)", "Pa", np.maximum(self.pressures[taken], 0.0),
                colours_of("YlGnBu"), name="stress", per="moment",
            )  # fmt: skip
        recording.add_wall_forces(scene.trajectory["wall_force"][scene.frame_sample[frames]])
        self._curves(recording)
        return recording

    @cached_property
    def shift(self) -> Floats:
        """Displacement of the enclosure in each frame (F, 3) [m]."""
        return np.array([self.scene.shift(frame) for frame in range(self.frames)])

    def _data(self) -> dict[str, Any]:
        scene, low, high = self.scene, *_box(self.scene.enclosure)
        in_seconds = scene.time[-1] > _LONG
        middles = {
            name: np.mean([p.mean(axis=0) for n, p in scene.enclosure.polygons if n == name], axis=0)
            for name, _ in scene.enclosure.polygons
        }
        usual = scene.enclosure.middle
        return {
            "name": self.folder.resolve().name,
            "title": scene.title,
            "outcome": scene.outcome,
            "particles": len(scene.radius),
            "clock": {"unit": "s", "factor": 1.0, "digits": 3} if in_seconds
                     else {"unit": "ms", "factor": 1e3, "digits": 2},
            "period": None if scene.settings.excitation.kind else scene.period,
            "facts": _facts(scene.summary),
            "pull_words": "" if scene.of_many_spheres else "Orange pulls.",
            "walls": [
                {"name": name, "middle": np.round(middles.get(name, usual), 6).tolist()}
                for name in scene.wall_names
            ],
            "space": {
                **{name: axis.tolist() for name, axis in scene.view._asdict().items()},
                "inner_low": low.tolist(),
                "inner_high": high.tolist(),
                "low": (low + self.shift.min(axis=0)).tolist(),
                "high": (high + self.shift.max(axis=0)).tolist(),
                "moves": bool(np.ptp(self.shift, axis=0).max() > 0.0),
                "reach": self._reach,
            },
        }  # fmt: skip

    @property
    def _reach(self) -> float:
        """Largest distance of a particle's surface from its centre [m]."""
        arm, radius, _ = self.scene.spheres(0)
        return float((np.linalg.norm(arm, axis=1) + radius).max())

    def _places(self, frames: NDArray[np.int64]) -> dict[str, Quantised]:
        position = self.position[frames]
        step = float(self.scene.size.max()) / _PLACES
        return {
            "position": linear(position.reshape(len(frames), -1), step, order=2),
            "shift": linear(self.shift[frames], 0.0, order=2),
            "radius": linear(self.scene.radius, 0.0),
        }

    def _shapes(self, frames: NDArray[np.int64]) -> dict[str, Quantised]:
        """Orientations and the surface of multi-sphere particles."""
        scene, static = self.scene, self.scene.trajectory.static
        if not scene.of_many_spheres:
            return {}
        turns = np.array([scene.orientation(frame) for frame in frames])
        # A rotation has two quaternions: the one that is nearer to that of the frame before.
        flips = np.sign((turns[1:] * turns[:-1]).sum(axis=2))
        turns[1:] *= np.cumprod(np.where(flips == 0.0, 1.0, flips), axis=0)[:, :, None]
        cells = np.sqrt(_TRIANGLES / len(scene.radius) / OF_A_CELL)
        surface = skin(
            static["sphere_offset"], static["sphere_radius"], int(np.clip(cells, *_CELLS))
        )
        spheres = np.column_stack([static["sphere_offset"], static["sphere_radius"]])
        return {
            "turn": linear(turns.reshape(len(frames), -1), _TURNS, order=2),
            "sphere": linear(spheres, 0.0),
            "surface_corner": linear(surface.corners, 0.0),
            "surface_normal": linear(surface.normals, 1e-3),
            "surface_triangle": counted(surface.triangles.ravel()),
        }

    def _colour(self, recording: Recording, frames: NDArray[np.int64]) -> None:
        scene, velocity = self.scene, self.velocity[frames]
        if scene.kinds > 1:
            names = [f"kind {k + 1}" for k in range(scene.kinds)]
            recording.arrays["kind"] = counted(scene.kind)
            tones = colours_of("Set2", 8)
            tones = [tones[k % 8] for k in range(scene.kinds)]
            recording.add_colour(Colour("kind", "", "particle", "kind", tones, names=names))
        along = velocity @ scene.direction
        recording.arrays["along"] = linear(along, float(np.ptp(along)) / 1000 or 1.0)
        limit = max(scene.peak_speed, float(np.percentile(np.abs(along), 99)))
        recording.add_colour(
            Colour("velocity along the motion", "m/s", "frame", "along", colours_of("coolwarm"),
                   -limit, limit)
        )  # fmt: skip
        speed = np.linalg.norm(velocity, axis=2)
        recording.add_scale("speed", "m/s", speed, colours_of("viridis"), name="speed")
        gained = self.dissipated[frames] - self.dissipated[0]
        recording.add_scale("energy dissipated so far", "J", gained, colours_of("plasma"), name="heat")
        recording.add_decades(
            "power dissipated", "W", self.power[frames], colours_of("YlOrRd"), name="power",
            per="frame",
        )  # fmt: skip
        layer, count = self._layers()
        recording.arrays["layer"] = counted(layer)
        names = [f"layer {k + 1}" for k in range(count)]
        recording.add_colour(
            Colour("layer at the start", "", "particle", "layer", colours_of("viridis", count),
                   names=names, numbered=True)
        )  # fmt: skip

    @cached_property
    def power(self) -> Floats:
        """Dissipated at each particle since the frame before (F, n) [W]."""
        return np.array([power(self.scene, frame) for frame in range(self.frames)])

    def _layers(self) -> tuple[NDArray[np.int64], int]:
        """Layer of each particle at the start, from the bottom, and how many: a diameter each."""
        height = self.position[0] @ self.scene.view.up
        span = float(np.ptp(height)) or 1.0
        count = int(np.clip(round(span / (2 * float(self.scene.radius.mean()))), *_LAYERS))
        return np.minimum((height - height.min()) / span * count, count - 1).astype(np.int64), count

    @cached_property
    def touching(self) -> list[Touching]:
        """Pairs that touch, in the frames with contacts."""
        if self.contacts is None:
            return []
        frame_of = {int(sample): k for k, sample in enumerate(self.scene.frame_sample)}
        found = [(frame_of.get(int(s)), k) for k, s in enumerate(self.contacts.frame)]
        return [self._touching(frame, k) for frame, k in found if frame is not None]

    def _touching(self, frame: int, k: int) -> Touching:
        bodies, force, normal, distance = self._pairs(frame, k)
        n = len(self.scene.radius)
        at_wall = bodies[:, 1] >= n
        pulls = (force * normal).sum(axis=1) < 0.0
        if self.scene.of_many_spheres:
            pulls = np.zeros(len(pulls), bool)  # the normals of their contacts are not kept
        branch = distance[at_wall, None] * normal[at_wall]
        return Touching(frame, bodies, np.linalg.norm(force, axis=1), pulls, branch)

    def _pairs(self, frame: int, k: int) -> tuple[NDArray[np.int64], Floats, Floats, Floats]:
        """Bodies (c, 2) that touch, force on the second (c, 3) [N], unit vector towards it (c, 3).

        And the distance of a centre from the other or from the wall (c,) [m].
        """
        assert self.contacts is not None
        kept = self.contacts.at(k)
        rows = np.column_stack([kept["body_1"], kept["body_2"]]).astype(np.int64)
        bodies, which = np.unique(rows, axis=0, return_inverse=True)
        bodies = bodies.reshape(-1, 2)
        force = np.zeros((len(bodies), 3))
        for axis, name in enumerate("xyz"):
            np.add.at(force[:, axis], which.ravel(), kept[f"force_{name}"].astype(float))
        n, position = len(self.scene.radius), self.position[frame]
        away = position[np.minimum(bodies[:, 1], n - 1)] - position[bodies[:, 0]]
        for row in np.flatnonzero(bodies[:, 1] >= n):
            centre = position[bodies[row, 0]]
            away[row] = _to_wall(self.scene.enclosure, int(bodies[row, 1]) - n, centre)
        distance = np.linalg.norm(away, axis=1)
        return bodies, force, away / np.maximum(distance, 1e-300)[:, None], distance

    @cached_property
    def pressures(self) -> Floats:
        """A third of the trace of the mean stress in each sphere, at each moment (M, n) [Pa].

        sigma = -(1/V) sum_c f_c (x) b_c, as silo2d.measures.basics.contacts.particle_stress has it;
        the branch of a sphere is its radius along the normal, its overlap left out.
        """
        scene = self.scene
        n, radius = len(scene.radius), scene.radius
        found = np.zeros((len(self.touching), n))
        by_frame = {int(sample): k for k, sample in enumerate(self.contacts.frame)}  # type: ignore[union-attr]
        for total, moment in zip(found, self.touching, strict=True):
            k = by_frame[int(scene.frame_sample[moment.frame])]
            bodies, force, normal, _ = self._pairs(moment.frame, k)
            pressing = (force * normal).sum(axis=1)
            for column in bodies.T:
                of = column < n
                np.add.at(total, column[of], radius[column[of]] * pressing[of])
        return found / (3.0 * 4.0 / 3.0 * np.pi * radius**3)

    def _curves(self, recording: Recording) -> None:
        scene, trajectory = self.scene, self.scene.trajectory
        time, window = scene.time, _CYCLES * scene.period
        bed = scene.along(trajectory["mean_velocity"])
        recording.add_curve(
            "velocity along the motion", "m/s", time,
            [Line("enclosure", trajectory["velocity"]), Line("bed", bed, VERMILION)],
            window=window,
        )  # fmt: skip
        force = scene.along(trajectory["wall_force"])
        walls = zip(scene.wall_names, WALL_COLOURS, strict=False)
        recording.add_curve(
            "force on the enclosure along the motion", "N", time,
            [Line("all walls", force.sum(axis=1)),
             *(Line(name, force[:, k], colour) for k, (name, colour) in enumerate(walls))],
            window=window,
        )  # fmt: skip
        by = {name: trajectory[name] - trajectory[name][0] for name in COLOURS}
        recording.add_curve(
            "energy dissipated", "J", time,
            [Line("all", np.sum(list(by.values()), axis=0)),
             *(Line(_mechanism(name), by[name], colour) for name, colour in COLOURS.items())],
        )  # fmt: skip
        recording.add_curve(
            "displacement of the enclosure", "mm", time,
            [Line("enclosure", 1e3 * trajectory["displacement"], BLUE)],
            window=None if scene.on_host else window,
        )  # fmt: skip


def _mechanism(name: str) -> str:
    how, _, between = name.partition("_particle_")
    return f"{how.replace('_', ' ')}, {'walls' if between == 'wall' else 'particles'}"


def _to_wall(enclosure: Enclosure, wall: int, point: Floats) -> Floats:
    """From a point to the nearest one of a wall (3,) [m]; walls as wall_names has them."""
    planes = enclosure.planes
    if wall < len(planes):
        normal, offset = planes[wall, :3], planes[wall, 3]
        return -(point @ normal - offset) * normal
    surface = enclosure.surface
    nearest: Callable[..., Any] = nearest_of(type(surface))
    distance, outwards, _ = nearest(surface, wall - len(planes), *map(float, point))
    return distance * np.array(outwards)


def _box(enclosure: Enclosure) -> tuple[Floats, Floats]:
    """Lower and upper corner [m] of the box round an enclosure."""
    points = np.concatenate([points for _, points in enclosure.polygons])
    return points.min(axis=0), points.max(axis=0)


def _walls(enclosure: Enclosure) -> dict[str, Quantised]:
    """Triangles of the walls (t, 3, 3), and of their edges the ends and two normals (e, 2, 3)."""
    polygons = [points for _, points in enclosure.polygons]
    triangles = [
        points[[0, k, k + 1]] for points in polygons for k in range(1, len(points) - 1)
    ]
    ends, normals = _edges(polygons)
    return {
        "face": linear(np.concatenate(triangles), 0.0),
        "edge": linear(ends, 0.0),
        "edge_normal": linear(normals, 0.0),
    }


def _edges(polygons: list[Floats]) -> tuple[Floats, Floats]:
    """Ends of the edges (e, 2, 3) [m], and unit normals of the two faces beside each (e, 2, 3).

    The normals are zeros where the edge is sharp and always drawn; else it is drawn where one of
    the faces is turned away from the eye.
    """
    beside: dict[tuple[Any, ...], list[tuple[Floats, int]]] = {}
    for points in polygons:
        normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
        normal /= max(float(np.linalg.norm(normal)), 1e-300)
        corners = [tuple(np.round(point, 9) + 0.0) for point in points]
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            beside.setdefault((min(a, b), max(a, b)), []).append((normal, 1 if a < b else -1))
    normals = np.zeros((len(beside), 2, 3))
    for row, faces in zip(normals, beside.values(), strict=True):
        if len(faces) == 2:
            (one, along), (two, other) = faces
            two = -two if along == other else two  # their corners go round alike
            if one @ two > _SHARP:
                row[:] = one, two
    return np.array(list(beside)), normals


_FACTS: dict[str, tuple[str, Callable[[Any], str]]] = {
    "n_particles": ("particles", str),
    "particles": ("shape", str),
    "fill_ratio": ("fill ratio", "{:.3f}".format),
    "efficiency": ("efficiency", "{:.3f}".format),
    "dissipated_power_w": ("power dissipated", "{:.4g} W".format),
    "loss_factor": ("loss factor", "{:.3f}".format),
    "peak_wall_force_n": ("largest force on it", "{:.4g} N".format),
    "phase": ("motion", lambda phase: str(phase).replace("_", " ")),
    "cycles": ("cycles", str),
    "energy_closure": ("energy unaccounted", lambda part: f"{100 * part:.2g} % of the dissipated"),
    "seed": ("seed", str),
}


def _facts(summary: dict[str, Any]) -> list[list[str]]:
    """Results of the run in words."""
    return [
        [label, words(summary[key])]
        for key, (label, words) in _FACTS.items()
        if summary.get(key) is not None
    ]
