"""Answers of a measurement as tables that spreadsheets open: xlsx, or CSV files next to each other.

What stands in the JSON of a result stands in the tables, under the same keys: single values by
name in "values", and so do sentences; a list of objects (trials, bounces, throws) is a table of its
own, lists of numbers are columns of "series".
"""

import io
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from granulab.campaign.output.files import write_atomic
from granulab.campaign.output.table import as_csv, flat
from granulab.errors import InputError

Rows = list[dict[str, Any]]
KINDS = (".xlsx", ".csv")
_LONGEST_NAME = 31  # of a sheet
_NO_NAME = re.compile(r"[\[\]:*?/\\']")  # signs that a sheet's name may not have


def check_table(path: Path) -> Path:
    """The path; InputError for one that no table can be written to under that name."""
    if path.suffix.lower() not in KINDS:
        raise InputError(f"--table = {str(path)!r}: end the name with {' or '.join(KINDS)}")
    return path


def write_answers(path: Path, answers: Mapping[str, Any]) -> list[Path]:
    """Write all answers as one workbook, or as PATH.csv and PATH-NAME.csv; the files.

    Raises FolderError where they cannot be written.
    """
    tables = tables_of(answers)
    if path.suffix.lower() == ".xlsx":
        write_atomic(path, _workbook(tables))
        return [path]
    files = {path.with_name(f"{path.stem}-{name}.csv"): rows for name, rows in tables.items()}
    files = {path: tables["values"], **dict(list(files.items())[1:])}
    for file, rows in files.items():
        write_atomic(file, as_csv(rows))
    return list(files)


def tables_of(answers: Mapping[str, Any]) -> dict[str, Rows]:
    """Tables by name, "values" first; see the head of this file."""
    values: Rows = []
    tables: dict[str, Rows] = {}
    series: dict[str, list[Any]] = {}
    for name, value in flat(answers):
        if isinstance(value, list) and value and all(isinstance(one, dict) for one in value):
            tables[name] = [dict(_in_a_line(one)) for one in value]
        elif isinstance(value, list) and any(isinstance(one, str) for one in value):
            values += [{"quantity": name, "value": one} for one in value]
        elif isinstance(value, list) and value:
            series[name] = value
        elif not isinstance(value, list):
            values.append({"quantity": name, "value": value})
    found = {"values": values, **tables}
    if series:
        longest = max(map(len, series.values()))
        found["series"] = [
            {name: one[k] if k < len(one) else None for name, one in series.items()}
            for k in range(longest)
        ]
    return found


def _in_a_line(row: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """An object of a list: what it holds of lists as words, since a cell holds one value."""
    for key, value in flat(row):
        if isinstance(value, list):
            value = " ".join(f"{one:.6g}" if isinstance(one, float) else str(one) for one in value)
        yield key, value


def _workbook(tables: Mapping[str, Rows]) -> bytes:
    from pandas import DataFrame, ExcelWriter

    image = io.BytesIO()
    taken: set[str] = set()
    with ExcelWriter(image, engine="xlsxwriter") as book:
        for name, rows in tables.items():
            sheet = _NO_NAME.sub(" ", name)[-_LONGEST_NAME:]
            while sheet.lower() in taken:
                sheet = f"{sheet[: _LONGEST_NAME - 2]} {len(taken)}"
            taken.add(sheet.lower())
            DataFrame(rows).to_excel(book, sheet_name=sheet, index=False)
    return image.getvalue()
