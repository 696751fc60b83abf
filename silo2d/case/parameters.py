"""Shapes, contact laws and time steps of a case: the files it names, then what it changes."""

import math
from functools import lru_cache
from pathlib import Path

from granulab.contact.files.table import ContactTable, load_table
from granulab.contact.laws import LinearLaw
from granulab.contact.material import Pair
from granulab.contact.restitution import damping_for_restitution
from granulab.errors import InputError
from silo2d.case.settings import Settings
from silo2d.case.shape import ShapeSet, load_shapes
from silo2d.case.stability import largest_stable_step, step_for_held_particles

USUAL_TIME_STEP = 5e-6  # [s] discharge times do not change between 2 and 10 us
# Filling takes a quarter of the stiffness, and so twice the step, of the materials file.
POUR_SOFTER = 4.0
_MARGIN = 0.8  # of the largest stable step, where the usual one is too long


def shapes_of(file: str | Path) -> ShapeSet:
    """See load_shapes; the same object for the same text."""
    return _shapes(file, _content(file))


def table_of(file: str | Path) -> ContactTable:
    """See load_table; the same object for the same text."""
    return _table(file, _content(file))


@lru_cache(maxsize=8)
def _shapes(file: str | Path, _content: bytes) -> ShapeSet:
    return load_shapes(file)


@lru_cache(maxsize=8)
def _table(file: str | Path, _content: bytes) -> ContactTable:
    return load_table(file)


def _content(file: str | Path) -> bytes:
    try:
        return Path(file).read_bytes()
    except OSError:
        return b""  # the reader says what is wrong


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
        if pair.linear is None:
            raise InputError(
                f"{settings.particles.materials}: [pair.{pair.first}-{pair.second}.linear] is "
                "missing; give kn, kt, gamma_n and gamma_t"
            )
        known = pair.linear
        kn = law.kn or known.kn.value
        stiffer = kn / known.kn.value if law.keep_ratios else 1.0
        kt = law.kt or known.kt.value * stiffer
        if kt <= 0:
            raise InputError(f"{where}: kt = {kt:g} N/m: must be above 0; for no friction, set mu")
        gamma_n = known.gamma_n.value * math.sqrt(stiffer) if gamma is None else gamma
        if law.damping == "restitution":
            gamma_n = _gamma_from_restitution(settings, pair, kn, mass, where)
        gamma_t = known.gamma_t.value if law.gamma_t is None else law.gamma_t
        mu = pair.friction.value if mu is None else mu
        laws.append(LinearLaw(kn, kt, mu, gamma_n, gamma_t, law.contact_end == "overlap"))
    return laws[0], laws[1]


def filling_laws(
    pairs: tuple[Pair, Pair], friction: tuple[float, float]
) -> tuple[LinearLaw, LinearLaw]:
    """Laws of the filling: soft, to be quick, and with a friction of its own.

    The rest comes from the materials file alone: what a case changes acts after the opening, and
    cases that differ in it share a packing.
    """
    laws = []
    for pair, mu in zip(pairs, friction, strict=True):
        assert pair.linear is not None  # contact_laws has refused that
        kn, kt = pair.linear.kn.value / POUR_SOFTER, pair.linear.kt.value / POUR_SOFTER
        gamma_n = pair.linear.gamma_n.value / math.sqrt(POUR_SOFTER)
        laws.append(LinearLaw(kn, kt, mu, gamma_n, pair.linear.gamma_t.value, True))
    return laws[0], laws[1]


def filling_friction(
    settings: Settings, laws: tuple[LinearLaw, LinearLaw], where: str
) -> tuple[float, float]:
    """Friction of the filling, between particles and at walls: none, the laws' or a given one."""
    fill = settings.fill
    if fill.pour_with == "pymunk" and (fill.friction or fill.layer is not None):
        key = "friction" if fill.friction else "layer"
        raise InputError(
            f"{where}: [fill] {key} goes with pour_with = 'dem'; pymunk pours all at once and "
            "without friction"
        )
    if fill.friction is True:
        return laws[0].mu, laws[1].mu
    return float(fill.friction), float(fill.friction)


def _gamma_overrides(
    settings: Settings, pairs: tuple[Pair, Pair]
) -> tuple[float | None, float | None]:
    """gamma_n of the case for both pairs; the wall's scales with the particles' unless given."""
    particle, wall = settings.law.gamma_n, settings.law.gamma_n_wall
    first, second = pairs[0].linear, pairs[1].linear
    if particle is not None and wall is None and first and second and first.gamma_n.value > 0:
        wall = particle * second.gamma_n.value / first.gamma_n.value
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
    if pair.restitution is None:
        raise InputError(
            f"{settings.particles.materials}: [pair.{pair.first}-{pair.second}] restitution is "
            "missing; damping = 'restitution' needs it"
        )
    return damping_for_restitution(pair.restitution.value, kn, mass, end=settings.law.contact_end)


def time_step_of(
    wanted: float | None,
    shapes: ShapeSet,
    surface_density: float,
    laws: tuple[LinearLaw, LinearLaw],
    drawn: bool,
    where: str,
) -> tuple[float, str]:
    """The time step [s] and the reason for it; InputError for one beyond the stable one.

    laws: the stiffest that a pair of particles, and a particle and a wall, can have; drawn: whether
    others have softer ones.
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
    chosen = _chosen_step(USUAL_TIME_STEP, limit)
    reason = "the usual one" if chosen == USUAL_TIME_STEP else f"{_MARGIN:g} of the largest stable"
    return chosen, f"{reason}; {bound}"


def filling_time_step(
    shapes: ShapeSet, surface_density: float, laws: tuple[LinearLaw, LinearLaw]
) -> float:
    """The time step [s] of the filling."""
    limit, _ = largest_stable_step(shapes, surface_density, *laws)
    return _chosen_step(math.sqrt(POUR_SOFTER) * USUAL_TIME_STEP, limit)


def _chosen_step(usual: float, limit: float) -> float:
    """The usual time step [s], or a part of the limit rounded down to two digits."""
    if limit >= usual:
        return usual
    exponent = math.floor(math.log10(_MARGIN * limit)) - 1
    return math.floor(_MARGIN * limit / 10**exponent) * 10.0**exponent
