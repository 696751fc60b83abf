"""Text for a terminal: lines that end between words, tables that fit, what became of runs."""

import dataclasses
from pathlib import Path

import pytest

from granulab.campaign.cli.library import packings_and_runs, run_in_words
from granulab.campaign.output.layout import fitted, on_screen, wrapped
from granulab.campaign.output.table import as_csv, write_table
from granulab.errors import SimulationError
from silo2d.case.case import SiloCase
from silo2d.run.protocol import RUNS

RESULTS = Path(__file__).parents[2] / "docs" / "results"


def test_long_lines_end_between_words_and_keep_numbers_with_their_units():
    """What follows stands under what the line says after its name."""
    text = "  energy      1 J dissipated, closed to 0.2 % of it\na word"
    assert wrapped(text, 4, width=32).split("\n") == [
        "  energy      1 J dissipated,",
        "              closed to 0.2 % of",
        "              it",
        "a word",
    ]
    assert wrapped("averyverylongword", 2, width=8) == "averyverylongword"
    assert wrapped("it took 1234567 kg", 2, width=17) == "it\n  took 1234567 kg"


@pytest.mark.parametrize("report", sorted(RESULTS.glob("*/reproduce-*.txt")), ids=lambda p: p.stem)
@pytest.mark.parametrize("width", [60, 80, 400])
def test_reports_fit_the_terminal_and_say_every_word(report, width):
    """Tables of up to 394 characters a line; a word longer than a line stays whole."""
    text = report.read_text(encoding="utf-8")
    shown = on_screen(text, width)
    words = set(text.split())
    assert max(map(len, shown.split("\n"))) <= max(width, 4 + max(map(len, words)))
    assert words <= set(shown.split())


def test_a_wide_table_says_in_each_part_which_line_it_is():
    """As many columns as tell the lines apart; what stands in no column is a sentence."""
    text = "made of\n    place   kind  long words    number\n    a       x     said of it    1\n"
    text += "    a       y     said of all   2\n    b       y     of none       3\nand so on"
    assert on_screen(text, 26).split("\n") == [
        "made of",
        "place  kind   long words",
        "    a     x   said of it",
        "    a     y  said of all",
        "    b     y      of none",
        "",
        "place  kind  number",
        "    a     x       1",
        "    a     y       2",
        "    b     y       3",
        "and so on",
    ]


def test_table_that_is_too_wide_is_said_in_parts_that_fit():
    """Labels that do not vary are said once, the others begin each part."""
    header = ["case", "outlet_m", "runs", "time_s", "rate_per_s"]
    lines = [["A4", "0.06", "2", "-", "-"], ["A4", "0.10", "2", "0.34 +- 0.01", "307"]]
    assert fitted(header, lines, 2, width=34).split("\n") == [
        "all with case A4",
        "",
        "outlet_m  runs        time_s",
        "    0.06     2             -",
        "    0.10     2  0.34 +- 0.01",
        "",
        "outlet_m  rate_per_s",
        "    0.06           -",
        "    0.10         307",
    ]
    wide = fitted([f"label_{k}" for k in range(12)] + ["x"], [["1"] * 13, ["2"] * 13], 12, 80)
    assert max(map(len, wide.split("\n"))) <= 80
    assert "label_11" in wide


@pytest.fixture
def failed(tmp_path):
    """A folder of runs with one that failed."""

    def fail(*_):
        raise SimulationError("the simulation failed at t = 0.5 s: try another step")

    runs = dataclasses.replace(RUNS, compute=fail)
    with pytest.raises(SimulationError):
        runs.run(SiloCase.load("A4"), out=tmp_path)
    return tmp_path


def test_run_that_failed_is_listed_and_shown_as_failed(failed):
    (line,) = packings_and_runs(failed, "silo", str)
    assert "failed: the simulation failed at t = 0.5 s" in line
    assert "unfinished" not in line
    (folder,) = failed.glob("A4-*")
    words = run_in_words(folder, "silo2d", lambda case: "A4", str)
    assert "failed: the simulation failed at t = 0.5 s" in words


def test_run_that_goes_on_after_a_failure_is_no_longer_one_that_failed(failed):
    runs = dataclasses.replace(RUNS, compute=lambda *_: {}, result=_Anything)
    runs.run(SiloCase.load("A4"), out=failed)
    (line,) = packings_and_runs(failed, "silo", lambda summary: "empty")
    assert "failed" not in line


class _Anything:
    @classmethod
    def read(cls, folder, *, reused):
        return folder


def test_list_says_in_what_the_runs_of_a_sweep_differ(tmp_path):
    for outlet in ("100 mm", "120 mm"):
        case = SiloCase.load("A4", {"silo.outlet": outlet})
        dataclasses.replace(RUNS, compute=lambda *_: {}, result=_Anything).run(case, out=tmp_path)
    lines = packings_and_runs(tmp_path, "silo", lambda summary: "empty")
    assert sorted(line.partition("empty; ")[2].partition(" (")[0] for line in lines) == [
        "silo.outlet 0.1 m", "silo.outlet 0.12 m",
    ]  # fmt: skip


def test_list_counts_the_runs_of_a_large_study_unless_each_is_wanted(tmp_path):
    for seed in range(1, 22):
        case = SiloCase.load("A4", {"run.seed": seed})
        dataclasses.replace(RUNS, compute=lambda *_: {}, result=_Anything).run(case, out=tmp_path)
    lost = next(tmp_path.glob("A4-seed7-*"))
    (lost / "summary.json").unlink()
    (line,) = packings_and_runs(tmp_path, "silo", str)
    assert line.startswith(f"runs       21 of A4 in {tmp_path}: 20 finished, 1 unfinished (")
    assert line.endswith("; each with --all")
    lines = packings_and_runs(tmp_path, "silo", lambda summary: "empty", every=True)
    assert len(lines) == 21
    assert sum("empty; run.seed" in one for one in lines) == 20


def test_list_leaves_out_the_runs_of_the_other_simulator(tmp_path):
    runs = dataclasses.replace(RUNS, compute=lambda *_: {}, result=_Anything)
    runs.run(SiloCase.load("A4"), out=tmp_path)
    assert len(packings_and_runs(tmp_path, "silo", lambda summary: "empty")) == 1
    assert packings_and_runs(tmp_path, "enclosure", lambda summary: "empty") == []


def test_list_names_a_run_whose_case_cannot_be_read(tmp_path):
    (tmp_path / "A4-seed1-0").mkdir()
    (tmp_path / "A4-seed1-0" / "case.toml").write_text("[silo", encoding="utf-8")
    for section in ("silo", "enclosure"):
        (line,) = packings_and_runs(tmp_path, section, str)
        assert "unfinished" in line


def test_run_folders_in_a_table_are_relative_to_it(tmp_path):
    folder = tmp_path / "studies" / "one"
    folder.mkdir(parents=True)
    write_table(folder, [{"n": 1, "run_folder": str(tmp_path / "A4-1")}, {"n": 2}])
    assert (folder / "table.csv").read_text() == as_csv(
        [{"n": 1, "run_folder": "../../A4-1"}, {"n": 2}]
    )
