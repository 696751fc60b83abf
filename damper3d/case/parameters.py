"""Contact laws, yield velocities and time step of a case: the materials file, then the changes."""

import dataclasses
import math
from pathlib import Path

from damper3d.case.oscillation import equivalent_sphere_radius
from damper3d.case.settings import Law, Settings
from damper3d.engine.records import CLASSES
from damper3d.shapes.multisphere import MultiSphere
from granulab.contact.files.datafile import data_file, read_toml
from granulab.contact.files.needs import DAMPER, Keys, keys_needed, table_with
from granulab.contact.files.schema import SCHEMA
from granulab.contact.files.table import ContactTable, namesake
from granulab.contact.files.units import located
from granulab.contact.hertz import HertzLaw
from granulab.contact.material import Material, Measured
from granulab.contact.sphere_law import sphere_law, yield_velocity
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


def materials_of(table: ContactTable, settings: Settings) -> tuple[Material, Material]:
    """Materials of particles and enclosure, with the case's own modulus and density."""
    particle = table.material(settings.particles.material)
    wall = table.material(settings.enclosure.material)
    law = settings.law
    if law.density is not None:
        particle = dataclasses.replace(particle, density=Measured(law.density))
    if law.youngs_modulus is not None:
        modulus = Measured(law.youngs_modulus)
        particle = dataclasses.replace(particle, youngs_modulus=modulus)
        wall = dataclasses.replace(wall, youngs_modulus=modulus)
    return particle, wall


def table_of(file: str | Path, settings: Settings) -> ContactTable:
    """See table_with: a table with all that the case needs and does not give itself, in [law]."""
    for material in dict.fromkeys((settings.enclosure.walls or {}).values()):
        table_of(file, of_one_wall(settings, material))
    law = settings.law
    given = {key for key in _LAW_STANDS_IN if getattr(law, key) is not None}
    at_wall = {f"{key}_wall" for key in given} | {
        key for key in ("friction_wall", "restitution_wall") if getattr(law, key) is not None
    }
    particle, wall = settings.particles.material, settings.enclosure.material
    of_wall = f"pair.{particle}-{wall}" if particle != wall else ""
    needed = [
        (where, key)
        for where, key in keys_needed(DAMPER, particle, wall)
        if key not in given and not (where == of_wall and f"{key}_wall" in at_wall)
    ]
    return table_with(file, needed, _cure)


def of_one_wall(settings: Settings, material: str) -> Settings:
    """The settings of a case all of whose walls are of one material."""
    enclosure = settings.enclosure.model_copy(update={"material": material, "walls": None})
    return settings.model_copy(update={"enclosure": enclosure})


def laws_by_wall(
    table: ContactTable, settings: Settings
) -> dict[str, tuple[HertzLaw, float, Material]]:
    """Law, restitution [-] and material of the walls that have their own, by the wall's name."""
    found = {}
    for name, material in (settings.enclosure.walls or {}).items():
        own = of_one_wall(settings, material)
        materials = materials_of(table, own)
        law = contact_laws(table, materials, own)[1]
        found[name] = law, restitutions(table, own)[CLASSES[1]], materials[1]
    return found


_LAW_STANDS_IN = ("friction", "restitution", "youngs_modulus")  # for what a file does not have


def _cure(absent: Keys) -> str:
    """The end of a refusal: what else would do."""
    missing = {key for _, key in absent}
    keys = [key for key in _LAW_STANDS_IN if key in missing]
    options = ", ".join(f"--{key.replace('_', '-')}" for key in keys)
    instead = f"or give [law] {', '.join(keys)} ({options}); " if keys else ""
    return f"{instead}damper3d init --materials FILE writes a file with all"


def restitutions(table: ContactTable, settings: Settings) -> dict[str, float]:
    """Restitution of each kind of contact [-]: the case's, else the file's."""
    law = settings.law
    given = law.restitution, _first(law.restitution_wall, law.restitution)
    found = {}
    for name, names, own in zip(CLASSES, _pairs(settings), given, strict=True):
        if own is None:
            known = table.pair(*names).restitution
            assert known is not None  # table_of has refused that
            own = known.value
        found[name] = own
    return found


def frictions(table: ContactTable, settings: Settings) -> dict[str, float]:
    """Friction of each kind of contact [-], as the restitution."""
    law = settings.law
    given = law.friction, _first(law.friction_wall, law.friction)
    return {
        name: table.pair(*names).friction.value if own is None else own
        for name, names, own in zip(CLASSES, _pairs(settings), given, strict=True)
    }


def _pairs(settings: Settings) -> tuple[tuple[str, str], tuple[str, str]]:
    """The materials of particle-particle and particle-wall contacts."""
    particle, wall = settings.particles.material, settings.enclosure.material
    return (particle, particle), (particle, wall)


def _first(*values: float | None) -> float | None:
    return next((value for value in values if value is not None), None)


def contact_laws(
    table: ContactTable, materials: tuple[Material, Material], settings: Settings
) -> tuple[HertzLaw, HertzLaw]:
    """Particle-particle and particle-wall laws (thesis, eqs 5.5-5.16, 5.32, 5.33)."""
    particle, wall = materials
    friction, restitution = frictions(table, settings), restitutions(table, settings)
    laws = [
        _law(particle, other, friction[name], restitution[name], settings.law, table.path)
        for name, other in zip(CLASSES, (particle, wall), strict=True)
    ]
    return laws[0], laws[1]


def _law(
    first: Material, second: Material, friction: float, restitution: float, law: Law,
    file: Path | None,
) -> HertzLaw:  # fmt: skip
    with located(f"{file}:"):
        return sphere_law(
            first,
            second,
            friction=friction,
            restitution=restitution,
            end=law.contact_end,
            tangential=law.tangential,
            yielding=law.yielding,
        )


def yield_velocities(
    materials: tuple[Material, Material], particle: MultiSphere
) -> dict[str, float | None]:
    """Eq. 5.26 for each kind of contact [m/s], between spheres of the particle's own radius.

    Each has its own reduced radius and mass; the wall is flat and does not move. None where no
    yield strength is known.
    """
    radius, density = particle.smallest_radius, materials[0].density.value
    mass = density * particle.volume
    found: dict[str, float | None] = {}
    for name, other, share in zip(CLASSES, materials, (0.5, 1.0), strict=True):
        if materials[0].yield_strength is None and other.yield_strength is None:
            found[name] = None
            continue
        found[name] = yield_velocity(materials[0], other, radius=share * radius, mass=share * mass)
    return found


def lowest_yield(walls: list[dict[str, float | None]]) -> dict[str, float | None]:
    """The lowest of yield velocities against several walls [m/s]; None where none is known."""
    found: dict[str, float | None] = {}
    for name in CLASSES:
        known = [own for wall in walls if (own := wall[name]) is not None]
        found[name] = min(known) if known else None
    return found


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
    load: float = 0.0,
) -> Steps:  # fmt: skip
    """The time step of a case and why; InputError where there is none.

    A cycle has a whole number of samples and a sample a whole number of steps, so the step that
    is given, or the usual one, is shortened to fit. tangential is kt/kn of the contacts [-], load
    the mass of the bed over that of the host: walls that give way make contacts swifter. One
    particle of mass m on a host M swings by sqrt(1 + m/M) faster, and all together, each on a
    contact of its own, by sqrt(1 + load).
    """
    rayleigh = _rayleigh(particle.smallest_radius, material)
    limit = _rayleigh(equivalent_sphere_radius(particle, tangential), material)
    if load > _LIGHTEST:
        raise InputError(
            f"{where}: [host] the bed has {load:.3g} times the host's mass: the walls' stiffness "
            f"over so light a host takes steps of {limit / math.sqrt(1.0 + load):.2g} s at most; "
            f"give a host of at least 1/{_LIGHTEST:g} of the bed, or fewer particles"
        )
    limit /= math.sqrt(1.0 + load)
    wanted, reason = _wanted_step(settings.run.time_step, limit, particle.is_sphere, load, where)
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
    given: float | None, limit: float, is_sphere: bool, load: float, where: str
) -> tuple[float, str]:
    """The step [s] before it is fitted to the samples, and why."""
    whose = "" if is_sphere else " of the sphere that oscillates as fast"
    if load > _LIGHT:
        whose += f" before a host of {1 / load:.3g} of the bed's mass"
    bound = f"Rayleigh step {limit:.3g} s{whose} (thesis, eq. 3.31)"
    usual = _USUAL_SHARE if is_sphere else _MULTI_SPHERE_SHARE
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
