"""What calibrate damping works on: given on the command line, else what a parameter file says."""

from dataclasses import dataclass
from typing import Literal

from calibration.quantity import measured_quantity
from contact.damping import reduced_mass_of
from contact.material import PROPERTIES, Measured, check_range
from contact.quantity import InputError, located
from contact.restitution import ContactEnd
from contact.table import ContactTable, load_table


@dataclass(frozen=True)
class Impact:
    """Two bodies of the linear law; every number with its uncertainty where one is known."""

    restitution: Measured  # through `contacts` in parallel [-]
    kn: Measured  # of each contact [N/m]
    mass: Measured  # reduced [kg]
    contacts: int
    end: ContactEnd
    remarks: list[str]


def impact_of(
    *, materials: str | None, pair: str | None, restitution: str | None, kn: str | None,
    mass: str | None, other_mass: str | None, area: str | None, wall: bool, contacts: int,
    end: Literal["overlap", "force"],
) -> Impact:  # fmt: skip
    """Put together what is given and what the pair of a parameter file holds.

    Raises InputError, one line that says what is missing, wrong or given twice.
    """
    names = _names(pair, materials)
    table = load_table(materials) if materials else None
    if contacts < 1:
        raise InputError(f"--contacts {contacts}: must be at least 1")
    e = _value("restitution", restitution, table, names)
    stiffness = _value("kn", kn, table, names)
    first = _mass(mass, area, table, names)
    reduced = _reduced(first, other_mass, wall)
    remarks = [
        f"{name} has no uncertainty and counts as exact; give one such as '+- 5 %'"
        for name, value in (("restitution", e), ("kn", stiffness), ("the mass", reduced))
        if value.sigma is None
    ]
    return Impact(e, stiffness, reduced, contacts, end, remarks)


def _names(pair: str | None, materials: str | None) -> tuple[str, str] | None:
    if materials is None:
        return None
    first, _, second = (pair or "").partition("-")
    if not first or not second:
        raise InputError(f"{materials}: say which pair is meant, such as --pair wood-steel")
    return first, second


def _value(
    key: str, given: str | None, table: ContactTable | None, names: tuple[str, str] | None
) -> Measured:
    """A property of the pair: as given, else from the file."""
    option = f"--{key}"
    if given is not None:
        value = measured_quantity(given, PROPERTIES[key].unit, option)
        check_range(key, value)
        return value
    if table is None or names is None:
        raise InputError(f"{option} is missing; give it, or --materials FILE and --pair A-B")
    pair = table.pair(*names)
    holder = pair.linear if key == "kn" else pair
    found = getattr(holder, key) if holder else None
    if found is None:
        raise InputError(f"{table.path}: [pair.{'-'.join(names)}] has no {key}; give {option}")
    return found


def _mass(
    mass: str | None, area: str | None, table: ContactTable | None,
    names: tuple[str, str] | None,
) -> Measured:  # fmt: skip
    """Of one body [kg]: as given, or of a prism of the first material of the pair."""
    if (mass is None) == (area is None):
        raise InputError(
            "give one of --mass '10.8 g +- 6 %' and, for a prism of the pair's first material, "
            "--area '200 mm2'"
        )
    if mass is not None:
        return _positive(measured_quantity(mass, "kg", "--mass"), "--mass", mass)
    assert area is not None
    section = _positive(measured_quantity(area, "m2", "--area"), "--area", area)
    if table is None or names is None:
        raise InputError("--area needs the density and length of --materials FILE and --pair A-B")
    material = table.material(names[0])
    if material.length is None:
        raise InputError(f"{table.path}: [material.{names[0]}] has no length; give --mass")
    return _product(material.density, material.length, section)


def _product(*factors: Measured) -> Measured:
    """A product of independent factors; relative uncertainties add in squares."""
    value, variance = 1.0, 0.0
    for factor in factors:
        value *= factor.value
        variance += ((factor.sigma or 0.0) / factor.value) ** 2
    known = any(factor.sigma is not None for factor in factors)
    return Measured(value, value * variance**0.5 if known else None)


def _reduced(first: Measured, other: str | None, wall: bool) -> Measured:
    """Reduced mass: against a wall (eq. 3.10), another body, or its like (eq. 3.9)."""
    if wall and other is not None:
        raise InputError("--wall does not move: leave out --other-mass, or --wall")
    if wall:
        return reduced_mass_of(first)
    if other is not None:
        second = measured_quantity(other, "kg", "--other-mass")
        return reduced_mass_of(first, _positive(second, "--other-mass", other))
    return Measured(first.value / 2, None if first.sigma is None else first.sigma / 2)


def _positive(value: Measured, field: str, given: str) -> Measured:
    with located(f"{field} = {given!r}:"):
        if value.value <= 0:
            raise InputError("must be above 0")
    return value
