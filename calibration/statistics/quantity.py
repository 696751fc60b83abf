"""Quantities with an uncertainty as people write them: "10.8 g +- 0.3 g", "0.53 +- 4 %"."""

import math
import re

from granulab.contact.files.units import is_plain_number, to_si
from granulab.contact.material import Measured
from granulab.errors import InputError

_SIGN = re.compile(r"\s*(?:\+-|\+/-|±)\s*")


def measured_quantity(text: str, unit: str, field: str) -> Measured:
    """A value and, behind +-, its standard uncertainty in SI units `unit`, or in % of the value.

    The unit may stand once, at the end. Raises InputError with one line that names the field.
    """
    written, *widths = _SIGN.split(text.strip())
    if len(widths) > 1 or "" in widths:
        raise InputError(f"{field} = {text!r}: not a quantity; write such as '0.53 +- 0.02'")
    width = widths[0] if widths else None
    relative = width is not None and width.endswith("%")
    if relative and written.endswith("%"):
        raise InputError(
            f"{field} = {text!r}: of a value in % it is open what the uncertainty is a share of; "
            "write such as '0.53 +- 0.02'"
        )
    if width is not None and not relative and is_plain_number(written) and unit != "1":
        number = re.match(r"[+-]?[0-9.]+(?:[eE][+-]?[0-9]+)?", width)
        written += width[number.end() :] if number else ""
    value = to_si(written, unit, field)
    if width is None:
        return Measured(value)
    sigma = to_si(width, "1" if relative else unit, f"{field}, uncertainty")
    if sigma < 0:
        raise InputError(f"{field} = {text!r}: the uncertainty must be at least 0")
    return Measured(value, abs(value) * sigma if relative else sigma)


def metres_per_pixel(text: str) -> float:
    """The scale of a picture, "0.81 mm/px", in metres per pixel; InputError for anything else."""
    length, slash, per = text.partition("/")
    if not slash or per.strip() not in ("px", "pixel"):
        raise InputError(f"--scale = {text!r}: a length per pixel, such as '0.81 mm/px'")
    scale = to_si(length.strip(), "m", "--scale")
    if not 0 < scale < math.inf:
        raise InputError(f"--scale = {text!r}: must be positive, such as '0.81 mm/px'")
    return scale


def six_digits(value: float) -> float | None:
    """A number for a table or an object, to six digits: more than is known; None for NaN."""
    return float(f"{value:.6g}") if math.isfinite(value) else None


def plus_minus(value: float, sigma: float | None) -> str:
    """A value and its uncertainty for a person: sigma to two digits, the value as far as it."""
    if not sigma or not math.isfinite(sigma):
        return f"{value:.6g}"
    digits = 1 - math.floor(math.log10(sigma))
    if abs(digits) > 6:  # more zeros than anybody counts
        places = digits + math.floor(math.log10(abs(value))) + 1 if value else 1
        known = f"{value:#.{max(1, min(places, 15))}g}".rstrip(".")
        return f"{known} +- {sigma:.2g}"
    shown = (f"{round(number, digits):.{max(digits, 0)}f}" for number in (value, sigma))
    return " +- ".join(shown)
