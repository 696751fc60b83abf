"""A run folder as pictures need it: particle outlines of a frame, walls, window, words, colours."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import Trajectory, read_trajectory
from granulab.errors import FolderError

WOOD = "#ecd3a4", "#b5793f"  # of the painted layers, alternating; they differ in lightness too
PARTICLE_EDGE = "#4a3018"

# What the pictures of a run need of its trajectory.
_STATIC = ["kind", "mass", "layer", "shape_points", "shape_start", "wall_segments"]
_OF_PARTICLES = ["x", "y", "angle", "vx", "vy", "spin", "inside", "out_time"]
_ATTRIBUTES = ["silo", "wall_names"]

_BELOW = 0.08, 0.2  # what is shown below the outlet, at least and at most, in silo heights
_ASIDE = 0.3  # what is shown at most beside the silo, in its widths
_OUTCOMES = {
    "empty": "empty",
    "dead_zones": "dead zones remain",
    "clogged": "clogged",
    "clogged_at_opening": "clogged at opening",
    "time_limit": "stopped at the time limit",
}


@dataclass(frozen=True)
class Scene:
    """One run as it stands on disk, finished or not.

    summary         as in summary.json; empty while the run goes on
    wall_names      (w,), the door last
    """

    trajectory: Trajectory
    summary: dict[str, Any]
    wall_names: list[str]

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the frames (F,) [s], 0 at the opening."""
        return self.trajectory["time"]

    @property
    def n_particles(self) -> int:
        """Number of particles, those in store included."""
        return len(self.trajectory.static["kind"])

    @cached_property
    def n_bed(self) -> int:
        """Number of particles in the silo at the opening."""
        return int(self.trajectory["inside"][0].sum())

    @property
    def in_all(self) -> str:
        """Number of particles in the bed, and in store where there is one, in words."""
        store = self.n_particles - self.n_bed
        return f"{self.n_bed} and {store} in store" if store else str(self.n_bed)

    @property
    def walls(self) -> NDArray[np.float64]:
        """End points of the walls (w - doors, 2, 2) [m], without the doors."""
        return self.trajectory.static["wall_segments"][: len(self.wall_names) - self.n_doors]

    @property
    def n_doors(self) -> int:
        """Number of doors, the last walls."""
        return sum(name.startswith("door") for name in self.wall_names)

    @property
    def gate(self) -> list[float]:
        """Times [s] at which the doors close, open, close ... again; none where they stay away."""
        return [float(time) for time in self.trajectory.attributes.get("gate_times", ())]

    @property
    def bearing(self) -> list[str]:
        """Names of the walls, and of the doors where they close."""
        return self.wall_names if self.gate else self.wall_names[: len(self.walls)]

    def door(self, frame: int) -> NDArray[np.float64]:
        """Rest of a door that is being drawn (1, 2, 2) [m], closed gates, or nothing (0, 2, 2)."""
        if sum(time <= self.time[frame] for time in self.gate) % 2:
            return self.trajectory.static["wall_segments"][-self.n_doors :]
        speed = self.trajectory.attributes.get("door_speed")  # none: it is gone at once
        ends = []
        if speed is not None:
            (left, y), (right, _) = self.trajectory.attributes["lips"]
            left += speed * self.time[frame]
            ends = [[(left, y), (right, y)]] if left < right else []
        return np.array(ends).reshape(-1, 2, 2)

    @cached_property
    def of_insert(self) -> NDArray[np.bool_]:
        """Mask (w,) of the walls that are sides of inserts."""
        return np.array([name.startswith("insert") for name in self.wall_names[: len(self.walls)]])

    @cached_property
    def across(self) -> tuple[float, float]:
        """Left and right end of the silo where it is widest [m]."""
        x = self.walls[..., 0]
        return float(x.min()), float(x.max())

    @cached_property
    def window(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of what is worth showing [m]."""
        left, bottom = self.walls.min(axis=(0, 1))
        right, top = self.walls.max(axis=(0, 1))
        if self.n_doors > 1 and self.trajectory["inside"].any():  # what flies out at a side
            x = self.trajectory["x"][self.trajectory["inside"]]
            most = _ASIDE * (right - left)
            left = max(min(left, x.min() - self.reach), left - most)
            right = min(max(right, x.max() + self.reach), right + most)
        inside, y = self.trajectory["inside"], self.trajectory["y"]
        heap = y[0][inside[0]].max(initial=bottom) + self.reach  # may stand above the rim
        fall = bottom - y[inside].min(initial=bottom) + self.reach
        least, most = (share * (top - bottom) for share in _BELOW)
        below = bottom - min(max(fall, least), most)
        return float(left), float(right), float(below), float(max(top, heap))

    @property
    def reach(self) -> float:
        """Largest distance of an outline from its centroid [m]."""
        return float(np.hypot(*self.trajectory.static["shape_points"].T).max())

    @property
    def areas(self) -> NDArray:
        """Area of each particle (n,) [m2], from the stored outlines (0.04 % small: chords)."""
        static = self.trajectory.static
        points, start = static["shape_points"], static["shape_start"]
        area = []
        for first, end in pairwise(start):
            x, y = points[first:end].T
            area.append(0.5 * (x * np.roll(y, -1) - np.roll(x, -1) * y).sum())  # Gauss
        return np.array(area)[static["kind"]]

    @cached_property
    def particle_size(self) -> float:
        """Side [m] of the square that has the mean area of the particles' outlines."""
        return float(np.sqrt(self.areas.mean()))

    @property
    def headline(self) -> str:
        """The silo and how its discharge ended, in one line."""
        silo = f"Silo {self.trajectory.attributes['silo']}"
        if engine := self.trajectory.attributes.get("engine"):  # another than the contact law
            silo += f", {engine}"
        n_out = self.trajectory["n_out"][-1]
        if not self.summary:
            return f"{silo}: unfinished, {n_out} of {self.in_all} out by {self.time[-1]:.2f} s"
        outcome = self.summary["outcome"]
        how = _OUTCOMES.get(outcome, outcome)
        end = self.summary.get("discharge_time_s")
        if end is None:
            return f"{silo}: {how}, {n_out} of {self.in_all} out"
        last = " after" if outcome == "empty" else "; the last particle left at"
        return f"{silo}: {how}{last} {end:.2f} s"

    def outlines(self, frame: int) -> Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]:
        """Particles inside (k,) and their outlines (k, p, 2) [m], shape by shape.

        Outlines that lie below the window are left out.
        """
        y = self.trajectory["y"][frame]
        shown = self.trajectory["inside"][frame] & (y > self.window[2] - self.reach)
        return self.placed(frame, np.flatnonzero(shown))

    def placed(
        self, frame: int, particles: NDArray[np.int64]
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]:
        """The given particles, shape by shape (k,), and their outlines (k, p, 2) [m]."""
        static = self.trajectory.static
        points, start, kind = static["shape_points"], static["shape_start"], static["kind"]
        x, y, angle = (self.trajectory[key][frame] for key in ("x", "y", "angle"))
        for shape in range(len(start) - 1):
            which = particles[kind[particles] == shape]
            px, py = points[start[shape] : start[shape + 1]].T
            cos, sin = np.cos(angle[which, None]), np.sin(angle[which, None])
            around = np.stack([px * cos - py * sin, px * sin + py * cos], axis=-1)
            yield which, around + np.stack([x[which], y[which]], axis=-1)[:, None, :]


def read_scene(run_folder: str | Path) -> Scene:
    """The run in a folder; FolderError where it has no frame yet, is damaged or cannot be read."""
    run = RunFolder(Path(run_folder))
    trajectory = read_trajectory(run.path)
    if "time" not in trajectory or not trajectory.static:
        raise FolderError(f"{run.path}: no frame yet; wait until the silo has opened")
    if wrong := _wrong(trajectory):
        cure = "use --again to compute the run again"
        raise FolderError(f"{run.path}: its trajectory is damaged ({wrong}); {cure}")
    summary = run.read_summary() if run.state == "finished" else {}
    if summary and not isinstance(summary.get("outcome"), str):
        cure = "use --again to compute the run again"
        raise FolderError(f"{run.path / 'summary.json'}: damaged (no outcome); {cure}")
    return Scene(trajectory, summary, json.loads(trajectory.attributes["wall_names"]))


def _wrong(trajectory: Trajectory) -> str:
    """Description of what a scene needs and a trajectory lacks; "" where all is there."""
    kept = [*trajectory.static, *trajectory, *trajectory.attributes]
    if missing := [key for key in (*_STATIC, *_OF_PARTICLES, *_ATTRIBUTES) if key not in kept]:
        return f"no {', '.join(missing)}"
    shape = len(trajectory["time"]), len(trajectory.static["kind"])
    odd = [key for key in _OF_PARTICLES if trajectory[key].shape != shape]
    for key in ("kind", "mass", "layer"):
        odd += [key] if np.shape(trajectory.static[key]) != shape[1:] else []
    return f"{odd[0]} is not of the {shape[1]} particles in {shape[0]} frames" if odd else ""
