"""Quantities as people write them ("1.0e4 N/mm", "475mm", "6 %") to SI numbers and back."""

import contextlib
import difflib
import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from decimal import Context, Decimal
from functools import cache, lru_cache
from typing import Any, TypeVar

from granulab.errors import InputError

_EXAMPLE = {
    "m": "475 mm",
    "m2": "200 mm2",
    "s": "5 us",
    "kg/m3": "0.45 g/cm3",
    "N/m": "1.0e4 N/mm",
    "1/s": "6085 1/s",
    "Hz": "40 Hz",
    "rad": "60 deg",
    "m/s": "0.5 m/s",
    "m/s2": "9.81 m/s2",
    "kg": "1.2 kg",
    "N": "0.79 N",
    "Pa": "3.3 GPa",
    "N/m3": "9 kN/m3",
    "1": "0.38",
}

# Powers of ten of the units that cases are usually written in, by the SI unit. These are read
# without pint, which takes a third of a second to load.
POWERS_OF_TEN = {
    "m": {"m": 0, "cm": -2, "mm": -3, "um": -6},
    "s": {"s": 0, "ms": -3, "us": -6},
    "kg": {"kg": 0, "g": -3},
    "kg/m3": {"kg/m3": 0, "g/cm3": 3},
    "N": {"N": 0, "kN": 3},
    "N/m": {"N/m": 0, "N/mm": 3, "kN/m": 3},
    "Pa": {"Pa": 0, "kPa": 3, "MPa": 6, "GPa": 9},
    "1/s": {"1/s": 0},
    "Hz": {"Hz": 0, "kHz": 3},
    "m/s": {"m/s": 0, "mm/s": -3},
    "m/s2": {"m/s2": 0},
    "1": {"": 0, "%": -2},
}

# One number and a product of units. pint alone would also evaluate "9**9**9" until the machine
# is full, and read "1,5 mm" as 15 mm.
_TERM = r"(?:[^\W\d_¹²³]+|[°%])(?:(?:\*\*|\^)?-?[1-9]|⁻?[¹²³])?"
_QUANTITY = re.compile(
    r"(?P<number>[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)\s*"
    rf"(?P<unit>(?:(?:1?\s*/\s*)?{_TERM}(?:(?:\s*[*/]\s*|\s+){_TERM})*)?)"
)
_SUPERSCRIPTS = str.maketrans("⁻¹²³", "-123")


@cache
def _registry():
    import pint  # half a second to import: only where a quantity is read

    # Decimal numbers make conversions exact: "475 mm" is the float 0.475, not its neighbour.
    return pint.UnitRegistry(non_int_type=Decimal)


def to_si(value: object, unit: str, field: str) -> float:
    """The number of SI units `unit` in `value`, for the input field named `field`.

    A text must carry a unit of the right kind ("475 mm"); a bare number is taken only where
    `unit` is "1". Raises InputError with one line otherwise.
    """
    example = _EXAMPLE.get(unit, f"1 {unit}")
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise InputError(f"{field} = {value!r}: expected a quantity such as {example!r}")
    if isinstance(value, str):
        number = _parse(value, unit, field, example)
    elif unit != "1":
        raise InputError(
            f"{field} = {value!r}: the unit is missing; write it as text, such as {example!r}"
        )
    else:
        number = float(value) if abs(value) <= sys.float_info.max else math.inf
    if not math.isfinite(number):
        raise InputError(f"{field} = {value!r}: not a finite number; write such as {example!r}")
    return number


@lru_cache(maxsize=4096)  # a table of results reads the same few quantities thousands of times
def _parse(text: str, unit: str, field: str, example: str) -> float:
    def bad(reason: str) -> InputError:
        return InputError(f"{field} = {text!r}: {reason}; write such as {example!r}")

    match = _QUANTITY.fullmatch(text.strip())
    if match is None:
        raise bad("not a quantity")
    if unit != "1" and not match["unit"]:
        raise bad("the unit is missing")
    if not math.isfinite(float(match["number"])):
        raise bad("not a finite number")
    power = POWERS_OF_TEN.get(unit, {}).get(match["unit"])
    if power is not None:
        return float(Decimal(match["number"]).scaleb(power))
    import pint

    registry = _registry()
    target = registry.Unit(_spelled_for_pint(unit))
    in_g = unit == "m/s2" and match["unit"] == "g"  # of an accelerometer: gravity, no gram
    try:
        given = registry.Unit("standard_gravity" if in_g else _spelled_for_pint(match["unit"]))
    except (pint.PintError, ValueError) as error:  # ValueError: "nan" is a number to pint
        raise bad(f"unknown unit {match['unit']!r}") from error
    # Root units, not dimensions: an angle is no pure number by these, and rpm not 1/s.
    if registry.get_root_units(given)[1] != registry.get_root_units(target)[1]:
        raise bad("the unit is wrong here")
    try:
        return float(registry.Quantity(Decimal(match["number"]), given).to(target).magnitude)
    except TypeError as error:  # pint has no exact logarithm, for decibel and its like
        raise bad("the unit is wrong here") from error


def _spelled_for_pint(unit: str) -> str:
    """Put "kg/m3" as "kg/m**3", "/s" as "1/s", "%" as "percent", "1" as "" (dimensionless)."""
    if unit == "1":
        return ""
    unit = unit.translate(_SUPERSCRIPTS).replace("%", "percent")
    unit = re.sub(r"(?<=[^\W\d_])(-?[0-9])", r"**\1", unit)
    return f"1{unit}" if unit.startswith("/") else unit


def is_unit(text: str) -> bool:
    """True where a text is a unit alone, of any kind; "-" and "1" are that of a pure number."""
    import pint

    if text in ("-", "1"):
        return True
    match = _QUANTITY.fullmatch(f"1 {text}")
    try:
        return match is not None and bool(_registry().Unit(_spelled_for_pint(match["unit"])))
    except (pint.PintError, ValueError):
        return False


def unit_in(text: str) -> str:
    """The unit that a quantity is written in, such as "mm"; "" where it has none or is none."""
    match = _QUANTITY.fullmatch(text.strip())
    return match["unit"] if match else ""


def is_plain_number(value: object) -> bool:
    """True where a value, or its text, is a number without a unit."""
    if not isinstance(value, str):
        return isinstance(value, int | float)
    match = _QUANTITY.fullmatch(value.strip())
    return match is not None and not match["unit"]


def from_si(value: float, unit: str) -> str:
    """An SI number as text in `unit`, such as "120 mm"; to_si gives the same float back."""
    registry = _registry()
    factor = registry.Quantity(Decimal(1), _spelled_for_pint(unit)).to_base_units().magnitude
    for digits in range(15, 29):  # 15 hold what a person wrote, 17 any float in a decimal unit
        number = Context(prec=digits).divide(Decimal(float(value)), factor).normalize()
        if float(number * factor) == value:
            break
    return f"{number:f} {unit}" if -5 < number.adjusted() < 15 else f"{number} {unit}"


def nearest(name: str, known: Iterable[str]) -> str:
    """The end of an error line about an unknown name: the nearest known one, and all of them."""
    names = list(known)
    same = [known for known in names if known.lower() == name.lower()]
    close = same or difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    hint = f"did you mean {close[0]!r}? " if close else ""
    return f"{hint}known: {', '.join(names) or 'none'}"


@contextlib.contextmanager
def located(where: str) -> Iterator[None]:
    """Put a position in front of the line of an InputError that comes from within."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{where} {error}") from None


First = TypeVar("First")
Second = TypeVar("Second")


def both(first: Callable[[], First], second: Callable[[], Second]) -> tuple[First, Second]:
    """Results of two readers; where they refuse, one InputError with the lines of both."""
    lines: list[str] = []
    found: list[Any] = []
    for read in (first, second):
        try:
            found.append(read())
        except InputError as error:
            lines.append(str(error))
    if lines:
        raise InputError("; and ".join(lines))
    return found[0], found[1]
