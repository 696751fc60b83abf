"""A full-size silo in a TOML file: its geometry, what is stored in it, and the rules that apply."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from granulab.contact.files import casefile, reference
from granulab.contact.files.casefile import (
    Angle,
    Friction,
    Length,
    Number,
    Section,
    Size,
    Unit,
    changed,
    folder_name,
    key,
    read,
)
from granulab.contact.files.units import located
from granulab.errors import InputError
from silo2d.loads.solid import Row, Solid, find_row, lateral_ratio_of
from silo2d.loads.vessel import Vessel

SCHEMA = 1
UnitWeight = Annotated[float, read("N/m3"), Unit("N/m3"), Field(gt=0)]
Factor = Annotated[Number, Field(ge=1, le=5)]
Ratio = Annotated[Number, Field(gt=0, le=2)]
_ROW = "that of [solid] name"
_STEEPEST = math.radians(90)


class Geometry(Section):
    """The silo: a constant cross section over a hopper or a flat bottom."""

    plan: Literal["circular", "rectangular", "slot"] = key(
        "circular", "cross section; slot: a slice between two parallel plates"
    )
    width: Size = key(..., "diameter; or the smaller side; of a slot between its walls",
                      example="5 m")  # fmt: skip
    length: Size | None = key(
        None, "larger side of a rectangle; of a slot the distance of its plates", example="5 m",
        left_out="as the width",
    )  # fmt: skip
    height: Size = key(
        ..., "h_c: of the vertical walls, from the transition to the levelled surface",
        example="15 m",
    )  # fmt: skip
    half_angle: Annotated[Angle, Field(gt=0, lt=_STEEPEST)] | None = key(
        None, "of the hopper, from the vertical", example="20 deg", left_out="a flat bottom"
    )
    hopper: Literal["cone", "pyramid", "wedge"] | None = key(
        None, "shape of the hopper", example="cone",
        left_out="a cone; a pyramid under a rectangle, a wedge under a slot",
    )  # fmt: skip
    outlet: Size | None = key(None, "width of the outlet", example="0.6 m",
                              left_out="a point")  # fmt: skip
    wall: Literal["thin", "thick"] = key(
        "thin", "circular wall: thin (diameter over 200 thicknesses) or thick, as concrete"
    )
    plates: Literal["frictionless", "rough"] = key(
        "frictionless", "plates of a slot: they carry nothing, or rub as the walls do"
    )


class SolidKeys(Section):
    """What is stored; what is given here goes before table E.1."""

    name: str | None = key(
        None, "line of EN 1991-4, table E.1", example="wheat",
        left_out="all properties are given", option="--solid", spelled_out=True,
    )  # fmt: skip
    wall_type: Literal["D1", "D2", "D3"] = key(
        "D2", "wall of table 4.1: D1 slippery, D2 smooth, D3 rough", option="--wall-type"
    )
    unit_weight: UnitWeight | None = key(
        None, "upper characteristic unit weight", example="9 kN/m3", left_out=_ROW,
        option="--unit-weight",
    )  # fmt: skip
    repose: Angle | None = key(
        None, "angle of repose", example="34 deg", left_out=f"{_ROW}, or the internal friction",
        option="--repose",
    )  # fmt: skip
    internal_friction: Angle | None = key(
        None, "mean angle of internal friction", example="30 deg", left_out=_ROW,
        option="--internal-friction",
    )  # fmt: skip
    internal_friction_factor: Factor | None = key(
        None, "its conversion factor a_phi", example=1.12, left_out=f"{_ROW}, or 1"
    )
    lateral_ratio: Ratio | None = key(
        None, "mean lateral pressure ratio K_m", example=0.54,
        left_out=f"{_ROW}, or 1.1 (1 - sin phi_im)", option="--lateral-ratio",
    )  # fmt: skip
    lateral_ratio_factor: Factor | None = key(
        None, "its conversion factor a_K", example=1.11, left_out=f"{_ROW}, or 1"
    )
    wall_friction: Friction | None = key(
        None, "mean friction mu_m at the vertical wall", example=0.38, left_out=_ROW,
        option="--wall-friction",
    )  # fmt: skip
    wall_friction_factor: Factor | None = key(
        None, "its conversion factor a_mu", example=1.16, left_out=f"{_ROW}, or 1"
    )
    hopper_friction: Friction | None = key(
        None, "mean friction at the hopper", example=0.38, left_out="as at the vertical wall"
    )
    patch: Annotated[Number, Field(le=2)] | None = key(
        None, "reference factor of patch loads C_op", example=0.5, left_out=f"{_ROW}, or 1"
    )
    effective_friction: Angle | None = key(
        None, "Jenike's effective angle of internal friction", example="36 deg",
        left_out="the mean internal friction", option="--effective-friction",
    )  # fmt: skip
    flow_function: Annotated[list[list[float]], Field(max_length=100)] = key(
        [], "flow function: points [major consolidation stress, unconfined yield strength] in kPa; "
        "none: without cohesion"
    )  # fmt: skip


class Rules(Section):
    """How the standard is applied."""

    assessment_class: Annotated[int, Field(ge=1, le=3, strict=True)] = key(
        2, "action assessment class: 1 (below 100 t) takes mean properties; 2 and 3 upper and "
        "lower ones", option="--assessment-class", metavar="2",
    )  # fmt: skip
    filling_eccentricity: Annotated[Length, Field(ge=0)] = key(
        0.0, "largest eccentricity of the surface pile while filling", example="0 m"
    )
    outlet_eccentricity: Annotated[Length, Field(ge=0)] = key(
        0.0, "eccentricity of the outlet's middle", example="0 m"
    )
    surface: Literal["heap", "level"] = key(
        "heap", "top of the solid: a heap at the angle of repose, or level"
    )
    emptied: Literal["below", "above"] = key(
        "below", "emptied through the outlet, or from above without flow"
    )
    dynamic_bottom: bool = key(
        False, "whether the solid may load the bottom dynamically, as coarse lumps or crusts"
    )


class Beside(Section):
    """What may stand beside a case, which has its own silo: a solid and rules."""

    name: Annotated[str, AfterValidator(folder_name)] = "silo"
    solid: SolidKeys = SolidKeys()
    rules: Rules = Rules()


class Spec(Section):
    """A whole file, but for its schema number."""

    name: Annotated[str, AfterValidator(folder_name)] = "silo"
    silo: Geometry
    solid: SolidKeys = SolidKeys()
    rules: Rules = Rules()


@dataclass(frozen=True)
class Design:
    """A silo, its solid and its rules, resolved; SI.

    flow_function   points (stress, strength) [Pa]
    assumptions     what was not given, in words
    """

    name: str
    vessel: Vessel
    solid: Solid
    rules: Rules
    flow_function: tuple[tuple[float, float], ...]
    assumptions: tuple[str, ...]


_FILE = casefile.CaseFile(Spec, SCHEMA, "[silo] width and height")
_BESIDE = casefile.CaseFile(Beside, SCHEMA)


def load_design(path: str | Path, changes: Mapping[str, Any] | None = None) -> Design:
    """The silo of a file; InputError, one line, where it cannot be."""
    where = str(path)
    spec = _FILE.check(changed(_FILE.read(Path(path)), dict(changes or {}), Spec), where)
    with located(f"{where}: [silo]"):
        vessel = vessel_of(spec.silo)
    return design_of(spec, vessel, where)


def load_beside(
    path: str | Path | None, changes: Mapping[str, Any], usual: Mapping[str, Any]
) -> Beside:
    """Solid and rules for a case, from a file or none, with changes; usual: below what it says."""
    where = "the options" if path is None else str(path)
    document: dict[str, Any] = {} if path is None else _BESIDE.read(Path(path))
    if "silo" in document:
        raise InputError(f"{where}: [silo]: the case has its own; leave it out, or the case")
    for name, table in changed({}, dict(usual), Beside).items():
        document[name] = table | document.get(name, {})
    return _BESIDE.check(changed(document, dict(changes), Beside), where)


def vessel_of(own: Geometry) -> Vessel:
    """The vessel of the keys of [silo]."""
    length = own.width if own.length is None else own.length
    if own.plan == "rectangular" and length < own.width:
        raise InputError(
            f"width = {own.width:g} m: the smaller side; at most length = {length:g} m"
        )
    usual = {"circular": "cone", "rectangular": "pyramid", "slot": "wedge"}[own.plan]
    return Vessel(
        own.plan, own.width, length, own.height, own.half_angle, own.outlet or 0.0,
        own.hopper or usual, own.wall == "thin", own.plates == "rough",
    )  # fmt: skip


def design_of(
    spec: Spec | Beside, vessel: Vessel, where: str, given: Mapping[str, float] | None = None
) -> Design:
    """A design of a vessel; given: properties that a case has, used where [solid] has none."""
    with located(f"{where}: [solid]"):
        solid, assumed = resolve_solid(spec.solid, given or {})
        points = _flow_function(spec.solid.flow_function)
    widest = vessel.characteristic_width / 2
    for name in ("filling_eccentricity", "outlet_eccentricity"):
        if (value := getattr(spec.rules, name)) > widest:
            raise InputError(
                f"{where}: [rules] {name} = {value:g} m: outside the silo; at most {widest:g} m"
            )
    return Design(spec.name, vessel, solid, spec.rules, points, tuple(assumed))


def resolve_solid(own: SolidKeys, given: Mapping[str, float]) -> tuple[Solid, list[str]]:
    """The solid of the keys, table E.1 and what is given otherwise; and what was assumed."""
    row = None if own.name is None else find_row(own.name)
    known: dict[str, float] = dict(given)
    assumed: list[str] = []
    for name in SolidKeys.model_fields:
        value = getattr(own, name)
        if isinstance(value, float):
            known[name] = value
        elif row is not None and name not in given and (found := _of_row(row, name, own)):
            known[name] = found
    for name in ("unit_weight", "internal_friction", "wall_friction"):
        if name not in known:
            raise InputError(
                f"{name} is missing; give it, such as {_EXAMPLES[name]}, or name = 'wheat', a line "
                "of EN 1991-4, table E.1"
            )
    for name, make, words in _ASSUMED:
        if name not in known:
            known[name] = make(known)
            assumed.append(words)
    title = own.name or "solid"
    names = (one for one in Solid.__dataclass_fields__ if one != "name")
    solid = Solid(title, **{one: float(known[one]) for one in names})
    _check(solid)
    return solid, assumed


_EXAMPLES = {
    "unit_weight": "'9 kN/m3'", "internal_friction": "'30 deg'", "wall_friction": "0.38"
}  # fmt: skip
_ASSUMED = [
    ("repose", lambda k: k["internal_friction"], "angle of repose: as the internal friction"),
    ("internal_friction_factor", lambda k: 1.0, "a_phi = 1: internal friction without scatter"),
    ("lateral_ratio", lambda k: lateral_ratio_of(k["internal_friction"]),
     "K_m = 1.1 (1 - sin phi_im) (eq. 4.7)"),
    ("lateral_ratio_factor", lambda k: 1.0, "a_K = 1: lateral pressure ratio without scatter"),
    ("wall_friction_factor", lambda k: 1.0, "a_mu = 1: wall friction without scatter"),
    ("hopper_friction", lambda k: k["wall_friction"], "friction at the hopper: as at the wall"),
    ("patch", lambda k: 1.0, "C_op = 1, as for a solid of which nothing is known"),
    ("effective_friction", lambda k: k["internal_friction"],
     "Jenike's effective angle: the mean internal friction"),
]  # fmt: skip


def _of_row(row: Row, name: str, own: SolidKeys) -> float | None:
    if name == "wall_friction":
        return row.wall_friction[int(own.wall_type[1]) - 1]
    return getattr(row, name, None)


def _check(solid: Solid) -> None:
    for name in ("repose", "internal_friction", "effective_friction"):
        angle = math.degrees(getattr(solid, name))
        if not 5 <= angle <= 75:
            raise InputError(f"{name} = {angle:.4g} deg: solids have 5 to 75 deg; check the unit")


def _flow_function(points: list[list[float]]) -> tuple[tuple[float, float], ...]:
    """Points in Pa; InputError where they are no pairs, not ascending, or negative."""
    for point in points:
        if len(point) != 2 or not all(math.isfinite(x) and x >= 0 for x in point):
            raise InputError(
                f"flow_function = {point!r}: write pairs of stress and strength in kPa, such as "
                "[[2, 0.8], [8, 1.5]]"
            )
    stresses = [point[0] for point in points]
    if any(b <= a for a, b in pairwise(stresses)):
        raise InputError("flow_function: stresses must ascend, each once, in kPa")
    return tuple((1e3 * stress, 1e3 * strength) for stress, strength in points)


def commented_spec() -> str:
    """A file of a silo for wheat with a comment on every key."""
    return reference.commented_case(
        Spec,
        "A full-size silo for `silo2d loads --silo`: its geometry, what is stored, and the rules. "
        "Quantities are texts with a unit; pure numbers have none.",
        "silo",
        SCHEMA,
    )
