"""Loads on bottoms and hoppers after EN 1991-4:2006, section 6.

Mean vertical stress in a hopper at a height x over its apex (6.1.2), under p_vft at the transition:

    p_v(x) = gamma h_h/(n - 1) (x/h_h - (x/h_h)^n) + p_vft (x/h_h)^n
    n      = F (m + S mu_eff cot beta) - m,    p_n = F p_v,   p_t = mu_eff p_n

    filling               F_f = 1 - b/(1 + tan beta/mu_eff),  b = 0.2
    discharge, steep      F_e = (1 + sin phi_i cos eps)/(1 - sin phi_i cos(2 beta + eps)),
                          eps = phi_wh + asin(sin phi_wh/sin phi_i)                       (6.3)
    shallow               mu_eff = (1 - K)/(2 tan beta); on discharge as on filling       (6.4)

A hopper is steep, once for all its loads, where tan beta < (1 - K)/(2 mu_h) with the lower values
of K and mu_h (6.1.1), those of the load case of filling. beta is the half angle from the vertical.

n is what the balance of a slice gives, x dp_v/dx = n p_v - gamma x. A hopper converges in m = 2
directions, a wedge in one. A pyramid over a rectangle b x a, beta that of the walls b apart, lifts
a slice of area A = a b (x/h_h)^2 by the pressure on its walls, 2 F p_v A/x, and by friction along
2 (a + b) x/h_h, so that S = 1 + b/a; F and mu_eff are those of beta on all four walls. S is 2 of
cones and square pyramids, 1 of wedges, the standard's own; of cones, n is its S (F mu_eff cot beta
+ F) - 2, on filling 2 (1 - b) mu_eff cot beta.
"""

import math
from typing import NamedTuple

import numpy as np

from silo2d.loads.janssen import Floats
from silo2d.loads.solid import Values
from silo2d.loads.vessel import HOPPERS, SLENDER, Vessel
from silo2d.loads.walls import Wall

_B = 0.2  # of a hopper that closes without a kink, by experiments (6.3.2)


def bottom_magnifier(assessment_class: int, dynamic: bool) -> float:
    """C_b (6.1.2): 1.0, of class 1 1.3; where the solid may load dynamically 1.2 and 1.6."""
    if assessment_class == 1:
        return 1.6 if dynamic else 1.3
    return 1.2 if dynamic else 1.0


def flat_bottom(wall: Wall, magnifier: float, pile: float) -> float:
    """Vertical pressure on a flat bottom [Pa]: C_b p_v(h_c), and more under a squat heap (6.2).

    wall: loads by the values of the load case "bottom"; pile: h_tp [m]. In silos of intermediate
    slenderness and squat ones gamma (h_tp - h_o) times (2 - h_c/d_c)/(2 - h_tp/d_c) is added.
    """
    vessel = wall.vessel
    uniform = magnifier * float(wall.vertical(np.array(vessel.height)))
    if vessel.slenderness >= SLENDER:
        return uniform
    share = (SLENDER - vessel.slenderness) / (SLENDER - pile / vessel.characteristic_width)
    return uniform + wall.unit_weight * (pile - wall.highest) * share


class Hopper(NamedTuple):
    """Pressures in a hopper, from the outlet up."""

    height: Floats  # x over the apex [m]
    vertical: Floats  # p_v [Pa]
    normal: Floats  # p_n [Pa]
    friction: Floats  # p_t [Pa]
    factor: float  # F [-], the hopper pressure ratio
    exponent: float  # n
    effective_friction: float  # mu_eff [-]


def steep_up_to(values: Values) -> float:
    """Half angle [rad] below which a hopper is steep: tan beta = (1 - K)/(2 mu_h) (6.1.1)."""
    return math.atan2(1 - values.lateral_ratio, 2 * values.wall_friction)


def _exponent(vessel: Vessel, factor: float, mu: float) -> float:
    """n = F (m + S mu cot beta) - m [-]."""
    assert vessel.half_angle is not None
    directions = HOPPERS[vessel.hopper]
    rubbing = vessel.friction_shape * mu / math.tan(vessel.half_angle)
    return factor * (directions + rubbing) - directions


def _pressures(
    vessel: Vessel, unit_weight: float, top: float, mu: float, factor: float, n: float, points: int
) -> Hopper:
    """The stresses of 6.1.2; top: p_vft [Pa]; the limit of n = 1 is x/h_h ln(h_h/x)."""
    high = vessel.hopper_height
    part = np.linspace(max(vessel.outlet / vessel.width, 1e-3), 1.0, points)
    if abs(n - 1.0) < 1e-9:
        own = -part * np.log(part)
    else:
        own = (part - part**n) / (n - 1.0)
    vertical = unit_weight * high * own + top * part**n
    normal = factor * vertical
    return Hopper(part * high, vertical, normal, mu * normal, factor, n, mu)


def effective_friction(half_angle: float, values: Values) -> float:
    """mu_h of a steep hopper, mobilised (1 - K)/(2 tan beta) of a shallow one (6.3, 6.4).

    values: of the load case "hopper_filling", the lower ones, which decide what the hopper is.
    """
    if half_angle < steep_up_to(values):
        return values.wall_friction
    return (1.0 - values.lateral_ratio) / (2.0 * math.tan(half_angle))


def hopper_filling(
    vessel: Vessel, unit_weight: float, top: float, values: Values, points: int = 33
) -> Hopper:
    """Pressures in a hopper on filling (6.3.2, 6.4.2); top: p_vft [Pa]."""
    assert vessel.half_angle is not None
    slope, mu = math.tan(vessel.half_angle), effective_friction(vessel.half_angle, values)
    factor = 1.0 - _B / (1.0 + slope / mu) if mu else 1.0
    n = _exponent(vessel, factor, mu)
    return _pressures(vessel, unit_weight, top, mu, factor, n, points)


def hopper_discharge(
    vessel: Vessel, unit_weight: float, top: float, values: Values, points: int = 33
) -> Hopper:
    """Pressures in a steep hopper on discharge (6.3.3); a shallow one keeps those of filling."""
    beta = vessel.half_angle
    assert beta is not None
    mu, sine = values.wall_friction, math.sin(values.internal_friction)
    wall = math.atan(mu)
    angle = wall + math.asin(min(math.sin(wall) / sine, 1.0))
    factor = (1.0 + sine * math.cos(angle)) / (1.0 - sine * math.cos(2.0 * beta + angle))
    n = _exponent(vessel, factor, mu)
    return _pressures(vessel, unit_weight, top, mu, factor, n, points)
