"""Shapes, contact laws and time steps of a case: the files it names, then what it changes."""

import dataclasses
import math
from functools import lru_cache
from pathlib import Path
from typing import Any

from granulab.contact.files.needs import (
    SILO,
    Keys,
    damping_is_left_out,
    follows_from_modulus,
    keys_needed,
    materials_of,
    table_with,
    tables_in,
)
from granulab.contact.files.table import ContactTable
from granulab.contact.laws import LinearLaw
from granulab.contact.material import LinearParameters, Measured, Pair
from granulab.contact.restitution import damping_for_restitution
from granulab.errors import InputError
from silo2d.case.settings import Particles, Settings
from silo2d.case.shape import ShapeSet, rounded, scaled
from silo2d.case.shapefile import content_with, load_shapes
from silo2d.case.stability import (
    USUAL_TIME_STEP,
    chosen_step,
    largest_stable_step,
    margin_of,
    step_for_held_particles,
)


def shapes_of(file: str | Path, particles: Particles) -> ShapeSet:
    """The shapes of a file, see load_shapes, as a case has them; the same object for the same.

    Their corners are rounded otherwise first, then all is scaled.
    """
    return _shapes(file, content_with(file), particles.scale, particles.spheroradius)


def table_of(file: str | Path, settings: Settings) -> tuple[ContactTable, Settings]:
    """A table with all that the case needs, see table_with; the settings with its materials' names.

    Names that the case leaves out are those of wood in methacrylate, or the table's own.
    """
    tables, particles = tables_in(Path(file)), settings.particles
    given = particles.material, particles.wall
    material, wall = materials_of(tables, given, particles.names)
    particles = particles.model_copy(update={"material": material, "wall": wall})
    settings = settings.model_copy(update={"particles": particles})
    needed = [found for one in needed_keys(settings) if (found := _that_gives(tables, one))]
    needed = list(dict.fromkeys(needed))
    return table_with(file, needed, _cure), settings


def _that_gives(tables: dict[str, Any], needed: tuple[str, str]) -> tuple[str, str] | None:
    """Section and key that a needed one is taken from; None where it follows from E and nu.

    The damping of a pair whose stiffness follows so is taken from its restitution, where the table
    has none.
    """
    where, key = needed
    if follows_from_modulus(tables, where, key):
        return None
    if key == "gamma_n" and damping_is_left_out(tables, where):
        return where.removesuffix(".linear"), "restitution"
    return needed


@lru_cache(maxsize=8)
def _shapes(
    file: str | Path, _content: bytes, scale: float, spheroradius: float | None
) -> ShapeSet:
    found = load_shapes(file)
    if spheroradius is None and scale == 1.0:
        return found
    shapes = found.shapes
    if spheroradius is not None:
        shapes = tuple(rounded(shape, spheroradius, "[particles]") for shape in shapes)
    return dataclasses.replace(found, shapes=tuple(scaled(shape, scale) for shape in shapes))


def _cure(absent: Keys) -> str:
    """The end of a refusal: what else would do."""
    damping = any(key in ("gamma_n", "gamma_t") for _, key in absent)
    stiffness = any(key in ("kn", "kt") for _, key in absent)
    instead = "or youngs_modulus and poisson of both materials, for kn and kt; " * stiffness
    instead += "or damping from the restitution (--damping restitution); " * damping
    return f"{instead}silo2d init --materials FILE writes a file with all"


def needed_keys(settings: Settings) -> Keys:
    """Sections and keys that a case takes of its materials file: what it does not give itself."""
    law, particles = settings.law, settings.particles
    needed = keys_needed(SILO, *particles.names)
    given = {key for key in ("kn", "kt", "gamma_n", "gamma_t") if getattr(law, key) is not None}
    by_restitution = law.damping == "restitution"
    if by_restitution:
        given |= {"gamma_n", "gamma_t"}
        pairs = dict.fromkeys(where for where, key in needed if key == "friction")
        needed += [(where, "restitution") for where in pairs]
    wall = f"pair.{'-'.join(particles.names)}.linear"
    if "gamma_n" in given and not by_restitution and law.gamma_n_wall is None:
        given.remove("gamma_n")  # the wall's scales with it by the two of the file
    apart = {(wall, "gamma_n")} if law.gamma_n_wall is not None else set()
    return [
        key
        for key in needed
        if not (key[0].endswith(".linear") and key[1] in given) and key not in apart
    ]


def whole_pairs(
    settings: Settings, pairs: tuple[Pair, Pair], mean_mass: float, where: str
) -> tuple[Pair, Pair]:
    """The pairs with all constants: those that the file does not have are the case's own.

    gamma_n may follow from the restitution instead, and gamma_t is then 0 where none is given.
    """
    whole = []
    for k, (pair, mass) in enumerate(zip(pairs, (mean_mass / 2, mean_mass), strict=True)):
        linear, law = pair.linear or LinearParameters(), settings.law
        kn, kt = linear.kn or _given(law.kn), linear.kt or _given(law.kt)
        gamma_n, gamma_t = linear.gamma_n, linear.gamma_t or _given(law.gamma_t)
        if gamma_n is None and law.damping == "restitution" and kn is not None:
            gamma_n = Measured(_gamma_from_restitution(settings, pair, kn.value, mass, where))
        if gamma_n is None:
            gamma_n = _given(law.gamma_n_wall if k and law.gamma_n_wall is not None
                             else law.gamma_n)  # fmt: skip
        if gamma_t is None and law.damping == "restitution":
            gamma_t = Measured(0.0)
        known = LinearParameters(kn, kt, gamma_n, gamma_t)
        whole.append(dataclasses.replace(pair, linear=known))
    return whole[0], whole[1]


def _given(value: float | None) -> Measured | None:
    return None if value is None else Measured(value)


def contact_laws(
    settings: Settings, pairs: tuple[Pair, Pair], mean_mass: float, where: str
) -> tuple[LinearLaw, LinearLaw]:
    """Particle-particle and particle-wall laws: the materials file, then what the case changes."""
    law = settings.law
    friction = law.mu_particle, law.mu_wall
    gammas = _gamma_overrides(settings, pairs)
    laws = []
    for pair, mu, gamma, mass in zip(
        pairs, friction, gammas, (mean_mass / 2, mean_mass), strict=True
    ):
        known_kn, known_kt, known_gamma_n, known_gamma_t = constants(pair)
        kn = law.kn or known_kn
        stiffer = kn / known_kn if law.keep_ratios else 1.0
        kt = law.kt or known_kt * stiffer
        if kt <= 0:
            raise InputError(f"{where}: kt = {kt:g} N/m: must be above 0; for no friction, set mu")
        gamma_n = known_gamma_n * math.sqrt(stiffer) if gamma is None else gamma
        if law.damping == "restitution":
            gamma_n = _gamma_from_restitution(settings, pair, kn, mass, where)
        gamma_t = known_gamma_t if law.gamma_t is None else law.gamma_t
        mu = pair.friction.value if mu is None else mu
        laws.append(LinearLaw(kn, kt, mu, gamma_n, gamma_t, law.contact_end == "overlap"))
    return laws[0], laws[1]


def constants(pair: Pair) -> tuple[float, float, float, float]:
    """kn, kt [N/m], gamma_n, gamma_t [1/s] of a whole pair."""
    assert pair.linear is not None  # see whole_pairs
    return pair.linear.numbers


def _gamma_overrides(
    settings: Settings, pairs: tuple[Pair, Pair]
) -> tuple[float | None, float | None]:
    """gamma_n of the case for both pairs; the wall's scales with the particles' unless given."""
    particle, wall = settings.law.gamma_n, settings.law.gamma_n_wall
    first, second = (constants(pair)[2] for pair in pairs)
    if particle is not None and wall is None and first > 0:
        wall = particle * second / first
    return particle, wall


def _gamma_from_restitution(
    settings: Settings, pair: Pair, kn: float, mass: float, where: str
) -> float:
    """The damping that gives one contact of two particles of mean mass the pair's restitution."""
    if settings.law.gamma_n is not None or settings.law.gamma_n_wall is not None:
        raise InputError(
            f"{where}: [law] gamma_n goes with damping = 'published'; with 'restitution' it "
            "follows from the materials file: leave one of them out"
        )
    assert pair.restitution is not None  # needed_keys has it
    return damping_for_restitution(pair.restitution.value, kn, mass, end=settings.law.contact_end)


def time_step_of(
    wanted: float | None,
    shapes: ShapeSet,
    surface_density: float,
    laws: tuple[LinearLaw, LinearLaw],
    shipped: bool,
    drawn: bool,
    where: str,
) -> tuple[float, str]:
    """The time step [s] and the reason for it; InputError for one beyond the stable one.

    laws: the stiffest that a pair of particles, and a particle and a wall, can have; shipped:
    whether the shapes are; drawn: whether other pairs have softer laws.
    """
    limit, configuration = largest_stable_step(shapes, surface_density, *laws)
    configuration += ", the stiffest pair that can be drawn" if drawn else ""
    held = step_for_held_particles(shapes, surface_density, laws[0])
    bound = (
        f"stable up to {limit * 1e6:.3g} us ({configuration}); {held * 1e6:.3g} us would cover a "
        "particle held on all faces"
    )
    if wanted is not None:
        if wanted > limit:
            raise InputError(
                f"{where}: [run] time_step = {wanted * 1e6:g} us: not stable; at most "
                f"{limit * 1e6:.3g} us ({configuration}); leave it out and one is chosen"
            )
        return wanted, f"as given; {bound}"
    reduced_mass = 0.5 * surface_density * shapes.mean_area
    margin = margin_of(laws[0], reduced_mass, shipped)
    chosen = chosen_step(1.0, limit, margin)
    usual = chosen == USUAL_TIME_STEP
    reason = "the usual one" if usual else f"{margin.part:g} of the largest stable"
    return chosen, f"{reason}; {bound}"
