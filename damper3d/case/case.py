"""A damper's case: settings resolved to enclosure, particles, laws, motion and time step."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.bed import Bed, bed_of, is_mixed, pairs_of, table_of_laws
from damper3d.case.contacts import (
    COHESIONS,
    Ball,
    Pairing,
    check_law,
    check_rolling_step,
    pairing_of,
)
from damper3d.case.excitation.excitation import Excitation, Peaks
from damper3d.case.excitation.recorded import COPY
from damper3d.case.host.host import (
    Drive,
    Shaken,
    bare_displacement,
    bare_rows,
    host_of,
    ride_together,
    with_motion,
)
from damper3d.case.host.modes import MODES, Modes, modes_copy
from damper3d.case.host.several import as_given, check_alike, documents, seeds_of, with_changes
from damper3d.case.parameters import (
    Steps,
    kinds_of_walls,
    materials_of,
    table_of,
    time_steps,
)
from damper3d.case.parts import (
    GRAVITY,
    amplitude_of,
    cavity_copy,
    check_enclosure,
    check_protocol,
    count_of,
    direction_of,
    enclosure_of,
    gravity_of,
    mesh_copy,
    motion_of,
    orientation_of,
    particle_wanted,
    with_copies,
    with_usual_cycles,
)
from damper3d.case.settings import Enclosure as EnclosureKeys
from damper3d.case.settings import Settings, check_settings, read_settings, to_toml
from damper3d.engine.enclosures import Enclosure
from damper3d.engine.laws.table import LawTable
from damper3d.engine.motions import Turning
from damper3d.engine.records import CLASSES
from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.particle import particle_of
from granulab.contact.files.casefile import changed
from granulab.contact.files.datafile import case_names, data_file, find, is_file
from granulab.contact.files.table import ContactTable
from granulab.contact.files.units import located, nearest
from granulab.contact.hertz import HertzLaw
from granulab.contact.material import Material
from granulab.errors import InputError

PRESETS: dict[str, dict[str, Any]] = {"thesis": {}}  # every default is the thesis's


@dataclass(frozen=True, eq=False)
class DamperCase:
    """Everything that a run needs to know, validated; SI, in the enclosure's frame."""

    settings: Settings
    enclosure: Enclosure
    particle: MultiSphere
    count: int
    density: float  # of the particles [kg/m3]; of several kinds their mean
    pairings: tuple[Pairing, ...]  # contacts of each two kinds, then of each with the enclosure
    steps: Steps
    gravity: np.ndarray  # (3,) [m/s2]
    settling_gravity: np.ndarray  # (3,) [m/s2] while the particles settle
    direction: np.ndarray  # (3,) of the motion, of length one
    files: dict[str, str]  # name in the run folder -> text, of materials, mesh and modes
    bed: Bed | None = None  # particles that are not all alike; then `particle` is their mean
    modes: Modes | None = None  # of the host that the enclosure rides on; None: it is driven
    drive: Drive | None = None  # what moves that host
    excitation: Excitation | None = None  # in place of a sine, of the enclosure or of that host
    peaks: Peaks | None = None  # of the enclosure under it, on a host of the bare one
    arc: float | None = None  # radius [m] at which a host that twists has its displacements
    dampers: tuple["DamperCase", ...] = ()  # all on the host, where there are several
    together: Settings | None = None  # then what was given for all of them
    source: tuple[dict[str, Any], str, Path] | None = None  # what `resolve` made it of

    @classmethod
    def load(cls, name_or_path: str | Path, changes: dict[str, Any] | None = None) -> "DamperCase":
        """A preset ("thesis") or a case file (TOML), with changes such as {"motion.gamma": 5}.

        Those of one of several dampers: "damper.tip.particles.count"; see host.several.
        Raises InputError, one line that names file or option, key, value and what would do.
        """
        name = str(name_or_path)
        path = Path(name)
        if name not in PRESETS and not is_file(path):
            known = [*PRESETS, *case_names("enclosure")]
            shipped = data_file("cases", name)
            if shipped is None and is_file(Path(f"{name}.toml")):
                raise InputError(f"case {name!r}: no such preset; did you mean '{name}.toml'?")
            if shipped is None:
                raise InputError(f"case {name!r}: no such preset or file; {nearest(name, known)}")
            path = shipped
        document = {"name": name, **PRESETS[name]} if name in PRESETS else read_settings(path)
        document, left = with_changes(document, changes or {}, str(path))
        return cls.resolve(changed(document, left, Settings), str(path), path.parent)

    @classmethod
    def resolve(cls, document: dict[str, Any], where: str, folder: Path) -> "DamperCase":
        """A case from the tables of a case file; files it names are looked for in `folder`."""
        given, source = check_settings(document, where), (document, where, folder)
        if given.damper is None:
            return replace(cls._single(document, where, folder), source=source)
        dampers: list[DamperCase] = []
        for _ in range(2):  # alone, which gives their masses; then with what the others weigh
            alone, dampers = dampers, []
            for k, (own, here) in enumerate(documents(document, given, where)):
                first = dampers[0].modes.shape if dampers and dampers[0].modes else None
                others = (
                    sum(one.load_on_host for one in alone) - alone[k].load_on_host if alone else 0.0
                )
                dampers.append(cls._single(own, here, folder, first, others))
        check_alike(dampers, where)
        shortest = min((one.steps for one in dampers), key=lambda steps: steps.time_step)
        for k, one in enumerate(dampers):
            steps = replace(shortest, free=one.steps.free)
            dampers[k] = replace(one, steps=steps)
        shown = dampers[(given.host.shown or 1) - 1]
        return replace(shown, dampers=tuple(dampers), together=given, source=source)

    @classmethod
    def _single(
        cls, document: dict[str, Any], where: str, folder: Path, first: np.ndarray | None = None,
        others: float = 0.0,
    ) -> "DamperCase":  # fmt: skip
        """The case of one damper; of several on a host, first: shape at the first, others: load."""
        settings = with_usual_cycles(check_settings(document, where), document)
        shaken = with_motion(settings, folder, where, first)
        settings = shaken.settings
        check_protocol(settings, where)
        file = find(settings.particles.materials, "materials", folder)
        table = table_of(file, settings)
        try:
            case = _resolved(cls, shaken, table, where, Path(file), folder, others)
            motion_of(settings.motion, where)  # refuses what its kind cannot be
            calculable = _calculable(case)
        except (OverflowError, ZeroDivisionError):
            calculable = False
        if not calculable:
            raise InputError(
                f"{where}: some values are too large or too small to calculate with; look at "
                "sizes, frequency, gamma, density, modulus and yield strength"
            )
        _check_stiff(case, where)
        return case

    @property
    def name(self) -> str:
        """Name that the run folder begins with."""
        return self.settings.name

    @property
    def pair_law(self) -> HertzLaw:
        """The plain law of particles with particles, of several kinds the first's."""
        return self.pairings[0].law

    @property
    def wall_law(self) -> HertzLaw:
        """The plain law of particles with walls, likewise."""
        return self._first_at_wall.law

    @property
    def _first_at_wall(self) -> Pairing:
        return next(pairing for pairing in self.pairings if pairing.of_wall)

    @cached_property
    def restitution(self) -> dict[str, float]:
        """Restitution of particle_particle and particle_wall, as given [-], of the first kind."""
        both = self.pairings[0], self._first_at_wall
        return {name: one.restitution for name, one in zip(CLASSES, both, strict=True)}

    @cached_property
    def yield_velocity(self) -> dict[str, float | None]:
        """Yield velocity of each class (eq. 5.26) [m/s]; None: not known, or of several kinds.

        Against walls of several materials it is the lowest.
        """
        found: dict[str, float | None] = {}
        for name, of_wall in zip(CLASSES, (False, True), strict=True):
            own = [one.yield_velocity for one in self.pairings if one.of_wall == of_wall]
            known = [limit for limit in own if limit is not None]
            found[name] = min(known) if known and self.sorts == 1 else None
        return found

    @cached_property
    def wave_speed(self) -> dict[str, float]:
        """Speed of dilatational waves (eq. 5.12) of each class's slowest material [m/s]."""
        return {
            name: min(one.wave_speed for one in self.pairings if one.of_wall == of_wall)
            for name, of_wall in zip(CLASSES, (False, True), strict=True)
        }

    @property
    def of_spheres(self) -> bool:
        """True where all particles are spheres, which need no orientation."""
        return self.particle.is_sphere if self.bed is None else self.bed.of_spheres

    @property
    def sub_spheres(self) -> np.ndarray:
        """Number of spheres of each particle (count,)."""
        if self.bed is not None:
            return self.bed.sub_spheres
        return np.full(self.count, len(self.particle.radii))

    def solids(self, count: int) -> MultiSphere | list[MultiSphere]:
        """The particle that all are, or each of the first of them, as the engine takes them."""
        return self.particle if self.bed is None else self.bed.particles[:count]

    @property
    def sorts(self) -> int:
        """Kinds of particles."""
        return 1 if self.bed is None else len(self.bed.sorts)

    @property
    def is_plain(self) -> bool:
        """True where one law holds for all pairs, without rolling resistance or cohesion.

        Shapes that differ have a table all the same, so that their kernels are compiled once.
        """
        law = self.settings.law
        alike = self.sorts == 1 and not self.wall_kinds.any()
        alike &= self.bed is None or self.bed.of_spheres
        return alike and law.cohesion is None and law.rolling_friction is None

    def laws(self, count: int) -> tuple[HertzLaw, HertzLaw] | tuple[LawTable, LawTable]:
        """Laws of the first particles among themselves and with walls, as the engine takes them."""
        if self.is_plain:
            return self.pair_law, self.wall_law
        law = self.settings.law
        rolling = law.rolling_stiffness or 0.0, law.rolling_damping or 0.0, law.rolling_friction
        more = law.surface_energy or 0.0, (*rolling[:2], rolling[2] or 0.0)
        kind = np.zeros(count, np.int64) if self.bed is None else self.bed.kind[:count]
        cohesion, walls = COHESIONS[law.cohesion], self.sorts + self.wall_kinds
        kind, radii = (
            np.repeat(each, self.sub_spheres[:count]) for each in (kind, self.radii[:count])
        )
        table = table_of_laws(walls, kind, radii, self.pairings, more, cohesion)
        return table, table

    @property
    def radii(self) -> np.ndarray:
        """Radius of each particle, or of the sphere of its volume (count,) [m]."""
        if self.bed is not None:
            return self.bed.radius
        own = self.particle.radii[0] if self.particle.is_sphere else None
        return np.full(self.count, self.particle.equal_volume_radius if own is None else own)

    @property
    def masses(self) -> np.ndarray:
        """Mass of each particle (count,) [kg]."""
        if self.bed is not None:
            return self.bed.density * self.bed.volume
        return np.full(self.count, self.particle_mass)

    @property
    def particle_mass(self) -> float:
        """Mass of one particle [kg], of unlike ones their mean."""
        return self.density * self.particle.volume

    @property
    def mass(self) -> float:
        """Mass of all particles [kg]."""
        return self.count * self.particle_mass

    @property
    def load_on_host(self) -> float:
        """Mass of all particles over the host's at their enclosure [-]; 0 without a host."""
        return 0.0 if self.modes is None else self.mass * float(self.modes.shape @ self.modes.shape)

    @property
    def fill_ratio(self) -> float:
        """Volume of the particles over that of the void (thesis, eq. 6.1) [-]."""
        return self.count * self.particle.volume / self.enclosure.volume

    @property
    def orientation(self) -> str:
        """Direction of gravity to the motion: "vertical", "horizontal" or "none"."""
        return orientation_of(self.gravity, self.direction)

    @property
    def period(self) -> float:
        """Length of a cycle [s]."""
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
        """Gamma g / omega^2 [m] (eq. 6.2); of an excitation its largest displacement."""
        if self.peaks is not None:
            return self.peaks.displacement
        motion = self.settings.motion
        return amplitude_of(motion.gamma, motion.frequency)

    @property
    def peak_speed(self) -> float:
        """Gamma g / omega, the largest velocity of the enclosure [m/s]."""
        if self.peaks is not None:
            return self.peaks.speed
        motion = self.settings.motion
        return motion.gamma * GRAVITY / (2.0 * math.pi * motion.frequency)

    @property
    def shaker(self) -> Any:
        """The motion of the enclosure along its direction, as numbers of its kind; a new host."""
        mover = self.excitation or self.drive
        if self.modes is not None and mover is not None:
            own = host_of(self.modes, mover, self.time_step, self.weight)
            return own if self.arc is None else Turning(own, self.arc, np.zeros(1))
        if self.excitation is not None:
            return self.excitation.motion
        return motion_of(self.settings.motion, self.name)

    def shown(self, k: int) -> "DamperCase":
        """The case with its results those of damper number k (from 0) of several."""
        assert self.together is not None
        host = self.together.host.model_copy(update={"shown": k + 1 if k else None})
        together = self.together.model_copy(update={"host": host})
        own = self.dampers[k]
        return replace(own, dampers=self.dampers, together=together, source=self.source)

    @property
    def settling(self) -> "DamperCase":
        """The case while its particles settle, with the friction that they settle with.

        Their restitution falls only where the case requests it: a packing serves all motions.
        """
        friction = self.settings.fill.friction
        laws = [self._settles_with(one) for one in self.pairings]
        if friction is not True:
            laws = [law._replace(mu=float(friction)) for law in laws]
        pairings = (replace(one, law=law) for one, law in zip(self.pairings, laws, strict=True))
        return replace(self, pairings=tuple(pairings))

    def _settles_with(self, pairing: Pairing) -> HertzLaw:
        """The law of a pairing, whatever the motion."""
        given = self.settings.law.yielding is not None
        return pairing.law if given else pairing.law._replace(yielding=math.inf)

    def with_seed(self, seed: int) -> "DamperCase":
        """The case with another seed, from which those of several dampers follow.

        Sizes that are drawn are drawn again, and all that follows from them.
        """
        if self.source and any(one.bed is not None for one in (self, *self.dampers)):
            document, where, folder = self.source
            again = self.resolve(changed(document, {"run.seed": seed}, Settings), where, folder)
            return again.shown(self.number) if self.dampers else again
        if self.together is None:
            return replace(self, settings=_seeded(self.settings, seed))
        seeds = seeds_of(self.together.damper or [], seed)
        dampers = tuple(
            replace(one, settings=_seeded(one.settings, own))
            for one, own in zip(self.dampers, seeds, strict=True)
        )
        together = _seeded(self.together, seed)
        return replace(dampers[self.number], dampers=dampers, together=together)

    @property
    def all_particles(self) -> int:
        """Number of particles of all dampers on the host."""
        return sum(one.count for one in self.dampers) or self.count

    @property
    def number(self) -> int:
        """Number of the damper among those on its host, from 0."""
        return 0 if self.together is None else (self.together.host.shown or 1) - 1

    @property
    def shakers(self) -> list[Any]:
        """Motion of each damper: of several a new host, whose state they share."""
        if not self.dampers:
            return [self.shaker]
        modes = [one.modes for one in self.dampers if one.modes is not None]
        return ride_together(self.dampers[0].shaker, modes, [one.weight for one in self.dampers])

    def bare_displacement(self, time: np.ndarray) -> np.ndarray:
        """Displacement [m] of the bare host at the times of samples (n,) [s] from 0 on."""
        assert self.modes is not None
        if self.excitation is None:
            assert self.drive is not None
            return bare_displacement(self.modes, self.drive, time)
        each, every = self.time_step, self.steps_per_sample
        return bare_rows(self.modes, self.excitation, each, len(time) - 1, every)[0]

    @property
    def weight(self) -> float:
        """Force of the bed at rest on its enclosure, along the motion [N]; none about the axis."""
        return 0.0 if self.arc is not None else self.mass * float(self.gravity @ self.direction)

    @property
    def is_decay(self) -> bool:
        """True where a host is let go, and nothing moves it from then on."""
        return self.drive is not None and self.drive.is_release

    @property
    def wall_names(self) -> list[str]:
        """Names of the walls in the order of their numbers."""
        return self.enclosure.wall_names

    @property
    def wall_kinds(self) -> np.ndarray:
        """Number of the material of each wall (n_walls,): that of the enclosure is 0."""
        return kinds_of_walls(self.settings, self.wall_names)

    def to_toml(self) -> str:
        """The case as a file for the run folder, which has copies of the files it names."""
        settings = self.settings if self.together is None else as_given(self.together)
        particles: dict[str, Any] = {"materials": "materials.toml"}
        copied = with_copies(settings.particles) if self.together is None else settings.particles
        kinds = settings.particles.kind or []
        if self.together is None and not any(kind.count for kind in kinds):
            particles["count"] = self.count
        modes = {"modes": MODES} if MODES in self.files else {}
        excited = {"file": COPY, "column": None, "full_scale": None} if COPY in self.files else {}
        excitation = self._excitation_keys(settings, excited)
        own = self.enclosure.keys if self.together is None else {}
        enclosure = {key: size for key, size in own.items() if key in EnclosureKeys.model_fields}
        if self.together is None and "height" not in own:
            enclosure["height"] = None
        return to_toml(
            settings.model_copy(
                update={
                    "particles": copied.model_copy(update=particles),
                    "enclosure": settings.enclosure.model_copy(update=enclosure),
                    "host": settings.host.model_copy(update=modes),
                    **excitation,
                }
            )
        )

    def _excitation_keys(self, settings: Settings, copied: dict[str, Any]) -> dict[str, Any]:
        """The tables of a case with an excitation, which stands for keys of [motion] and [run]."""
        if self.excitation is None:
            return {}
        psd = settings.excitation.psd
        if isinstance(psd, str):
            copied = {**copied, "psd": self.excitation.breakpoints}
        return {"excitation": settings.excitation.model_copy(update=copied)}

    def identity(self) -> dict[str, Any]:
        """All that the results of a run depend on, by which its folder is named."""
        run, motion = self.settings.run, self.settings.motion
        length = {"steady": run.max_cycles} if run.steady else {}
        own = motion.model_extra or {}
        kind = [motion.kind, *own.items()] if motion.kind != "sines" else []
        packing, laws = self.packing_identity(), [list(one.law) for one in self.pairings]
        settled = {"settling_laws": packing["laws"]} if packing["laws"] != laws else {}
        return {
            **packing,
            "laws": laws,
            **settled,
            "motion": [motion.orientation, motion.frequency, motion.gamma, motion.ramp, *kind],
            "direction": self.direction,
            "gravity": self.gravity,
            "cycles": [run.cycles, run.discard],
            **length,
            **self._host_identity(),
            **self._excitation_identity(),
            **self._others_identity(),
            "time_step": self.time_step,
            "yield_velocity": self.yield_velocity,
            "output": self.settings.output.model_dump(),
        }

    def _host_identity(self) -> dict[str, Any]:
        """Modes and drive of a host; nothing without one."""
        if self.modes is None:
            return {}
        drive = [] if self.drive is None else vars(self.drive).values()
        arc = [] if self.arc is None else [self.arc]
        modes = [values for values in vars(self.modes).values() if values is not None]
        return {"host": [*modes, *drive, *arc]}

    def _others_identity(self) -> dict[str, Any]:
        """All dampers on its host, and which of them it is; nothing of a single one."""
        if not self.dampers:
            return {}
        return {"dampers": [one.identity() for one in self.dampers], "shown": self.number}

    def _excitation_identity(self) -> dict[str, Any]:
        """Numbers that an excitation is made of; nothing without one."""
        own = self.excitation
        if own is None:
            return {}
        return {"excitation": [own.kind, own.on, *own.identity]}

    def packing_identity(self) -> dict[str, Any]:
        """All that a settled packing depends on: not what acts only once the enclosure moves."""
        enclosure, particle, law = self.enclosure, self.particle, self.settings.law
        # Two spheres have one contact.
        model = {} if self.of_spheres else {"contact_treatment": law.contact_treatment}
        return {
            "enclosure": enclosure.identity,
            "particle": [particle.offsets, particle.radii, particle.volume, particle.inertia],
            "count": self.count,
            "density": self.density,
            "laws": [list(self._settles_with(pairing)) for pairing in self.pairings],
            **self._more_identity(),
            "wall_curvature": law.wall_curvature,
            **model,
            "settling_gravity": self.settling_gravity,
            "fill": self.settings.fill.model_dump(include={"settle_time"}),
            "fill_time_step": self.steps.free,
            "seed": self.settings.run.seed,
        }

    def _more_identity(self) -> dict[str, Any]:
        """Likewise, of unlike particles and of what a law has besides Hertz, Mindlin and Tsuji."""
        law = self.settings.law
        more: dict[str, Any] = {}
        if self.wall_kinds.any():
            more["walls"] = self.wall_kinds
        if self.bed is not None:
            more["bed"] = self.bed.identity
        if self.settings.fill.friction is not True:
            more["fill_friction"] = float(self.settings.fill.friction)
        if law.cohesion is not None:
            more["cohesion"] = [law.cohesion, law.surface_energy]
        if law.rolling_friction is not None:
            more["rolling"] = [law.rolling_friction, law.rolling_stiffness, law.rolling_damping]
        return more


def _resolved(
    cls: type[DamperCase], shaken: Shaken, table: ContactTable, where: str, file: Path,
    folder: Path, others: float,
) -> DamperCase:  # fmt: skip
    settings, modes = shaken.settings, shaken.modes
    enclosure = enclosure_of(settings, where, folder)
    materials, walls = materials_of(table, settings)
    files = {"materials.toml": file.read_text(encoding="utf-8")}
    files |= cavity_copy(enclosure) | modes_copy(settings.host, folder)
    bed = None
    if is_mixed(settings.particles):
        bed = bed_of(settings.particles, materials, enclosure, settings.run.seed, where, folder)
        particle, count, density = bed.mean_sphere, len(bed.radius), bed.mean_density
        balls = [sort.ball for sort in bed.sorts]
        for sort in bed.sorts:
            check_enclosure(enclosure, sort.shape, settings, where)
            files |= sort.mesh
    else:
        with located(f"{where}: [particles]"):
            wanted = particle_wanted(settings.particles, folder)
            particle = particle_of(wanted)
        check_enclosure(enclosure, particle, settings, where)
        count = count_of(enclosure, particle, settings.particles, where)
        density = materials[0].density.value
        balls = [Ball(materials[0], particle.smallest_radius, density * particle.volume)]
        files |= mesh_copy(wanted)
    of_spheres = particle.is_sphere if bed is None else bed.of_spheres
    check_law(settings.law, of_spheres, where)
    fastest = 2.0 * settings.motion.gamma * GRAVITY / (2.0 * math.pi * settings.motion.frequency)
    if shaken.excitation is not None and shaken.peaks is not None:
        fastest = 2.0 * shaken.peaks.speed
        files |= shaken.excitation.files
    partners: list[Ball | Material] = [*balls, *walls]
    pairings = tuple(
        pairing_of(table, settings.law, balls[a], partners[b], fastest)
        for a, b in pairs_of(len(balls), len(walls))
    )
    tangential = max(pairing.law.tangential for pairing in pairings)
    mobility = 0.0 if modes is None else float(modes.shape @ modes.shape)
    load = count * density * particle.volume * mobility if mobility else 0.0  # not infinity times 0
    load += others
    swiftest = [(particle, materials[0], 1.0)] if bed is None else bed.swiftest(tangential)
    steps = [
        time_steps(one, own, tangential, settings, where, load, faster)
        for one, own, faster in swiftest
    ]
    shortest = min(steps, key=lambda one: (one.free, one.limit))
    check_rolling_step(settings.law, pairings, shortest.free, where)
    gravity, settling = gravity_of(settings.motion, where)
    direction = direction_of(settings.motion, f"{where}: [motion] direction")
    return cls(
        settings, enclosure, particle, count, density, pairings, shortest, gravity, settling,
        direction, files, bed, *shaken[1:],
    )  # fmt: skip


def _check_stiff(case: DamperCase, where: str) -> None:
    """Raise InputError where a particle sinks into a wall by its own weight alone.

    Hertz: m g = K d^(3/2), with K as in an impact (damper3d.case.plan).
    """
    for pairing in case.pairings:
        radius, mass, law = pairing.radius, pairing.mass, pairing.law
        sunk = (mass * GRAVITY / (law.hertz * math.sqrt(radius))) ** (2 / 3)
        if pairing.of_wall and sunk > 0.5 * radius:  # which ends a run
            raise InputError(
                f"{where}: youngs_modulus is too low: by its own weight a particle would sink into "
                f"a wall by {sunk / radius:.2g} radii; give a higher one"
            )


def _seeded(settings: Settings, seed: int) -> Settings:
    run = settings.run.model_copy(update={"seed": seed})
    return settings.model_copy(update={"run": run})


def _calculable(case: DamperCase) -> bool:
    """True where squares, cubes and ratios of all numbers are floats too."""
    yields = [v for v in case.yield_velocity.values() if v is not None]
    laws = [x for one in case.pairings for x in (one.law.hertz, one.law.tangential)]
    inertia = case.density * float(case.particle.inertia.min())
    motion = [case.amplitude, case.peak_speed, case.steps.limit, case.time_step]
    sizes = [case.enclosure.volume, case.mass, case.density, inertia]
    friction = max(pairing.law.mu for pairing in case.pairings)
    ordinary = all(1e-60 < x < 1e60 for x in [*yields, *laws, *motion, *sizes])
    return ordinary and friction < 1e60 and case.settings.motion.ramp * case.period < 1e60
