"""Sheets of spreadsheets (xls, xlsx, ods) as lines of fields, by one reader for all of them."""

import zipfile
from pathlib import Path
from typing import Any

from calibration.files.dialect import Row, is_number
from granulab.errors import InputError

_MARKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1")  # of a zip, and of what xls is in
_MOST_BYTES = 2**28  # unpacked


def is_spreadsheet(path: Path) -> bool:
    """True for a file that begins as spreadsheets do, whatever it is called."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return file.read(8).startswith(_MARKS)
    except (OSError, ValueError):
        return False  # who reads it says why


def sheets(path: Path) -> dict[str, list[Row]]:
    """The lines that say something of each sheet, by its name; numbers with all their digits.

    Raises InputError for what no spreadsheet is, and for one that is damaged or locked.
    """
    from python_calamine import CalamineWorkbook

    _refuse_large(path)
    try:
        book = CalamineWorkbook.from_path(str(path))
        read = {name: book.get_sheet_by_name(name).to_python() for name in book.sheet_names}
    except (KeyboardInterrupt, SystemExit, MemoryError):
        raise
    except BaseException as error:  # the reader's own, among them panics, which are no Exception
        first = str(error).partition("\n")[0]
        raise InputError(
            f"{path}: a spreadsheet that cannot be read ({first or type(error).__name__}); save it "
            "again without a password, or as CSV"
        ) from None
    return {name: _lines(cells) for name, cells in read.items()}


def best_sheet(path: Path) -> tuple[list[Row], tuple[str, ...]]:
    """The lines of the sheet that holds most numbers, and a remark where others hold some."""
    found = sheets(path)
    numbers = {
        name: sum(is_number(field) for _, fields in lines for field in fields)
        for name, lines in found.items()
    }
    named = max(numbers, key=lambda name: numbers[name], default=None)
    if named is None or not found[named]:
        raise InputError(f"{path}: empty")
    others = [name for name, n in numbers.items() if n and name != named]
    if not others:
        return found[named], ()
    listed = ", ".join(map(repr, others))
    return found[named], (
        f"{path}: sheet {named!r} is read, which holds most numbers, and not {listed}; save "
        "another one as CSV to read that",
    )


def _refuse_large(path: Path) -> None:
    """A small file may unpack to more than there is memory for."""
    try:
        with zipfile.ZipFile(path) as packed:
            size = sum(part.file_size for part in packed.infolist())
    except (zipfile.BadZipFile, NotImplementedError, OSError, ValueError):
        size = path.stat().st_size  # an xls, or damaged
    if size > _MOST_BYTES:
        raise InputError(f"{path}: larger than {_MOST_BYTES >> 20} MiB; save the part of it as CSV")


def _lines(cells: list[list[Any]]) -> list[Row]:
    fields = [[_field(cell) for cell in line] for line in cells]
    return [(number, line) for number, line in enumerate(fields, start=1) if any(line)]


def _field(cell: Any) -> str:
    """A cell as it would stand in a table: 65 and not 65.0, times as Excel's CSV has them."""
    if isinstance(cell, float) and cell.is_integer() and abs(cell) < 1e15:
        return str(int(cell))
    return str(cell).strip()
