"""A sweep of a simulator without physics: rows, shared packings, what is there, what fails."""

import csv
import dataclasses
import json

from fake_simulator import FAKE, fake

from granulab.campaign.output.table import as_csv, as_parquet, read_parquet, write_table
from granulab.campaign.sweeps.sweep import over_seeds, run_labelled


def run(cases, out, **options):
    return run_labelled(FAKE, cases, out=out, quiet=True, **{"workers": 1} | options)


def test_a_row_a_run_in_order_with_labels_in_front(tmp_path):
    """Fields that are tables become columns of their own; a label goes before a field."""
    cases = [({"n": n, "square": "mine"}, fake(n)) for n in (3, 2)]
    rows = run(cases, tmp_path)
    assert [row["n"] for row in rows] == [3, 2]
    assert {row["square"] for row in rows} == {"mine"}
    assert [row["parts.half"] for row in rows] == [4.5, 2.0]
    assert list(rows[0]) == [
        "n", "square", "parts.half", "per_cycle", "reused", "run_folder", "state", "reason",
    ]  # fmt: skip
    assert {(row["state"], row["reason"]) for row in rows} == {("done", "")}


def test_seeds_are_labels_and_name_the_folders(tmp_path):
    rows = run(over_seeds({"n": 2}, fake(2), [1, 7]), tmp_path)
    assert [(row["n"], row["seed"]) for row in rows] == [(2, 1), (2, 7)]
    assert len({row["run_folder"] for row in rows}) == 2
    assert "square-seed7-" in rows[1]["run_folder"]


def test_a_packing_that_runs_share_is_made_once_before_them(tmp_path):
    """Two workers at once: the second one to make the folder of the packing would fail."""
    cases = [({"n": n}, fake(n)) for n in range(4)]
    cases.append(({"n": 8}, fake(8, packing="dense")))
    rows = run(cases, tmp_path, workers=2)
    assert [row["state"] for row in rows] == ["done"] * 5
    assert len(list(tmp_path.glob("packings/*/packing.h5"))) == 2


def test_what_is_finished_is_read_and_not_done_again(tmp_path):
    first = run([({}, fake(2))], tmp_path)
    again = run([({}, fake(2)), ({}, fake(3))], tmp_path)
    assert [row["reused"] for row in [*first, *again]] == [False, True, False]


def test_what_fails_is_a_row_with_its_reason(tmp_path):
    """A sweep has no --again to offer, and the other runs go on."""
    rows = run([({}, fake(n)) for n in (13, 99, 2)], tmp_path)
    assert [row["state"] for row in rows] == ["failed", "interrupted", "done"]
    assert rows[0]["reason"] == (
        "13: unlucky; delete the folder of the run and the same command does it again"
    )
    assert rows[1]["reason"] == "the same command goes on"
    assert "square" not in rows[0]


def test_other_sources_are_reported_in_one_line(tmp_path, capsys):
    case = fake(2)
    run([({}, case)], tmp_path)
    assert capsys.readouterr().err == ""
    FAKE.packing_file(case, tmp_path).write_text(json.dumps({"sources": "0" * 12}))
    run([({}, case)], tmp_path)
    reported = capsys.readouterr().err
    assert reported.startswith(
        "warning: 0 of 1 runs and 1 of 1 packings were made by another version"
    )
    assert reported.count("\n") == 1


def test_compilation_is_reported_where_something_is_still_to_be_run(tmp_path, capsys):
    uncompiled = dataclasses.replace(FAKE, compiled=lambda: False)
    for reported in (1, 0):
        run_labelled(uncompiled, [({}, fake(2))], out=tmp_path, workers=1)
        assert capsys.readouterr().err.count("compiling the kernels") == reported


def test_parquet_keeps_every_bit_and_the_kinds_of_columns(tmp_path):
    """A third, a whole number, a truth, a text and a list, each also where it lacks."""
    rows = [
        {"x": 1 / 3, "n": 3, "ok": True, "word": "a", "each": [0.1, None], "mixed": 1},
        {"x": None, "n": None, "ok": None, "word": None, "each": None, "mixed": "two"},
    ]
    path = tmp_path / "table.parquet"
    path.write_bytes(as_parquet(rows, {"command": "x"}))
    about, back = read_parquet(path)
    assert about == {"command": "x"}
    assert back == [rows[0] | {"mixed": "1"}, rows[1]]


def test_csv_keeps_the_named_columns_and_groups():
    rows = [{"a": 1, "ab": 2, "shares.x": 0.1, "shares.y": None, "seed": 1}]
    assert as_csv(rows, ("a", "shares.")) == "a,shares.x,shares.y\n1,0.1,\n"
    assert as_csv(rows) == "a,ab,shares.x,shares.y,seed\n1,2,0.1,,1\n"


def test_a_list_is_one_cell_of_the_table_that_json_reads(tmp_path):
    """Such as a number for each cycle; None is null."""
    rows = run([({}, fake(3))], tmp_path)
    write_table(tmp_path, [{**rows[0], "gaps": [1.5, None]}])
    (row,) = csv.DictReader((tmp_path / "table.csv").read_text().splitlines())
    assert json.loads(row["per_cycle"]) == [9, 0.5]
    assert json.loads(row["gaps"]) == [1.5, None]
