"""From two materials to the contact law of their spheres; speeds of yielding and of waves."""

import math
from typing import Literal

from granulab.contact.hertz import HertzLaw
from granulab.contact.material import Material
from granulab.contact.reduced import reduced_modulus, reduced_shear_modulus
from granulab.contact.restitution import ContactEnd, ratio_of_restitution
from granulab.errors import InputError

History = Literal["displacement", "force"]


def sphere_law(
    first: Material,
    second: Material | None,
    *,
    friction: float,
    restitution: float,
    end: ContactEnd = "overlap",
    tangential: History = "displacement",
    tangential_damping: bool = True,
    yielding: bool = False,
) -> HertzLaw:
    """The law between spheres (or a sphere and a wall) of two materials; None: a rigid body.

    friction and restitution are pure numbers, restitution in (0, 1]. The dashpots are those of
    eqs 5.32 and 5.33, with which a contact that ends at zero overlap has exactly that restitution;
    one that ends at zero force has a little more (contact.hertz_restitution says how much, and
    which number to give instead). tangential is what the spring carries on while the overlap
    changes; tangential_damping False leaves the tangential dashpot out. yielding lets
    the restitution fall above the yield velocity (see granulab.contact.hertz.damping_of_impact).

    Raises InputError, one line, where a material lacks its modulus or Poisson's ratio.
    """
    b = damping_ratio(restitution)
    constants = (*elastic(first), *elastic(second))
    hertz = 4.0 / 3.0 * reduced_modulus(*constants)
    ratio = 8.0 * reduced_shear_modulus(*constants) / hertz
    return HertzLaw(
        hertz=hertz,
        tangential=ratio,
        mu=friction,
        damping=b,
        tangential_damping=math.sqrt(10.0 / 3.0 * ratio) if tangential_damping else 0.0,
        yielding=_yield_constant(first, second) if yielding else math.inf,
        pulls=end == "overlap",
        stored_force=tangential == "force",
    )


def damping_ratio(restitution: float) -> float:
    """Eq. 5.29: b = -ln e / sqrt(ln^2 e + pi^2) [-]: 0 for e = 1, towards 1 as e falls to 0.

    Raises InputError outside (0, 1].
    """
    if not 0.0 < restitution <= 1.0:
        raise InputError(f"restitution = {restitution:g}: must be above 0 and at most 1")
    return ratio_of_restitution(restitution)


def yield_velocity(
    first: Material, second: Material | None, *, radius: float, mass: float
) -> float:
    """Eq. 5.26: the impact speed [m/s] at which the softer of two materials begins to yield.

    radius and mass are the reduced ones [m, kg]. None stands for a rigid body. Raises InputError
    where a material lacks its modulus or Poisson's ratio, or where neither has a yield strength.
    """
    return _yield_constant(first, second) * math.sqrt(radius**3 / mass)


def wave_speed(material: Material) -> float:
    """Eq. 5.12: speed of dilatational waves, sqrt(E (1 - nu)/(rho (1 + nu)(1 - 2 nu))) [m/s].

    Raises InputError where the material lacks its modulus or Poisson's ratio.
    """
    modulus, nu = elastic(material)
    return math.sqrt(
        modulus * (1.0 - nu) / (material.density.value * (1.0 + nu) * (1.0 - 2.0 * nu))
    )


def hertz_validity(waves: float, speed: float) -> float:
    """Eq. 5.11: (c/v)^(1/5) [-] of a wave speed and an impact speed > 0 [m/s].

    Hertz's static law describes an impact where this is much greater than 1: the contact lasts so
    long that waves cross the bodies many times. The thesis names no bound.
    """
    return (waves / speed) ** 0.2


def _yield_constant(first: Material, second: Material | None) -> float:
    """v_y sqrt(m / R^3) of eq. 5.26 [kg^0.5 / (m^0.5 s)]."""
    modulus = reduced_modulus(*elastic(first), *elastic(second))
    known = [m for m in (first, second) if m is not None and m.yield_strength is not None]
    if not known:
        raise InputError(_missing(first, "yield_strength", "125 MPa"))
    strength = min(m.yield_strength.value for m in known if m.yield_strength is not None)
    return math.sqrt(107.0 * strength**5 / modulus**4)


def elastic(material: Material | None) -> tuple[float, float]:
    """Young's modulus [Pa] and Poisson's ratio of a material; None: a rigid body.

    Raises InputError, one line, where it lacks one.
    """
    if material is None:
        return math.inf, 0.0
    if material.youngs_modulus is None:
        raise InputError(_missing(material, "youngs_modulus", "3.3 GPa"))
    if material.poisson is None:
        raise InputError(_missing(material, "poisson", "0.37"))
    return material.youngs_modulus.value, material.poisson.value


def _missing(material: Material, key: str, example: str) -> str:
    value = example if key == "poisson" else f'"{example}"'
    return f"material {material.name!r} has no {key}; give one, such as {key} = {value}"
