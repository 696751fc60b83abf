"""Spreadsheets are read wherever a table is, and answers are written as tables."""

import json
import random
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from calibrating import calibrate
from refusals import assert_refused

from calibration.files.sheets import sheets
from calibration.files.tables import read_table
from calibration.files.track_table import read_tracks
from granulab.errors import InputError


def book(path, **frames):
    with pd.ExcelWriter(path, engine="xlsxwriter") as writer:
        for name, frame in frames.items():
            frame.to_excel(writer, sheet_name=name, index=False)
    return path


def test_a_spreadsheet_holds_what_its_csv_holds(tmp_path):
    """Spreadsheets keep 16 digits: to 5e-16 of a number."""
    rng = np.random.default_rng(1)
    frame = pd.DataFrame({"load [kN]": rng.standard_normal(40), "group": ["a", "b"] * 20})
    frame.to_csv(tmp_path / "t.csv", index=False)
    ours = read_table(book(tmp_path / "t.xlsx", only=frame))
    theirs = read_table(tmp_path / "t.csv")
    np.testing.assert_allclose(ours.column("load", "N"), theirs.column("load", "N"), rtol=1e-15)
    assert ours.labels("group") == theirs.labels("group")
    assert ours.remarks == ()


def test_a_track_in_a_spreadsheet_is_a_track(tmp_path):
    frame = pd.DataFrame({"frame": range(20), "x": 3.0, "y": np.linspace(0, 9.5, 20)})
    (track,) = read_tracks(book(tmp_path / "t.xlsx", track=frame))
    np.testing.assert_allclose(track.y, frame["y"])


def test_of_several_sheets_the_one_with_most_numbers_is_read_and_said(tmp_path):
    one = pd.DataFrame({"angle [deg]": [20.0, 21.0, 22.0]})
    path = book(tmp_path / "t.xlsx", notes=pd.DataFrame({"who": ["A"]}),
                few=pd.DataFrame({"n": [1]}), tilt=one)  # fmt: skip
    found = calibrate("incline", path, "--json").json["friction"]
    assert found["trials"] == 3
    assert any("sheet 'tilt' is read" in one and "'few'" in one for one in found["remarks"])


def _broken(tmp_path):
    path = book(tmp_path / "t.xlsx", one=pd.DataFrame({"angle [deg]": [20.0]}))
    whole = path.read_bytes()
    with zipfile.ZipFile(tmp_path / "other.xlsx", "w") as packed:
        packed.writestr("readme.txt", "no workbook")
    yield "cut", whole[: len(whole) // 2]
    yield "zip", (tmp_path / "other.xlsx").read_bytes()
    yield "xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600)
    chance = random.Random(4)
    for k in range(60):
        damaged = bytearray(whole)
        for _ in range(chance.choice([1, 5, 50])):
            damaged[chance.randrange(4, len(damaged))] = chance.randrange(256)
        yield f"flipped {k}", bytes(damaged)


def test_a_damaged_spreadsheet_is_read_or_refused_in_a_line(tmp_path):
    """A flipped byte may stand where nothing reads it; what is refused names the file."""
    path, refusals = tmp_path / "damaged.xlsx", []
    for _, data in _broken(tmp_path):
        path.write_bytes(data)
        try:
            read_table(path)
        except InputError as error:
            refusals.append(str(error))
    assert len(refusals) >= 3
    assert all(str(path) in words and "\n" not in words for words in refusals)


def test_a_spreadsheet_that_unpacks_to_more_than_memory_is_refused(tmp_path):
    path = tmp_path / "bomb.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("xl/worksheets/sheet1.xml", bytes(300 * 2**20))
    with pytest.raises(InputError, match="larger than 256 MiB"):
        sheets(path)


@pytest.mark.parametrize("kind", ["xlsx", "csv"])
def test_tables_of_answers_hold_what_the_json_holds(tmp_path, kind):
    table = tmp_path / "t.csv"
    table.write_text("angle [deg],group\n20,a\n21,a\n25,b\n")
    written = tmp_path / f"out.{kind}"
    result = calibrate("incline", table, "--json", "--table", written).json
    assert str(written) in result["tables"]
    if kind == "xlsx":
        read = sheets(written)
        values = dict(fields for _, fields in read["values"])
        trials = [fields for _, fields in read["friction.per_trial"]][1:]
    else:
        values = pd.read_csv(written).set_index("quantity")["value"]
        trials = pd.read_csv(tmp_path / "out-friction.per_trial.csv").to_numpy()
    found = result["friction"]
    for key, wanted in (
        ("value", found["value"]),
        ("groups.a.value", found["groups"]["a"]["value"]),
    ):
        assert float(values[f"friction.{key}"]) == pytest.approx(wanted, rel=1e-15)
    singles = [one["value"] for one in found["per_trial"]]
    assert [float(line[2]) for line in trials] == pytest.approx(singles, rel=1e-15)
    assert json.dumps(result)  # with paths as words


def test_a_table_of_another_kind_is_refused_before_the_work(tmp_path):
    table = tmp_path / "t.csv"
    table.write_text("angle [deg]\n20\n")
    result = calibrate("incline", table, "--table", tmp_path / "out.ods")
    assert_refused(result, "out.ods", ".xlsx or .csv")
    assert [Path(p).name for p in tmp_path.iterdir()] == ["t.csv"]
