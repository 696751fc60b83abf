"""A damper's case: settings resolved to enclosure, particles, laws, motion and time step."""

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from contact.casefile import changed
from contact.datafile import data_file, data_root, find, is_file
from contact.hertz import HertzLaw
from contact.quantity import InputError, located, nearest
from contact.table import ContactTable, load_table
from damper3d.cluster import Cluster, parse_particle
from damper3d.enclosure import Enclosure, box, cylinder
from damper3d.parameters import (
    Steps,
    contact_laws,
    materials_of,
    restitutions,
    time_steps,
    yield_velocities,
)
from damper3d.settings import Motion, Settings, check_settings, read_settings, to_toml
from damper3d.shaker import Sines, sine

GRAVITY = 9.81  # [m/s2]
PRESETS: dict[str, dict[str, Any]] = {"thesis": {}}  # every default is the thesis's
# The thesis keeps the volume of 700 spheres of 4 mm in 40 mm x 40 mm: a fill ratio of 7/15, with
# which 3, 5 and 6 mm are 1659, 358 and 207 spheres (Table 6.1).
USUAL_FILL_RATIO = 7 / 15
CLOSE_PACKING = 0.64  # of random spheres; more do not go in by shaking


def shipped_cases() -> list[str]:
    """Names of the shipped case files that are dampers; a silo's has the table [silo]."""
    root = data_root() / "cases"
    names = sorted(path.stem for path in root.glob("*.toml"))
    return [n for n in names if "[silo]" not in (root / f"{n}.toml").read_text(encoding="utf-8")]


@dataclass(frozen=True, eq=False)
class DamperCase:
    """Everything that a run needs to know, validated; SI, in the enclosure's frame."""

    settings: Settings
    enclosure: Enclosure
    particle: Cluster
    count: int
    density: float  # of the particles [kg/m3]
    pair_law: HertzLaw
    wall_law: HertzLaw
    restitution: dict[str, float]  # of particle_particle and particle_wall, as given [-]
    yield_velocity: dict[str, float | None]  # likewise, eq. 5.26 [m/s]; None: not known
    steps: Steps
    gravity: np.ndarray  # (3,) [m/s2]
    settling_gravity: np.ndarray  # (3,) [m/s2] while the particles settle
    direction: np.ndarray  # (3,) of the motion, of length one
    files: dict[str, str]  # name in the run folder -> text, of the materials used

    @classmethod
    def load(cls, name_or_path: str | Path, changes: dict[str, Any] | None = None) -> "DamperCase":
        """A preset ("thesis") or a case file (TOML), with changes such as {"motion.gamma": 5}.

        Raises InputError, one line that names file or option, key, value and what would do.
        """
        name = str(name_or_path)
        path = Path(name)
        if name in PRESETS:
            document = changed({"name": name, **PRESETS[name]}, changes, Settings)
            return cls.resolve(document, name, Path())
        if not is_file(path):
            known = [*PRESETS, *shipped_cases()]
            shipped = data_file("cases", name)
            if shipped is None and is_file(Path(f"{name}.toml")):
                raise InputError(f"case {name!r}: no such preset; did you mean '{name}.toml'?")
            if shipped is None:
                raise InputError(f"case {name!r}: no such preset or file; {nearest(name, known)}")
            path = shipped
        document = changed(read_settings(path), changes, Settings)
        return cls.resolve(document, str(path), path.parent)

    @classmethod
    def resolve(cls, document: dict[str, Any], where: str, folder: Path) -> "DamperCase":
        """A case from the tables of a case file; files it names are looked for in `folder`."""
        settings = check_settings(document, where)
        _check_protocol(settings, where)
        file = find(settings.particles.materials, "materials", folder)
        table = load_table(file)
        try:
            case = _resolved(cls, settings, table, where, Path(file))
            calculable = _calculable(case)
        except (OverflowError, ZeroDivisionError):
            calculable = False
        if not calculable:
            raise InputError(
                f"{where}: some values are too large or too small to calculate with; look at "
                "sizes, frequency, gamma, density, modulus and yield strength"
            )
        return case

    @property
    def name(self) -> str:
        """What the run folder is called after."""
        return self.settings.name

    @property
    def particle_mass(self) -> float:
        """Of one particle [kg]."""
        return self.density * self.particle.volume

    @property
    def mass(self) -> float:
        """Of all particles [kg]."""
        return self.count * self.particle_mass

    @property
    def fill_ratio(self) -> float:
        """Volume of the particles over that of the void (thesis, eq. 6.1) [-]."""
        return self.count * self.particle.volume / self.enclosure.volume

    @property
    def period(self) -> float:
        """Of a cycle [s]."""
        return 1.0 / self.settings.motion.frequency

    @property
    def time_step(self) -> float:
        """[s]"""
        return self.steps.time_step

    @property
    def steps_per_sample(self) -> int:
        """Steps from one sample to the next."""
        return self.steps.per_sample

    @property
    def amplitude(self) -> float:
        """Gamma g / omega^2 [m] (eq. 6.2)."""
        motion = self.settings.motion
        return motion.gamma * GRAVITY / (2.0 * math.pi * motion.frequency) ** 2

    @property
    def peak_speed(self) -> float:
        """Gamma g / omega, the largest velocity of the enclosure [m/s]."""
        motion = self.settings.motion
        return motion.gamma * GRAVITY / (2.0 * math.pi * motion.frequency)

    @cached_property
    def shaker(self) -> Sines:
        """The motion of the enclosure along its direction."""
        motion = self.settings.motion
        return sine(motion.gamma, motion.frequency, GRAVITY, motion.ramp)

    @property
    def wall_names(self) -> list[str]:
        """In the order of the walls' numbers."""
        return self.enclosure.wall_names

    def to_toml(self) -> str:
        """The case as a file for the run folder, beside the copies of the files it names."""
        settings = self.settings
        particles = {"materials": "materials.toml", "count": self.count}
        enclosure = {"diameter": 2 * self.enclosure.radius} if self.enclosure.radius else {}
        return to_toml(
            settings.model_copy(
                update={
                    "particles": settings.particles.model_copy(update=particles),
                    "enclosure": settings.enclosure.model_copy(update=enclosure),
                }
            )
        )

    def identity(self) -> dict[str, Any]:
        """What a run's folder is named by: all that its answers depend on."""
        run, motion = self.settings.run, self.settings.motion
        length = {"steady": run.max_cycles} if run.steady else {}
        return {
            **self.packing_identity(),
            "motion": [motion.orientation, motion.frequency, motion.gamma, motion.ramp],
            "direction": self.direction,
            "gravity": self.gravity,
            "cycles": [run.cycles, run.discard],
            **length,
            "time_step": self.time_step,
            "yield_velocity": self.yield_velocity,
            "output": self.settings.output.model_dump(),
        }

    def packing_identity(self) -> dict[str, Any]:
        """What a settled packing is named by: not what acts only once the enclosure moves."""
        enclosure, particle = self.enclosure, self.particle
        return {
            "enclosure": [enclosure.shape, enclosure.width, enclosure.depth, enclosure.height],
            "particle": [particle.offsets, particle.radii, particle.volume, particle.inertia],
            "count": self.count,
            "density": self.density,
            "laws": [list(self.pair_law), list(self.wall_law)],
            "wall_curvature": self.settings.law.wall_curvature,
            "settling_gravity": self.settling_gravity,
            "fill": self.settings.fill.model_dump(),
            "fill_time_step": self.steps.free,
            "seed": self.settings.run.seed,
        }


def _resolved(
    cls: type[DamperCase], settings: Settings, table: ContactTable, where: str, file: Path
) -> DamperCase:
    with located(f"{where}: [particles]"):
        particles = settings.particles
        particle = parse_particle(particles.shape, particles.equal_volume_radius)
    enclosure = _enclosure(settings, where)
    count = _count(enclosure, particle, particles.count, where)
    materials = materials_of(table, settings)
    laws = contact_laws(table, materials, settings)
    yields = yield_velocities(materials, particle)
    gravity, settling = _gravity(settings.motion, where)
    direction = settings.motion.direction or [0.0, 0.0, 1.0]
    return cls(
        settings, enclosure, particle, count, materials[0].density.value, *laws,
        restitutions(table, settings), yields,
        time_steps(particle, materials[0], settings, where), gravity, settling,
        _unit(direction, f"{where}: [motion] direction"),
        {"materials.toml": file.read_text(encoding="utf-8")},
    )  # fmt: skip


def _enclosure(settings: Settings, where: str) -> Enclosure:
    given = settings.enclosure
    if given.shape == "cylinder":
        if given.width is not None or given.depth is not None:
            raise InputError(
                f"{where}: [enclosure] width and depth go with shape = 'box', diameter with "
                "'cylinder'; leave them out or change the shape"
            )
        return cylinder(0.04 if given.diameter is None else given.diameter, given.height)
    if given.diameter is not None:
        raise InputError(
            f"{where}: [enclosure] diameter goes with shape = 'cylinder'; a box has width and depth"
        )
    if given.width is None:
        raise InputError(f"{where}: [enclosure] width is missing; give it for a box, like '40 mm'")
    return box(given.width, given.depth or given.width, given.height)


def _count(enclosure: Enclosure, particle: Cluster, given: int | None, where: str) -> int:
    """The number of particles; InputError where they cannot be inside."""
    size = 2.0 * particle.bounding_radius
    if enclosure.narrowest < size:
        raise InputError(
            f"{where}: [enclosure] {1e3 * enclosure.narrowest:g} mm at the narrowest: smaller than "
            f"a particle, {1e3 * size:g} mm; give a larger enclosure or smaller particles"
        )
    room = enclosure.volume / particle.volume
    count = max(round(USUAL_FILL_RATIO * room), 1) if given is None else given
    fit = max(math.floor(CLOSE_PACKING * room), 1)
    if count > fit:
        raise InputError(
            f"{where}: [particles] count = {count}: fill ratio {count / room:.3f}, above random "
            f"close packing, {CLOSE_PACKING:g}; at most {fit} fit"
        )
    return count


def _gravity(motion: Motion, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Gravity [m/s2] of the motion and of the settling."""
    if motion.gravity is not None:
        if motion.orientation == "none":
            raise InputError(
                f"{where}: [motion] gravity is given, and orientation = 'none' has none; leave one "
                "of them out"
            )
        vector = GRAVITY * _unit(motion.gravity, f"{where}: [motion] gravity")
        return vector, vector
    down = np.array([0.0, 0.0, -GRAVITY])
    across = np.array([-GRAVITY, 0.0, 0.0])
    if motion.orientation == "none":
        return np.zeros(3), down
    return (across, across) if motion.orientation == "horizontal" else (down, down)


def _unit(vector: list[float], what: str) -> np.ndarray:
    """The vector at length one; InputError where it has no direction."""
    largest = max(abs(x) for x in vector)
    if not 0.0 < largest < math.inf:
        raise InputError(f"{what} = {vector}: has no direction; write such as [0, 0, 1]")
    scaled = np.array(vector) / largest  # squares neither overflow nor vanish
    return scaled / np.linalg.norm(scaled)


def _check_protocol(settings: Settings, where: str) -> None:
    """What must hold between cycles, samples and frames."""
    run, output = settings.run, settings.output
    cycles = run.max_cycles if run.steady else run.cycles
    if run.discard >= cycles:
        key = "max_cycles" if run.steady else "cycles"
        raise InputError(
            f"{where}: [run] discard = {run.discard}: must be below {key} = {cycles}, or none is "
            "left to count"
        )
    if output.frames and output.samples % output.frames:
        near = [n for n in range(1, output.samples + 1) if output.samples % n == 0]
        best = min(near, key=lambda n: abs(n - output.frames))
        raise InputError(
            f"{where}: [output] frames = {output.frames}: must divide samples = {output.samples}; "
            f"give {best}, or 0 for none"
        )


def _calculable(case: DamperCase) -> bool:
    """Whether squares, cubes and ratios of all numbers are floats too."""
    yields = [v for v in case.yield_velocity.values() if v is not None]
    laws = [x for law in (case.pair_law, case.wall_law) for x in (law.hertz, law.tangential)]
    inertia = case.density * float(case.particle.inertia.min())
    motion = [case.amplitude, case.peak_speed, case.steps.rayleigh, case.time_step]
    sizes = [case.enclosure.volume, case.mass, case.density, inertia]
    friction = max(case.pair_law.mu, case.wall_law.mu)
    ordinary = all(1e-60 < x < 1e60 for x in [*yields, *laws, *motion, *sizes])
    return ordinary and friction < 1e60 and case.shaker.ramp_time < 1e60
