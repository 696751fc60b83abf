"""The page that plays a damper's run: particles in their enclosure, forces, velocities."""

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damper3d.shapes.surfaces.skin import OF_A_CELL, skin
from damper3d.view.charts import COLOURS, WALL_COLOURS
from damper3d.view.colouring import power
from damper3d.view.player.contacts import Pairs, pairs_of, pressure, touching
from damper3d.view.player.walls import box, drawn_walls
from damper3d.view.scene import Scene, read_scene
from granulab.campaign.output.figure import BLUE, VERMILION
from granulab.campaign.output.page.packing import Quantised, counted, linear
from granulab.campaign.output.page.player import (
    Colour,
    Facts,
    Line,
    Recording,
    colours_of,
    facts,
    player,
)
from granulab.campaign.runs.folder import RunFolder
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
_LONG = 20.0  # [s] of a run whose times are in seconds
_KEPT_WHOLE = 'run it with output.keep = "all" and output.frames above 0'


def player_page(run_folder: str | Path, most_bytes: float) -> tuple[str, str]:
    """The page of a finished run, and a remark where frames were left out.

    Raises FolderError where the run cannot be read, is not finished or kept no frames.
    """
    scene = read_scene(run_folder)
    if not scene.summary:
        go_on = RunFolder(Path(run_folder)).go_on("damper3d")
        raise FolderError(f"{run_folder}: unfinished; wait for it, or go on with it: {go_on}")
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
        """Return what a page shows of some frames."""
        scene, n = self.scene, len(self.scene.radius)
        recording = Recording(self._data())
        recording.arrays |= self._places(frames) | self._shapes(frames)
        recording.arrays |= drawn_walls(scene.enclosure)
        self._colour(recording, frames)
        time = scene.time[scene.frame_sample]
        moments = [touching(scene, pairs) for pairs in self.pairs]
        taken = recording.add_contacts(moments, time, frames, n, colours_of("YlOrRd"))
        if taken and not scene.of_many_spheres:  # the points of their contacts are not kept
            stress = np.array([pressure(scene, self.pairs[k]) for k in taken])
            recording.add_decades(
                "stress (pressure)", "Pa", np.maximum(stress, 0.0), colours_of("YlGnBu"),
                name="stress", per="moment",
            )  # fmt: skip
        samples = scene.frame_sample[frames]
        counted_from = int(np.searchsorted(samples, self._counted_from))
        recording.add_wall_forces(scene.trajectory["wall_force"][samples], counted_from)
        self._curves(recording)
        return recording

    @cached_property
    def pairs(self) -> list[Pairs]:
        """Pairs that touch, in the frames with contacts."""
        return [] if self.contacts is None else pairs_of(self.scene, self.contacts, self.position)

    @cached_property
    def shift(self) -> Floats:
        """Displacement of the enclosure in each frame (F, 3) [m]."""
        return np.array([self.scene.shift(frame) for frame in range(self.frames)])

    @property
    def _counted_from(self) -> int:
        """Sample from which on cycles count: the sudden start is the hardest blow."""
        return self.scene.counted.start * self.scene.samples_per_cycle

    def _data(self) -> dict[str, Any]:
        scene = self.scene
        low, high = box(scene.enclosure)
        in_seconds = scene.time[-1] > _LONG
        middles = {name: [scene.enclosure.middle] for name in scene.wall_names}
        middles |= {name: [] for name, _ in scene.enclosure.polygons}
        for name, corners in scene.enclosure.polygons:
            middles[name].append(corners.mean(axis=0))
        return {
            "name": self.folder.resolve().name,
            "title": scene.title,
            "outcome": scene.outcome,
            "particles": len(scene.radius),
            "clock": {"unit": "s", "factor": 1.0, "digits": 3} if in_seconds
                     else {"unit": "ms", "factor": 1e3, "digits": 2},
            "period": None if scene.settings.excitation.kind else scene.period,
            "facts": facts(scene.summary, _FACTS),
            "pull_words": "" if scene.of_many_spheres else "Orange pulls.",
            "walls": [
                {"name": name, "middle": np.round(np.mean(middles[name], axis=0), 6).tolist()}
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
        """Orientations of multi-sphere particles, and the surface and spheres of each kind.

        Those of a kind have one shape, each at its own scale.
        """
        scene = self.scene
        if not scene.of_many_spheres:
            return {}
        turns = np.array([scene.orientation(frame) for frame in frames])
        # A rotation has two quaternions: the one that is nearer to that of the frame before.
        flips = np.sign((turns[1:] * turns[:-1]).sum(axis=2))
        turns[1:] *= np.cumprod(np.where(flips == 0.0, 1.0, flips), axis=0)[:, :, None]
        cells = int(np.clip(np.sqrt(_TRIANGLES / len(scene.radius) / OF_A_CELL), *_CELLS))
        offset, radius, whose = scene.own_spheres
        lead = np.unique(scene.kind, return_index=True)[1]
        own = [whose == one for one in lead]
        surfaces = [skin(offset[one], radius[one], cells) for one in own]
        corners = [len(one.corners) for one in surfaces]
        triangles = [one.triangles + begin for one, begin in zip(
            surfaces, np.cumsum(corners) - corners, strict=True
        )]  # fmt: skip
        spheres = [np.column_stack([offset[one], radius[one]]) for one in own]
        return {
            "turn": linear(turns.reshape(len(frames), -1), _TURNS, order=2),
            "form": counted(scene.kind),
            "scale": linear(scene.radius / scene.radius[lead][scene.kind], 0.0),
            "sphere": linear(np.concatenate(spheres), 0.0),
            "sphere_end": counted(np.cumsum([len(one) for one in spheres])),
            "surface_corner": linear(np.concatenate([one.corners for one in surfaces]), 0.0),
            "surface_normal": linear(np.concatenate([one.normals for one in surfaces]), 1e-3),
            "surface_triangle": counted(np.concatenate(triangles).ravel()),
            "surface_end": counted(np.cumsum([len(one) for one in triangles])),
        }

    def _colour(self, recording: Recording, frames: NDArray[np.int64]) -> None:
        scene, velocity = self.scene, self.velocity[frames]
        if scene.kinds > 1:
            names = [f"kind {k + 1}" for k in range(scene.kinds)]
            recording.arrays["kind"] = counted(scene.kind)
            recording.add_colour(
                Colour("kind", "", "particle", "kind", colours_of("Set2", 8), names=names)
            )
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
        recording.add_scale(
            "energy dissipated so far", "J", gained, colours_of("plasma"), name="heat"
        )
        recording.add_decades(
            "power dissipated", "W", self.power[frames], colours_of("YlOrRd"), name="power",
            per="frame",
        )  # fmt: skip
        layer, count = self._layers()
        recording.arrays["layer"] = counted(layer)
        recording.add_colour(
            Colour("layer at the start", "", "particle", "layer", colours_of("viridis", count),
                   numbered=count)
        )  # fmt: skip

    @cached_property
    def power(self) -> Floats:
        """Dissipated at each particle since the frame before (F, n) [W]."""
        return np.array([power(self.scene, frame) for frame in range(self.frames)])

    def _layers(self) -> tuple[NDArray[np.int64], int]:
        """Layer of each particle at the start, from the bottom, and how many: a diameter each."""
        height = self.position[0] @ self.scene.view.up
        radius = float(self.scene.radius.mean())
        part = (height - height.min() + radius) / (np.ptp(height) + 2 * radius)
        count = int(np.clip(round((np.ptp(height) + 2 * radius) / (2 * radius)), *_LAYERS))
        return (part * count).astype(np.int64), count

    def _curves(self, recording: Recording) -> None:
        scene, trajectory = self.scene, self.scene.trajectory
        time, window = scene.time, _CYCLES * scene.period
        since = float(time[self._counted_from])
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
            window=window, since=since,
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


_FACTS: Facts = {
    "n_particles": ("particles", str),
    "particles": ("shape", str),
    "fill_ratio": ("fill ratio", "{:.3f}".format),
    "efficiency": ("efficiency", "{:.3f}".format),
    "dissipated_power_w": ("power dissipated", "{:.4g} W".format),
    "loss_factor": ("loss factor", "{:.3f}".format),
    "peak_wall_force_n": ("largest force on it, mean over a sample", "{:.4g} N".format),
    "phase": ("motion", lambda phase: str(phase).replace("_", " ")),
    "cycles": ("cycles", str),
    "energy_closure": ("energy unaccounted", lambda part: f"{100 * part:.2g} % of the dissipated"),
    "seed": ("seed", str),
}
