"""A run folder as pictures need it: samples by cycles, particles of a frame, enclosure, words."""

import json
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damper3d.case.case import DamperCase
from damper3d.case.host.host import COUNTED
from damper3d.case.host.modes import base_of
from damper3d.case.parts import enclosure_of, orientation_of
from damper3d.case.settings import Settings, check_settings, read_settings
from damper3d.engine.enclosures import Enclosure
from damper3d.engine.records import UNITS
from damper3d.measures.counted import harmonics
from damper3d.measures.efficiency import in_words, reference_energy
from damper3d.run.folders import shaken
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.ragged import Tables
from granulab.campaign.runs.trajectory import Trajectory, read_trajectory, stored_tables
from granulab.errors import FolderError

Array = NDArray[np.float64]

_ANEW = "use --again to compute the run again"
_G = 9.81  # m/s2, in which gamma is counted
_OF_PARTICLES = [f"{name}{axis}" for name in ("", "v", "spin_") for axis in "xyz"] + ["heat"]
_ORIENTATION = [f"turn_{c}" for c in "wxyz"]  # and of several spheres


class NothingKept(FolderError):
    """The run kept no more than its summary."""


class Particles(NamedTuple):
    """Particles of one frame.

    position          (n, 3) [m] of the centres, relative to the enclosure
    velocity          (n, 3) [m/s] in the lab
    angular_velocity  (n, 3) [rad/s]
    dissipated        (n,) energy dissipated at each so far [J]
    """

    position: Array
    velocity: Array
    angular_velocity: Array
    dissipated: Array


class View(NamedTuple):
    """View of the enclosure: unit vectors (3,), along axes of its own frame."""

    right: Array
    up: Array
    nearer: Array  # towards the eye

    def project(self, points: Array) -> Array:
        """Points or vectors (..., 3) as right, up and towards the eye (..., 3)."""
        return points @ np.stack(self, axis=1)


def view_of(gravity: Array, direction: Array) -> View:
    """Gravity (3,) downwards, the motion's direction (3,) to be seen; along the frame's axes."""
    down = 2 if abs(gravity[2]) >= np.abs(gravity).max() else int(np.abs(gravity).argmax())
    up = np.zeros(3)
    up[down] = -1.0 if gravity[down] > 0 else 1.0
    seen = np.abs(direction)
    seen[down] = -1.0
    across = [axis for axis in (2, 0, 1) if axis != down]  # z first where it lies
    right = np.zeros(3)
    right[max(across, key=lambda axis: seen[axis])] = 1.0
    return View(right, up, np.cross(right, up))


@dataclass(frozen=True)
class Scene:
    """One run as it stands on disk, finished or not.

    The frames of the trajectory are the samples; some of them come with a table of the particles,
    and those are called frames here.

    summary         as in summary.json; empty while the run goes on
    folder          of the run
    """

    trajectory: Trajectory
    tables: Tables
    settings: Settings
    summary: dict[str, Any]
    folder: Path = Path()

    @property
    def time(self) -> Array:
        """Times of the samples (S,) [s], 0 where the vibration begins."""
        return self.trajectory["time"]

    @property
    def period(self) -> float:
        """Length of a cycle [s]."""
        return 1 / self.settings.motion.frequency

    @property
    def on_host(self) -> bool:
        """True where the enclosure rides on a host."""
        return "host_energy" in self.trajectory

    @property
    def peak_speed(self) -> float:
        """Gamma g / omega [m/s], the largest velocity of the enclosure (eq. 6.2).

        On a host it is that of the first harmonic: of the mean over the cycles that count, as in
        the results (over the last ones while the run goes on), or, of one that was let go, in the
        first. Under an excitation that is no sine it is the largest.
        """
        if self.settings.excitation.kind is not None:
            return float(np.abs(self.trajectory["velocity"]).max())
        prescribed = self.settings.motion.gamma * _G * self.period / (2 * np.pi)
        per = self.samples_per_cycle
        n_cycles = (len(self.time) - 1) // per
        if not self.on_host or not n_cycles:
            return prescribed
        found = harmonics(self.trajectory["displacement"][: n_cycles * per + 1], per)
        keys = self.settings.host
        driven = keys.force or keys.torque or base_of(keys)
        first = self.counted.start if self.summary else max(n_cycles - COUNTED, 0)
        size = abs(found[first:].mean() if driven else found[0])
        return float(2 * np.pi / self.period * size)

    @property
    def masses(self) -> Array:
        """Masses of the particles (n,) [kg]."""
        return self.trajectory.static["mass"]

    @property
    def mass(self) -> float:
        """Mass of all particles [kg]."""
        return float(self.masses.sum())

    @property
    def radius(self) -> Array:
        """Radii of the particles (n,) [m]."""
        return self.trajectory.static["radius"]

    @property
    def kind(self) -> NDArray[np.int64]:
        """Number of the kind of each particle (n,); 0 where all are of one."""
        return self.trajectory.static.get("kind", np.zeros(len(self.radius), np.int64))

    @property
    def kinds(self) -> int:
        """Return how many kinds there are."""
        return int(self.kind.max()) + 1

    @property
    def full_energy(self) -> float:
        """4 (Gamma g/omega)^2 M [J], the most that a cycle can dissipate (eq. 6.10).

        Of an excitation the mean of what its windows can (measures/counted.py), once it is known.
        """
        known = self.summary.get("excitation")
        if known:
            return float(known["most_energy_j"]) / (
                self.summary["cycles"] - self.summary["discarded"]
            )
        return reference_energy(self.peak_speed, self.mass)

    @property
    def direction(self) -> Array:
        """Direction of the enclosure's motion (3,), a unit vector."""
        return np.asarray(self.trajectory.attributes["direction"], dtype=float)

    @property
    def gravity(self) -> Array:
        """Gravity in the enclosure's frame (3,) [m/s2]; zeros where there is none."""
        return np.asarray(self.trajectory.attributes["gravity"], dtype=float)

    @property
    def wall_names(self) -> list[str]:
        """As the rows of wall_force."""
        return json.loads(self.trajectory.attributes["wall_names"])

    @cached_property
    def enclosure(self) -> Enclosure:
        """As it stands in the case of the run folder, where no size is left out."""
        return enclosure_of(self.settings, "case.toml", self.folder)

    @property
    def size(self) -> Array:
        """Width, depth and height (3,) [m] of the enclosure, along x, y and z."""
        return np.array([self.enclosure.width, self.enclosure.depth, self.enclosure.height])

    @property
    def view(self) -> View:
        """Gravity downwards, the motion to be seen; along the enclosure's own axes."""
        return view_of(self.gravity, self.direction)

    @property
    def samples_per_cycle(self) -> int:
        """Row k samples_per_cycle is the end of cycle k; row 0 stands before the first."""
        return self.settings.output.samples

    @property
    def n_cycles(self) -> int:
        """Whole cycles that are there."""
        return (len(self.time) - 1) // self.samples_per_cycle

    @property
    def counted(self) -> range:
        """Cycles that count: those after the discarded ones, or all while there are no others."""
        discarded = self.summary.get("discarded", self.settings.run.discard)
        return range(discarded if discarded < self.n_cycles else 0, self.n_cycles)

    @property
    def phase(self) -> Array:
        """Parts of a cycle (k + 1,), 0 to 1, at which `by_cycle` gives a series."""
        return np.linspace(0.0, 1.0, self.samples_per_cycle + 1)

    def by_cycle(self, series: Array) -> Array:
        """A series (S, ...) of the samples, cut into whole cycles (c, k + 1, ...).

        The last value of a cycle is the first of the next.
        """
        per = self.samples_per_cycle
        return series[per * np.arange(self.n_cycles)[:, None] + np.arange(per + 1)]

    def along(self, vectors: Array) -> Array:
        """Components of vectors (..., 3) along the motion (...)."""
        return vectors @ self.direction

    @property
    def frame_sample(self) -> NDArray[np.int64]:
        """Sample (row) of each frame (F,)."""
        return self.tables.frame

    def frames_of(self, cycle: int) -> list[int]:
        """Frames of a whole cycle, its end left out."""
        per = self.samples_per_cycle
        low, high = np.searchsorted(self.frame_sample, [cycle * per, (cycle + 1) * per])
        return list(range(low, high))

    def spheres(self, frame: int) -> tuple[Array, Array, NDArray[np.int64]]:
        """Spheres of all particles in a frame.

        From the particle's centre to the sphere's (m, 3) [m], radius (m,) [m], number of the
        particle (m,).
        """
        n = len(self.radius)
        if not self.of_many_spheres:
            return np.zeros((n, 3)), self.radius, np.arange(n)
        offset, radius, whose = self.own_spheres
        orientation = self.orientation(frame)[whose]
        w, about = orientation[:, :1], orientation[:, 1:]
        # r + 2 w (q x r) + 2 q x (q x r) of a unit quaternion (w, q)
        first = np.cross(about, offset)
        return offset + 2.0 * w * first + 2.0 * np.cross(about, first), radius, whose

    @cached_property
    def own_spheres(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Spheres of all particles in their own axes; see `spheres`."""
        static, n = self.trajectory.static, len(self.radius)
        count = static.get("sphere_count", np.full(n, len(static["sphere_radius"])))
        whose = np.repeat(np.arange(n), count)
        begin = static.get("sphere_row", np.zeros(n, np.int64)) - (np.cumsum(count) - count)
        rows = np.arange(len(whose)) + begin[whose]
        return static["sphere_offset"][rows], static["sphere_radius"][rows], whose

    @property
    def of_unlike_spheres(self) -> bool:
        """True for particles of several spheres that are not alike."""
        return "sphere_row" in self.trajectory.static

    @property
    def of_many_spheres(self) -> bool:
        """True for particles of several spheres, which have orientations."""
        return "sphere_offset" in self.trajectory.static

    def orientation(self, frame: int) -> Array:
        """Orientations (n, 4): unit quaternions (w, x, y, z), from principal axes to the lab."""
        table = self.tables.at(frame)
        return np.stack([table[name] for name in _ORIENTATION], axis=1).astype(float)

    def particles(self, frame: int) -> Particles:
        """Positions, velocities and dissipation of the particles in a frame."""
        table = self.tables.at(frame)
        position, velocity, angular_velocity = (
            np.stack([table[f"{name}{axis}"] for axis in "xyz"], axis=1).astype(float)
            for name in ("", "v", "spin_")
        )
        return Particles(position, velocity, angular_velocity, table["heat"].astype(float))

    def shift(self, frame: int) -> Array:
        """Displacement (3,) [m] of the enclosure in a frame."""
        return self.way[self.frame_sample[frame]]

    @cached_property
    def way(self) -> Array:
        """Displacement (S, 3) [m] of the enclosure, along both of two directions; 0: it twists."""
        along = self.trajectory["displacement"][:, None]
        if self.settings.host.inertia is not None:
            return np.zeros((len(along), 3))
        if self.settings.excitation.across is None:
            return along * self.direction
        from damper3d.case.case import DamperCase

        own = DamperCase.load(self.folder / "case.toml").excitation
        assert own is not None
        across = own.across(self.time)
        assert across is not None
        return along * self.direction + across[0][:, None] * own.second

    @property
    def title(self) -> str:
        """Particles, enclosure and motion, in one line."""
        n, motion = len(self.radius), self.settings.motion
        shape, kinds = self.settings.particles.shape, self.settings.particles.kind
        kind, _, size = shape.partition(":")
        what = f"{n} spheres of {re.sub('(?<=[0-9])(?=[a-z])', ' ', size)}"
        if kind != "sphere":
            what = f"{n} particles {shape.removesuffix('.obj')}"
        if kinds:
            noun = "particles" if self.of_many_spheres else "spheres"
            what = f"{n} {noun} of {len(kinds)} kinds"
        how = orientation_of(self.gravity, self.direction).replace("none", "no gravity")
        fill = self.trajectory.attributes["fill_ratio"]
        moved = self.settings.excitation.kind or f"{motion.frequency:g} Hz"
        at = f"{self.settings.host.at}: " if self.settings.host.at else ""
        gamma = motion.gamma  # of the bare host where it has a host and no one sine moves it
        keys = self.settings.host
        if self.on_host and (keys.force or keys.torque or base_of(keys)):
            gamma = 2 * np.pi / self.period * self.peak_speed / _G
        return f"{at}{what}, fill ratio {fill:.3f}; {moved}, \u0393 = {gamma:.4g}, {how}"

    @property
    def outcome(self) -> str:
        """Result of the run, in a few words."""
        if not self.summary:
            return f"unfinished, {self.time[-1] / self.period:.1f} cycles"
        words = in_words(self.summary)
        phase = self.summary.get("phase")
        return f"{words}, {str(phase).replace('_', ' ')}" if phase else words


def read_scene(run_folder: str | Path) -> Scene:
    """The run in a folder.

    Raises FolderError where it has no whole cycle yet, is damaged or cannot be read, NothingKept
    where it has no samples any more.
    """
    run = RunFolder(Path(run_folder))
    path = shaken(run_folder).case_file
    settings = check_settings(read_settings(path), str(path))
    if settings.damper is not None:  # the file has what was given for all, and not what follows
        settings = DamperCase.load(path).settings
    summary = run.read_summary() if run.state == "finished" else {}
    if summary and not (run.path / "trajectory.h5").exists():
        raise NothingKept(
            f'{run.path}: only its summary was kept (output.keep = "summary"), nothing to draw '
            'or export; run it with output.keep = "all"'
        )
    trajectory = read_trajectory(run.path)
    if "time" not in trajectory or len(trajectory["time"]) < 2 or not trajectory.static:
        raise FolderError(f"{run.path}: no sample yet; wait until the enclosure moves")
    if wrong := _wrong(trajectory):
        raise FolderError(f"{run.path}: its trajectory is damaged ({wrong}); {_ANEW}")
    none = Tables(np.empty(0, np.int64), np.empty(0, np.int64), {})
    tables = stored_tables(run.path).get("particles", none)
    needed = [*_OF_PARTICLES, *(_ORIENTATION if "sphere_offset" in trajectory.static else [])]
    if len(tables) and (missing := [key for key in needed if key not in tables.columns]):
        wrong = f"particles without {', '.join(missing)}"
        raise FolderError(f"{run.path}: its trajectory is damaged ({wrong}); {_ANEW}")
    # A run that goes on may have flushed more frames between the two readings.
    tables = tables.of_frames(0, len(trajectory["time"]))
    scene = Scene(trajectory, tables, settings, summary, path.parent)
    if not scene.n_cycles:
        raise FolderError(f"{run.path}: no whole cycle yet; wait until one is computed")
    return scene


def _wrong(trajectory: Trajectory) -> str:
    """Names of what a scene needs and a trajectory lacks, in words; "" where all is there."""
    kept = [*trajectory, *trajectory.static, *trajectory.attributes]
    needed = [*UNITS, "radius", "mass", "wall_names", "fill_ratio", "direction", "gravity"]
    missing = [name for name in needed if name not in kept]
    return f"no {', '.join(missing)}" if missing else ""
