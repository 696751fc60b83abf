"""Materials and time step of a case: the materials file, then the changes."""

import dataclasses
import itertools
import math
from pathlib import Path

import numpy as np

from damper3d.case.oscillation import equivalent_sphere_radius
from damper3d.case.settings import Settings
from damper3d.shapes.multisphere import MultiSphere
from granulab.contact.files.datafile import data_file, read_toml
from granulab.contact.files.needs import (
    DAMPER,
    Keys,
    follows_from_loss,
    keys_needed,
    table_with,
    tables_in,
)
from granulab.contact.files.schema import SCHEMA
from granulab.contact.files.table import ContactTable, namesake
from granulab.contact.material import Material, Measured
from granulab.contact.timestep import rayleigh_time_step
from granulab.errors import InputError

USUAL_TIME_STEP = 1e-6  # [s] the thesis's (Table 6.1); 2 us gives the same within the scatter
_USUAL_SHARE = 0.2  # of the Rayleigh step, by two digits, where the usual step is longer
# The same of multi-sphere particles, whose limit counts contacts that act together: at 0.43 90
# spheroids left 0.6 % of the energy unaccounted, which goes as the square of the step
_MULTI_SPHERE_SHARE = 0.3
SAFE_SHARE = 0.4  # of the Rayleigh step; the thesis takes 0.1 to 0.4 of it (eq. 3.32)
MOST_STEPS = 10**12  # a year of one core, and more
_LIGHT = 0.1  # of the host, that a bed weighs whose share in the step's limit is named
_LIGHTEST = 100.0  # likewise, above which the step would be ten times shorter for the host alone


def materials_of(table: ContactTable, settings: Settings) -> tuple[list[Material], list[Material]]:
    """Materials of each kind of particle and of the walls, with the case's own constants."""
    particles = [table.material(name) for name in _names(settings)]
    walls = [table.material(name) for name in _of_walls(settings)]
    law = settings.law
    if law.density is not None:
        density = Measured(law.density)
        particles = [dataclasses.replace(one, density=density) for one in particles]
    if law.youngs_modulus is not None:
        modulus = Measured(law.youngs_modulus)
        particles = [dataclasses.replace(one, youngs_modulus=modulus) for one in particles]
        walls = [dataclasses.replace(one, youngs_modulus=modulus) for one in walls]
    return particles, walls


def _names(settings: Settings) -> list[str]:
    """The material of each kind of particle."""
    particles = settings.particles
    if not particles.kind:
        return [particles.material]
    return [kind.material or particles.material for kind in particles.kind]


def table_of(file: str | Path, settings: Settings) -> ContactTable:
    """See table_with: a table with all that the case needs and does not give itself, in [law]."""
    for material in dict.fromkeys((settings.enclosure.walls or {}).values()):
        table_of(file, of_one_wall(settings, material))
    law = settings.law
    given = {key for key in _LAW_STANDS_IN if getattr(law, key) is not None}
    at_wall = {f"{key}_wall" for key in given} | {
        key for key in ("friction_wall", "restitution_wall") if getattr(law, key) is not None
    }
    wall, names = settings.enclosure.material, list(dict.fromkeys(_names(settings)))
    of_walls = {f"pair.{name}-{wall}" for name in names} if wall not in names else set()
    wanted = {one: None for name in names for one in keys_needed(DAMPER, name, wall)}
    wanted |= {
        (f"pair.{first}-{second}", key): None
        for first, second in itertools.combinations(names, 2)
        for key in DAMPER.pair
    }
    tables = tables_in(Path(file))
    needed = [
        (where, key)
        for where, key in wanted
        if key not in given
        and not (where in of_walls and f"{key}_wall" in at_wall)
        and not follows_from_loss(tables, where, key)
    ]
    prisms = any("kn" in pair.get("linear", {}) for pair in tables.get("pair", {}).values())
    return table_with(file, needed, _cure_of_prisms if prisms else _cure)


def of_one_wall(settings: Settings, material: str) -> Settings:
    """The settings of a case all of whose walls are of one material."""
    enclosure = settings.enclosure.model_copy(update={"material": material, "walls": None})
    return settings.model_copy(update={"enclosure": enclosure})


def kinds_of_walls(settings: Settings, names: list[str]) -> np.ndarray:
    """Number of the material of each wall (n_walls,), in the order of `materials_of`."""
    known, own = _of_walls(settings), settings.enclosure.walls or {}
    return np.array([known.index(own.get(name, known[0])) for name in names])


def _of_walls(settings: Settings) -> list[str]:
    """The materials of the walls, that of the enclosure first."""
    enclosure = settings.enclosure
    return list(dict.fromkeys([enclosure.material, *(enclosure.walls or {}).values()]))


_LAW_STANDS_IN = ("friction", "restitution", "youngs_modulus")  # for what a file does not have


def _cure(absent: Keys) -> str:
    """The end of a refusal: what else would do."""
    missing = {key for _, key in absent}
    keys = [key for key in _LAW_STANDS_IN if key in missing]
    options = ", ".join(f"--{key.replace('_', '-')}" for key in keys)
    instead = f"or give [law] {', '.join(keys)} ({options}); " if keys else ""
    return f"{instead}damper3d init --materials FILE writes a file with all"


def _cure_of_prisms(absent: Keys) -> str:
    """The same for a file with kn of prisms, which E and nu alone do not follow from."""
    elastic = any(key in ("youngs_modulus", "poisson") for _, key in absent)
    words = (
        "its kn and kt are of prisms, and go with their shapes and load too: silo2d elastic CASE "
        "--materials FILE says which E and nu they stand for, or that no solid has them; "
    )
    return words * elastic + _cure(absent)


@dataclasses.dataclass(frozen=True)
class Steps:
    """Time steps: of a sample, and samples of a cycle."""

    time_step: float  # [s] a whole number of them makes a sample
    per_sample: int
    free: float  # [s] the step before it was fitted to the samples: that of the filling
    rayleigh: float  # [s] eq. 3.31, of the smallest sphere
    limit: float  # [s] the same, of the sphere that oscillates as fast on its contacts
    reason: str


def time_steps(
    particle: MultiSphere, material: Material, tangential: float, settings: Settings, where: str,
    load: float = 0.0, faster: float = 1.0,
) -> Steps:  # fmt: skip
    """The time step of a case and why; InputError where there is none.

    A cycle has a whole number of samples and a sample a whole number of steps, so the step that
    is given, or the usual one, is shortened to fit. tangential is kt/kn of the contacts [-], load
    the mass of all beds on a host over its own: walls that give way make contacts swifter. One
    particle of mass m on a host M swings by sqrt(1 + m/M) faster, and all together, each on a
    contact of its own, by sqrt(1 + load). Contacts with other particles may oscillate faster than
    those with a wall by the factor `faster`.
    """
    rayleigh = _rayleigh(particle.smallest_radius, material)
    limit = _rayleigh(equivalent_sphere_radius(particle, tangential), material) / faster
    if load > _LIGHTEST:
        raise InputError(
            f"{where}: [host] the bed has {load:.3g} times the host's mass: the walls' stiffness "
            f"over so light a host takes steps of {limit / math.sqrt(1.0 + load):.2g} s at most; "
            f"give a host of at least 1/{_LIGHTEST:g} of the bed, or fewer particles"
        )
    limit /= math.sqrt(1.0 + load)
    alone = particle.is_sphere and faster == 1.0
    wanted, reason = _wanted_step(settings.run.time_step, limit, alone, load, where)
    samples, frequency = settings.output.samples, settings.motion.frequency
    sample = 1.0 / (frequency * samples)
    ratio = sample / wanted
    if ratio < 1 - 1e-9:
        raise InputError(
            f"{where}: [motion] frequency = {frequency:g} Hz: a sample, 1/{samples} of a cycle, "
            f"takes {sample:.3g} s, less than a time step of {wanted:.3g} s; give fewer samples "
            "a cycle or a shorter time step"
        )
    run = settings.run
    cycles = run.max_cycles if run.steady else run.cycles
    if not ratio * samples * cycles <= MOST_STEPS:
        raise InputError(
            f"{where}: {cycles} cycles of {1 / frequency:.3g} s in steps of {wanted:.3g} s: more "
            f"than {MOST_STEPS:.0e} steps, which nobody can wait for; give a higher frequency, "
            "fewer cycles or a longer time step"
        )
    if not settings.fill.settle_time / wanted <= MOST_STEPS:
        raise InputError(
            f"{where}: [fill] settle_time = {settings.fill.settle_time:g} s in steps of "
            f"{wanted:.3g} s: more than {MOST_STEPS:.0e} steps; give a shorter one"
        )
    per_sample = max(math.ceil(ratio * (1 - 1e-9)), 1)
    fitted = 1.0 / (frequency * samples * per_sample)
    return Steps(fitted, per_sample, wanted, rayleigh, limit, reason)


def _rayleigh(radius: float, material: Material) -> float:
    assert material.youngs_modulus is not None  # the laws have refused that
    assert material.poisson is not None
    modulus, poisson = material.youngs_modulus.value, material.poisson.value
    return rayleigh_time_step(radius, material.density.value, modulus, poisson)


def _wanted_step(
    given: float | None, limit: float, alone: bool, load: float, where: str
) -> tuple[float, str]:
    """The step [s] before it is fitted to the samples, and why; alone: one contact acts."""
    whose = "" if alone else " of the sphere that oscillates as fast"
    if load > _LIGHT:
        whose += f" before a host of {1 / load:.3g} of the bed's mass"
    bound = f"Rayleigh step {limit:.3g} s{whose} (thesis, eq. 3.31)"
    usual = _USUAL_SHARE if alone else _MULTI_SPHERE_SHARE
    if given is not None:
        if given > limit:
            raise InputError(
                f"{where}: [run] time_step = {given:.6g} s: above the Rayleigh limit of "
                f"{limit:.3g} s{whose}; give at most {SAFE_SHARE * limit:.2g} s, "
                f"{SAFE_SHARE:g} of it, or leave it out and one is chosen"
            )
        return given, f"as given, {given / limit:.2f} of the {bound}"
    if round(USUAL_TIME_STEP / limit, 2) <= usual:
        return USUAL_TIME_STEP, f"the usual one, {USUAL_TIME_STEP / limit:.2f} of the {bound}"
    exponent = math.floor(math.log10(usual * limit)) - 1
    chosen = math.floor(usual * limit / 10**exponent) * 10.0**exponent
    return chosen, f"{chosen / limit:.2f} of the {bound}"


def named_material(file: str) -> dict[str, str]:
    """The changes of a case whose particles and walls are of the material of a table.

    It is the one that the table is called after, or its only one. Raises InputError otherwise.
    """
    path = data_file("materials", file) or Path(file)
    name = namesake(path, read_toml(path, "materials", SCHEMA).get("material", {}))
    return {
        "particles.materials": str(Path(file).resolve()) if Path(file).is_file() else file,
        "particles.material": name,
        "enclosure.material": name,
    }
