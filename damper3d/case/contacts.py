"""Contacts of a bed: parameters of each pair of materials, and whether their restitution falls."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from damper3d.case.settings import Law
from damper3d.engine.laws.cohesion import Dmt, Jkr
from granulab.contact.files.table import ContactTable
from granulab.contact.files.units import located
from granulab.contact.hertz import HertzLaw
from granulab.contact.material import Material, Pair
from granulab.contact.restitution import restitution_of_ratio
from granulab.contact.sphere_law import sphere_law, wave_speed, yield_velocity
from granulab.errors import InputError

COHESIONS = {"dmt": Dmt(), "jkr": Jkr(), None: None}
# The restitution falls by itself where the yield velocity is below this part of the largest
# relative velocity: impacts at half of it are as fast as the enclosure, and common.
_COMMON = 0.5


class Ball(NamedTuple):
    """A kind of sphere as a contact sees it."""

    material: Material
    radius: float  # [m] of its smallest sphere, where it is a multi-sphere particle
    mass: float  # [kg] of the whole particle


@dataclass(frozen=True)
class Pairing:
    """Contacts of two kinds of sphere, or of one with the enclosure; SI."""

    materials: tuple[str, str]
    of_wall: bool
    law: HertzLaw
    restitution: float  # below the yield velocity [-]
    origin: str  # of the restitution
    yield_velocity: float | None  # eq. 5.26 [m/s]; None: not known
    falls: bool  # whether the restitution falls above it
    reason: str  # why it does or does not, in words
    radius: float  # reduced [m]
    mass: float  # reduced [kg]
    wave_speed: float  # of the slower of the two materials, eq. 5.12 [m/s]


def pairing_of(
    table: ContactTable, law: Law, first: Ball, second: Ball | Material, fastest: float
) -> Pairing:
    """The contacts of a kind with another, or with an enclosure of a material.

    fastest: largest relative velocity of the case, 2 Gamma g/omega [m/s]. Raises InputError, one
    line, where a material or pair lacks something.
    """
    of_wall = isinstance(second, Material)
    other = second if isinstance(second, Material) else second.material
    if isinstance(second, Material):
        radius, mass = first.radius, first.mass
    else:
        radius = _reduced(first.radius, second.radius)
        mass = _reduced(first.mass, second.mass)
    names = first.material.name, other.name
    wants = law.friction is None or law.restitution is None
    pair = table.pair(*names) if wants else table.pairs.get(names) or table.pairs.get(names[::-1])
    with located(f"{table.path}:"):
        limit = _yield_velocity(first.material, other, radius, mass)
        falls, reason = _rule(law, pair, limit, fastest)
        restitution, origin = _restitution(law, pair, first.material, other, of_wall=of_wall)
        made = sphere_law(
            first.material,
            other,
            friction=_friction(law, pair, of_wall),
            restitution=restitution,
            end=law.contact_end,
            tangential=law.tangential,
            yielding=falls,
        )
        waves = min(wave_speed(first.material), wave_speed(other))
    return Pairing(
        names, of_wall, made, restitution, origin, limit, falls, reason,
        radius, mass, waves,
    )  # fmt: skip


def _friction(law: Law, pair: Pair | None, of_wall: bool) -> float:
    if of_wall and law.friction_wall is not None:
        return law.friction_wall
    if law.friction is not None:
        return law.friction
    assert pair is not None  # table_of has refused that
    return pair.friction.value


def _reduced(a: float, b: float) -> float:
    """a b/(a + b); exact for two that are alike."""
    return 0.5 * a if a == b else a * b / (a + b)


def _yield_velocity(first: Material, second: Material, radius: float, mass: float) -> float | None:
    if first.yield_strength is None and second.yield_strength is None:
        return None
    return yield_velocity(first, second, radius=radius, mass=mass)


def _rule(law: Law, pair: Pair | None, limit: float | None, fastest: float) -> tuple[bool, str]:
    """True where the restitution falls above the yield velocity; the reason in words."""
    if law.yielding is not None:
        word = "falls" if law.yielding else "constant"
        return law.yielding, f"{word}, as [law] yielding says"
    if pair is not None and pair.restitution_model == "constant":
        return False, "constant, as the materials table says"
    if limit is None:
        return False, "constant, as no yield strength is known"
    if law.contact_treatment == "scaled":
        return False, "constant, as contact_treatment = 'scaled' shares out masses"
    if limit < _COMMON * fastest:
        return True, f"falls, as that is below half of the largest relative velocity {fastest:.3g}"
    return False, f"constant, as that is not below half of the largest relative {fastest:.3g}"


def _restitution(
    law: Law, pair: Pair | None, first: Material, second: Material, *, of_wall: bool
) -> tuple[float, str]:
    """The restitution of a pair and where it is from: the case, the table, or loss factors."""
    if of_wall and law.restitution_wall is not None:
        return law.restitution_wall, "[law] restitution_wall"
    if law.restitution is not None:
        return law.restitution, "[law] restitution"
    if pair is not None and pair.restitution is not None:
        return pair.restitution.value, "materials table"
    loss = pair_loss_factor(first, second)
    assert loss is not None  # table_of has refused that
    return restitution_of_loss(loss), f"loss factor {loss:.3g}"


def pair_loss_factor(first: Material, second: Material) -> float | None:
    """Loss factor of the contact of two materials [-]; None where one is not known.

    Each stores elastic energy in proportion to its compliance (1 - nu^2)/E, of which it loses its
    own part: the mean with these weights (bodies in series under the same force).
    """
    weighted = total = 0.0
    for material in (first, second):
        modulus, poisson = material.youngs_modulus, material.poisson
        if material.loss_factor is None or modulus is None or poisson is None:
            return None
        compliance = (1.0 - poisson.value**2) / modulus.value
        weighted += compliance * material.loss_factor.value
        total += compliance
    return weighted / total


def restitution_of_loss(loss_factor: float) -> float:
    """Restitution [-] of a contact whose damping ratio is half of a loss factor.

    A viscous damper loses as much in a cycle at resonance as a material of the loss factor 2 zeta
    (Nashif, Jones and Henderson, Vibration Damping, 1985, sec. 2.3). Tsuji's dashpot makes of a
    Hertz contact a linear one of the damping ratio b (granulab.contact.restitution): b = zeta, and
    e = exp(-pi zeta/sqrt(1 - zeta^2)), eq. 5.29 of the thesis solved for e.

    Raises InputError at 2 and above, where nothing rebounds.
    """
    if loss_factor >= 2.0:
        raise InputError(
            f"loss_factor = {loss_factor:g}: nothing rebounds from 2 on; give less, or the "
            "restitution of the pair"
        )
    return restitution_of_ratio(0.5 * loss_factor)


def check_law(law: Law, is_sphere: bool, where: str) -> None:
    """Raise InputError where rolling resistance or cohesion do not go with the rest of a law."""
    rolling = law.rolling_friction, law.rolling_stiffness, law.rolling_damping
    wrong = None
    if law.cohesion is not None and law.surface_energy is None:
        wrong = f"cohesion = '{law.cohesion}': surface_energy is missing, such as '0.05 J/m2'"
    elif law.cohesion is None and law.surface_energy is not None:
        wrong = "surface_energy goes with cohesion = 'dmt' or 'jkr'; give it, or leave this out"
    elif law.cohesion is not None and law.contact_end == "force":
        wrong = "cohesion pulls, and contact_end = 'force' lets nothing pull; give 'overlap'"
    elif law.cohesion is not None and law.tangential == "force":
        wrong = (
            "cohesion ends a contact under a force that friction limits, and tangential = 'force' "
            "keeps that in a spring whose stiffness goes to 0, with energy beyond bounds; give "
            "'displacement'"
        )
    elif law.rolling_friction is None and rolling != (None, None, None):
        wrong = "rolling_friction is missing; give it beside rolling_stiffness, such as 0.1"
    elif law.rolling_friction is not None and law.rolling_stiffness is None:
        wrong = "rolling_friction: rolling_stiffness is missing, such as '1e5 N/m'"
    elif not is_sphere and (law.cohesion is not None or law.rolling_friction is not None):
        name = "rolling_friction" if law.cohesion is None else "cohesion"
        wrong = (
            f"{name} is of spheres: particles of several roll and stick by their shape, at each "
            "of their contacts; leave it out, or give spheres"
        )
    if wrong:
        raise InputError(f"{where}: [law] {wrong}")


def check_rolling_step(law: Law, pairings: tuple[Pairing, ...], dt: float, where: str) -> None:
    """Raise InputError where a step is too long for the spring or dashpot that resist rolling.

    A solid sphere on a wall rolls on its spring with w^2 = k R^2/I = 2.5 k/m; two of them against
    each other with 1.25 k/m, which is less of their reduced mass. w dt = 0.5 is a dozen steps a
    period, and leaves room for sixteen contacts at once before leapfrog's limit of 2.
    """
    if law.rolling_friction is None or law.rolling_stiffness is None:
        return
    lightest = min(pairing.mass for pairing in pairings)
    wanted = (0.5 / dt) ** 2 * lightest / 2.5, 0.5 / dt * lightest / 2.5
    if law.rolling_stiffness > wanted[0]:
        raise InputError(
            f"{where}: [law] rolling_stiffness = {law.rolling_stiffness:.6g} N/m: more than steps "
            f"of {dt:.3g} s resolve; give at most {_down(wanted[0])} N/m, or a shorter time_step"
        )
    if law.rolling_damping is not None and law.rolling_damping > wanted[1]:
        raise InputError(
            f"{where}: [law] rolling_damping = {law.rolling_damping:.6g} N s/m: more than steps of "
            f"{dt:.3g} s resolve; give at most {_down(wanted[1])} N s/m, or a shorter time_step"
        )


def _down(value: float) -> str:
    """Two digits, rounded down."""
    scale = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.floor(value / scale) * scale:.2g}"
