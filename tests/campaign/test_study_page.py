"""The page of a sweep or map: its tables as kept, links to pages that are there, and no others."""

import json
from pathlib import Path

import pytest
from read_page import element
from refusals import assert_refused
from small_damper import damper3d
from small_silo import silo2d

from granulab.campaign.output.page.study import page_of, study_page
from granulab.campaign.output.table import as_parquet, write_table
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.sweeps.report.comparison import Comparison, Varied
from granulab.campaign.sweeps.report.quantities import Quantities
from granulab.campaign.sweeps.report.summary import summary, write_ranking

KEPT = Path(__file__).parents[1] / "data" / "kept"


def data_of(text: str) -> dict:
    return json.loads(element(text, "data"))


def write_study(folder: Path, runs: list[tuple[str, dict]]) -> Path:
    """A study below folder/studies of runs with these names and labels; the first has a page."""
    rows = []
    for k, (name, labels) in enumerate(runs):
        run = folder / name
        run.mkdir(parents=True)
        (run / "case.toml").write_text("schema = 1\n", "utf-8")
        if k == 0:
            page_of(run).parent.mkdir()
            page_of(run).write_text("a page", "utf-8")
        rows.append({**labels, "seed": 1, "t90_s": 1.0 + k, "outcome": "empty", "state": "done",
                     "reason": "", "run_folder": str(run), "reused": False})  # fmt: skip
    study = folder / "studies" / "one"
    study.mkdir(parents=True)
    write_table(study, rows)
    return study


def test_rows_link_to_the_pages_that_are_there_as_seen_from_the_page(tmp_path):
    """Names with signs that an address would read otherwise are written as it wants them."""
    study = write_study(tmp_path, [("a b#1?", {"x": 1.0}), ("c", {"x": 2.0})])
    table = data_of(study_page(study, ("t90_s",), study / "page.html"))["tables"][0]
    assert table["links"] == ["../../a%20b%231%3F/figures/page.html", None]
    elsewhere = data_of(study_page(study, ("t90_s",), tmp_path / "page.html"))["tables"][0]
    assert elsewhere["links"] == ["a%20b%231%3F/figures/page.html", None]
    assert "run_folder" not in table["columns"]
    assert "1 of 2 have no page here" in table["note"]


def test_a_run_folder_that_is_an_address_of_another_kind_gets_no_link(tmp_path):
    study = write_study(tmp_path, [("a", {"x": 1.0})])
    rows = [{"x": 1.0, "seed": 1, "state": "done", "run_folder": name}
            for name in ("javascript:alert(1)", "https://example.org", "", None)]  # fmt: skip
    write_table(study, rows)
    found = data_of(study_page(study, (), study / "page.html"))
    assert found["tables"][0]["links"] == [None] * 4


@pytest.mark.parametrize(
    ("labels", "plot"),
    [
        # Two keys that vary together are one; of two that do not, one tells the points apart.
        ([{"a": 1.0, "b": 1.0}, {"a": 2.0, "b": 2.0}], {"x": "a"}),
        ([{"a": 1.0, "b": 5.0}, {"a": 1.0, "b": 6.0}, {"a": 2.0, "b": 5.0}, {"a": 2.0, "b": 7.0}],
         {"x": "b", "group": "a"}),
        ([{"case": "A4", "a": 1.0}, {"case": "B4", "a": 1.0}], {"x": "a", "group": "case"}),
        ([{"case": "A4"}, {"case": "B4"}], {}),
    ],
)  # fmt: skip
def test_the_plot_begins_with_the_keys_that_were_varied(tmp_path, labels, plot):
    study = write_study(tmp_path, [(f"run{k}", one) for k, one in enumerate(labels)])
    table = data_of(study_page(study, ("t90_s",), study / "page.html"))["tables"][0]
    named = {axis: table["columns"][k] for axis, k in table["plot"].items()}
    assert named == {"y": "t90_s", **plot}


def test_a_kept_map_shows_its_points_and_its_runs(tmp_path):
    """Of an earlier version; its runs are not beside it."""
    (folder,) = (KEPT / "damper" / "maps").iterdir()
    page = tmp_path / "map.html"
    done = damper3d("view", folder, "-o", page)
    assert (done.code, done.err) == (0, "")
    found = data_of(page.read_text("utf-8"))
    assert [table["title"] for table in found["tables"]] == ["Points", "Runs"]
    assert found["tables"][0]["links"] is None
    assert "frequency_hz" in found["tables"][1]["columns"]


def test_runs_get_their_pages_and_those_without_frames_are_counted(finished, tmp_path):
    """A finished run, one that was cut off, and the page of the study after them."""
    run = next(finished.glob("small-*"))
    begun = run.with_name("begun")
    begun.mkdir()
    (begun / "case.toml").write_bytes((run / "case.toml").read_bytes())
    study = finished / "studies" / "one"
    study.mkdir(parents=True)
    write_table(study, [{"case": "small", "seed": k, "state": "done", "run_folder": str(path)}
                        for k, path in enumerate((run, begun))])  # fmt: skip
    done = silo2d("view", study, "--runs")
    assert done.code == 0, done.err
    assert done.out.split() == [str(page_of(run)), str(study / "page.html")]
    assert done.err.startswith("1 of its runs without a page: ")
    links = data_of((study / "page.html").read_text("utf-8"))["tables"][0]["links"]
    assert [link is not None for link in links] == [True, False]


@pytest.mark.parametrize("name", ["table.parquet", "ranking.parquet", "runs/table.parquet"])
def test_a_table_that_was_changed_is_not_shown(tmp_path, name):
    """Another whole table in the place of a sealed one; a map seals that of its runs too."""
    study = write_study(tmp_path, [("a", {"x": 1.0})])
    own, other = (
        as_parquet([{"x": x, "seed": 1, "state": "done", "run_folder": ""}]) for x in (1.0, 2.0)
    )
    (study / "runs").mkdir()
    (study / "runs" / "table.csv").touch()
    for one in ("ranking.parquet", "runs/table.parquet"):
        (study / one).write_bytes(own)
    folder = RunFolder(study)
    folder.write_provenance({})
    folder.seal("table.parquet", "ranking.parquet", "runs/table.parquet")
    assert silo2d("view", study).code == 0
    (study / name).write_bytes(other)
    assert_refused(silo2d("view", study), f"{study / name}", "changed since", "its sweep or map")


def test_the_files_of_a_ranking_are_sealed(tmp_path):
    folder = RunFolder(tmp_path)
    folder.write_provenance({})
    rows = [{"x": float(k), "seed": 1, "state": "done", "run_folder": ""} for k in range(2)]
    comparison = Comparison.of("one", (Varied("x", "a.x"),), Quantities(), rows)
    write_ranking(tmp_path, comparison, summary(comparison, tmp_path))
    assert folder.seals().keys() == {"ranking.csv", "ranking.parquet"}


def test_a_damaged_table_and_a_folder_of_something_else_are_refused(tmp_path):
    study = write_study(tmp_path, [("a", {"x": 1.0})])
    (study / "table.parquet").write_bytes(b"PAR1 no more")
    assert_refused(silo2d("view", study), "table.parquet", "cannot be read")
    assert_refused(silo2d("view", tmp_path), "neither a run folder")
    assert_refused(silo2d("view", tmp_path / "gone"), "neither a run folder")
