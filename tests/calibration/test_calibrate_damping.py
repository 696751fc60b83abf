"""calibrate damping and calibrate report: what they print, write and refuse."""

import contextlib

import pytest
from calibrating import calibrate
from hypothesis import given, settings
from hypothesis import strategies as st
from refusals import assert_refused

from calibration.statistics.quantity import measured_quantity, plus_minus
from granulab.contact.files.datafile import data_names, data_root
from granulab.contact.files.table import load_table
from granulab.errors import InputError

WOOD = ("--materials", "wood", "--pair", "wood-wood", "--area", "200 mm2")
GIVEN = ("--restitution", "0.53 +- 0.02", "--kn", "1e4 N/mm +- 5 %", "--mass", "10.8 +- 0.3 g")


@pytest.fixture
def wood(tmp_path):
    path = tmp_path / "wood.toml"
    path.write_bytes((data_root() / "materials" / "wood.toml").read_bytes())
    return path


def test_the_file_gives_what_the_command_line_does_not():
    """Density, length and area make the paper's 10.8 g; two of them reduce to 5.4 g (eq. 3.9)."""
    result = calibrate("damping", *WOOD, "--json").json
    assert result["reduced_mass_kg"]["value"] == pytest.approx(5.4e-3, rel=1e-12)
    assert result["reduced_mass_kg"]["sigma"] == pytest.approx(0.06 * 5.4e-3, rel=1e-12)
    assert result["restitution"] == {"value": 0.45, "sigma": pytest.approx(0.0765)}
    assert result["gamma_n_per_s"]["overlap"]["value"] == pytest.approx(21200, rel=5e-3)  # errata
    assert result["restitution_in_parallel"]["overlap"]["8"]["value"] == pytest.approx(
        0.05, abs=0.005
    )
    assert result["warnings"] == []


def test_a_wall_and_a_particle_of_its_own():
    """Eq. 3.10: gamma at a wall is that of two equal bodies over sqrt(2)."""
    gammas = [
        calibrate("damping", *GIVEN, *more, "--json").json["gamma_n_per_s"]["overlap"]["value"]
        for more in ([], ["--wall"], ["--other-mass", "10.8 g"])
    ]
    assert gammas[0] / gammas[1] == pytest.approx(2**0.5, rel=1e-12)
    assert gammas[2] == pytest.approx(gammas[0], rel=1e-12)


def test_damping_goes_into_the_file(wood):
    """gamma_n of the chosen end of contact, with what it came from; the rest as it was."""
    result = calibrate(
        "damping", "--into", wood, "--pair", "methacrylate-wood", *GIVEN, "--wall",
        "--contact-end", "force", "--json",
    )  # fmt: skip
    found = load_table(wood).pair("wood", "methacrylate").linear.gamma_n
    expected = result.json["gamma_n_per_s"]["force"]
    assert found.value == pytest.approx(expected["value"], abs=expected["sigma"] / 100)
    assert found.sigma == pytest.approx(expected["sigma"], rel=5e-3)
    assert found.history[0].value == 4303
    assert "zero force" in found.method
    assert found.source.startswith("restitution 0.530 +- 0.020 of one contact, kn 10000 +- 500 N")
    assert result.json["into"]["replaces"] == 4303
    assert "gamma_n replaced; the old value is kept as history" in result.err


def test_what_has_no_uncertainty_is_named():
    result = calibrate("damping", "--restitution", "0.5", "--kn", "1e4 N/mm", "--mass", "10 g")
    assert result.code == 0
    assert result.out.count("has no uncertainty and counts as exact") == 3


def test_the_report_of_a_file_says_where_each_number_came_from(wood):
    calibrate("damping", "--into", wood, "--pair", "wood-wood", *GIVEN)
    rows = {(row["section"], row["key"]): row for row in
            calibrate("report", wood, "--json").json["values"]}  # fmt: skip
    assert len(rows) == 17
    gamma = rows["pair.wood-wood.linear", "gamma_n"]
    assert gamma["history"][0]["value"] == 6085
    assert gamma["method"].startswith("from restitution, eq. 3.8")
    density = rows["material.wood", "density"]
    assert (density["value"], density["unit"], density["trials"]) == (450.0, "kg/m3", 5)
    text = calibrate("report", wood).out
    assert "  before        6085 1/s; from a restitution; GM 2013, Table 4, sec. 3.3.3" in text
    assert "density         0.450 +- 0.027 g/cm3; 5 trials; weighing; GM 2013, sec. 3.5" in text


def test_a_file_in_the_making_is_read_too(tmp_path):
    """Restitution first, then kn, then gamma_n from both: simulators could not read it yet."""
    new = tmp_path / "new.toml"
    new.write_text(
        "schema = 1\n[pair.a-b]\nrestitution = { value = 0.5, sigma = 0.01, trials = 12 }\n"
        '[pair.a-b.linear]\nkn = { value = "1e4 N/mm", sigma = "5 %" }\n'
    )
    result = calibrate("damping", "--into", new, "--pair", "b-a", "--mass", "10 g +- 1 %", "--json")
    assert result.json["restitution"] == {"value": 0.5, "sigma": 0.01}
    rows = {row["key"]: row for row in calibrate("report", new, "--json").json["values"]}
    assert (rows["gamma_n"]["section"], rows["gamma_n"]["trials"]) == ("pair.a-b.linear", 12)


@pytest.mark.parametrize("restitution", ["0.1 +- 0.3", "0.95 +- 0.1"])
def test_an_interval_that_no_contact_can_have_is_doubted(restitution):
    """gamma_n is infinite at e = 0 and 0 at e = 1: no slope holds from one end to the other."""
    result = calibrate("damping", *GIVEN[2:], "--restitution", restitution)
    assert result.code == 0
    assert "reaches beyond 0 or 1" in result.out
    assert "reaches beyond" not in calibrate("damping", *GIVEN).out


def test_the_report_of_a_file_in_the_making(tmp_path):
    new = tmp_path / "new.toml"
    calibrate("damping", "--into", new, "--pair", "wood-steel", *GIVEN)
    result = calibrate("report", new)
    assert "a simulator still needs [material.steel] density; [material.wood]" in result.out
    assert "[pair.wood-wood.linear] kn, kt, gamma_n, gamma_t" in result.out


@pytest.mark.parametrize("name", data_names("materials"))
def test_shipped_tables_can_be_reported(name):
    result = calibrate("report", name)
    assert result.code == 0, result.err
    assert "no source given" not in result.out


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ([], "--restitution is missing; give it, or --materials FILE and --pair A-B"),
        (["--materials", "wood"], "wood: say which pair is meant, such as --pair wood-steel"),
        (
            ["--materials", "wood", "--pair", "wood-steel"],
            "no restitution of pair wood-steel; give --restit",
        ),
        (
            ["--materials", "glass", "--pair", "glass-glass", *GIVEN[2:]],
            "no restitution of pair glass-glass; give",
        ),
        ([*WOOD, "--mass", "1 g"], "give one of --mass '10.8 g +- 6 %' and"),
        ([*WOOD, "--contacts", "0"], "--contacts 0: must be at least 1"),
        ([*WOOD, "--restitution", "1.2"], "restitution = 1.2: must be above 0 and at most 1"),
        ([*WOOD, "--restitution", "0.5 +- 2 g"], "--restitution, uncertainty = '2 g': the unit"),
        ([*WOOD, "--restitution", "1e-100"], "restitution 1e-100, kn 1e+07 N/m and reduced mass"),
        ([*GIVEN, "--wall", "--other-mass", "1 g"], "--wall does not move: leave out"),
        ([*GIVEN[:4], "--mass", "0 g"], "--mass = '0 g': must be above 0"),
        ([*GIVEN[:4], "--area", "200 mm2"], "--area needs the density and length of"),
        ([*GIVEN, "--into", "t.toml"], "--into t.toml: say of which pair: --pair wood-steel"),
        ([*GIVEN, "--into", "t.mp4", "--pair", "a-b"], "t.mp4: no parameter file; give"),
        ([*GIVEN, "--into", "t.toml", "--pair", "ab"], "'pair.ab': no section"),
        ([*GIVEN, "--contact-end", "never"], "Invalid value for '--contact-end'"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(arguments, line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = calibrate("damping", *arguments)
    assert_refused(result, line)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("pairs", "line"),
    [
        (["wood"], "[pair.wood] a pair is named by two materials"),
        (["wood-steel-wood"], "[pair.wood-steel-wood] a pair is named by two materials"),
        (["wood-"], "a pair is named by two materials"),
        (["wood-steel", "steel-wood"], "is given again as steel-wood; leave one out"),
    ],
)
def test_pairs_named_wrongly_or_twice_are_not_reported(pairs, line, tmp_path):
    """As a simulator refuses them; one of two entries would count, and nobody knows which."""
    file = tmp_path / "new.toml"
    tables = "".join(f"[pair.{names}]\nfriction = 0.3\n" for names in pairs)
    file.write_text(f"schema = 1\n{tables}", encoding="utf-8")
    assert_refused(calibrate("report", file), line)


def test_a_file_that_is_not_there_cannot_be_reported():
    result = calibrate("report", "wod")
    assert result.code == 2
    assert "did you mean 'wood'?" in result.err


# Quantities with their uncertainty


@pytest.mark.parametrize(
    ("text", "unit", "value", "sigma"),
    [
        ("10.8 g +- 0.3 g", "kg", 10.8e-3, 0.3e-3),
        ("10.8 +- 0.3 g", "kg", 10.8e-3, 0.3e-3),
        ("10.8 g ± 300 mg", "kg", 10.8e-3, 0.3e-3),
        ("1e4 N/mm +/- 18 %", "N/m", 1e7, 1.8e6),
        ("0.53 +- 0.02", "1", 0.53, 0.02),
        ("0.5 +- 4%", "1", 0.5, 0.02),
        ("-2 mm +- 5 %", "m", -2e-3, 1e-4),
    ],
)
def test_quantities_with_uncertainty(text, unit, value, sigma):
    found = measured_quantity(text, unit, "x")
    assert (found.value, found.sigma) == pytest.approx((value, sigma), rel=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "+-",
        "1 g +-",
        "1 g +- 2 g +- 3 g",
        "1 +- 2",
        "1 g +- -2 g",
        "1 g +- 2 mm",
        "g",
        "53 % +- 2 %",
    ],
)
def test_what_is_no_quantity_is_refused(text):
    with pytest.raises(InputError, match="x"):
        measured_quantity(text, "kg", "x")


@settings(deadline=None)
@given(text=st.text("0123456789.+-±%eE mg/", max_size=15))
def test_any_text_is_read_or_refused(text):
    with contextlib.suppress(InputError):
        found = measured_quantity(text, "kg", "x")
        assert found.sigma is None or found.sigma >= 0


@pytest.mark.parametrize(
    ("value", "sigma", "shown"),
    [
        (12054.9, 693.0, "12050 +- 690"),
        (0.530012, 0.0201, "0.530 +- 0.020"),
        (650.0, 400.0, "650 +- 400"),
        (0.38, None, "0.38"),
        (1.5e-9, 1e-10, "1.50e-09 +- 1e-10"),
        (0.75000015, 6.3e-7, "0.75000015 +- 6.3e-07"),
    ],
)
def test_a_value_is_shown_as_far_as_it_is_known(value, sigma, shown):
    assert plus_minus(value, sigma) == shown
