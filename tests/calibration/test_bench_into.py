"""Results of the bench in the parameter file that the simulators read."""

import tomllib

import pytest
from bench_calls import write
from calibrating import calibrate
from refusals import assert_refused

from granulab.contact.files.datafile import data_root

MARKERS = data_root() / "published" / "interface_markers.csv"


def test_kt_of_the_rough_surface_goes_into_the_file(tmp_path):
    """Sec. 3.2.2: kt = 0.065 kn = 650 N/mm with kn = 1e4 N/mm; the file rounds to sigma's third
    digit. 18 % of kn and the markers' own sigma add as squares.
    """
    file = tmp_path / "wood.toml"
    options = ["--group", "surface", "--only", "rough", "--constant", "kn=1e4 N/mm +- 18 %"]
    result = calibrate(
        "interface", MARKERS, *options, "--into", file, "--pair", "wood-wood", "--json"
    )
    assert result.code == 0, result.err
    kt, ratio = result.json["kt_n_per_m"], result.json["kt_over_kn"]
    assert round(kt["value"], -4) == 650e3
    assert kt["sigma"] == pytest.approx(
        1e7 * (ratio["sigma"] ** 2 + (0.18 * ratio["value"]) ** 2) ** 0.5, rel=1e-9
    )
    written = tomllib.loads(file.read_text())["pair"]["wood-wood"]["linear"]["kt"]
    assert (written["value"], written["trials"], written["method"]) == ("646 N/mm", 6, "interface")
    assert written["source"] == "interface_markers.csv"


@pytest.mark.parametrize(
    ("command", "head", "rows", "where", "key"),
    [
        ("incline", "angle_deg", [[20, 21]], ["--pair", "wood-wood"], "friction"),
        ("density", "mass_g;volume_cm3", [[2.7, 2.6], [6, 6]], ["--material", "wood"], "density"),
        (
            "slide", "terminal_velocity_m_s;incline_deg;friction",
            [[0.4, 0.5], [30] * 2, [0.4] * 2], ["--pair", "wood-wood"], "gamma_t",
        ),
    ],
)  # fmt: skip
def test_each_method_writes_its_own_property(tmp_path, command, head, rows, where, key):
    table, file = write(tmp_path / "t.csv", head, rows), tmp_path / "wood.toml"
    result = calibrate(command, table, "--into", file, *where)
    assert result.code == 0, result.err
    assert f"\n{key} = {{ value =" in file.read_text()


def test_what_was_not_measured_is_not_written(tmp_path):
    """One line, and no file."""
    file = tmp_path / "wood.toml"
    for options, line in (
        (["--into", file, "--pair", "wood-wood"], "no kt: its columns or constants are missing"),
        (["--into", file], "say of which pair"),
        (["--only", "smooth", "--group", "surface"], "--only smooth: no such group"),
        (["--only", "rough"], "--only rough: the trials are not in groups; name the column"),
    ):
        result = calibrate("interface", MARKERS, *options)
        assert result.code == 2
        assert line in result.err
        assert result.err.count("\n") == 1
    assert not file.exists()


def test_a_mean_over_pairs_is_not_written_into_one_of_them(tmp_path):
    """Wood on wood and wood on steel have no friction in common; --only says which is meant."""
    table, into = tmp_path / "t.csv", tmp_path / "m.toml"
    table.write_text("angle [deg],pairing\n20,wood-wood\n21,wood-wood\n12,wood-steel\n")
    where = ["--into", into, "--pair", "wood-wood"]
    assert_refused(calibrate("incline", table, *where), "wood-wood and wood-steel", "--only")
    assert not into.exists()
    assert calibrate("incline", table, *where, "--only", "wood-wood").code == 0
