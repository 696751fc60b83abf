"""Response of a structure from simulations with its bed: points, table, picture, resume."""

import csv
import json
import math

import pytest
from refusals import assert_refused
from small_damper import damper3d, write_damper

from damper3d.studies.field.simulated import response_cases

FORCED = {
    "host.mass": "0.1 kg", "host.frequency": 80.0, "host.damping_ratio": 0.02, "host.force": "2 N",
    "motion.gamma": None, "motion.frequency": None,
}  # fmt: skip


def respond(path, out, *words):
    return damper3d("response", path, *words, "--out", out, "--quiet", "--workers", 1)


def test_simulated_points_are_runs_of_the_host_that_are_not_done_again(tmp_path):
    """Two levels at two frequencies; bare F/|k - w^2 M + i w c|; a run of the case is the same."""
    path, out = write_damper(tmp_path, FORCED), tmp_path / "runs"
    asked = ("--simulate", "--frequencies", "70,80", "--levels", "1,2")
    done = respond(path, out, *asked, "--json")
    assert done.code == 0, done.err
    found = json.loads(done.out)["simulated"]
    assert [(one["level"], one["frequency_hz"]) for one in found] == [
        (1, 70), (1, 80), (2, 70), (2, 80),
    ]  # fmt: skip
    k, zeta = 0.1 * (2 * math.pi * 80) ** 2, 0.02
    assert found[1]["bare_amplitude_m"] == pytest.approx(2 / (2 * zeta * k))
    assert found[3]["bare_amplitude_m"] == pytest.approx(2 * found[1]["bare_amplitude_m"])
    assert all(0 < one["amplitude_m"] < 0.02 for one in found)
    alone = damper3d("run", path, "--host-frequency", 80, "--out", out, "--json", "--quiet",
                     "--no-figures", "--cycles", 4)  # fmt: skip
    amplitude = json.loads(alone.out)["host"]["amplitude_m"]
    assert found[1]["amplitude_m"] == pytest.approx(amplitude, rel=1e-12)
    with (out / "response-small-simulated.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert float(table[3]["amplitude_m"]) == found[3]["amplitude_m"]
    assert (out / "response-small.png").stat().st_size > 10_000
    again = respond(path, out, *asked, "--levels", "1,2,0.5", "--no-figures")
    assert "6 runs (4 were there)" in again.out


def test_a_steady_run_is_judged_when_its_start_is_forgotten(tmp_path):
    """exp(-2 pi zeta n f0/f) = 0.01; cycles that the case gives stay as they are."""
    by_itself = {"run.cycles": None, "run.discard": None}
    ((_, case),) = response_cases(str(write_damper(tmp_path, FORCED | by_itself)), [1.0], [40.0])
    assert case.settings.run.steady
    assert case.settings.run.discard == math.ceil(math.log(100) / (2 * math.pi * 0.02) * 40 / 80)
    assert case.settings.run.max_cycles > case.settings.run.discard + 20
    ((_, given),) = response_cases(str(write_damper(tmp_path, FORCED)), [1.0], [40.0])
    assert (given.settings.run.cycles, given.settings.run.discard) == (4, 2)


def test_a_host_s_response_says_its_cost_and_its_map_is_refused(tmp_path):
    """A map sets the motion that a host would find; the refusal names the command to give."""
    path, out = write_damper(tmp_path, FORCED), tmp_path / "runs"
    said = respond(path, out, "--simulate", "--frequencies", "70,80", "--dry-run")
    assert said.out.startswith("2 runs of 1 packings, about "), said.err
    assert not out.exists()
    mapped = damper3d("map", path, "--frequencies", "70", "--gammas", "5", "--out", out)
    assert_refused(mapped, "[host] moves", f"damper3d response {path} --simulate")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "give --field TABLE"),
        (["--simulate"], "give --frequencies 38,40,42"),
        (["--frequencies", "40"], "those of --simulate"),
        (["--simulate", "--frequencies", "40", "--between", "30,50"], "give --field TABLE too"),
        (["--simulate", "--frequencies", "40,0"], "frequencies: 0: must be above 0"),
    ],
)
def test_a_response_that_is_not_said_is_refused_in_one_line(words, said, tmp_path):
    path = write_damper(tmp_path, FORCED)
    assert_refused(damper3d("response", path, *words, "--out", tmp_path / "runs"), said)


def test_a_case_that_nothing_shakes_steadily_has_no_response(tmp_path):
    let_go = {"host.force": None, "host.start_displacement": "1 mm"}
    path = write_damper(tmp_path, FORCED | let_go)
    asked = ("--simulate", "--frequencies", "40")
    assert_refused(damper3d("response", path, *asked, "--out", tmp_path / "runs"), "let go")
