"""Flow in hoppers after Jenike: mass or funnel flow, and outlets that do not arch or rathole.

Half angles are from the vertical, delta is the effective angle of internal friction, phi_w that of
the wall.

Limit of mass flow. Cones: the end of the radial stress field (Jenike 1961, 1964),

    theta = 90 deg - acos((1 - sin delta)/(2 sin delta))/2 - beta
    beta  = (phi_w + asin(sin phi_w/sin delta))/2

Wedges: Jenike's chart for plane flow (Utah Engineering Experiment Station, Bulletin 123, 1964), as
ter Borg (1986) fits it, within 2 deg of Arnold, McLean and Roberts's fit (1982); angles in degrees:

    theta = (60.5 + atan((50 - delta)/7.73)/15.07)(1 - phi_w/(42.3 + 0.131 exp(0.06 delta)))

for phi_w <= delta - 3 and theta <= 60. The chart's line for plane flow is not a sharp one; three
degrees are kept from it, as Jenike advises for cones.

Stress in the flow. Enstad (1975), Chem. Eng. Sci. 30, 1273, on arcs between the walls (m = 0 in the
plane, 1 in a cone), near the outlet at a distance r from the apex: mean stress gamma r Y/(X - 1),

    X = 2^m sin delta/(1 - sin delta) (sin(2 beta + theta)/sin theta + 1)
    Y = ((2 (1 - cos(beta + theta)))^m (beta + theta)^(1-m) sin theta
         + sin beta sin^(1+m)(beta + theta))/((1 - sin delta) sin^(2+m)(beta + theta))

which is within some per cent of Jenike's radial field (Arnold and McLean 1976, Powder Technol. 13,
255). Flow factor: major stress over the stress in a stable arch, sigma_1/(gamma B/H),

    ff = H (1 + sin delta) Y/(2 (X - 1) sin theta),    H = (2 + theta/65)^m (1 + theta/200)^(1-m)

Outlet. An arch stands where the strength f_c(sigma_1) exceeds sigma_1/ff: B = H f_c/gamma at their
crossing. A rathole stands up to D = G f_c/gamma, G = 4.3 tan phi_t (fit to Jenike's curve), with
the strength after the largest vertical pressure; gamma is the lower characteristic unit weight, by
which both are widest. A solid without cohesion has f_c = 0 and neither.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

MARGIN = math.radians(3)  # kept from the limit of mass flow
_STEEPEST_FIT = math.radians(60)  # to which ter Borg's fit reaches


def mass_flow_limit(delta: float, wall: float, plane: bool) -> float:
    """Largest half angle [rad] at which a hopper flows in mass; 0 where none does.

    wall: angle of wall friction [rad]; beyond delta - 3 deg a wall counts as rough, and the solid
    slides on itself rather than along it.
    """
    if plane:
        d, w = math.degrees(delta), math.degrees(min(wall, max(delta - MARGIN, 0.0)))
        first = 60.5 + math.degrees(math.atan((50.0 - d) / 7.73)) / 15.07
        limit = math.radians(first * (1.0 - w / (42.3 + 0.131 * math.exp(0.06 * d))))
        return max(min(limit, _STEEPEST_FIT), 0.0)
    ratio = (1.0 - math.sin(delta)) / (2.0 * math.sin(delta))
    limit = math.pi / 2 - 0.5 * math.acos(min(ratio, 1.0)) - wall_angle(delta, wall)
    return max(limit, 0.0)


def wall_angle(delta: float, wall: float) -> float:
    """beta [rad]: angle between the major stress at a wall and the wall's normal."""
    ratio = min(math.sin(wall) / math.sin(delta), 1.0)
    return 0.5 * (min(wall, delta) + math.asin(ratio))


def flow_pattern(half_angle: float, limit: float) -> str:
    """ "mass flow", "funnel flow", or "at the limit" within three degrees below it."""
    if half_angle <= limit - MARGIN:
        return "mass flow"
    return "funnel flow" if half_angle > limit else "at the limit"


class Converging(NamedTuple):
    """Flow in a converging channel."""

    stress: float  # mean stress over gamma r [-]
    flow_factor: float  # ff [-]
    arch: float  # H(theta) [-]


def converging(delta: float, wall: float, half_angle: float, plane: bool) -> Converging | None:
    """Enstad's stress and the flow factor; None where no such flow is (X <= 1, or theta = 0)."""
    m = 0 if plane else 1
    beta, sine = wall_angle(delta, wall), math.sin(delta)
    both = beta + half_angle
    if not 0 < half_angle < math.pi / 2 or math.sin(both) <= 0:
        return None
    x = 2**m * sine / (1 - sine) * (math.sin(2 * beta + half_angle) / math.sin(half_angle) + 1)
    if x <= 1:
        return None
    first = (2 * (1 - math.cos(both))) ** m * both ** (1 - m) * math.sin(half_angle)
    y = (first + math.sin(beta) * math.sin(both) ** (1 + m)) / (
        (1 - sine) * math.sin(both) ** (2 + m)
    )
    stress, degrees = y / (x - 1), math.degrees(half_angle)
    arch = 1 + degrees / 200 if plane else 2 + degrees / 65
    return Converging(stress, arch * (1 + sine) * stress / (2 * math.sin(half_angle)), arch)


def strength(flow_function: Sequence[Sequence[float]], stress: float) -> float:
    """Unconfined yield strength f_c [Pa] after a major stress [Pa], straight between points.

    flow_function: points (stress, strength) [Pa], ascending; beyond them the nearest straight.
    """
    if not flow_function:
        return 0.0
    points = np.asarray(flow_function, dtype=float)
    if len(points) == 1:
        return float(points[0, 1])
    k = int(np.clip(np.searchsorted(points[:, 0], stress) - 1, 0, len(points) - 2))
    (x0, y0), (x1, y1) = points[k], points[k + 1]
    return float(max(y0 + (y1 - y0) * (stress - x0) / (x1 - x0), 0.0))


def arching_stress(
    flow_function: Sequence[Sequence[float]], flow_factor: float, largest: float
) -> float | None:
    """The strength [Pa] where f_c(s) = s/ff, below which an arch stands; 0 where none does.

    None where the solid is stronger up to the largest stress [Pa]: no outlet is wide enough.
    """
    from scipy.optimize import brentq

    def excess(stress: float) -> float:
        return strength(flow_function, stress) - stress / flow_factor

    if excess(0.0) <= 0:
        return 0.0
    if excess(largest) >= 0:
        return None
    return float(brentq(excess, 0.0, largest)) / flow_factor


def rathole(internal: float, strength_at: float, unit_weight: float) -> float:
    """Diameter [m] up to which a rathole stands: 4.3 tan(phi_t) f_c/gamma."""
    return 4.3 * math.tan(internal) * strength_at / unit_weight
