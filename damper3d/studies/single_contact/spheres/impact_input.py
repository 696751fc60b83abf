"""From the words of a command to an impact: materials by name or by their constants, units."""

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from damper3d.studies.single_contact.spheres.impact import Impact
from granulab.contact.files.datafile import data_file, data_names
from granulab.contact.files.table import ContactTable, load_table
from granulab.contact.files.units import nearest, to_si
from granulab.contact.material import Material, Measured
from granulab.errors import InputError

_CONSTANTS = {"youngs_modulus": "Pa", "poisson": "1", "density": "kg/m3", "yield_strength": "Pa"}
_NEEDED = ("youngs_modulus", "poisson", "density")
_NUMBERS = {"speed": "m/s", "spin": "1/s", "other_spin": "1/s"}  # plain, or with this unit
_PURE = ("friction", "restitution")
_CHOICES = {
    "tangential": ("displacement", "force", "mindlin-deresiewicz"),
    "end": ("overlap", "force"),
    "damping": ("published", "restitution"),
}


def impact_of(
    given: Mapping[str, str | None], *, against: str, flags: dict[str, Any]
) -> tuple[Impact, list[str]]:
    """The impact that options describe, and a line for each constant that nobody gave.

    given: texts by the names of Impact, `material` and the keys of a material; None: not given.
    against: "wall", "rigid-wall", "sphere" or a material. Raises InputError.
    """
    texts = {key: text for key, text in given.items() if text is not None}
    first, table = _sphere_material(texts)
    rigid, sphere = against == "rigid-wall", against == "sphere"
    second = first if against in ("wall", "sphere") else None
    if not (rigid or second):
        second, _ = _named_material(against, "against", ("wall", "rigid-wall", "sphere"))
    known = _pair_constants(table, first, second)
    fields: dict[str, Any] = {key: plain_or_unit(texts[key], unit, key)
                    for key, unit in _NUMBERS.items() if key in texts}  # fmt: skip
    if "radius" in texts:
        fields["radius"] = to_si(texts["radius"], "m", "radius")
    if "other_spin" in fields and not sphere:
        raise InputError(
            f"other_spin = {fields['other_spin']:g} rad/s: against = {against!r} does not rotate; "
            "leave it out, or give --against sphere"
        )
    if "angle" in texts:
        fields["angle"] = _angle(texts["angle"])
    fields |= {key: plain_or_unit(texts[key], "1", key) for key in _PURE if key in texts}
    for key, choices in _CHOICES.items():
        if key in texts:
            fields[key] = _choice(key, texts[key], choices)
    remarks = []
    for key, usual in (("restitution", 1.0), ("friction", 0.0)):
        if key not in fields:
            fields[key] = known.get(key, usual)
            if key not in known:
                pair = f"{first.name} on {second.name if second else 'a rigid wall'}"
                remarks.append(f"no {key} of {pair} is known: {usual:g} is taken; give --{key}")
    return Impact(first, second, sphere=sphere, **fields, **flags), remarks


def plain_or_unit(text: str, unit: str, field: str) -> float:
    """A plain number, in SI, or a quantity with its unit."""
    try:
        number = float(text)
    except ValueError:
        return to_si(text, unit, field)
    return to_si(number, "1", field)


def _angle(text: str) -> float:
    """Angle in radians; a plain number is in degrees."""
    try:
        degrees = float(text)
    except ValueError:
        return to_si(text, "rad", "angle")
    return math.radians(to_si(degrees, "1", "angle"))


def _choice(key: str, text: str, choices: tuple[str, ...]) -> str:
    if text not in choices:
        raise InputError(f"{key} = {text!r}: takes {', '.join(choices)}")
    return text


def _sphere_material(texts: Mapping[str, str]) -> tuple[Material, ContactTable | None]:
    """The sphere's material, and the table it comes from if it comes from one."""
    own: dict[str, Any] = {
        key: Measured(plain_or_unit(texts[key], unit, key) if unit == "1"
                      else to_si(texts[key], unit, key))
        for key, unit in _CONSTANTS.items()
        if key in texts
    }  # fmt: skip
    if own and "material" not in texts:
        missing = [key for key in _NEEDED if key not in own]
        if missing:
            flags = ", ".join("--" + key.replace("_", "-") for key in missing)
            raise InputError(f"a material of its own needs {flags} too; or give --material")
        return Material("given", **own), None
    material, table = _named_material(texts.get("material", "acrylic"), "material")
    return dataclasses.replace(material, **own), table


def _named_material(
    name: str, field: str, others: tuple[str, ...] = ()
) -> tuple[Material, ContactTable]:
    """The material of a shipped table or a file: the one it is called after, or its only one."""
    if data_file("materials", name) is None and not Path(name).is_file():
        known = [*others, *data_names("materials")]
        raise InputError(f"{field} = {name!r}: no such table or file; {nearest(name, known)}")
    table = load_table(name)
    return table.namesake(), table


def _pair_constants(
    table: ContactTable | None, first: Material, second: Material | None
) -> dict[str, float]:
    """Friction and restitution that the table of the sphere's material gives."""
    if table is None or second is None:
        return {}
    names = (first.name, second.name)
    pair = table.pairs.get(names) or table.pairs.get(names[::-1])
    if pair is None:
        return {}
    known = {"friction": pair.friction.value}
    if pair.restitution is not None:
        known["restitution"] = pair.restitution.value
    return known
