"""calibrate inverse with simulators: a known value found again, kept runs, refusals."""

import csv
import re
import tomllib
from pathlib import Path

import calibrating
import pytest
from small_damper import write_damper
from small_silo import write_case

from calibration.inverse import campaign_runs
from campaign.sweep import Task, run_labelled
from damper3d.case import DamperCase
from damper3d.protocol import run

# Twenty cycles that count: the efficiency scatters by 4 % from one packing to the next.
BED = {"output.keep": "summary", "output.frames": 0, "run.cycles": 22, "run.discard": 2}
TRUTH, TRIALS = 0.3, 12
FIT = """
schema = 1
simulator = "damper3d"
case = "small.toml"
seeds = 2
runs = 24
[settings]
law.restitution = 0.6
[parameters]
law.friction = { distribution = "uniform", min = 0.02, max = 2.0 }
[[observation]]
kind = "eta"
file = "eta.csv"
trials = 12
"""
SILO_FIT = """
schema = 1
simulator = "silo2d"
case = "small.toml"
seeds = 2
runs = 16
[parameters]
"law.mu_particle, law.mu_wall" = { distribution = "uniform", min = 0.1, max = 0.4 }
[[observation]]
kind = "curve"
file = "curve.csv"
[[observation]]
kind = "discharge_time"
value = "0.31 s"
sigma = "10 ms"
"""


@pytest.fixture
def here(monkeypatch):
    """Runs in this process, which has the kernels: new workers would load them again."""

    def run_here(simulator, cases, *, out, **engine):
        for _, case in cases:
            if simulator.run_folder(case, out).state != "finished":
                simulator.work(Task(case, out, packing_only=False), lambda: False)
        return run_labelled(simulator, cases, out=out, quiet=True)

    monkeypatch.setattr(campaign_runs, "run_labelled", run_here)


@pytest.fixture(scope="module")
def damper(tmp_path_factory):
    """A fit file with the mean efficiency of packings of a known friction, sigma 0.5 %."""
    folder = tmp_path_factory.mktemp("damper")
    case = write_damper(folder, BED)
    changes = {"law.friction": TRUTH, "law.restitution": 0.6}
    found = [
        run(
            DamperCase.load(case, changes | {"run.seed": 1000 + k}), out=folder / "truth"
        ).efficiency
        for k in range(TRIALS)
    ]
    mean = sum(found) / TRIALS
    (folder / "eta.csv").write_text(
        f"frequency [Hz],gamma,eta,sigma\n80,10,{mean},{0.005 * mean}\n"
    )
    (folder / "fit.toml").write_text(FIT)
    return folder


def test_a_known_friction_is_found_again_within_the_stated_interval(damper, here):
    """95 % of such fits hold the truth in two of the stated half intervals."""
    folder = damper
    done = calibrating.calibrate(
        "inverse", folder / "fit.toml", "-o", folder / "runs", "--json", "--quiet"
    )
    answer = done.json
    (found,) = answer["parameters"]
    low, high = found["interval_68"]
    assert low < found["median"] < high
    assert abs(found["median"] - TRUTH) < high - low
    assert found["identifiable"]
    assert answer["goodness"]["reproducible"]
    assert answer["runs"] == {"total": 24, "passed": 24, "blocked": 0, "failed": 0}
    rows = list(csv.DictReader(Path(answer["table"]).read_text().splitlines()))
    assert len({row["seed"] for row in rows}) == 24  # each run has its own chance
    assert all(path.endswith(".png") for path in answer["figures"])
    assert len(answer["figures"]) == 3
    begun = {path: path.stat().st_mtime_ns for path in (folder / "runs").glob("*/summary.json")}
    again = calibrating.calibrate(
        "inverse", folder / "fit.toml", "-o", folder / "runs", "--json", "--no-figures"
    ).json
    assert again["parameters"] == answer["parameters"]
    assert begun == {path: path.stat().st_mtime_ns for path in begun}


def test_what_is_identifiable_is_written_into_a_parameter_file(damper, here):
    folder = damper
    calibrating.calibrate("inverse", folder / "fit.toml", "-o", folder / "runs", "--no-figures")
    table = folder / "bed.toml"
    again = calibrating.calibrate(
        "inverse", folder / "fit.toml", "-o", folder / "runs", "--no-figures", "--into", table,
        "--json",
    )  # fmt: skip
    (found,) = again.json["parameters"]
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
    done = calibrating.calibrate("inverse", folder / "wrong.toml", "-o", folder / "runs",
                                 "--no-figures", "--quiet")  # fmt: skip
    assert "CANNOT reproduce the observation" in done.out
    table = folder / "none.toml"
    refused = calibrating.calibrate("inverse", folder / "wrong.toml", "-o", folder / "runs",
                                    "--no-figures", "--quiet", "--into", table)  # fmt: skip
    assert refused.code == 2
    assert "cannot reproduce the observation" in refused.err
    assert not table.exists()


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


def test_a_silo_that_clogs_is_data(tmp_path, here):
    """Of the small silo some seeds clog: they are counted, and the others give times and curves."""
    write_case(tmp_path)
    (tmp_path / "curve.csv").write_text("time,fraction,sigma\n0.1,0.3,0.05\n0.2,0.7,0.05\n".replace(
        "time", "time [s]"))  # fmt: skip
    (tmp_path / "fit.toml").write_text(SILO_FIT)
    answer = calibrating.calibrate("inverse", tmp_path / "fit.toml", "-o", tmp_path / "runs",
                                   "--no-figures", "--json", "--quiet").json  # fmt: skip
    runs = answer["runs"]
    assert runs["passed"] + runs["blocked"] == runs["total"] == 16
    assert runs["blocked"] > 0
    rows = list(csv.DictReader(Path(answer["table"]).read_text().splitlines()))
    assert sum(row["outcome"].startswith("clogged") for row in rows) == runs["blocked"]
    assert [row["values"] for row in answer["observations"]] == [2, 1]


def test_interrupted_runs_end_with_130_and_keep_their_table(damper, monkeypatch):
    def stopped(simulator, cases, **engine):
        return [{**labels, "state": "interrupted", "reason": "stopped"} for labels, _ in cases]

    monkeypatch.setattr(campaign_runs, "run_labelled", stopped)
    done = calibrating.calibrate("inverse", damper / "fit.toml", "-o", damper / "cut", "--quiet")
    assert (done.code, done.out) == (130, "")
    assert "the same command goes on from there" in done.err
    (table,) = (damper / "cut").glob("inverse/fit-*/table.csv")
    assert "interrupted" in table.read_text()


def test_a_run_that_fails_is_a_row_with_its_reason(damper, here, monkeypatch):
    real = campaign_runs.run_labelled

    def first_fails(simulator, cases, **options):
        rows = real(simulator, cases, **options)
        if rows[0]["point"] == 0:
            labels = {k: rows[0][k] for k in ("point", "case", "seed")}
            rows[0] = {**labels, "state": "failed", "reason": "the books are off"}
        return rows

    monkeypatch.setattr(campaign_runs, "run_labelled", first_fails)
    done = calibrating.calibrate("inverse", damper / "fit.toml", "-o", damper / "runs",
                                 "--no-figures", "--quiet")  # fmt: skip
    assert done.code == 3
    assert "1 of 24 runs failed" in done.err
    assert "the first: the books are off" in done.out
