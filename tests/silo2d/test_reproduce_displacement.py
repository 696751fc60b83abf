"""Displacement profiles over seeds: rows from run folders, the table, the checked statements."""

import json

import numpy as np
import pytest
from moved_run import falling, write_moved_run

from granulab.campaign.output.figure import write_figure
from granulab.campaign.output.layout import done
from silo2d.case.outline import preset
from silo2d.reproduce import displacement

DEEP = {"A4": 0.1, "D4": 0.2}  # m/s: how much faster the middle falls than the walls
SEEDS = 2


@pytest.fixture(scope="module")
def rows(tmp_path_factory) -> list[dict]:
    """Two seeds of both silos, falling as parabolas of half a metre a second at most; a failure."""
    root, found = tmp_path_factory.mktemp("moved"), []
    for silo, deep in DEEP.items():
        for seed in range(1, SEEDS + 1):
            folder = root / f"{silo}-{seed}"

            def motion(start, time, deep=deep):
                return falling(start, time, 0.1 + deep * (1 - (start[:, 0] / 0.15) ** 2))

            write_moved_run(folder, motion, silo=preset(silo), n_frames=27, spacing=0.014)
            run = {"silo": silo, "seed": seed, "state": "done", "reason": "", "outcome": "empty",
                   "n_particles": 600, "n_out": 600 if silo == "A4" else 580,
                   "discharge_time_s": 1.0, "run_folder": str(folder)}  # fmt: skip
            found += displacement.rows_of(run)
    failed = {"silo": "D4", "seed": 3, "state": "failed", "reason": "the disk is full"}
    return [*found, *displacement.rows_of(failed)]


def test_rows_are_those_of_the_profile(rows):
    """Every layer at 0 and 0.25 s; the parabola's depth to its bins (see test_measure_profile).

    The side columns' particles stand some 4 mm further in than the columns' middles: 0.88 of the
    whole depth, to 5 %.
    """
    json.dumps(rows, allow_nan=False)
    for silo, deep in DEEP.items():
        own = [row for row in done(rows) if row["silo"] == silo and row["seed"] == 1]
        assert {row["time_s"] for row in own} == {0.0, 0.25}
        depth = {(row["time_s"], row["layer"]): row["depth_m"] for row in own}
        assert depth[0.0, 8] == pytest.approx(0.0, abs=1e-5)  # rows are rounded to 0.01 mm
        assert depth[0.25, 8] == pytest.approx(0.25 * deep * (132.5 / 150) ** 2, rel=0.05)
        line = next(row for row in own if (row["time_s"], row["layer"]) == (0.25, 8))
        columns = [line[f"y{k}_m"] for k in range(1, 12)]
        assert line["level_m"] == pytest.approx(np.mean(columns), abs=1e-5)


def test_report_gives_mean_and_spread_over_the_seeds(rows):
    """Both seeds are alike here: 20 mm in A4 and 39 mm in D4, with an sd of 0; and the failure."""
    text = displacement.report(rows)
    lines = [line for line in text.splitlines() if line.startswith("layer 8")]
    assert len(lines) == len(DEEP)
    for line, deep in zip(lines, DEEP.values(), strict=True):
        depth, _, spread = line.split()[2:5]
        assert float(depth) == pytest.approx(1e3 * 0.25 * deep * (132.5 / 150) ** 2, rel=0.06)
        assert spread == "0"
    assert "failed: D4, seed 3: the disk is full" in text


def test_claims_of_the_paper_are_checked(rows):
    """V shapes in both, the deeper in D4 wherever both have one; A4 empties and D4 does not.

    Shear alone scatters displacements alike at all heights: mixing does not follow from these.
    """
    text = displacement.report(rows)
    assert "  PASS  A4  of " in text
    assert "  PASS  A4  0 of 600 particles stay" in text
    assert "  PASS  D4  20 of 600 particles stay" in text
    (verdict,) = [line for line in text.splitlines() if " cases, by " in line]
    deeper, _, cases = verdict.split()[:3]
    assert deeper == cases


def test_flat_lines_do_not_agree_with_a_v(rows):
    """The claim can fail: depths of nought."""
    flat = [{**row, "depth_m": 0.0} if row.get("depth_m") else row for row in rows]
    assert "  FAIL  A4  of " in displacement.report(flat)


def test_picture(rows, tmp_path):
    """A row of panels for each silo, also with a run that failed among them."""
    picture = write_figure(tmp_path / "d.png", lambda: displacement.draw(rows))
    assert picture.stat().st_size


def test_both_silos_are_run_with_every_seed(monkeypatch, tmp_path):
    """The cases that the sweep is given, and rows of runs that it could not do."""
    sweep = pytest.importorskip("silo2d.run.sweep")
    requested = []

    def run_cases(cases, **options):
        requested.extend((labels, case.name, case.settings.run.seed) for labels, case in cases)
        return [{**labels, "state": "interrupted", "reason": "Ctrl-C"} for labels, _ in cases]

    monkeypatch.setattr(sweep, "run_cases", run_cases)
    rows = displacement.run(out=tmp_path, seeds=[1, 2], workers=1, quiet=True)
    assert [(name, seed) for _, name, seed in requested] == [
        ("A4", 1), ("A4", 2), ("D4", 1), ("D4", 2)
    ]  # fmt: skip
    assert {row["state"] for row in rows} == {"interrupted"}
    assert "interrupted: A4, seed 1: Ctrl-C" in displacement.report(rows)
    assert displacement.draw(rows)
