"""Tables of numbers and text: every dialect gives the same columns; reports on what is none."""

import contextlib
import csv
import io
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibration.files.dialect import name_and_unit
from calibration.files.tables import Table, read_table
from granulab.contact.files.datafile import data_root
from granulab.errors import InputError

_NUMBERS = st.floats(-1e9, 1e9, allow_nan=False, allow_infinity=False)
_DIALECTS = [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), (" ", "."), (" ", ",")]


def table_of(tmp_path, text: str | bytes) -> Table:
    path = tmp_path / "table.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_table(path)


@given(
    rows=st.lists(st.tuples(_NUMBERS, _NUMBERS, _NUMBERS), min_size=1, max_size=6),
    dialect=st.sampled_from(_DIALECTS),
    head=st.sampled_from(["", "time [s]|load (N)|x", "time|load|x", '"time [s]"|"load (N)"|"x"']),
    blank=st.sampled_from(["", "\n", "# remark, with; all\tseparators 1,5\n", "   \n"]),
    quoted=st.booleans(),
    ending=st.sampled_from(["\n", "\r\n"]),
)
def test_every_dialect_gives_the_same_numbers(
    tmp_path_factory, rows, dialect, head, blank, quoted, ending
):
    """Oracle: the floats that were written with repr, which float() reads back exactly."""
    separator, point = dialect
    mark = '"' if quoted else ""
    lines = [separator.join(f"{mark}{v!r}{mark}".replace(".", point) for v in row) for row in rows]
    text = (head.replace("|", separator) + "\n" if head else "") + blank + "\n".join(lines) + "\n"
    path = tmp_path_factory.mktemp("tables") / "t.csv"
    path.write_bytes(text.replace("\n", ending).encode())
    table = read_table(path)
    np.testing.assert_array_equal(np.column_stack(list(table.columns.values())), np.array(rows))
    if "[" in head:
        assert list(table.units.items()) == [("time", "s"), ("load", "N"), ("x", "")]


_WORDS = st.text(st.characters(codec="utf-8", categories=["L", "N", "P", "Zs"]), max_size=12)


@given(
    rows=st.lists(st.tuples(_WORDS, _NUMBERS), min_size=2, max_size=6),
    separator=st.sampled_from([";", "\t"]),
)
def test_text_of_any_kind_stands_next_to_the_numbers(tmp_path_factory, rows, separator):
    """Oracle: what the csv module wrote, spaces at the ends left out."""
    written = io.StringIO()
    writer = csv.writer(written, delimiter=separator, quoting=csv.QUOTE_ALL)
    writer.writerows([("pairing", "angle"), *((f"x{w}", repr(v)) for w, v in rows)])
    path = tmp_path_factory.mktemp("tables") / "t.csv"
    path.write_bytes(written.getvalue().encode())
    table = read_table(path)
    assert table.labels("pairing") == tuple(f"x{word}".strip() for word, _ in rows)
    assert list(table.columns["angle"]) == [value for _, value in rows]


@given(data=st.binary(max_size=200))
def test_any_bytes_are_a_table_or_refused(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("tables") / "t.csv"
    path.write_bytes(data)
    with contextlib.suppress(InputError):  # its line is looked at in the tests below
        table = read_table(path)
        assert all(len(column) == len(table.lines) for column in table.columns.values())


def test_a_testing_machine_writes_units_below_and_quotes_everything(tmp_path):
    table = table_of(
        tmp_path, '"Time","Extension","Load"\n"(s)","(mm)","(kN)"\n"0.0","0.1","2"\n"1","0.2","3"\n'
    )
    np.testing.assert_allclose(table.column("load", "N"), [2000, 3000], rtol=1e-15)
    np.testing.assert_allclose(table.column("EXTENSION", "m"), [1e-4, 2e-4], rtol=1e-15)


@pytest.mark.parametrize(
    ("head", "unit", "factor"),
    [
        ("dx_mm", "m", 1e-3),
        ("dx_m_s", "m/s", 1.0),
        ("dx_m_per_s", "m/s", 1.0),
        ("dx_g_cm3", "kg/m3", 1e3),
        ("dx_MPa", "Pa", 1e6),
        ("dx [µm]", "m", 1e-6),
        ("dx (mm²)", "m2", 1e-6),
        ("dx_percent", "1", 0.01),
        ("dx", "1", 1.0),
    ],
)
def test_the_unit_may_stand_in_the_name(tmp_path, head, unit, factor):
    """One rounding of the conversion: 1e-15."""
    table = table_of(tmp_path, f"{head};note\n4;a\n5;b\n")
    np.testing.assert_allclose(table.column("dx", unit), [4 * factor, 5 * factor], rtol=1e-15)


def test_spaces_empty_fields_surplus_separators_and_other_encodings(tmp_path):
    table = table_of(tmp_path, "  Frame    r (m) (Cam 1)   v (m)\n   0   1.5    2\n  1  2  3\n")
    assert list(table.units.items()) == [("Frame", ""), ("r (Cam 1)", "m"), ("v", "m")]
    table = table_of(tmp_path, "a;b\n1;\n;2;\n")
    np.testing.assert_array_equal(table.columns["a"], [1, math.nan])
    table = table_of(tmp_path, "x y z\n1  3\n2 4 \n")  # one space each, some fields empty
    np.testing.assert_array_equal(table.columns["y"], [math.nan, 4])
    for encoding in ("utf-16", "cp1252", "utf-8-sig"):
        table = table_of(tmp_path, "Weg [µm];n\n1;2\n".encode(encoding))
        assert table.units["Weg"] == "µm", encoding


_NUMBERS_OF_3 = {"Nr": [1, 2, 3], "angle": [20.8, 21.3, 20.1]}


@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("pad", [False, True])  # spreadsheets fill every line to the same width
@pytest.mark.parametrize("below", ["", "\nNotes: by hand\nHumidity 45 %\n", "Mean|21.07\nSD|0.6\n"])
@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_words_above_and_below_the_numbers_are_left_out_and_reported(
    tmp_path, separator, pad, below, encoding
):
    """A title, a remark and a line of units above; notes, or a mean that is no trial, below."""
    text = "Versuch 7, Müller|\nPlatte 3|\n|\nNr|angle\n|[°]\n1|20.8\n2|21.3\n3|20.1\n" + below
    lines = [line if pad else line.rstrip("|") for line in text.splitlines()]
    text = "\r\n".join(lines).replace("|", separator)
    table = table_of(tmp_path, text.encode(encoding))
    assert {name: list(column) for name, column in table.columns.items()} == _NUMBERS_OF_3
    assert table.units["angle"] == "°"
    assert any("above the head" in words for words in table.remarks)
    assert sum("a note or made from" in words for words in table.remarks) == (2 if below else 0)


def test_a_slip_among_the_numbers_or_at_their_end_is_no_note(tmp_path):
    for last in ("2x", "21,x", "1.021,3"):
        for text in (f"angle;a\n20;1\n{last};2\n", f"angle;a\n{last};1\n20;2\n21;3\n"):
            with pytest.raises(InputError, match=f"angle = '{last}' is no number"):
                table_of(tmp_path, text).column("angle", "1")
    table = table_of(tmp_path, "angle [deg];a\n\N{MINUS SIGN}20,8;A\n21,3;B\n")
    assert list(table.columns["angle"]) == [-20.8, 21.3]  # and not a line of units


def test_means_between_the_trials_are_no_trials(tmp_path):
    text = "pairing,angle [deg]\nA,20\nA,22\nMean:,21\nMax,22\nB,23\nB,25\nmean,24\nSD,1.4\n"
    table = table_of(tmp_path, text)
    assert list(table.columns["angle"]) == [20, 22, 23, 25]
    assert len(table.remarks) == 4
    table = table_of(tmp_path, "load,angle [deg]\nmin,20\nmax,22\n")  # groups, not made of others
    assert list(table.columns["angle"]) == [20, 22]


def test_a_head_and_labels_stand_between_spaces(tmp_path):
    table = table_of(tmp_path, "angle [deg]  pairing\n20.1  A\n21.2  B\n")
    assert (table.units["angle"], table.labels("pairing")) == ("deg", ("A", "B"))


@pytest.mark.parametrize("head", [",angle [deg]", "#,angle [deg]", "# by hand\n#,angle [deg]"])
def test_a_column_of_line_numbers_needs_no_name(tmp_path, head):
    """As pandas writes its index; a # in front of a separator names a column, and is no remark."""
    table = table_of(tmp_path, f"{head}\n# a remark\n0,20.8\n1,21.3\n")
    assert list(table.columns["angle"]) == [20.8, 21.3]
    assert table.units["angle"] == "deg"


def test_what_else_spreadsheets_write(tmp_path):
    table = table_of(tmp_path, "sep=,\na,b\n1,2\n3,4\n")  # Excel's own line
    assert list(table.columns) == ["a", "b"]
    table = table_of(tmp_path, "a\n1\n#DIV/0!\n#WERT!\n3\n")  # errors are no remarks
    np.testing.assert_array_equal(table.columns["a"], [1, math.nan, math.nan, 3])
    table = table_of(tmp_path, "a;;b\n[deg];[rad];\n1;2;x\n")  # two cells of the head in one
    assert table.units == {"a": "deg", "column 2": "rad", "b": ""}


def test_one_column_with_decimal_commas_is_one_column(tmp_path):
    assert list(table_of(tmp_path, "angle\n20,5\n21,0\n").columns["angle"]) == [20.5, 21.0]


def test_columns_can_be_called_otherwise(tmp_path):
    table = table_of(tmp_path, "Kraft;load\n1;7\n2;8\n").renamed({"load": "Kraft [kN]"})
    assert list(table.column("load", "N")) == [1000, 2000]
    headless = table_of(tmp_path, "1 2\n3 4\n").renamed({"load": "column 2 [N]"})
    assert list(headless.column("load", "N")) == [2, 4]


def test_parts_of_a_head():
    assert name_and_unit("load (max) [N]") == ("load (max)", "N")
    assert name_and_unit("load") == ("load", "")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("", "empty"),
        ("\n# only this\n", "empty"),
        ("a,b\n", "no line below the head"),
        ("a,b\nx,y\n", "no column of numbers"),
        ("a,b\n1,2\n3\n", "line 3: 1 fields and not 2"),
        ("a,a\n1,2\n", "two columns are called 'a'"),
        ("flat,1,2\nflat,3,4\n", "a head is missing"),
        ('a,b\n"1,234",2\n', "a comma in quotes may be decimal or mark thousands"),
        ("time [ms];load [N]\n1.5,2\n2.5,3\n", "line 1, .* does not name them; write a line of"),
        ("a;b\n20.8°;c\n", "no column of numbers; line 2: a = '20.8°' is no number"),
        ("a;b\n1,5;2\n2.5;3\n", "decimal commas and decimal points"),
        ("a;b\n0,5;1.250\n0,6;1.500\n", "a = '0,5' has a decimal comma and b = '1.250' a point"),
        ("a;b\n0.5;1,250\n0.6;1,500\n", "b = '1,250' has a decimal comma and a = '0.5' a point"),
        (b"RIFF\x00\x01\x02", "not a text file"),
    ],
)
def test_what_is_no_table_is_reported_in_one_line(tmp_path, text, line):
    with pytest.raises(InputError, match=line) as caught:
        table_of(tmp_path, text)
    assert "\n" not in str(caught.value)
    assert "table.csv" in str(caught.value)


def test_a_missing_column_unit_or_number_is_reported_with_what_would_do(tmp_path):
    table = table_of(tmp_path, "load;x [mm]\n1;2\n1_0;3\n")
    with pytest.raises(InputError, match="line 3: load = '1_0' is no number"):
        table.column("load", "N", written_in="N")
    with pytest.raises(InputError, match=r"the unit is missing; write it .* 'load \[N\]'"):
        table.column("load", "N")
    with pytest.raises(InputError, match="no column 'lod'; did you mean 'load'"):
        table.column("lod", "N")
    with pytest.raises(InputError, match="the unit is wrong here"):
        table.column("x", "N")


def test_a_device_is_no_file():
    """It may have no end: /dev/zero would fill the memory."""
    with pytest.raises(InputError, match="/dev/null: not a file"):
        read_table("/dev/null")


def test_there_is_no_table_where_there_is_no_file(tmp_path):
    for path in (tmp_path / "no.csv", tmp_path, "a\0b"):
        with pytest.raises(InputError, match="cannot be read"):
            read_table(path)


@pytest.mark.parametrize("path", sorted((data_root() / "published").glob("*.csv")), ids=str)
def test_every_published_table_is_read(path):
    """Rows: the lines that are no remark, less the head."""
    kept = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    assert len(read_table(path).lines) == len(kept) - 1
