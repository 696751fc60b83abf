"""Two runs compared: the distance of curves, the table, the picture, bad input."""

from pathlib import Path

import numpy as np
import pytest
from fake_run import write_fake_run
from small_silo import silo2d, write_case

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.errors import FolderError
from silo2d.view.compare import compare, curve_distance, mean_distance

TIMES = np.array([0.1, 0.2, 0.4, 0.8])


def test_a_curve_that_lags_by_a_time_is_that_far_away():
    """t_2(n) = t_1(n) + tau: mean, largest and signed distance are tau."""
    for tau in (0.05, -0.05):
        found = curve_distance(TIMES, TIMES + tau)
        assert found == pytest.approx(
            {"counts": 4, "mean_s": 0.05, "max_s": 0.05, "later_s": tau}, rel=1e-12
        )


def test_a_curve_that_is_slower_by_a_factor():
    """t_2(n) = c t_1(n): the mean is (c - 1) of the mean time, the largest of the last."""
    found = curve_distance(TIMES, 1.1 * TIMES)
    assert found["mean_s"] == pytest.approx(0.1 * TIMES.mean())
    assert found["max_s"] == pytest.approx(0.1 * 0.8)


def test_early_and_late_do_not_cancel_in_the_distance():
    """They do in the lag."""
    found = curve_distance(TIMES, TIMES + 0.02 * np.array([1, -1, 1, -1]))
    assert found["mean_s"] == pytest.approx(0.02)
    assert found["later_s"] == pytest.approx(0.0, abs=1e-15)


def test_only_counts_that_both_reach_are_compared():
    """One that clogs after two particles is compared over two; one without any, over none."""
    found = curve_distance(TIMES, TIMES[:2] + 0.01)
    assert found["counts"] == 2
    assert found["max_s"] == pytest.approx(0.01)
    assert curve_distance(TIMES, np.array([])) is None
    nothing, something = {"curve": None}, {"curve": found}
    assert mean_distance([nothing]) is None
    assert mean_distance([nothing, something, something]) == pytest.approx(found)


def test_a_run_compared_with_itself_is_no_distance_away(reference):
    """And starts where it starts; what it found stands in its summary."""
    found = compare(reference.path, reference.path)
    assert found["curve"]["max_s"] == 0.0
    assert found["start_offset_m"] == 0.0
    summary = reference.read_summary()
    for row in found["runs"]:
        assert row["label"] == "dem, 10 us"
        assert row["discharge_time_s"] == summary["discharge_time_s"]
        cpu = summary["cpu_us_per_step"] * summary["steps"]
        assert row["discharge_cpu_s"] == pytest.approx(1e-6 * cpu)
        assert row["wall_s"] > 0


def test_engines_are_compared_on_the_same_packing(reference, runs, tmp_path):
    """One table, one picture; of the two folders, the same numbers again."""
    case = write_case(tmp_path)
    arguments = ["--engines", "dem,pymunk", case, "-o", runs, "--quiet"]
    result = silo2d("compare", *arguments, "--json")
    (pair,) = result.json["pairs"]
    assert [row["engine"] for row in pair["runs"]] == ["dem", "pymunk"]
    assert [row["label"] for row in pair["runs"]] == ["dem, 10 us", "pymunk, 30 x 0.25 ms"]
    assert result.json["mean_curve"] == pair["curve"]
    law, impulses = (read_trajectory(row["run_folder"])["out_time"][-1] for row in pair["runs"])
    apart = np.sort(impulses) - np.sort(law)
    assert pair["curve"]["mean_s"] == pytest.approx(np.abs(apart).mean())
    picture = result.err.strip()
    assert picture.endswith(".png")
    folders = [row["run_folder"] for row in pair["runs"]]
    assert picture.startswith(folders[0])
    again = silo2d("compare", *folders, "--json", "--no-figures")
    assert again.json["pairs"] == [pair]
    assert again.err == ""
    text = silo2d("compare", *folders, "--no-figures").out
    n = len(law)  # goes by the processor
    words = ("dem, 10 us", "pymunk, 30 x 0.25 ms", f"{n}/{n}", "apart in the mean", f"{n} counts")
    for word in words:
        assert word in text
    first, second = text.splitlines()[:2]
    assert first.startswith(f"1 {Path(folders[0]).name}; run.engine dem")
    assert second.startswith(f"2 {Path(folders[1]).name}; run.engine pymunk")


def test_engines_run_the_seed_of_the_case(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(
        "silo2d.baseline.comparison.run_engines",
        lambda case, changes, pair, seeds, *others: asked.append(list(seeds)) or [],
    )
    case = write_case(tmp_path, {"run.seed": 7})
    silo2d("compare", "--engines", "dem,pymunk", case, "-o", tmp_path / "runs", "--quiet")
    assert asked == [[7]]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["A4"], "give two run folders; or --engines"),
        (["--engines", "dem,pymunk", "A4", "A3"], "compares the runs of one case; give one"),
        (["--engines", "dem,bullet", "A4"], "no engine 'bullet'"),
        (["--engines", "dem,dem", "A4"], "give two that differ"),
        (["--engines", "dem", "A4"], "give two that differ"),
        (
            ["--engines", "dem,pymunk", "A4", "--engine", "dem"],
            "--engine: not taken here; give --engines",
        ),
        (["--engines", "dem,pymunk", "A4", "--seeds", "0"], "--seeds"),
        (["--seeds", "2", "A", "B"], "give two run folders; or --engines"),
        (["nowhere", "elsewhere"], "not a run folder"),
    ],
)
def test_bad_comparisons_are_refused_in_one_line(arguments, words, tmp_path, monkeypatch):
    """With what would do; nothing is run."""
    monkeypatch.chdir(tmp_path)
    result = silo2d("compare", *arguments)
    assert result.code == 2
    assert words in result.err
    assert len(result.err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_is_not_finished_or_is_damaged_is_refused(reference, finished, tmp_path):
    """It has no results; the message says how to get them."""
    unfinished = write_fake_run(tmp_path / "unfinished", finished=False)
    with pytest.raises(FolderError, match="not finished; go on with: silo2d run --resume"):
        compare(reference.path, unfinished.path)
    (summary,) = finished.glob("*/summary.json")
    run = RunFolder(summary.parent)
    kept = run.read_summary()
    del kept["t90_s"]
    run.write_summary(kept)
    with pytest.raises(FolderError, match=r"summary\.json: damaged \(no t90_s\); use --again"):
        compare(reference.path, summary.parent)
