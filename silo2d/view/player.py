"""The page that plays a discharge: particles, contact network, wall forces, discharge curve."""

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import GREEN, VERMILION
from granulab.campaign.output.page.packing import Quantised, counted, linear
from granulab.campaign.output.page.player import (
    Colour,
    Facts,
    Line,
    Recording,
    Touching,
    colours_of,
    facts,
    player,
)
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.ragged import Tables
from granulab.campaign.runs.trajectory import stored_tables
from granulab.errors import FolderError, InputError
from silo2d.measures.basics.contacts import Moment, moment_at, particle_stress
from silo2d.measures.basics.particles import prism_length
from silo2d.run.numbers import dissipated
from silo2d.view.charts import MECHANISM_COLOURS, wall_styles
from silo2d.view.scene import WOOD, Scene, read_scene

Floats = NDArray[np.float64]

_TURN = 2.0 * np.pi / 4096  # of an angle, which is told from the next


def player_page(run_folder: str | Path, most_bytes: float) -> tuple[str, str]:
    """The page of a finished run, and a remark where frames were left out.

    Raises FolderError where the run cannot be read, is not finished or has one frame only.
    """
    scene = read_scene(run_folder)
    if not scene.summary:
        go_on = RunFolder(Path(run_folder)).go_on("silo2d")
        raise FolderError(f"{run_folder}: unfinished; wait for it, or go on with it: {go_on}")
    contacts = stored_tables(run_folder).get("contacts")
    return player(_Recorder(Path(run_folder), scene, contacts).record, scene.time, most_bytes)


class _Recorder:
    """Recordings of a run; what they share is made once."""

    def __init__(self, folder: Path, scene: Scene, contacts: Tables | None) -> None:
        self.folder, self.scene, self.contacts = folder, scene, contacts
        self.shown = scene.trajectory["inside"] & (
            scene.trajectory["y"] > scene.window[2] - scene.reach
        )

    def record(self, frames: NDArray[np.int64]) -> Recording:
        """Return what a page shows of some frames."""
        scene, n = self.scene, self.scene.n_particles
        recording = Recording(self._data())
        recording.arrays |= {
            **self._places(frames),
            "inside": counted(self.shown[frames]),
            "kind": counted(scene.trajectory.static["kind"]),
            "counted": counted(scene.trajectory["n_out"][frames]),
        }
        self._colour(recording, frames)
        taken = recording.add_contacts(self.touching, scene.time, frames, n, colours_of("YlOrRd"))
        if taken:
            unit, length = self._length
            values = np.maximum(self.pressures[taken] / length, 0.0)
            recording.add_decades(
                "stress (pressure)", unit, values, colours_of("YlGnBu"), name="stress", per="moment"
            )
        if "wall_force" in scene.trajectory:
            recording.add_wall_forces(scene.trajectory["wall_force"][frames])
        self._curves(recording)
        return recording

    def _data(self) -> dict[str, Any]:
        scene = self.scene
        name, _, outcome = scene.headline.partition(": ")
        walls = scene.walls
        static = scene.trajectory.static
        points, start = static["shape_points"], static["shape_start"]
        outlines = [np.round(part, 7).tolist() for part in np.split(points, start[1:-1])]
        ends = [np.round(wall, 6).tolist() for wall in walls]
        middles = np.round(static["wall_segments"].mean(axis=1), 6).tolist()
        away = len(scene.wall_names) - len(scene.bearing)
        middles[len(scene.bearing) :] = [None] * away
        return {
            "name": self.folder.resolve().name,
            "title": name,
            "outcome": outcome,
            "particles": scene.n_particles,
            "clock": {"unit": "s", "factor": 1.0, "digits": 3},
            "counted": f"of {scene.in_all} out",
            "facts": facts(scene.summary, _FACTS),
            "notes": [],
            "pull_words": "Orange pulls.",
            "walls": [
                {"name": wall, "middle": middle}
                for wall, middle in zip(scene.wall_names, middles, strict=True)
            ],
            "plane": {
                "window": list(scene.window),
                "outlines": outlines,
                "walls": [{"ends": pair} for pair in ends],
                "lips": np.asarray(scene.trajectory.attributes["lips"]).tolist(),
                "doorSpeed": scene.trajectory.attributes.get("door_speed"),
                "doors": np.round(static["wall_segments"][-scene.n_doors :], 6).tolist(),
                "gateTimes": scene.gate,
            },
        }

    def _places(self, frames: NDArray[np.int64]) -> dict[str, Quantised]:
        """Positions and angles; a particle that is not shown stays where it was last."""
        trajectory, shown = self.scene.trajectory, self.shown[frames]
        left, right, bottom, top = self.scene.window
        step = max(right - left, top - bottom) / 2**16
        last = np.where(shown, np.arange(len(frames))[:, None], 0)
        last = np.maximum.accumulate(last, axis=0)
        each = np.arange(shown.shape[1])
        held = {name: trajectory[name][frames][last, each] for name in ("x", "y", "angle")}
        return {
            name: linear(values, _TURN if name == "angle" else step, order=2)
            for name, values in held.items()
        }

    def _colour(self, recording: Recording, frames: NDArray[np.int64]) -> None:
        trajectory = self.scene.trajectory
        layer = trajectory.static["layer"].astype(np.int64)
        layer = layer - layer.min()
        recording.arrays["layer"] = counted(layer)
        recording.add_colour(
            Colour("layer", "", "particle", "layer", WOOD, numbered=int(layer.max()) + 1)
        )
        speed = np.hypot(trajectory["vx"][frames], trajectory["vy"][frames])
        speed = np.where(self.shown[frames], speed, 0.0)
        recording.add_scale("speed", "m/s", speed, colours_of("viridis"), name="speed")

    @cached_property
    def moments(self) -> list[Moment]:
        """Frames with contacts."""
        if self.contacts is None:
            return []
        return [moment_at(self.scene, self.contacts, k) for k in range(len(self.contacts))]

    @cached_property
    def touching(self) -> list[Touching]:
        """Pairs that touch at each of them."""
        return [_touching(moment) for moment in self.moments]

    @cached_property
    def pressures(self) -> Floats:
        """Half the trace of the mean stress in each particle at each of them (M, n) [N/m]."""
        assert self.contacts is not None
        found = np.zeros((len(self.moments), self.scene.n_particles))
        for row, moment in zip(found, self.moments, strict=True):
            stress = particle_stress(self.scene, self.contacts, moment.frame)
            assert stress is not None  # these frames have contacts
            row[:] = np.trace(stress, axis1=1, axis2=2) / 2
        return found

    @cached_property
    def _length(self) -> tuple[str, float]:
        """Unit of a stress and what divides one of the plane [N/m]: the prisms' length [m]."""
        try:
            return "Pa", prism_length(self.folder)
        except (InputError, FolderError):
            return "N/m", 1.0

    def _curves(self, recording: Recording) -> None:
        scene, trajectory, time = self.scene, self.scene.trajectory, self.scene.time
        recording.add_curve(
            "particles out", "", time, [Line("out", trajectory["n_out"])],
            spans=_published(scene.summary), steps=True,
        )  # fmt: skip
        if "wall_force" in trajectory:
            force = -trajectory["wall_force"][:, :, 1]
            styles = wall_styles(scene.bearing)
            lines = [
                Line(name, force[:, k], style["color"], dashed=style["ls"] != "-")
                for k, (name, style) in enumerate(styles.items())
            ]
            every = Line("all walls", np.nan_to_num(force).sum(axis=1))  # with the doors
            recording.add_curve("downward force on the walls", "N", time, [every, *lines])
        if all(name in trajectory for name in MECHANISM_COLOURS):
            by = dissipated(trajectory)
            recording.add_curve(
                "energy dissipated", "J", time,
                [Line("all", np.sum(list(by.values()), axis=0)),
                 *(Line(_mechanism(name), by[name], colour)
                   for name, colour in MECHANISM_COLOURS.items())],
            )  # fmt: skip
        recording.add_curve(
            "kinetic energy of the particles inside", "J", time,
            [Line("kinetic", trajectory["kinetic"], VERMILION)],
        )  # fmt: skip


def _touching(moment: Moment) -> Touching:
    """The pairs of bodies of a moment, their contacts added up."""
    bodies, which = np.unique(moment.bodies, axis=0, return_inverse=True)
    bodies, which = bodies.reshape(-1, 2), which.ravel()
    force, pressing = np.zeros((len(bodies), 2)), np.zeros(len(bodies))
    np.add.at(force, which, moment.force)
    np.add.at(pressing, which, (moment.force * moment.normal).sum(axis=1))
    points = np.zeros((len(bodies), 2))
    np.add.at(points, which, moment.point)
    points /= np.bincount(which, minlength=len(bodies))[:, None]
    at_wall = bodies[:, 1] >= moment.scene.n_particles if len(bodies) else np.zeros(0, bool)
    branch = points[at_wall] - moment.centres[bodies[at_wall, 0]]
    return Touching(moment.frame, bodies, np.hypot(*force.T), pressing < 0.0, branch)


def _mechanism(name: str) -> str:
    how, _, between = name.partition("_grain_")
    return f"{how.replace('_', ' ')}, {'walls' if between == 'wall' else 'particles'}"


def _published(summary: dict[str, Any]) -> list[dict[str, Any]]:
    """Published discharge times, as spans of a curve."""
    known = summary.get("published") or {}
    spans, mean = [], known.get("experiment_mean_s")
    if mean is not None:
        sd = known.get("experiment_sd_s") or 0.0
        words = f"experiment {mean:.2f} \N{PLUS-MINUS SIGN} {sd:.2f} s"
        spans.append({"from": mean - sd, "to": mean + sd, "label": words, "colour": GREEN})
    if (simulated := known.get("simulation_s")) is not None:
        words = f"SPOLY {simulated:.2f} s"
        spans.append({"from": simulated, "to": simulated, "label": words, "colour": VERMILION})
    return spans


_FACTS: Facts = {
    "n_particles": ("particles", str),
    "n_out": ("out", str),
    "discharge_time_s": ("discharge time", "{:.3f} s".format),
    "t90_s": ("T90", "{:.3f} s".format),
    "mean_rate_per_s": ("mean rate", "{:.0f} particles/s".format),
    "mean_mass_flow_kg_per_s": ("mass flow", "{:.2f} kg/s".format),
    "packing_fraction": ("packing fraction", "{:.3f}".format),
    "energy_closure": ("energy unaccounted", lambda part: f"{100 * part:.2g} % of the dissipated"),
    "seed": ("seed", str),
    "engine": ("engine", str),
}
