"""The schema of a file of a full-size silo: geometry, what is stored, and the rules that apply."""

from typing import Annotated, Literal

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
    folder_name,
    key,
    read,
)

SCHEMA = 1
UnitWeight = Annotated[float, read("N/m3"), Unit("N/m3"), Field(gt=0)]
Factor = Annotated[Number, Field(ge=1, le=5)]
Ratio = Annotated[Number, Field(gt=0, le=2)]
_ROW = "that of [solid] name"
_FLAT = 1.57  # [rad] below a right angle


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
    half_angle: Annotated[Angle, Field(gt=0, lt=_FLAT)] | None = key(
        None,
        "of the hopper, from the vertical; of a pyramid that of its longer sides",
        example="20 deg",
        left_out="a flat bottom",
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
    """The stored solid; what is given here goes before table E.1."""

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
    unit_weight_lower: UnitWeight | None = key(
        None, "lower characteristic unit weight, for Jenike's outlets", example="7.5 kN/m3",
        left_out=f"{_ROW} where its upper one is, too, or unit_weight",
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
    """Rules by which the standard is applied."""

    assessment_class: Annotated[int, Field(ge=1, le=3, strict=True)] = key(
        2, "action assessment class: 1 (below 100 t) takes mean properties; 2 and 3 upper and "
        "lower ones", option="--assessment-class", metavar="2",
    )  # fmt: skip
    filling_eccentricity: Annotated[Length, Field(ge=0)] = key(
        0.0, "largest eccentricity of the surface pile while filling", example="0 m"
    )
    outlet_eccentricity: Annotated[Length, Field(ge=0)] = key(
        0.0, "eccentricity of the outlet's middle; with a CASE that of its own", example="0 m"
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
    """Solid and rules beside a case, which has its own silo."""

    name: Annotated[str, AfterValidator(folder_name)] = "silo"
    solid: SolidKeys = SolidKeys()
    rules: Rules = Rules()


class Spec(Section):
    """A whole file, but for its schema number."""

    name: Annotated[str, AfterValidator(folder_name)] = "silo"
    silo: Geometry
    solid: SolidKeys = SolidKeys()
    rules: Rules = Rules()


FILE = casefile.CaseFile(Spec, SCHEMA, "[silo] width and height")
BESIDE = casefile.CaseFile(Beside, SCHEMA)


def commented_spec() -> str:
    """A file of a silo for wheat with a comment on every key."""
    return reference.commented_case(
        Spec,
        "A full-size silo for `silo2d loads --silo`: its geometry, what is stored, and the rules. "
        "Quantities are texts with a unit; pure numbers have none.",
        "silo",
        SCHEMA,
    )
