"""The commands map and predict: what they print, what they leave, how they end; runs are made."""

import json

import pytest
from made_map import made_runs
from read_page import element

from damper3d.case.case import DamperCase
from damper3d.case.settings import EXAMPLES, commented_case
from damper3d.commands import main as cli
from damper3d.run.sweep import DAMPER
from damper3d.studies.map import grid as mapping
from damper3d.studies.predict import compare

SMALL = ["--frequencies", "20,40", "--gammas", "1,2,3,5,8,12,20,30", "--no-figures"]


@pytest.fixture
def damper3d(monkeypatch, tmp_path, capsys):
    """Run a command line in this process; its exit code, stdout and stderr."""
    monkeypatch.setattr(mapping, "run_cases", made_runs)
    monkeypatch.setattr(compare, "run_cases", made_runs)

    def run(*words):
        monkeypatch.setattr("sys.argv", ["damper3d", *words, "--out", str(tmp_path)])
        code = 0
        try:
            cli.main()
        except SystemExit as end:
            code = end.code or 0
        said = capsys.readouterr()
        return code, said.out, said.err

    return run


def test_map_prints_its_ridges_and_leaves_its_table(damper3d, tmp_path):
    code, out, _ = damper3d("map", *SMALL, "--json")
    results = json.loads(out)
    assert code == 0
    assert {peak["ridge"] for peak in results["ridges"]} == {"bouncing_bed", "fluidisation"}
    (folder,) = (tmp_path / "maps").iterdir()
    names = {"provenance.json", "summary.json", "table.csv", "table.parquet", "table.h5", "runs"}
    names |= {"ranking.csv", "ranking.parquet"}
    assert {path.name for path in folder.iterdir()} == names
    assert str(folder) == results["folder"]


def test_map_ranks_its_points_by_their_means_and_puts_them_on_a_page(damper3d, tmp_path):
    """The best is that of `best`; the picture, the ranking, points and runs are in one file."""
    code, out, err = damper3d("map", *SMALL[:-1], "--packings", "2")
    assert code == 0
    assert "thesis: ranked by efficiency (most first)" in out
    (page,) = tmp_path.rglob("page.html")
    assert err.splitlines()[-2:] == [str(page.parent / "map.png"), str(page)]
    data = json.loads(element(page.read_text(), "data"))
    assert [figure["name"] for figure in data["figures"]] == ["map"]
    assert [table["title"] for table in data["tables"]] == [
        "Combinations, the best first", "Points", "Runs",
    ]  # fmt: skip
    assert [len(table["rows"]) for table in data["tables"]] == [16, 16, 32]
    results = json.loads((page.parent / "summary.json").read_text())
    best, first = results["best"], results["ranking"][0]
    assert (first["frequency_hz"], first["gamma"]) == (best["frequency_hz"], best["gamma"])
    assert first["efficiency.mean"] == pytest.approx(best["efficiency"])
    assert first["efficiency.low"] == pytest.approx(best["efficiency_low"])


def test_a_field_costs_its_runs_and_the_packings_that_are_to_be_filled(damper3d):
    grid = ["--frequencies", "20", "--gammas", "0.5,1", "--packings", "2"]
    words = ["field", "thesis", *grid, "--dry-run", "--json"]
    planned = json.loads(damper3d(*words)[1])
    cases = [DamperCase.load("thesis", {"motion.frequency": 20.0, "motion.gamma": gamma,
                                        "run.steady": True}) for gamma in (0.5, 1.0)]  # fmt: skip
    each = [DAMPER.expected_cpu_s(case) for case in cases]
    seconds = 2 * (each[0][0] + sum(run for _, run in each))
    assert planned["packings_to_fill"] == 2
    assert 60 * planned["expected_cpu_min_at_most"] == pytest.approx(seconds, rel=1e-6)


@pytest.mark.parametrize(
    ("command", "of"), [(["map"], "host"), (["predict", "--simulate"], "host"), (["map"], "random")]
)
def test_runs_over_frequency_and_gamma_refuse_what_else_moves_the_enclosure(
    damper3d, tmp_path, command, of
):
    """In words on the case, not on keys that the command sets."""
    file, section = tmp_path / "case.toml", "host" if of == "host" else "excitation"
    file.write_text(commented_case(EXAMPLES[of]), encoding="utf-8")
    name, *more = command
    code, out, err = damper3d(name, str(file), *more, "--no-figures")
    assert (code, out) == (2, "")
    assert f"give a case without [{section}]" in err
    assert ("damper3d response" in err) == (of == "host")


def test_dry_run_says_how_many_runs_and_writes_nothing(damper3d, tmp_path):
    code, out, _ = damper3d("map", *SMALL, "--packings", "3", "--dry-run", "--json")
    planned = json.loads(out)
    assert (code, planned["runs"], planned["finished"]) == (0, 48, 0)
    assert planned["packings_to_fill"] == 3  # one a seed, for all frequencies and Gammas
    assert planned["expected_cpu_min"] > 0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["map", "--gammas", "1,0"], "gammas: 0: must be above 0"),
        (["map", "--frequencies", ""], "frequencies: empty"),
        (["map", "--frequencies", "40,,80"], "write numbers with commas"),
        (["map", "--packings", "0"], "packings = 0"),
        (["map", "--frequency", "40"], "give --frequencies"),
        (["map", "--rank-by", "efficency"], "did you mean 'efficiency'"),
        (["predict", "--frequencies", "a"], "write numbers with commas"),
        (["predict", "--frequencies", "0"], "frequencies: 0"),
        (["predict", "--packing", "0.4"], "fill ratio = 0.466"),
        (["predict", "--full-count", "3"], "full count = 3"),
    ],
)
def test_bad_input_ends_with_code_2_and_one_line(damper3d, words, said):
    code, out, err = damper3d(*words)
    assert (code, out) == (2, "")
    assert said in err
    assert len(err.strip().splitlines()) == 1


def test_interrupted_map_keeps_its_table_and_ends_with_code_130(damper3d, monkeypatch, tmp_path):
    def half(cases, **_):
        rows = made_runs(cases, out=None)
        return rows[:8] + [{**row, "state": "interrupted"} for row in rows[8:]]

    monkeypatch.setattr(mapping, "run_cases", half)
    code, out, err = damper3d("map", *SMALL)
    assert code == 130
    assert "the same command goes on" in err
    assert "8 done, 0 failed, 8 interrupted" in out
    assert len(list((tmp_path / "maps").glob("*/table.csv"))) == 1


def test_predict_prints_the_table_of_the_four_fills(damper3d, tmp_path):
    code, out, _ = damper3d("predict", "--json")
    results = json.loads(out)
    assert code == 0
    assert [round(fill["fill_ratio"], 3) for fill in results["fills"]] == [
        0.466, 0.414, 0.373, 0.339]  # fmt: skip
    assert results["fills"][0]["bouncing_bed"][1]["gamma"] == pytest.approx(
        [5.57, 22.3, 89.1], rel=2e-3)  # fmt: skip
    assert (tmp_path / "predict-thesis.png").exists()


def test_predict_compares_with_simulations(damper3d):
    words = ["predict", "--height", "40 mm", "--frequencies", "40", "--simulate", "--no-figures"]
    code, out, _ = damper3d(*words)
    assert code == 0
    assert out.splitlines()[-1].split()[1:3] == ["40", "66.8"]  # three times 22.27
