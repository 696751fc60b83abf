"""calibrate inverse with simulators: a known value found again, kept runs, refusals."""

import csv
import os
import re
import signal
import time
import tomllib
from pathlib import Path

import calibrating
import numpy as np
import pytest
from small_fit import FIT, TRUTH, run_here, write_fit
from small_silo import write_case

from calibration.inverse import fit as fits
from calibration.inverse.observation import Observation
from calibration.inverse.silo import SIMULATED
from silo2d.case.case import SiloCase
from silo2d.measures.profile import measure
from silo2d.run.protocol import run as run_silo

# Forty particles that come to rest soon, in layers of 15 mm: a run takes a quarter of a second.
SILO = {
    "fill.level": "30 mm",
    "fill.settled": 1e-2,
    "run.at_rest": 1e-3,
    "output.layer_height": "15 mm",
    "output.checkpoint_interval": "10 s",
}
OUTLET, PROFILES = 0.05, 6
SILO_FIT = """
schema = 1
simulator = "silo2d"
case = "small.toml"
seeds = 2
runs = 16
[parameters]
silo.outlet = { distribution = "uniform", min = "20 mm", max = "60 mm" }
[[observation]]
kind = "profile"
file = "profile.csv"
sigma = "1 mm"
trials = 6
"""


@pytest.fixture
def here(monkeypatch):
    monkeypatch.setattr(fits, "run_labelled", run_here)


@pytest.fixture(scope="module")
def damper(tmp_path_factory):
    """A fit file with the mean efficiency of packings of a known friction, sigma 0.5 %."""
    return write_fit(tmp_path_factory.mktemp("damper")).parent


@pytest.fixture(scope="module")
def whole(damper):
    """The result of the fit, made without a break."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fits, "run_labelled", run_here)
        done = calibrating.calibrate(
            "inverse", damper / "fit.toml", "-o", damper / "runs", "--json", "--quiet"
        )
    return done.json


def test_a_known_friction_is_found_again_within_the_stated_interval(whole):
    """997 of 1000 such fits hold the truth in three of the stated half intervals."""
    (found,) = whole["parameters"]
    low, high = found["interval_68"]
    assert low < found["median"] < high
    assert abs(found["median"] - TRUTH) < 1.5 * (high - low)
    assert found["identifiable"]
    assert whole["goodness"]["reproducible"]
    assert whole["runs"] == {"total": 24, "passed": 24, "blocked": 0, "failed": 0}
    rows = list(csv.DictReader(Path(whole["table"]).read_text().splitlines()))
    assert len({row["seed"] for row in rows}) == 24  # each run has its own chance
    assert all(path.endswith(".png") for path in whole["figures"])
    assert len(whole["figures"]) == 3


def test_a_fit_that_is_killed_goes_on_to_the_same_bits(damper, whole, here):
    """SIGKILL in the first and in the second round of points; what is done is not done again."""
    folder = damper / "killed"
    arguments = "inverse", damper / "fit.toml", "-o", folder, "--json", "--no-figures", "--quiet"
    for count in (5, 14):
        child = os.fork()
        if child == 0:
            try:
                calibrating.calibrate(*arguments)
            finally:
                os._exit(1)  # not reached: it is killed
        while len(done := list(folder.glob("*/summary.json"))) < count:
            time.sleep(1e-3)
        os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        assert os.waitstatus_to_exitcode(status) == -signal.SIGKILL
    begun = {path: path.stat().st_mtime_ns for path in done}
    assert len(begun) < 24
    again = calibrating.calibrate(*arguments).json
    assert begun == {path: path.stat().st_mtime_ns for path in begun}
    places = {"folder", "table", "figures"}
    assert {k: v for k, v in again.items() if k not in places} == {
        k: v for k, v in whole.items() if k not in places
    }
    timed = {"reused", "cpu_s", "cpu_us_per_step", "run_folder"}
    tables = [
        [{k: v for k, v in row.items() if k not in timed} for row in csv.DictReader(lines)]
        for lines in (Path(result["table"]).read_text().splitlines() for result in (again, whole))
    ]
    assert tables[0] == tables[1]


def test_what_is_identifiable_is_written_into_a_parameter_file(damper, whole, here):
    table = damper / "bed.toml"
    again = calibrating.calibrate(
        "inverse", damper / "fit.toml", "-o", damper / "runs", "--no-figures", "--into", table,
        "--json",
    )  # fmt: skip
    (found,) = again.json["parameters"]
    assert [found] == whole["parameters"]
    entry = tomllib.loads(table.read_text())["pair"]["acrylic-acrylic"]["friction"]
    assert entry["value"] == pytest.approx(found["mean"], abs=0.01)
    assert entry["sigma"] == pytest.approx(
        (found["interval_68"][1] - found["interval_68"][0]) / 2, rel=0.02
    )
    assert entry["method"] == "inverse"
    assert entry["source"] == "fit.toml, eta.csv; simulated by damper3d"
    assert "restitution" not in tomllib.loads(table.read_text())["pair"]["acrylic-acrylic"]


def test_what_the_simulator_cannot_make_is_said_and_not_written(damper, here):
    """An efficiency of 0.9 is far above what twenty spheres take."""
    folder = damper
    (folder / "wrong.csv").write_text("frequency,gamma,eta,sigma\n80,10,0.9,0.01\n")
    (folder / "wrong.toml").write_text(FIT.replace("eta.csv", "wrong.csv"))
    table = folder / "none.toml"
    refused = calibrating.calibrate("inverse", folder / "wrong.toml", "-o", folder / "runs",
                                    "--no-figures", "--quiet", "--into", table)  # fmt: skip
    assert refused.code == 2
    assert "cannot reproduce the observation" in refused.err
    assert not table.exists()
    (report,) = (folder / "runs").glob("inverse/wrong-*/report.txt")
    assert "CANNOT reproduce the observation" in report.read_text()


def test_a_parameter_that_no_file_holds_is_refused_before_the_work(damper):
    path = damper / "height.toml"
    prior = 'enclosure.height = { distribution = "uniform", min = "20 mm", max = "30 mm" }'
    path.write_text(re.sub(r"law.friction = .*", prior, FIT))
    done = calibrating.calibrate(
        "inverse", path, "-o", damper / "none", "--into", damper / "a.toml"
    )
    assert done.code == 2
    assert "enclosure.height is nothing that a parameter file holds" in done.err
    assert not (damper / "none").exists()


@pytest.fixture(scope="module")
def silo(tmp_path_factory):
    """The lines of both layers as `silo2d observe RUN profile` has them: of a run, and a fit file.

    The fit is to their mean over runs with an outlet of 50 mm.
    """
    folder = tmp_path_factory.mktemp("silo")
    case = write_case(folder, SILO)
    observed = []
    for k in range(PROFILES):
        changes = {"run.seed": 1000 + k, "silo.outlet": f"{OUTLET} m"}
        run_silo(SiloCase.load(case, changes), out=folder / f"truth{k}")
        (run_folder,) = (folder / f"truth{k}").glob("small-*")
        observed.append(measure(run_folder, interval=0.04))
    edges, times = np.array(observed[0]["column_edges_m"]), observed[0]["times_s"][1:3]
    lines = np.array(
        [[layer["lines_m"][1:3] for layer in one["layers"]] for one in observed], dtype=float
    ).mean(axis=0)  # (layers, times, columns), NaN where a run has no line
    middles = (edges[:-1] + edges[1:]) / 2
    rows = [
        f"{t},{k},{x},{lines[k, f, j]}"
        for k in range(2) for f, t in enumerate(times) for j, x in enumerate(middles)
        if np.isfinite(lines[k, f, j])
    ]  # fmt: skip
    (folder / "profile.csv").write_text("time [s],layer,x [m],y [m]\n" + "\n".join(rows) + "\n")
    (folder / "fit.toml").write_text(SILO_FIT)
    return folder, run_folder, observed[-1]


def test_a_profile_is_the_lines_that_the_run_is_observed_to_have(silo):
    """At the middles of columns the line itself; between two of them the mean; gone: the outlet."""
    _, run_folder, observed = silo
    edges, times = np.array(observed["column_edges_m"]), observed["times_s"]
    middles = (edges[:-1] + edges[1:]) / 2
    lower, upper = (np.array(layer["lines_m"], dtype=float) for layer in observed["layers"])
    known = [(times[1], 0, 2), (times[1], 1, 0), (times[2], 1, 3)]
    at = np.array([(t, k, middles[j]) for t, k, j in known]
                  + [(times[1], 1, edges[1]), (times[1], 7, 0.0)])  # fmt: skip
    nothing = np.zeros(len(at))
    requested = Observation("profile", (), nothing, nothing, 1, at, (), nothing, ("", ""))
    found = SIMULATED.kinds["profile"].of(requested, {"run_folder": str(run_folder)})
    expected = [lower[1, 2], upper[1, 0], upper[2, 3], (upper[1, 0] + upper[1, 1]) / 2, 0.0]
    assert found == pytest.approx(expected, abs=1e-12)
    assert lower[1, 2] < lower[0, 2] - 1e-3  # it has sunk by then


def test_an_outlet_is_found_again_from_a_profile_and_clogged_silos_are_data(silo, here):
    """95 % of such fits hold the truth in two of the stated half intervals; narrow outlets clog."""
    folder, _, _ = silo
    result = calibrating.calibrate("inverse", folder / "fit.toml", "-o", folder / "runs",
                                   "--no-figures", "--json", "--quiet").json  # fmt: skip
    runs = result["runs"]
    assert runs["passed"] + runs["blocked"] == runs["total"] == 16
    assert runs["blocked"] > 0
    rows = list(csv.DictReader(Path(result["table"]).read_text().splitlines()))
    assert sum(row["outcome"].startswith("clogged") for row in rows) == runs["blocked"]
    (found,) = result["parameters"]
    low, high = found["interval_68"]
    assert abs(found["median"] - OUTLET) < high - low
    assert found["identifiable"]
    assert result["goodness"]["reproducible"]


def test_interrupted_runs_end_with_130_and_keep_their_table(damper, monkeypatch):
    def stopped(simulator, cases, **engine):
        return [{**labels, "state": "interrupted", "reason": "stopped"} for labels, _ in cases]

    monkeypatch.setattr(fits, "run_labelled", stopped)
    done = calibrating.calibrate("inverse", damper / "fit.toml", "-o", damper / "cut", "--quiet")
    assert (done.code, done.out) == (130, "")
    assert "the same command goes on from there" in done.err
    (table,) = (damper / "cut").glob("inverse/fit-*/table.csv")
    assert "interrupted" in table.read_text()


def test_a_run_that_fails_is_a_row_with_its_reason(damper, whole, here, monkeypatch):
    real = fits.run_labelled

    def last_fails(simulator, cases, **options):
        rows = real(simulator, cases, **options)
        if rows[-1]["point"] == 11:  # of the last round: the points before are those of the fit
            labels = {k: rows[-1][k] for k in ("point", "case", "seed")}
            rows[-1] = {**labels, "state": "failed", "reason": "the energy balance is off"}
        return rows

    monkeypatch.setattr(fits, "run_labelled", last_fails)
    done = calibrating.calibrate("inverse", damper / "fit.toml", "-o", damper / "runs",
                                 "--no-figures", "--quiet")  # fmt: skip
    assert done.code == 3
    assert "1 of 24 runs failed" in done.err
    assert "the first: the energy balance is off" in done.out
