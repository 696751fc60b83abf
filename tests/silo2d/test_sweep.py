"""A sweep of small silos: the same bits on any engine, nothing done twice, nothing lost."""

import csv
import errno
import json
import os
import shutil
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import mock

import h5py
import numpy as np
import pytest
from analytic import wilson_interval
from read_page import element
from refusals import assert_refused
from small_silo import DRY, Completed, contents, finish, silo2d, start, write_case
from waiting import is_alive, wait_until

from granulab.campaign.runs import folder as campaign_folder
from granulab.campaign.runs.checkpoint import save_checkpoint
from granulab.campaign.runs.folder import RunFolder, write_json
from granulab.campaign.sweeps.sweep import without_again
from silo2d.case.case import SiloCase
from silo2d.run.numbers import MECHANISMS
from silo2d.run.sweep import run_cases

# A second of simulated time is more than these runs get: they end by their time limit.
BRIEF = {"run.max_time": "20 ms", "output.checkpoint_interval": "10 ms"}
STUDY = """
schema = 1
name = "walls"
case = "small.toml"
seeds = [1, 2]
[vary]
law.mu_wall = [0.1, 0.3]
"""


@pytest.fixture(scope="module")
def packings(_finished_root, tmp_path_factory) -> Path:
    """A folder of runs with the packings of seeds 1 and 2."""
    root = tmp_path_factory.mktemp("packings")
    shutil.copytree(_finished_root / "runs" / "packings", root / "packings")
    assert silo2d("packing", write_case(root), "--seed", 2, "-o", root, "--quiet").code == 0
    return root / "packings"


@pytest.fixture
def study(tmp_path, packings) -> Path:
    """A study of four brief runs, in a folder whose runs/ has their packings."""
    return make_study(tmp_path, packings)


def make_study(folder: Path, packings: Path, text: str = STUDY, **changes: Any) -> Path:
    shutil.copytree(packings, folder / "runs" / "packings")
    write_case(folder, BRIEF | changes)
    path = folder / "walls.toml"
    path.write_text(text, encoding="utf-8")
    return path


def sweep(study: Path, *options: object) -> Completed:
    """Run a study in the folder of its file."""
    return silo2d("sweep", study, "-o", study.parent / "runs", "--quiet", *options)


def rows_of(study: Path) -> list[dict[str, str]]:
    (table,) = study.parent.glob("runs/studies/walls-*/table.csv")
    return list(csv.DictReader(table.read_text().splitlines()))


def run_folders(study: Path) -> list[Path]:
    return sorted(path.parent for path in study.parent.glob("runs/*/case.toml"))


@pytest.fixture(scope="module")
def _swept_root(tmp_path_factory, packings) -> Path:
    """The study, swept by two workers."""
    root = tmp_path_factory.mktemp("swept")
    result = sweep(make_study(root, packings), "--workers", 2)
    assert result.code == 0, result.err
    return root


@pytest.fixture
def swept(_swept_root, tmp_path) -> Path:
    """A copy of the study with its finished runs."""
    shutil.copytree(_swept_root, tmp_path, dirs_exist_ok=True)
    return tmp_path / "walls.toml"


@pytest.fixture(scope="module")
def digests(_swept_root) -> list[str]:
    """State digests of the four runs."""
    found = [row["state_digest"] for row in rows_of(_swept_root / "walls.toml")]
    assert len(set(found)) == 4
    return found


# The same bits, and none twice


@pytest.mark.usefixtures("in_this_process")
def test_a_sweep_from_python_is_the_table_as_a_frame(swept, digests):
    """Runs that are there are taken; rows in the order of the command's table."""
    from silo2d import sweep as swept_from_python

    found = swept_from_python(swept, out=swept.parent / "runs", workers=1)
    assert list(found["state_digest"]) == digests
    assert list(found["seed"]) == [1, 2, 1, 2]
    assert set(found["state"]) == {"done"}


@pytest.mark.usefixtures("in_this_process")
def test_the_same_bits_as_alone_however_many_workers(study, digests):
    """None, as two, as `silo2d run`.

    One tidy table: a row a run, what was varied in its unit, results, state and reason.
    """
    case, root = study.parent / "small.toml", study.parent / "alone"
    shutil.copytree(study.parent / "runs", root)
    options = ["--mu-wall", 0.3, "--seed", 2, "-o", root, "--quiet", "--json", "--no-figures"]
    assert silo2d("run", case, *options).json["state_digest"] == digests[3]
    table = sweep(study, "--json").json
    assert (table["runs"], table["done"], table["failed"], table["reused"]) == (4, 4, 0, 0)
    rows = rows_of(study)
    assert [row["state_digest"] for row in rows] == digests
    assert [(row["law.mu_wall"], row["seed"]) for row in rows] == [
        ("0.1", "1"), ("0.1", "2"), ("0.3", "1"), ("0.3", "2"),
    ]  # fmt: skip
    assert {(row["case"], row["state"], row["reason"]) for row in rows} == {("small", "done", "")}
    means = table["combinations"]
    assert [row["law.mu_wall"] for row in means] == [0.1, 0.3]
    assert [row["runs"] for row in means] == [2, 2]


def test_the_same_bits_on_a_dask_cluster(study, digests, cluster):
    table = sweep(study, "--engine", "dask", "--scheduler", cluster, "--json").json
    assert (table["done"], table["reused"]) == (4, 0)
    assert [row["state_digest"] for row in rows_of(study)] == digests


def test_a_finished_run_is_not_done_again_by_anyone(swept):
    """Neither by the same sweep, nor by another study of it, nor by a single run."""
    study = swept
    before = {path: contents(path) for path in run_folders(study)}
    assert sweep(study, "--json").json["reused"] == 4
    study.write_text(STUDY.replace("[1, 2]", "[2, 1]"))
    assert sweep(study, "--json").json["reused"] == 4
    options = ["--mu-wall", "0.3", "-o", study.parent / "runs", "--json", "--quiet", "--no-figures"]
    assert silo2d("run", study.parent / "small.toml", *options).json["reused"]
    assert {path: contents(path) for path in run_folders(study)} == before
    tables = list(study.parent.glob("runs/studies/walls-*/table.csv"))
    assert len(tables) == 2  # each list of runs has its own


def test_hdf5_holds_what_csv_holds(swept):
    study = swept
    (path,) = study.parent.glob("runs/studies/walls-*/table.h5")
    rows = rows_of(study)
    with h5py.File(path) as file:
        assert list(file) == list(rows[0])
        for name, column in file.items():
            texts = [row[name] for row in rows]
            if column.dtype.kind == "f":
                np.testing.assert_array_equal(column, [float(text or "nan") for text in texts])
            elif column.dtype.kind == "i":
                np.testing.assert_array_equal(column, [int(text) for text in texts])
            elif column.dtype.kind == "b":
                assert [str(x).lower() for x in column[()].tolist()] == texts
            else:
                assert column.asstr()[()].tolist() == texts


@pytest.mark.usefixtures("in_this_process")
def test_the_same_case_twice_is_run_once(tmp_path, packings):
    make_study(tmp_path, packings)
    case = SiloCase.load(tmp_path / "small.toml")
    rows = run_cases(
        [({"name": "a"}, case), ({"name": "b"}, case)], out=tmp_path / "runs", workers=1, quiet=True
    )
    assert [row["name"] for row in rows] == ["a", "b"]
    assert [row["state"] for row in rows] == ["done", "done"]
    assert rows[0]["state_digest"] == rows[1]["state_digest"]
    assert set(MECHANISMS) == {key[13:] for key in rows[0] if key.startswith("dissipated_j.")}


def test_a_packing_that_runs_share_is_poured_once(tmp_path):
    """Three runs and two workers, no packing there: one filling, and all runs from it."""
    write_case(tmp_path, BRIEF)
    text = STUDY.replace("[1, 2]", "1").replace("[0.1, 0.3]", "[0.1, 0.2, 0.3]")
    study = tmp_path / "walls.toml"
    study.write_text(text)
    planned = sweep(study, *DRY, "--json").json
    assert planned["packings_to_fill"] == 1
    assert [study] == [path for path in tmp_path.iterdir() if path.name == "walls.toml"]
    assert not (tmp_path / "runs").exists()
    told = silo2d("sweep", study, "-o", study.parent / "runs", "--workers", 2)
    assert "3 runs of 1 packings, about " in told.err
    assert sweep(study, "--json").json["done"] == 3
    assert planned["expected_cpu_s"] > 0.0
    assert sweep(study, *DRY, "--json").json["expected_cpu_s"] == 0.0  # nothing is left
    (packing,) = tmp_path.glob("runs/packings/*/packing.h5")
    filled = packing.stat().st_mtime_ns
    begun = [(folder / "case.toml").stat().st_mtime_ns for folder in run_folders(study)]
    assert all(filled < moment for moment in begun)


def test_a_dry_run_says_what_would_be_done_and_writes_nothing(study):
    before = contents(study.parent)
    result = sweep(study, *DRY)
    assert "4 runs, 0 of them finished; 0 packings to fill" in result.out
    assert contents(study.parent) == before


def test_a_dry_run_draws_the_silos_beside_the_folder_of_the_study(study):
    """Frictions do not show: one silo and its shapes."""
    before = contents(study.parent)
    planned = sweep(study, "--dry-run", "--json").json
    (picture,) = study.parent.rglob("*.png")
    assert planned["picture"] == str(picture) == f"{planned['folder']}.png"
    assert {
        k: v for k, v in contents(study.parent).items() if not str(k).endswith(".png")
    } == before


# What it ends in


def test_a_sweep_ends_in_a_ranking_a_picture_and_a_page(swept):
    """Of runs that are all out of time nobody is the best; in the page each leads to its folder."""
    table = sweep(swept, "--json").json
    assert table["ranked_by"] == ["clogged"]
    assert table["endings"] == {"out of time": 4}
    for row in table["ranking"]:
        assert (row["rank"], row["runs"], row["not_done"]) == (1, 2, 0)
        assert (row["clogged"], row["time_limit"], row["t90_s.mean"]) == (0, 2, None)
        assert row["clogged.high"] == pytest.approx(wilson_interval(0, 2)[1])
        assert row["cpu_s"] > 0
    assert "2 out of time" in sweep(swept).out
    folder = Path(table["folder"])
    assert Path(table["picture"]).read_bytes().startswith(b"\x89PNG")
    ranking = list(csv.DictReader((folder / "ranking.csv").read_text().splitlines()))
    assert [row["rank"] for row in ranking] == ["1", "1"]
    combinations, runs = json.loads(element(Path(table["page"]).read_text(), "data"))["tables"]
    rank = combinations["columns"].index("rank")
    assert [row[rank] for row in combinations["rows"]] == [{"words": "1", "by": 1}] * 2
    linked = [(folder / address).resolve() for address in runs["folders"]]
    assert sorted(linked) == run_folders(swept)


def test_a_sweep_without_figures_makes_neither_picture_nor_page(swept):
    """Those of an earlier one are left as they are."""
    table = sweep(swept, "--json").json
    Path(table["picture"]).unlink()
    again = sweep(swept, "--no-figures", "--json").json
    assert "picture" not in again
    assert "page" not in again
    assert not Path(table["picture"]).exists()


def test_another_quantity_to_rank_by_is_refused_before_anything_is_run(study):
    before = contents(study.parent)
    assert_refused(sweep(study, "--rank-by", "t90"), "--rank-by 't90'", "did you mean 't90_s'?")
    assert contents(study.parent) == before
    by_time = sweep(study, "--rank-by", "t90_s", *DRY)
    assert by_time.code == 0


# What fails


@pytest.mark.usefixtures("in_this_process")
def test_a_failed_run_is_a_row_with_its_reason(tmp_path, packings):
    """A damaged packing: exit code 3; the runs of the other one are done."""
    study = make_study(tmp_path, packings)
    broken = sorted((tmp_path / "runs" / "packings").glob("*/packing.h5"))[0]
    broken.write_bytes(broken.read_bytes()[:-100])
    result = sweep(study, "--workers", 1)
    assert result.code == 3
    assert result.err.count("\n") == 1
    assert "2 of 4 runs failed" in result.err
    rows = rows_of(study)
    failed = [row for row in rows if row["state"] == "failed"]
    assert len(failed) == 2
    for row in failed:
        assert f"{broken}: damaged" in row["reason"]
        assert "delete it" in row["reason"]
        assert row["state_digest"] == ""
    assert result.out.count("failed: case small") == 2
    assert sum(row["state"] == "done" for row in rows) == 2


@pytest.mark.usefixtures("in_this_process")
def test_a_checkpoint_that_does_not_fit_is_a_row_that_says_what_to_delete(swept):
    """As one of another version is: its arrays are of other lengths."""
    folder = run_folders(swept)[0]
    (folder / "summary.json").unlink()
    checkpoint = folder / "checkpoint.h5"
    save_checkpoint(checkpoint, {"key": np.zeros(3), "row": np.zeros((2, 2))}, {"parts": []})
    result = sweep(swept, "--workers", 1)
    assert result.code == 3
    (row,) = [row for row in rows_of(swept) if row["state"] == "failed"]
    assert row["reason"].startswith(f"{checkpoint}: does not fit this case")
    assert "delete it and the run starts from its opening" in row["reason"]


@pytest.mark.usefixtures("in_this_process")
def test_what_other_sources_made_is_reported_once(swept):
    """Not once a packing and run; a sweep has no --again to offer."""
    for folder in run_folders(swept)[:3]:
        run = RunFolder(folder)
        run.write_provenance({**run.read_provenance(), "source_digest": "0" * 12})
    (folder / "summary.json").unlink()
    result = sweep(swept, "--workers", 1)
    assert result.code == 0
    assert result.err == (
        "warning: 3 of 4 runs and 0 of 2 packings were made by another version of the sources; "
        "delete their folders and the same command makes them again\n"
    )


@pytest.mark.parametrize(
    ("line", "reported"),
    [
        ("x: damaged; use --again to compute", "x: damaged; delete the folder of the run and the "
         "same command does it again"),
        ("x: busy; wait for it, or use --again to compute", "x: busy; wait for it"),
        ("x: lost; delete it", "x: lost; delete it"),
    ],
)  # fmt: skip
def test_a_sweep_offers_no_again(line, reported):
    assert without_again(line) == reported


@pytest.mark.usefixtures("in_this_process")
def test_a_damaged_summary_of_a_finished_run(swept, digests):
    """Refused with the folder to delete, and left as it is; deleted, it is done again."""
    study = swept
    harmed = run_folders(study)[0] / "summary.json"
    harmed.write_text("{")
    before = contents(harmed.parent)
    result = sweep(study)
    assert result.code == 3
    (row,) = [row for row in rows_of(study) if row["state"] == "failed"]
    assert row["reason"].startswith(f"{harmed}: damaged")
    assert row["reason"].endswith(f"delete the folder {harmed.parent} and the same command does "
                                  "it again")  # fmt: skip
    assert contents(harmed.parent) == before
    shutil.rmtree(harmed.parent)
    assert sweep(study, "--workers", 1, "--json").json["done"] == 4
    assert [row["state_digest"] for row in rows_of(study)] == digests


def test_a_page_of_a_damaged_ranking_is_refused_and_the_sweep_makes_it_again(swept):
    (ranking,) = swept.parent.rglob("ranking.parquet")
    ranking.write_bytes(ranking.read_bytes()[:200])
    assert_refused(silo2d("view", ranking.parent), f"{ranking}: cannot be read", "its sweep or map")
    assert sweep(swept).code == 0
    assert silo2d("view", ranking.parent).code == 0


@pytest.mark.usefixtures("in_this_process")
def test_a_run_of_another_version_is_a_row_that_says_so_and_the_page_shows_it(swept):
    """Its schema is not read; the others are compared, and the ranking counts the missing one."""
    folder = run_folders(swept)[0]
    write_json(folder / "summary.json", {**RunFolder(folder).read_summary(), "schema": 99})
    result = sweep(swept)
    assert result.code == 3
    (row,) = [row for row in rows_of(swept) if row["state"] == "failed"]
    assert "schema 99 of another version" in row["reason"]
    assert "1 failed" in result.out
    (page,) = swept.parent.rglob("studies/*/page.html")
    _, runs = json.loads(element(page.read_text(), "data"))["tables"]
    reasons = [cells[runs["columns"].index("reason")] for cells in runs["rows"]]
    assert sorted(map(bool, reasons)) == [False, False, False, True]


def test_a_damaged_table_is_written_again(swept, digests):
    study = swept
    for table in study.parent.glob("runs/studies/walls-*/table.*"):
        table.write_bytes(b"\x00")
    assert sweep(study).code == 0
    assert [row["state_digest"] for row in rows_of(study)] == digests


def full_disk(concerns: Callable[[Path], bool]) -> Any:
    """A context in which no file that it concerns is put in its place."""
    replace = Path.replace

    def full(part: Path, target: Path) -> Path:
        if concerns(target):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return replace(part, target)

    return mock.patch.object(campaign_folder.Path, "replace", full)


def test_a_full_disk_while_the_table_is_written(swept, digests):
    """Simulated: one line; the runs stay, and the same command writes the table."""
    study = swept
    with full_disk(lambda file: "studies" in file.parts and file.name.startswith("table")):
        result = sweep(study)
    assert_refused(result, "table.csv: cannot be written (No space left on device)")
    assert sweep(study, "--json").json["reused"] == 4
    assert [row["state_digest"] for row in rows_of(study)] == digests
    assert not list(study.parent.rglob(".*.tmp"))


@pytest.mark.usefixtures("in_this_process")
def test_a_full_disk_in_a_run(swept, digests):
    """Simulated: rows that fail with the reason; afterwards they go on."""
    study = swept
    for folder in run_folders(study):
        if "seed2" in folder.name:
            shutil.rmtree(folder)
    with full_disk(lambda file: "seed2" in str(file) and file.name == "summary.json"):
        result = sweep(study, "--workers", 1)
    assert result.code == 3
    failed = [row for row in rows_of(study) if row["state"] == "failed"]
    assert [row["seed"] for row in failed] == ["2", "2"]
    assert all("No space left on device" in row["reason"] for row in failed)
    assert sweep(study, "--workers", 1, "--json").json["reused"] == 2
    assert [row["state_digest"] for row in rows_of(study)] == digests


# Killed and stopped

SLOW = {"run.max_time": "0.3 s", "run.time_step": "4 us", "output.checkpoint_interval": "5 ms"}


@pytest.fixture
def slow(tmp_path, packings) -> Path:
    """A study of four runs of a second each."""
    return make_study(tmp_path, packings, **SLOW)


def n_parts(study: Path) -> int:
    """How many checkpoints the runs have kept."""
    return len(list(study.parent.glob("runs/*/parts/*.h5")))


def started(study: Path) -> Any:
    """The sweep as a process, once its runs have kept some checkpoints more."""
    before = n_parts(study)
    options = ["-o", study.parent / "runs", "--workers", 2, "--json", "--quiet"]
    process = start("sweep", study, *options)
    wait_until(lambda: n_parts(study) >= before + 4 or process.poll() is not None, 60.0)
    assert process.poll() is None
    return process


def test_ctrl_c_and_kill_9_lose_nothing(slow):
    """Ctrl-C: 130, one line, a table. kill -9 of all: no orphans. Of a worker: done all the same.

    At each stop at most what came since the last checkpoints is lost.
    """
    process = started(slow)
    process.send_signal(signal.SIGINT)
    result = finish(process)
    assert result.code == 130
    assert result.err == "silo2d: stopped; the same command goes on from there\n"
    assert json.loads(result.out)["interrupted"] >= 3
    states = [row["state"] for row in rows_of(slow)]
    assert states.count("interrupted") >= 3
    process = started(slow)
    workers = children(process.pid)
    assert len(workers) == 2
    process.kill()
    assert finish(process).code == -signal.SIGKILL
    wait_until(lambda: not any(map(is_alive, workers)), 5.0)
    assert n_parts(slow) >= 8
    process = started(slow)
    os.kill(children(process.pid)[-1], signal.SIGKILL)
    result = finish(process)
    assert result.code == 0, result.err
    assert json.loads(result.out)["done"] == 4
    assert {row["reason"] for row in rows_of(slow)} == {""}


def children(pid: int) -> list[int]:
    """Process numbers of the workers that a process has started."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            words = stat.read_text().rpartition(")")[2].split()
            command = stat.with_name("cmdline").read_bytes()
        except OSError:
            continue
        if int(words[1]) == pid and b"spawn_main" in command:
            found.append(int(stat.parent.name))
    return found
