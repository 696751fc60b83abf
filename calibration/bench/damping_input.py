"""What calibrate damping works on: given on the command line, else what a parameter file says."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from calibration.bench.damping import reduced_mass_of
from calibration.files.provenance import read_values
from calibration.statistics.quantity import measured_quantity
from granulab.contact.files.units import located
from granulab.contact.material import PROPERTIES, Measured, check_range
from granulab.contact.restitution import ContactEnd
from granulab.errors import InputError


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

    The file may be one in the making. Raises InputError, one line that says what is missing,
    wrong or given twice.
    """
    if contacts < 1:
        raise InputError(f"--contacts {contacts}: must be at least 1")
    known = _Known.of(materials, pair) if materials else None
    e, stiffness = _value("restitution", restitution, known), _value("kn", kn, known)
    reduced = _reduced(_mass(mass, area, known), other_mass, wall)
    remarks = [
        f"{name} has no uncertainty and counts as exact; give one such as '+- 5 %'"
        for name, value in (("restitution", e), ("kn", stiffness), ("the mass", reduced))
        if value.sigma is None
    ]
    if e.sigma is not None and not e.sigma < e.value <= 1 - e.sigma:
        remarks.append(
            f"restitution {e.value:g} +- {e.sigma:.2g} reaches beyond 0 or 1, where no contact is: "
            "sigmas to first order say little of what follows"
        )
    return Impact(e, stiffness, reduced, contacts, end, remarks)


@dataclass(frozen=True)
class _Known:
    """What a file says of a pair, its own name or turned round."""

    path: Path
    first: str
    second: str
    values: dict[tuple[str, str], Measured]

    @classmethod
    def of(cls, materials: str, pair: str | None) -> "_Known":
        first, _, second = (pair or "").partition("-")
        if not first or not second:
            raise InputError(f"{materials}: say which pair is meant, such as --pair wood-steel")
        path, values, _ = read_values(materials)
        return cls(path, first, second, values)

    def of_pair(self, key: str) -> Measured | None:
        linear = ".linear" if key == "kn" else ""
        names = (f"{self.first}-{self.second}", f"{self.second}-{self.first}")
        found = (self.values.get((f"pair.{name}{linear}", key)) for name in names)
        return next((value for value in found if value is not None), None)


def _value(key: str, given: str | None, known: _Known | None) -> Measured:
    """A property of the pair: as given, else from the file."""
    option = f"--{key}"
    if given is not None:
        value = measured_quantity(given, PROPERTIES[key].unit, option)
        check_range(key, value)
        return value
    if known is None:
        raise InputError(f"{option} is missing; give it, or --materials FILE and --pair A-B")
    found = known.of_pair(key)
    if found is None:
        raise InputError(
            f"{known.path}: no {key} of pair {known.first}-{known.second}; give {option}"
        )
    return found


def _mass(mass: str | None, area: str | None, known: _Known | None) -> Measured:
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
    if known is None:
        raise InputError("--area needs the density and length of --materials FILE and --pair A-B")
    factors = [section]
    for key in ("density", "length"):
        found = known.values.get((f"material.{known.first}", key))
        if found is None:
            raise InputError(f"{known.path}: [material.{known.first}] has no {key}; give --mass")
        factors.append(found)
    return _product(*factors)


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
