"""Designs: a full-size silo, its solid and its rules, resolved from a file or a case."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from granulab.contact.files.casefile import changed
from granulab.contact.files.units import located
from granulab.errors import InputError
from silo2d.loads.solid import Row, Solid, find_row, lateral_ratio_of
from silo2d.loads.spec import BESIDE, FILE, Beside, Geometry, Rules, SolidKeys, Spec
from silo2d.loads.vessel import Vessel

FlowFunction = tuple[tuple[float, float], ...]  # points (stress, strength) [Pa]


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
    flow_function: FlowFunction
    assumptions: tuple[str, ...]


def load_design(path: str | Path, changes: Mapping[str, Any] | None = None) -> Design:
    """The silo of a file; InputError, one line, where it cannot be."""
    where = str(path)
    spec = FILE.check(changed(_read(path), dict(changes or {}), Spec), where)
    with located(f"{where}: [silo]"):
        vessel = vessel_of(spec.silo)
    return design_of(spec, vessel, where)


def _read(path: str | Path) -> dict[str, Any]:
    if not Path(path).exists():
        raise InputError(f"{path}: no such file; silo2d init FILE --loads writes one")
    return FILE.read(Path(path))


def load_beside(
    path: str | Path | None, changes: Mapping[str, Any], usual: Mapping[str, Any]
) -> Beside:
    """Solid and rules for a case, from a file or none, with changes; usual: below what it says."""
    where = "the options" if path is None else str(path)
    document: dict[str, Any] = {} if path is None else _read(path)
    if "silo" in document:
        raise InputError(f"{where}: [silo]: the case has its own; leave it out, or the case")
    for name, table in changed({}, dict(usual), Beside).items():
        document[name] = table | document.get(name, {})
    beside = BESIDE.check(changed(document, dict(changes), Beside), where)
    with located(f"{where}: [solid]"):  # before anything is run for it
        _flow_function(beside.solid.flow_function)
        _check(_known(beside.solid, {}))
    return beside


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
    widest = vessel.width / 2
    for name in ("filling_eccentricity", "outlet_eccentricity"):
        if (value := getattr(spec.rules, name)) > widest:
            raise InputError(
                f"{where}: [rules] {name} = {value:g} m: outside the silo; at most {widest:g} m"
            )
    return Design(spec.name, vessel, solid, spec.rules, points, tuple(assumed))


def resolve_solid(own: SolidKeys, given: Mapping[str, float]) -> tuple[Solid, list[str]]:
    """The solid of the keys, table E.1 and what is given otherwise; and what was assumed."""
    known, assumed = _known(own, given), []
    for name in ("unit_weight", "internal_friction", "wall_friction"):
        if name not in known:
            raise InputError(
                f"{name} is missing; give it, such as {_EXAMPLES[name]}, or name = 'wheat', a line "
                "of EN 1991-4, table E.1"
            )
    known.setdefault("unit_weight_lower", known["unit_weight"])
    _check(known)
    for name, make, words in _ASSUMED:
        if name not in known:
            known[name] = make(known)
            assumed.append(words)
    title = own.name or "as given"
    names = (one for one in Solid.__dataclass_fields__ if one != "name")
    return Solid(title, **{one: float(known[one]) for one in names}), assumed


def _known(own: SolidKeys, given: Mapping[str, float]) -> dict[str, float]:
    """Properties by the keys, else as given, else by table E.1."""
    row = None if own.name is None else find_row(own.name)
    known = dict(given)
    for name in SolidKeys.model_fields:
        value = getattr(own, name)
        if isinstance(value, float):
            known[name] = value
        elif row is not None and name not in given and (found := _of_row(row, name, own)):
            known[name] = found
    if own.unit_weight_lower is None and row and known["unit_weight"] != row.unit_weight:
        del known["unit_weight_lower"]  # it goes with the upper one of its line
    return known


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


def _check(known: Mapping[str, float]) -> None:
    """Refuse properties that no solid has, upper characteristic values among them."""
    for name in ("repose", "internal_friction", "effective_friction"):
        if name in known and not 5 <= math.degrees(known[name]) <= 75:
            raise InputError(
                f"{name} = {math.degrees(known[name]):.4g} deg: solids have 5 to 75 deg; check "
                "the unit"
            )
    upper, lower = known.get("unit_weight", math.inf), known.get("unit_weight_lower", 0.0)
    if lower > upper:
        raise InputError(
            f"unit_weight_lower = {lower / 1e3:.4g} kN/m3: more than the upper one; give at most "
            f"unit_weight = {upper / 1e3:.4g} kN/m3"
        )
    angle = known.get("internal_friction")
    if angle is not None:
        _check_upper(known, "internal_friction", math.degrees(angle), 90.0, " deg")
    if "lateral_ratio" in known:
        _check_upper(known, "lateral_ratio", known["lateral_ratio"], 1.0)
    elif angle is not None:
        _check_upper(known, "lateral_ratio", lateral_ratio_of(angle), 1.0, by=" by eq. 4.7")


def _check_upper(
    known: Mapping[str, float], name: str, mean: float, limit: float, unit: str = "", by: str = ""
) -> None:
    factor = known.get(f"{name}_factor", 1.0)
    if mean * factor >= limit:
        raise InputError(
            f"{name} = {mean:.4g}{unit}{by}: times {name}_factor = {factor:.4g} it is "
            f"{mean * factor:.4g}{unit}; must be below {limit:g}{unit}: give less than "
            f"{limit / factor:.4g}{unit}"
        )


def _flow_function(points: list[list[float]]) -> FlowFunction:
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
