"""Stored solids after EN 1991-4:2006: mean properties, and the values that a load case takes.

A property x has a mean x_m and a conversion factor a_x >= 1; its upper characteristic value is
a_x x_m, its lower one x_m/a_x (4.2, 4.3). Which of them is unfavourable differs from load case to
load case (table 3.1). The friction at a wall is never more than inside the solid, mu <= tan phi_i.
"""

import math
from dataclasses import dataclass, fields
from functools import cache
from typing import NamedTuple

from granulab.contact.files.datafile import shipped_rows
from granulab.contact.files.units import nearest
from granulab.errors import InputError

# Table 3.1: which values of wall friction, lateral pressure ratio and internal friction a load case
# takes. 1: upper, -1: lower.
LOAD_CASES = {
    "wall_pressure": (-1, 1, -1),  # largest normal pressure on the vertical wall
    "wall_friction": (1, 1, -1),  # largest frictional traction on it
    "bottom": (-1, -1, 1),  # largest vertical load on hopper or bottom
    "hopper_filling": (-1, -1, -1),
    "hopper_discharge": (-1, 1, 1),
}
WALL_TYPES = ("D1", "D2", "D3")  # slippery, smooth and rough walls (table 4.1)


@dataclass(frozen=True)
class Solid:
    """Properties of a stored solid, mean values but for the unit weights.

    unit_weight          upper characteristic unit weight gamma_u [N/m3]
    unit_weight_lower    lower one gamma_l [N/m3], with which an arch or a rathole stands wider
    repose               angle of repose phi_r [rad]
    internal_friction    phi_im [rad], with its factor a_phi
    lateral_ratio        K_m [-], with a_K
    wall_friction        mu_m [-] at the vertical wall, with a_mu; hopper_friction: at the hopper
    patch                reference factor of patch loads C_op [-]
    effective_friction   Jenike's effective angle of internal friction delta [rad]
    """

    name: str
    unit_weight: float
    unit_weight_lower: float
    repose: float
    internal_friction: float
    internal_friction_factor: float
    lateral_ratio: float
    lateral_ratio_factor: float
    wall_friction: float
    wall_friction_factor: float
    hopper_friction: float
    patch: float
    effective_friction: float


class Values(NamedTuple):
    """Characteristic values that a load case takes of a solid."""

    wall_friction: float  # mu [-], at most tan phi_i
    lateral_ratio: float  # K [-]
    internal_friction: float  # phi_i [rad]


def characteristic(solid: Solid, load_case: str, means: bool = False) -> Values:
    """The values of table 3.1 for a load case; means: those of assessment class 1 (2.5, 4.2)."""
    ends = (0, 0, 0) if means else LOAD_CASES[load_case]
    if "hopper" in load_case:
        return at_hopper(solid, ends)
    return _values(solid, solid.wall_friction, ends)


def at_hopper(solid: Solid, ends: tuple[int, int, int]) -> Values:
    """Values with the friction at the hopper; ends: as LOAD_CASES has them, 0 for the mean."""
    return _values(solid, solid.hopper_friction, ends)


def _values(solid: Solid, friction: float, ends: tuple[int, int, int]) -> Values:
    mu, ratio, phi = ends
    internal = solid.internal_friction * solid.internal_friction_factor**phi
    return Values(
        min(friction * solid.wall_friction_factor**mu, math.tan(internal)),
        solid.lateral_ratio * solid.lateral_ratio_factor**ratio,
        internal,
    )


def lateral_ratio_of(internal_friction: float) -> float:
    """K_m = 1.1 (1 - sin phi_im) (EN 1991-4:2006, eq. 4.7)."""
    return 1.1 * (1.0 - math.sin(internal_friction))


class Row(NamedTuple):
    """A line of table E.1."""

    unit_weight: float  # upper [N/m3]
    unit_weight_lower: float  # [N/m3]
    repose: float  # [rad]
    internal_friction: float  # [rad]
    internal_friction_factor: float
    lateral_ratio: float
    lateral_ratio_factor: float
    wall_friction: tuple[float, float, float]  # on walls D1, D2, D3
    wall_friction_factor: float
    patch: float


@cache
def table_e1() -> dict[str, Row]:
    """The solids of EN 1991-4:2006, table E.1, by name."""
    rows = shipped_rows("published", "en1991_4_solids")
    return {str(row.pop("solid")): _row({k: float(v) for k, v in row.items()}) for row in rows}


def _row(line: dict[str, float]) -> Row:
    return Row(
        1e3 * line["gamma_u_kN_m3"],
        1e3 * line["gamma_l_kN_m3"],
        math.radians(line["phi_r_deg"]),
        math.radians(line["phi_im_deg"]),
        line["a_phi"],
        line["K_m"],
        line["a_K"],
        (line["mu_m_D1"], line["mu_m_D2"], line["mu_m_D3"]),
        line["a_mu"],
        line["C_op"],
    )


def find_row(name: str) -> Row:
    """A line of table E.1; InputError with the names there are."""
    if name not in table_e1():
        raise InputError(f"name = {name!r}: not in table E.1; {nearest(name, table_e1())}")
    return table_e1()[name]


def as_numbers(solid: Solid) -> dict[str, float | str]:
    """A solid for JSON, units in the keys."""
    units = dict.fromkeys(("unit_weight", "unit_weight_lower"), "n_per_m3") | dict.fromkeys(
        ("repose", "internal_friction", "effective_friction"), "rad"
    )
    named = {one.name: getattr(solid, one.name) for one in fields(solid)}
    return {f"{k}_{units[k]}" if k in units else k: value for k, value in named.items()}
