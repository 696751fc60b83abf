"""A case of the pack, its rows, and the words that both use."""

from dataclasses import dataclass
from typing import Any, NamedTuple

CLOSED, SIMULATED, MEASURED = "closed form", "simulation", "measurement"

# Quantities of expected.csv: unit and meaning. Angular velocities are about y, positive where a
# body rolls in the direction of x.
QUANTITIES = {
    "deepest overlap": ("m", "largest overlap of the contact"),
    "largest normal force": ("N", "largest normal force of the contact"),
    "contact time": ("s", "from the first touch until the contact ends"),
    "normal velocity": ("m/s", "component along z"),
    "tangential velocity": ("m/s", "component along x"),
    "angular velocity": ("rad/s", "component about y"),
    "height": ("m", "position of the centroid along z"),
    "energy lost": ("J", "kinetic energy of all bodies at the start less that at the end"),
    "overlap below": ("m", "overlap of the body with what it stands on"),
    "force on the floor": ("N", "normal force on the floor"),
    "own angular velocity x": ("rad/s", "angular velocity about the body's own first axis"),
    "own angular velocity y": ("rad/s", "angular velocity about the body's own second axis"),
    "own angular velocity z": ("rad/s", "angular velocity about the body's own third axis"),
    "energy lost a cycle": ("J", "mean energy dissipated in a counted cycle"),
    "efficiency": ("1", "energy lost in a cycle over 4 (A omega)^2 M, thesis eqs 6.8 to 6.10"),
    "efficiency by wall work": ("1", "the same of the work of the walls in a cycle"),
    "area": ("m2", "area of the cross section"),
    "polar moment of area": ("m4", "second moment of the area about its centroid"),
    "volume": ("m3", "volume of the body"),
    "vertical stress": ("Pa", "mean vertical stress at the depth of the variant"),
    "discharge time": ("s", "from the opening to the last particle out"),
    "mean avalanche": ("1", "particles that leave between two clogs"),
}


class Row(NamedTuple):
    """A row of expected.csv; a result agrees where it is within `tolerance` of `value`."""

    variant: str
    quantity: str
    value: float
    tolerance: float
    body: int | str = ""
    time_s: float | str = ""  # "": at the end, or over all of the run
    kind: str = CLOSED
    source: str = ""  # "": that of the case


@dataclass(frozen=True)
class Case:
    """A benchmark: a set-up that another code can rebuild, and what comes out of it."""

    name: str
    title: str
    source: str
    reason: str  # of the tolerances
    setup: dict[str, Any]
    rows: tuple[Row, ...]
    doi: str = ""


CHUNG_OOI = "10.1007/s10035-011-0277-0"
WOOD = "10.1007/s10035-013-0443-7"
THESIS = "F. Terzioglu, Granular dampers, thesis, University of Sheffield, 2023"
MFIX = "R. Garg et al., Documentation of open-source MFIX-DEM software for gas-solids flows, 2012"

HERTZ = (
    "f_n = max(kn d + c_n d', 0 where it ends at force), kn = 4/3 E sqrt(R d), "
    "c_n = sqrt(5) b sqrt(kn m); f_t = -(kt s + c_t s'), kt = 8 G sqrt(R d), "
    "c_t = sqrt(10/3) b sqrt(kt m), |f_t| <= mu max(f_n, 0); "
    "b = -ln e/sqrt(ln^2 e + pi^2), 1/E = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, "
    "1/G = (2 - nu1)/G1 + (2 - nu2)/G2; d overlap, s slip, R and m reduced radius and mass "
    "(thesis, eqs 5.5 to 5.33)"
)
LINEAR = (
    "f_n = k d + m gamma d', f_t = -kt s - m gamma_t s', |kt s| <= mu k d; d overlap, s slip, "
    "m reduced mass, at a wall the body's (wood-silo paper, eqs 2.1 to 2.3)"
)


def hertz(friction: float, restitution: float, ends: str = "overlap") -> dict[str, Any]:
    """The law between spheres; it ends at zero overlap or at zero force."""
    return {
        "kind": "hertz", "equation": HERTZ, "friction": friction, "restitution": restitution,
        "ends_at_zero": ends,
    }  # fmt: skip


def linear(
    stiffness: float, damping: float = 0.0, friction: float = 0.0, ends: str = "overlap",
    tangential_damping: float = 0.0,
) -> dict[str, Any]:  # fmt: skip
    """The linear law of one contact, with equal tangential and normal stiffness."""
    return {
        "kind": "linear", "equation": LINEAR, "friction": friction, "stiffness_n_m": stiffness,
        "tangential_stiffness_n_m": stiffness, "damping_1_s": damping,
        "tangential_damping_1_s": tangential_damping, "ends_at_zero": ends,
    }  # fmt: skip


def wall(name: str, height: float, normal: int, material: str = "") -> dict[str, Any]:
    """A plane across z; its normal (1 up, -1 down) points to the bodies."""
    found = {"name": name, "point_m": [0.0, 0.0, height], "normal": [0, 0, normal]}
    return found | ({"material": material} if material else {})


def sphere(
    radius: float, height: float, velocity: tuple[float, float] = (0.0, 0.0), spin: float = 0.0,
    **more: Any,
) -> dict[str, Any]:  # fmt: skip
    """A sphere over the origin; velocity along x and z [m/s], angular about y [rad/s]."""
    return {
        "shape": "sphere", "radius_m": radius, "position_m": [0.0, 0.0, height],
        "velocity_m_s": [velocity[0], 0.0, velocity[1]],
        "angular_velocity_rad_s": [0.0, spin, 0.0], **more,
    }  # fmt: skip
