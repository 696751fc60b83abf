"""The paper's tables compared with ours: words of the reports, files, and the command line."""

import importlib
from pathlib import Path
from typing import Any

import pytest
from made_rows import clogged, emptied, ended, failed, line_of
from refusals import assert_refused
from scipy.stats import fisher_exact
from small_silo import Completed, silo2d

from granulab.campaign.output.layout import on_screen
from granulab.campaign.output.results import read_results, write_results
from granulab.errors import FolderError
from silo2d.case.outline import PRESETS
from silo2d.reproduce import TABLES, clogging, discharge, displacement, find

# The experiment has 2.15, 2.10, 2.05, 2.07 s in A3: 2.0925 +- 0.0435 s, and 1 of 5 clogged.
SPREAD = [-0.03, -0.01, 0.0, 0.01, 0.03]


def around(mean: float) -> list[float]:
    return [mean + off for off in SPREAD]


# discharge


def test_times_within_noise_agree():
    """A3 at 2.11 s: 0.0175 s off, of 0.065 s allowed (Welch: t(4.26) = 2.71, error 0.0239 s)."""
    line = line_of(discharge.report(emptied("A3", around(2.11))), "A3")
    assert "2.110 +- 0.022 (5)" in line
    assert "1.899 +- 0.020 (5)" in line  # T90
    assert "agrees +0.8 % (+- 3.1 %)" in line  # 0.0649/2.0925


@pytest.mark.parametrize(("mean", "word"), [(2.30, "high by 9.9 %"), (1.80, "low by 14 %")])
def test_times_beyond_noise_are_high_or_low(mean, word):
    line = line_of(discharge.report(emptied("A3", around(mean))), "A3")
    assert word in line
    assert "agrees +" not in line


def test_one_time_is_too_few_to_judge():
    """A spread needs two: one run says how far off it is, not whether that is noise."""
    text = discharge.report(emptied("A3", [2.3]))
    assert "+9.9 %, too few to judge" in line_of(text, "A3")
    assert "1 have too few times" in text


def test_clogged_runs_have_no_time_and_are_counted():
    """4 emptied, 1 clogged at the opening, as 1 of 5 in the experiment."""
    rows = emptied("A3", around(2.1)[:4]) + clogged("A3", 1, 5, at_opening=True)
    line = line_of(discharge.report(rows), "A3")
    assert "(4)" in line
    assert line.count("1 of 5 [0.04, 0.62]") == 2  # there and here
    assert line.split()[-2:] == ["1", "agrees"]


def test_a_silo_that_clogs_there_and_flows_here_differs_once_there_are_enough_runs():
    """1 of 1 against 0 of n has Fisher's p = 1/(n + 1): 0.053 of 18, 0.048 of 20."""
    for n, word in ((18, "agrees"), (20, "clogs less often")):
        line = line_of(discharge.report(emptied("A2", [1.5] * n)), "A2")
        assert line.endswith(word)
        assert "clogged" in line  # SPOLY's
    assert line_of(discharge.report(clogged("A4", 9)), "A4").endswith("clogs more often")


def test_failed_runs_are_named_and_do_not_count():
    """Their reason stands below; mean and shares are those of the others."""
    good = emptied("A4", around(1.0))
    text = discharge.report([*good, failed("the energy balance is off", silo="A4", seed=6)])
    line = line_of(text, "A4")
    assert line.split("0 of 5")[0] == line_of(discharge.report(good), "A4").split("0 of 5")[0]
    assert ", 1 failed" in line
    assert "failed: silo A4, seed 6: the energy balance is off" in text


def test_a_run_at_the_time_limit_is_neither_clogged_nor_emptied():
    rows = [*emptied("D3", around(2.6)), ended("time_limit", silo="D3", seed=6)]
    line = line_of(discharge.report(rows), "D3")
    assert "0 of 5" in line
    assert ", 1 at the time limit" in line


def test_all_runs_of_a_table_may_fail(tmp_path):
    rows = [failed("no space left", silo=silo, seed=1) for silo in ("A1", "A4")]
    text = discharge.report(rows)
    assert text.count("no space left") == 2
    assert clogging.report(rows[:1]).count("no space left") == 1
    head = ["command: x"]
    for table, own in ((discharge, rows), (discharge, rows[:1]), (clogging, rows[:1])):
        write_results(tmp_path, "failed", own, head, "", lambda t=table, r=own: t.draw(r))


def test_summary_counts_and_compares_the_deviation_with_spolys():
    """A4 0.99 s there; ours 1.0 and SPOLY 1.00 s are both 1.0 % off. B4: 1.21; ours 1.4, 1.19."""
    rows = emptied("A4", around(1.0)) + emptied("B4", around(1.4)) + clogged("A1", 5)
    text = discharge.report(rows)
    assert "times: 1 of 2 silos agree within noise, 1 do not, 0 have too few" in text
    assert "outcomes: 3 of 3 agree" in text
    ours = (abs(1 / 0.99 - 1) + abs(1.4 / 1.21 - 1)) / 2
    spoly = (abs(1 / 0.99 - 1) + abs(1.19 / 1.21 - 1)) / 2
    assert f"(A4, B4): ours {100 * ours:.1f} % over 2 silos" in text
    assert f"SPOLY's own {100 * spoly:.1f} %" in text


# clogging


def test_clogging_counts_the_opening_apart():
    """5 at the opening, 6 later, 9 flow: 11 of 20; later, 6 of the 15 that the opening left."""
    rows = clogged("B3", 5, at_opening=True) + clogged("B3", 6, 6) + emptied("B3", [2.5] * 9, 12)
    line = line_of(clogging.report(rows), "B3")
    for words in ("1 of 4 [0.05, 0.70]", "11 of 20 [0.34, 0.74]", "5 of 20 [0.11, 0.47]",
                  "6 of 15 [0.20, 0.64]", "agrees"):  # fmt: skip
        assert words in line


def test_silos_that_clog_alike_differ_together():
    """A3 and C3 each overlap the experiment's interval; their sums do not fit together."""
    rows = clogged("A3", 15, 6) + emptied("A3", [2.0] * 5, 12)
    rows += clogged("C3", 12, 6) + emptied("C3", [2.0] * 8, 12)
    text = clogging.report(rows)
    assert "A3, C3 together: the experiment clogged in 1 of 8" in text
    assert "ours in 27 of 40" in text
    assert f"p = {fisher_exact([[1, 7], [27, 13]]).pvalue:.2g}" in text


# What is run


@pytest.fixture
def requested(monkeypatch) -> list[tuple[dict[str, Any], Any]]:
    """Takes the cases that a table would run, and lets all of them clog."""
    from silo2d.run import sweep

    taken: list[tuple[dict[str, Any], Any]] = []

    def run_cases(cases, **how):
        taken.extend(cases)
        return [ended("clogged", **labels) for labels, _ in cases]

    monkeypatch.setattr(sweep, "run_cases", run_cases)
    return taken


@pytest.mark.parametrize(
    ("table", "silos"), [("discharge", PRESETS), ("clogging", [p for p in PRESETS if p[1] != "4"])]
)
def test_each_silo_is_run_with_each_seed(table, silos, requested, tmp_path):
    find(table).run(out=tmp_path, seeds=[1, 2, 7], workers=1, quiet=True)
    labels = [(labels["silo"], labels["seed"]) for labels, _ in requested]
    assert labels == [(silo, seed) for silo in silos for seed in (1, 2, 7)]
    cases = [(case.name, case.settings.run.seed) for _, case in requested]
    assert cases == labels


def test_a_case_at_a_seed_is_the_run_of_that_command(requested, tmp_path):
    """Content-addressed: `silo2d run A4 --seed 2` is the same run, not done again."""
    from silo2d import SiloCase
    from silo2d.run.protocol import run_digest

    find("discharge").run(out=tmp_path, seeds=[2], workers=1, quiet=True)
    case = next(case for labels, case in requested if labels["silo"] == "A4")
    assert run_digest(case) == run_digest(SiloCase.load("A4", {"run.seed": 2}))


# Files


def test_rows_come_back_from_their_file(tmp_path):
    """So that what is committed can be judged again; folders of this machine stay out of it."""
    rows = [*emptied("A4", around(1.0)), failed('line 1, "quoted"', silo="A4", seed=6)]
    files = write_results(
        tmp_path / "new", "reproduce-discharge", rows, ["command: x", "date: y"], "words",
        lambda: discharge.draw(rows),
    )  # fmt: skip
    assert [f.suffix for f in files] == [".csv", ".parquet", ".txt", ".png"]
    assert files[3].read_bytes().startswith(b"\x89PNG")
    for file in files[:2]:
        head, back = read_results(file)
        assert head == {"command": "x", "date": "y"}
        assert discharge.report(back) == discharge.report(rows)
    assert "somewhere" not in files[0].read_text(encoding="utf-8")


@pytest.mark.parametrize("text", ["", "# date: today\n", "a,b\n1,2\n", "state,n\ndone,1,3\n"])
def test_a_damaged_table_is_named(text, tmp_path):
    path = tmp_path / "reproduce-discharge.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FolderError, match="not a table of the command reproduce"):
        read_results(path)
    path.unlink()
    with pytest.raises(FolderError, match="cannot be read"):
        read_results(path)


def test_the_command_prints_the_table_and_writes_its_files(requested, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = silo2d("reproduce", "clogging", "--seeds", 1, "--quiet", "--write", "kept")
    assert (result.code, result.err) == (0, "")
    assert "clogged" in result.out
    head, rows = read_results(tmp_path / "kept" / "reproduce-clogging.csv")
    assert head["command"] == "silo2d reproduce clogging --seeds 1"
    assert set(head) == {"command", "versions", "date", "arithmetic", "machine"}
    kept = (tmp_path / "kept" / "reproduce-clogging.txt").read_text("utf-8")
    assert result.out.strip() == on_screen(kept.partition("\n\n")[2]).strip()
    assert all(row["state"] == "done" for row in rows)


def test_rows_that_are_done_are_kept_and_others_run(monkeypatch, tmp_path):
    """What ran elsewhere goes on from its table: seed 1 is there, but for one that failed."""
    taken: list[dict[str, Any]] = []

    def run_labelled(simulator, cases, **how):
        taken.extend(labels for labels, _ in cases)
        return [ended("clogged", **labels) for labels, _ in cases]

    there = [ended("emptied", silo=s, seed=1) for s in PRESETS if s[1] != "4"]
    there[-1] = failed("unlucky", silo="D3", seed=1)
    write_results(
        tmp_path, "reproduce-clogging", there, ["date: y", "versions: x; sources 0123"], "", None
    )
    monkeypatch.setattr("granulab.campaign.sweeps.sweep.run_labelled", run_labelled)
    add = ["--seeds", 2, "-o", tmp_path, "--add"]
    result = silo2d("reproduce", "clogging", *add)
    assert result.code == 0
    assert "13 runs" in result.err
    assert "11 rows of y, sources 0123, are kept, which another version" in result.err
    assert taken[0] == {"silo": "A1", "seed": 2}
    assert len(taken) == 13
    assert {"silo": "D3", "seed": 1} in taken
    head, rows = read_results(tmp_path / "reproduce-clogging.csv")
    assert head["kept"] == "11 rows of y, sources 0123"
    assert [row["outcome"] for row in rows[:3]] == ["emptied", "clogged", "emptied"]


@pytest.mark.parametrize(
    "table",
    [
        "silo2d.reproduce.beverloo",
        "silo2d.reproduce.remarks",
        "damper3d.reproduce.cycles",
        "damper3d.reproduce.experiments",
    ],
)
def test_rows_whose_runs_are_elsewhere_are_not_measured_again(table, tmp_path):
    module = importlib.import_module(table)
    there = [{**labels, "state": "done", "phase": str(k)}
             for k, (labels, _) in enumerate(module.cases([1]))]  # fmt: skip
    rows = module.run(out=tmp_path, seeds=[1], workers=1, quiet=True, known=there)
    assert rows == there


def test_all_rows_of_a_run_that_is_elsewhere_are_kept(tmp_path):
    there = [{"silo": silo, "seed": 1, "state": "done", "layer": k}
             for silo in displacement.SILOS for k in range(3)]  # fmt: skip
    assert displacement.run(out=tmp_path, seeds=[1], workers=1, quiet=True, known=there) == there


def test_json_has_the_rows(requested, tmp_path):
    result = silo2d("reproduce", "discharge", "--seeds", 1, "-o", tmp_path, "--json")
    assert [row["silo"] for row in result.json["rows"]] == list(PRESETS)
    assert "16 runs of 16 packings" in result.err


def test_runs_cut_off_leave_earlier_results_alone(monkeypatch, tmp_path):
    """After Ctrl-C: what there is on stdout, one line, exit code 130, no file written."""
    from silo2d.run import sweep

    def run_cases(cases, **how):
        rows = [ended("clogged", **labels) for labels, _ in cases[:-1]]
        return [*rows, {**cases[-1][0], "state": "interrupted", "reason": "stopped"}]

    monkeypatch.setattr(sweep, "run_cases", run_cases)
    result = silo2d("reproduce", "clogging", "--seeds", 1, "-o", tmp_path / "runs", "--quiet")
    assert result.code == 130
    assert result.err.count("\n") == 1
    assert "runs that are missing: 1" in result.err
    assert "interrupted: silo D3, seed 1: stopped" in result.out
    assert not (tmp_path / "runs").exists()


def test_failed_runs_give_exit_code_3_and_the_table(monkeypatch, tmp_path):
    """As `silo2d sweep` does: what there is, one line, 3."""
    from silo2d.run import sweep

    def run_cases(cases, **how):
        rows = [ended("clogged", **labels) for labels, _ in cases[:-1]]
        return [*rows, failed("no space left", **cases[-1][0])]

    monkeypatch.setattr(sweep, "run_cases", run_cases)
    result = silo2d("reproduce", "clogging", "--seeds", 1, "-o", tmp_path, "--quiet")
    assert result.code == 3
    assert result.err.count("\n") == 1
    assert "1 of 12 rows are failed runs" in result.err
    _, rows = read_results(tmp_path / "reproduce-clogging.csv")
    assert [row["reason"] for row in rows if row["state"] == "failed"] == ["no space left"]


def test_the_result_is_printed_even_where_no_file_can_be_written(monkeypatch, tmp_path):
    """Hours of work are not lost: the runs stand below --out, the words on stdout."""
    from silo2d.run import sweep

    def run_cases(cases, **how):
        (tmp_path / "kept").write_text("came in between")
        return [ended("clogged", **labels) for labels, _ in cases]

    monkeypatch.setattr(sweep, "run_cases", run_cases)
    result = silo2d("reproduce", "clogging", "--seeds", 1, "--quiet", "-o", tmp_path / "runs",
                    "--write", tmp_path / "kept")  # fmt: skip
    assert result.code == 2
    assert result.err.count("\n") == 1
    assert "of 12 silos agree with the experiment" in result.out


@pytest.mark.parametrize("place", ["file", "file/below", "link"])
@pytest.mark.parametrize("option", ["--out", "--write"])
def test_a_folder_that_cannot_be_made_is_refused_before_anything_is_run(
    requested, tmp_path, monkeypatch, place, option
):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("in the way")
    Path("link").symlink_to("nowhere")
    before = sorted(tmp_path.iterdir())
    result = silo2d("reproduce", "clogging", "--seeds", 1, "--quiet", option, place)
    assert (result.code, result.out, requested) == (2, "", [])
    assert result.err.count("\n") == 1
    for word in (f"{place}: cannot be written", f"with {option}"):
        assert word in result.err
    assert sorted(tmp_path.iterdir()) == before


def test_a_folder_without_permission_to_write_is_refused(requested, tmp_path, monkeypatch):
    """The system's error is made up here: root may write anywhere."""
    monkeypatch.setattr(
        "granulab.campaign.output.files.os.access", lambda path, mode: path != tmp_path
    )
    result = silo2d("reproduce", "clogging", "--quiet", "--write", tmp_path / "new" / "results")
    assert (result.code, result.out, requested) == (2, "", [])
    assert "results: cannot be written (Permission denied)" in result.err


def test_without_a_table_it_lists_them():
    result = silo2d("reproduce")
    assert result.code == 0
    assert [line.split()[0] for line in result.out.splitlines()] == list(TABLES)
    for name in TABLES:
        assert find(name).SEEDS >= 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["discharg"], ["'discharg'", "did you mean 'discharge'?"]),
        (["discharge", "--seeds", 0], ["--seeds = 0", "at least 1"]),
        (["discharge", "--seeds", "many"], ["'many'", "integer"]),
        (["discharge", "--workers", -1], ["--workers = -1", "at least 1"]),
        (["discharge", "--engine", "slurm"], ["'slurm'", "'processes', 'dask'"]),
        (["discharge", "--scheduler", "tcp://a:1"], ["--scheduler", "--engine dask"]),
    ],
)
def test_a_bad_command_line(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result: Completed = silo2d("reproduce", *arguments)
    assert_refused(result, *words)
    assert not list(tmp_path.iterdir())
