"""Settings of the impulse engine for a case: friction and restitution of the pairs, steps."""

import math
from dataclasses import dataclass

from granulab.contact.laws import LinearLaw
from granulab.contact.material import Pair
from granulab.errors import InputError
from silo2d.case.settings import Settings
from silo2d.case.shape import ShapeSet

# Overlap that is left alone, over the spheroradius: 0.01 mm for 1 mm, about what the contact law's
# springs give way at the bottom of such a silo (60 N over 1e7 N/m is 0.006 mm).
SLOP = 0.01
# Part of a particle's narrowest width that it may move in a step at the speed of a fall through the
# whole silo: a wall has no thickness, and a particle whose middle has passed it is pushed out
# behind.
_LONGEST_MOVE = 0.5
# What a factor of a product may be at least, so that the other factor can be found.
_TINY = 1e-12


@dataclass(frozen=True)
class Impulses:
    """Settings of the impulse engine, validated; pairs are particle-particle and particle-wall."""

    iterations: int  # over all contacts, a step
    time_step: float  # [s]
    friction: tuple[float, float]  # [-]
    restitution: tuple[float, float]  # [-]
    slop: float  # overlap that is left alone [m]


def impulses_of(
    settings: Settings,
    pairs: tuple[Pair, Pair],
    laws: tuple[LinearLaw, LinearLaw],
    shapes: ShapeSet,
    fall: float,
    where: str,
) -> Impulses | None:
    """Settings for pymunk; None where the case is not for pymunk.

    fall is the speed [m/s] after a fall through the whole silo. Friction is the case's;
    restitution is what was measured of the pairs, or none. Raises InputError for a time step in
    which a particle could pass a wall, where no restitution was measured, and for what only the
    contact law can do.
    """
    if settings.run.engine != "pymunk":
        return None
    for what, wanted in (
        ("[disorder] per", settings.disorder.per != "none"),
        ("[run] door_speed", settings.run.door_speed is not None),
        ("[fill] friction", bool(settings.fill.friction)),
    ):
        if wanted:
            raise InputError(f"{where}: {what} goes with engine = 'dem'; leave one of them out")
    given = settings.pymunk
    longest = _LONGEST_MOVE * min(shape.width for shape in shapes.shapes) / fall
    if given.time_step > longest:
        raise InputError(
            f"{where}: [pymunk] time_step = {given.time_step * 1e3:g} ms: a particle that falls at "
            f"{fall:.2g} m/s could pass a wall; at most {longest * 1e3:.2g} ms"
        )
    return Impulses(
        given.iterations,
        given.time_step,
        (laws[0].mu, laws[1].mu),
        _restitution(settings, pairs),
        SLOP * min(shape.spheroradius for shape in shapes.shapes),
    )


def _restitution(settings: Settings, pairs: tuple[Pair, Pair]) -> tuple[float, float]:
    if settings.pymunk.restitution == "none":
        return 0.0, 0.0
    values = []
    for pair in pairs:
        if pair.restitution is None:
            raise InputError(
                f"{settings.particles.materials}: [pair.{pair.first}-{pair.second}] restitution is "
                "missing; give it, or [pymunk] restitution = 'none'"
            )
        values.append(pair.restitution.value)
    return values[0], values[1]


def factors(particle_particle: float, particle_wall: float) -> tuple[float, float]:
    """Values of a particle and of a wall whose products are those of the two pairs.

    pymunk multiplies what two shapes have: sqrt(mu_gg) sqrt(mu_gg) and sqrt(mu_gg) (mu_gw/
    sqrt(mu_gg)). Two particles of no friction against a wall with some have 1e-12 instead.
    """
    particle = math.sqrt(max(particle_particle, _TINY))
    return particle, particle_wall / particle
