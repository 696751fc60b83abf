"""The command damper3d run on a small damper: stdout and stderr, what it reuses, what it writes."""

from pathlib import Path

import pytest
from small_damper import KEYS, damper3d
from small_silo import contents


@pytest.fixture
def finished(damper_folder) -> Path:
    """A folder with the case and its finished run; tests of this file add to it."""
    return damper_folder


def test_a_run_says_its_case_and_its_efficiency(damper_root):
    said = (damper_root / "said.txt").read_text(encoding="utf-8")
    assert said.startswith("20 of sphere:5mm, vertical, 80 Hz, gamma 10, seed 1: efficiency")


def test_a_finished_run_is_given_again_and_nothing_changes(finished):
    """One JSON object on stdout, with the keys that scripts rely on; the echo is on stderr."""
    before = contents(finished)
    result = damper3d("run", finished / "small.toml", "-o", finished / "runs", "--json",
                      "--no-figures")  # fmt: skip
    table = result.json
    assert table["reused"]
    assert table.keys() >= KEYS
    assert (table["n_particles"], table["seed"]) == (20, 1)
    assert len(table["efficiency_per_cycle"]) == table["cycles"] == 4
    assert table["steps"] * table["time_step_s"] == pytest.approx(4 / 80, rel=1e-12)
    mean = sum(table["efficiency_per_cycle"][table["discarded"] :]) / 2
    assert mean == pytest.approx(table["efficiency"], rel=1e-12)
    assert "time step" in result.err
    assert contents(finished) == before


def test_efficiency_and_power_are_of_the_same_energy(finished):
    """eta 4 V^2 M / T = power: eqs 6.8-6.10 with M of all particles."""
    table = damper3d("run", finished / "small.toml", "-o", finished / "runs", "--json", "--quiet",
                     "--no-figures").json  # fmt: skip
    speed = 10 * 9.81 / (2 * 3.141592653589793 * 80)
    power = table["efficiency"] * 4 * speed**2 * table["mass_kg"] * 80
    assert table["dissipated_power_w"] == pytest.approx(power, rel=1e-12)
    assert table["mass_kg"] == pytest.approx(20 * table["particle_mass_kg"], rel=1e-14)


def test_again_computes_the_same_bits_in_a_new_folder(finished):
    """In a folder -2, from the same packing."""
    first = damper3d("run", finished / "small.toml", "-o", finished / "runs", "--json", "--quiet",
                     "--no-figures").json  # fmt: skip
    second = damper3d("run", finished / "small.toml", "-o", finished / "runs", "--json", "--quiet",
                      "--no-figures", "--again").json  # fmt: skip
    assert not second["reused"]
    assert second["run_folder"] == f"{first['run_folder']}-2"
    assert second["state_digest"] == first["state_digest"]
    assert len(list((finished / "runs" / "packings").glob("*/packing.h5"))) == 1


def test_a_run_leaves_its_case_and_list_and_show_find_it(finished):
    """case.toml and the materials next to it are the same run, wherever they lie."""
    run = next((finished / "runs").glob("small-seed1-*"))
    for name in ("case.toml", "materials.toml", "provenance.json", "summary.json", "trajectory.h5"):
        assert (run / name).is_file()
    listed = damper3d("list", "-o", finished / "runs").out
    _, _, line = " ".join(listed.split()).partition(f"run {run}: ")
    for word in ("20 of sphere:5mm", "vertical", " Hz, gamma ", ": efficiency 0."):
        assert word in line
    assert "packings   " in listed
    assert "seed 1: efficiency" in damper3d("show", run).out
    resumed = damper3d("run", "--resume", run, "--json", "--quiet", "--no-figures").json
    assert resumed["reused"]


def test_only_the_summary_is_kept_where_that_is_requested(finished):
    table = damper3d("run", finished / "small.toml", "-o", finished / "runs", "--json", "--quiet",
                     "--keep", "summary").json  # fmt: skip
    left = {path.name for path in Path(table["run_folder"]).iterdir()} - {".lock"}
    assert left == {"case.toml", "materials.toml", "provenance.json", "summary.json"}


def test_a_run_leaves_pictures(finished):
    result = damper3d("run", finished / "small.toml", "-o", finished / "runs", "--json")
    assert "drawing" in result.err
    figures = Path(result.json["run_folder"]) / "figures"
    assert {"cycle.png", "energy.png", "motion.png"} <= {path.name for path in figures.iterdir()}
    again = damper3d("run", finished / "small.toml", "-o", finished / "runs", "--json")
    assert "drawing" not in again.err
