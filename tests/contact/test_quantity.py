"""Quantities with units: what is read, exactly; what is refused, in one line; and the way back."""

import contextlib
import math
from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from granulab.contact.files import units
from granulab.contact.files.units import from_si, nearest, to_si
from granulab.errors import InputError


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("475 mm", "m", 0.475),
        ("475mm", "m", 0.475),
        ("  +4.75e2 mm\n", "m", 0.475),
        (".5 m", "m", 0.5),
        ("5. m", "m", 5.0),
        ("-3 mm", "m", -0.003),
        ("1.0e4 N/mm", "N/m", 1e7),
        ("1E4N/mm", "N/m", 1e7),
        ("10 kN / m", "N/m", 1e4),
        ("0.45 g/cm3", "kg/m3", 450.0),
        ("0.45 g/cm**3", "kg/m3", 450.0),
        ("0.45 g cm^-3", "kg/m3", 450.0),
        ("200 mm2", "m2", 200e-6),
        ("200 mm²", "m2", 200e-6),
        ("3.3 GPa", "Pa", 3.3e9),
        ("5 us", "s", 5e-6),
        ("5 µs", "s", 5e-6),
        ("6085 1/s", "1/s", 6085.0),
        ("6085/s", "1/s", 6085.0),
        ("6085 s-1", "1/s", 6085.0),
        ("6085 s⁻¹", "1/s", 6085.0),
        ("40 Hz", "1/s", 40.0),
        ("9.81 m/s2", "m/s2", 9.81),
        ("6 %", "1", 0.06),
        ("6%", "1", 0.06),
        ("0.38", "1", 0.38),
        (0.38, "1", 0.38),
        (1, "1", 1.0),
    ],
)
def test_a_quantity_is_the_nearest_float_of_its_decimal_value(text, unit, number):
    """SI prefixes are powers of ten, so the conversion is exact and == is the right comparison."""
    assert to_si(text, unit, "field") == number


def test_degrees_are_pi_over_180():
    """One unit in the last place: math.radians rounds twice, the reader once."""
    assert to_si("60 deg", "rad", "angle") == pytest.approx(math.pi / 3, rel=3e-16)
    assert to_si("60°", "rad", "angle") == pytest.approx(math.pi / 3, rel=3e-16)


@given(digits=st.integers(-(10**17), 10**17), exponent=st.integers(-30, 30))
def test_reading_rounds_once(digits, exponent):
    """Oracle: the same decimal as an exact fraction, rounded to the nearest float."""
    exact = Fraction(digits) * Fraction(10) ** (exponent - 3)
    assert to_si(f"{digits}e{exponent} mm", "m", "length") == float(exact)


@pytest.mark.parametrize(
    ("value", "unit", "reason"),
    [
        ("475", "m", "the unit is missing"),
        (475, "m", "the unit is missing"),
        (0.475, "m", "the unit is missing"),
        ("475 kg", "m", "the unit is wrong here"),
        ("475 mm2", "m", "the unit is wrong here"),
        ("20 deg", "1", "the unit is wrong here"),  # an angle of repose is no coefficient
        ("20 %", "rad", "the unit is wrong here"),
        ("600 rpm", "1/s", "the unit is wrong here"),  # 2 pi away from what is meant
        ("5 dB", "1", "the unit is wrong here"),
        ("475 mn", "m", "unknown unit 'mn'"),
        ("mm", "m", "not a quantity"),
        ("", "m", "not a quantity"),
        ("1,5 mm", "m", "not a quantity"),  # a decimal comma must not become a factor of ten
        ("1_5 mm", "m", "not a quantity"),
        ("1 2 mm", "m", "not a quantity"),
        ("3 + 4 mm", "m", "not a quantity"),
        ("5² m", "m", "not a quantity"),
        ("[1] mm", "m", "not a quantity"),
        ("nan mm", "m", "not a quantity"),
        ("9**9**9**9 mm", "m", "not a quantity"),  # must not be evaluated
        ("1 m**9**9**9**9", "m", "not a quantity"),
        ("1e9999999999 mm", "m", "not a quantity"),
        ("1e400 mm", "m", "not a finite number"),
        ("1e308 km", "m", "not a finite number"),
        (math.nan, "1", "not a finite number"),
        (math.inf, "1", "not a finite number"),
        (10**400, "1", "not a finite number"),
        (True, "1", "expected a quantity"),
        (None, "1", "expected a quantity"),
        (["1 m"], "m", "expected a quantity"),
    ],
)
def test_a_bad_quantity_is_refused_in_one_line(value, unit, reason):
    with pytest.raises(InputError) as refused:
        to_si(value, unit, "FILE: fill_level")
    message = str(refused.value)
    assert message.startswith(f"FILE: fill_level = {value!r}: {reason}")
    assert "such as" in message
    assert "\n" not in message


@given(st.text("0123456789.eE+-*/^% °µ²mskgNPadB\n", max_size=12) | st.text(max_size=12))
@settings(deadline=None)
def test_any_text_is_a_quantity_or_an_input_error(text):
    """Nothing else may come out of the unit library, whatever is typed."""
    with contextlib.suppress(InputError):
        assert math.isfinite(to_si(text, "1", "field"))


@given(
    value=st.floats(-1e200, 1e200),
    unit=st.sampled_from(["mm:m", "g/cm3:kg/m3", "GPa:Pa", "N/mm:N/m", "us:s", "deg:rad", "%:1"]),
)
def test_a_written_quantity_reads_back_to_the_same_float(value, unit):
    """Exact: a table that is written and read again gives the same bits."""
    written, si = unit.split(":")
    assert to_si(from_si(value, written), si, "field") == value


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.12, "mm", "120 mm"),
        (450.0, "g/cm3", "0.45 g/cm3"),
        (1e7, "N/mm", "10000 N/mm"),
        (0.1 + 0.2, "m", "0.30000000000000004 m"),  # not 0.3
    ],
)
def test_a_quantity_is_written_with_the_fewest_digits_that_hold_it(value, unit, text):
    assert from_si(value, unit) == text


def test_an_unknown_name_is_reported_with_the_nearest_and_all():
    assert nearest("orifce", ["orifice", "height"]) == (
        "did you mean 'orifice'? known: orifice, height"
    )
    assert nearest("xyz", ["orifice", "height"]) == "known: orifice, height"
    assert nearest("xyz", []) == "known: none"


def test_units_that_are_read_without_pint_are_what_pint_has():
    """Exact: powers of ten, in decimal numbers."""
    registry = units._registry()
    for unit, powers in units.POWERS_OF_TEN.items():
        for written, power in powers.items():
            given, target = (registry.Unit(units._spelled_for_pint(name)) for name in
                             (written, unit))  # fmt: skip
            assert registry.Quantity(Decimal(1), given).to(target).magnitude == Decimal(10) ** power
