"""Record of how values came into a parameter file, and the page that shows it."""

import base64
import json
import re

import pandas as pd
import pytest
from calibrating import calibrate

from calibration.files.page import outliers


@pytest.fixture
def measured(tmp_path):
    """A file with a friction of nine trials, one of which is far off, and its table."""
    angles = [20.0, 20.4, 19.8, 20.1, 20.2, 19.9, 20.0, 20.3, 27.0]
    table = tmp_path / "tilt.csv"
    table.write_text("angle [deg]\n" + "\n".join(map(str, angles)) + "\n")
    into = tmp_path / "m.toml"
    calibrate("incline", table, "--into", into, "--pair", "wood-steel")
    return into


def test_the_record_keeps_answers_raw_data_and_figure(measured):
    folder = measured.with_suffix(".record")
    kept = json.loads((folder / "pair.wood-steel.friction.json").read_text())
    assert kept["raw"]["tilt.csv"].startswith("angle [deg]\n20.0\n")
    assert kept["answers"]["friction"]["value"] == kept["value"]
    assert kept["provenance"]["command"][0] == "calibrate"
    assert (folder / "pair.wood-steel.friction.png").read_bytes().startswith(b"\x89PNG")


def test_raw_data_are_kept_of_files_with_one_name_of_spreadsheets_and_of_older_codes(tmp_path):
    tables = [tmp_path / name / "run.csv" for name in "AB"]
    for k, table in enumerate(tables):
        table.parent.mkdir()
        table.write_bytes(f"angle [°]\n2{k}\n2{k}.5\n".encode(("cp1252", "utf-16")[k]))
    book = tmp_path / "tilt.xlsx"
    pd.DataFrame({"angle [deg]": [20.0, 21.0]}).to_excel(book, index=False)
    into = tmp_path / "m.toml"
    calibrate("incline", *tables, book, "--into", into, "--pair", "wood-steel")
    kept = json.loads((into.with_suffix(".record") / "pair.wood-steel.friction.json").read_text())
    assert [kept["raw"][str(table)][:14] for table in tables] == [
        "angle [°]\n20\n2", "angle [°]\n21\n2",
    ]  # fmt: skip
    assert kept["raw"]["tilt.xlsx"] == "# Sheet1\nangle [deg]\n20\n21\n"


def test_the_page_shows_what_a_reviewer_would_ask(measured, tmp_path):
    page = tmp_path / "m.html"
    calibrate("report", measured, "--page", page)
    text = page.read_text()
    for words in ("friction = 0.38", "how many trials", "<td>9</td>", "outliers", "line 10: 0.5095",
                  "angle [deg]", "pair.wood-steel"):  # fmt: skip
        assert words in text, words
    assert not re.search(r"https?://", text)
    picture = re.search(r"data:image/png;base64,([^\"]+)", text)[1]
    assert base64.b64decode(picture).startswith(b"\x89PNG")


def test_a_value_changed_by_hand_is_not_shown_as_measured(measured, tmp_path):
    measured.write_text(re.sub(r"value = 0\.38\d*", "value = 0.5", measured.read_text()))
    page = tmp_path / "m.html"
    found = calibrate("report", measured, "--page", page, "--json").json
    assert found["values"][0]["command"] is None
    assert "There is no record of the measurement" in page.read_text()


def test_the_record_of_a_replaced_value_is_kept(measured, tmp_path):
    table = tmp_path / "again.csv"
    table.write_text("angle [deg]\n30\n31\n")
    calibrate("incline", table, "--into", measured, "--pair", "wood-steel")
    kept = json.loads(
        (measured.with_suffix(".record") / "pair.wood-steel.friction.json").read_text()
    )
    assert "again.csv" in kept["raw"]
    assert [list(one["raw"]) for one in kept["history"]] == [["tilt.csv"]]


def test_shipped_tables_have_a_page_without_records(tmp_path):
    page = tmp_path / "wood.html"
    assert calibrate("report", "wood", "--page", page).code == 0
    assert "not on record" in page.read_text()


def test_outliers_are_more_than_three_and_a_half_robust_deviations_away():
    """Of 1 to 5 the median deviation is 1: beyond 3 +- 3.5 x 1.4826 lies 8.2 and more."""
    close = [(str(k), float(k)) for k in range(1, 6)]
    assert outliers([*close, ("far", 8.1)]) == []  # of six the median deviation is 1.5
    assert outliers([*close, *close, ("far", 12.0)]) == [("far", 12.0)]
    assert outliers(close[:3]) == []
