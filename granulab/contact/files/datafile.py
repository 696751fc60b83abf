"""Data files: the folder of the shipped ones, in a checkout or installed, and reading TOML."""

import csv
import os
import stat
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from granulab.contact.files.units import nearest
from granulab.errors import InputError

_GRANULAB = Path(__file__).resolve().parents[2]


def data_root() -> Path:
    """The folder of the shipped tables, shapes, materials and cases."""
    installed = _GRANULAB / "data"  # in a wheel; a checkout has it next to the packages
    return installed if installed.is_dir() else _GRANULAB.parent / "data"


def data_names(kind: str) -> list[str]:
    """Names of the shipped files of a kind: "materials", "shapes", "cases" or "published"."""
    return sorted(path.stem for path in (data_root() / kind).glob("*.*"))


def case_names(table: str) -> list[str]:
    """Names of the shipped cases that have a table, such as "silo": those of one simulator."""
    cases = data_root() / "cases"
    return [
        name
        for name in data_names("cases")
        if f"[{table}]" in (cases / f"{name}.toml").read_text(encoding="utf-8")
    ]


def data_file(kind: str, name: str) -> Path | None:
    """Path of the shipped file `name` of a kind (without its ending), or None."""
    return next((p for p in sorted((data_root() / kind).glob("*.*")) if p.stem == name), None)


def shipped_rows(kind: str, name: str) -> list[dict[str, str]]:
    """Rows of a shipped CSV table of a kind, by the names of its columns, without its remarks."""
    path = data_file(kind, name)
    assert path is not None  # shipped
    lines = path.read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def is_file(path: Path) -> bool:
    """True where there is such a file; False also for a name that no file can have."""
    try:
        return path.is_file()
    except OSError:  # too long
        return False


def content_of(file: str | Path) -> bytes:
    """Content of a file by which what was read of it is kept; empty where it cannot be read."""
    try:
        return Path(file).read_bytes() if is_file(Path(file)) else b""
    except OSError:
        return b""  # the reader says what is wrong


def is_shipped(file: str | Path, kind: str) -> bool:
    """True for a shipped file of a kind and for a copy of it, as a run folder holds one."""
    return content_of(file) in map(content_of, (data_root() / kind).glob("*.*"))


def refuse_pipe(path: Path) -> None:
    """Raise InputError for a pipe, socket or device, which may give bytes late or for ever."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):  # nothing there, a loop of links, no name for a file
        return
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode) or str(path) == os.devnull):
        raise InputError(f"{path}: a pipe or device, not a file; write it to a file and give that")


def find(name: str, kind: str, folder: Path) -> str | Path:
    """A file in the folder of the case, else a shipped one of a kind, else the name as it is.

    Raises InputError for a name that no file has.
    """
    if "\0" in name:
        raise InputError(f"{kind} = {name!r}: no name of a file; leave out the zero byte")
    refuse_pipe(folder / name)
    return folder / name if is_file(folder / name) else data_file(kind, name) or name


def csv_lines(path: Path, what: str) -> list[str]:
    """Lines of a CSV file; InputError where there is none, and what to give, or it is no text."""
    if not is_file(path):
        raise InputError(f"{path}: no such file; give {what}")
    try:
        return path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: no CSV table: {error}") from None


def csv_rows(path: Path, what: str) -> list[tuple[int, list[str]]]:
    """Line number and cells of each line of a CSV table; see csv_lines, numbered."""
    return numbered(csv_lines(path, what))


def below_header(path: Path, what: str, header: str) -> list[list[str]]:
    """Cells of each line of a CSV table below its header; InputError where it has none."""
    rows = [[cell.strip() for cell in row] for _, row in csv_rows(path, what)]
    if rows and rows[0][0][:1] in tuple("0123456789.+-"):
        raise InputError(f"{path}: expected a line {header!r} first, above the numbers")
    return rows[1:]


def numbered(lines: list[str]) -> list[tuple[int, list[str]]]:
    """Line number and cells of each line, but empty ones and remarks after a #."""
    rows = enumerate(csv.reader(lines), 1)
    return [(k, row) for k, row in rows if any(map(str.strip, row)) and row[0][:1] != "#"]


def toml_text(path: Path) -> tuple[str, dict[str, Any]]:
    """The text of a TOML file, and its tables.

    Raises FileNotFoundError where there is none, and InputError, one line that names the file,
    where it is no file that ends, no text, no TOML, or nested beyond belief.
    """
    try:
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: not a file; give a TOML file")
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(f"{path}: larger than {_MOST_BYTES >> 20} MB; give a TOML file")
        text = path.read_text(encoding="utf-8")
        tables = tomllib.loads(text)
    except (FileNotFoundError, InputError):
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give a TOML file") from None
    except ValueError as error:  # also bytes that are not text, and a name with a NUL
        raise InputError(f"{path}: not valid TOML: {error}") from None
    except RecursionError:
        raise _nested(path) from None
    level: list[Any] = [tables]
    for _ in range(_DEEPEST):
        level = [inner for outer in level for inner in _inside(outer)]
    if level:
        raise _nested(path)
    return text, tables


_MOST_BYTES = 2**26
_DEEPEST = 50  # tables and lists in each other; the deepest of ours have five


def _inside(outer: Any) -> list[Any]:
    parts = outer.values() if isinstance(outer, dict) else outer if isinstance(outer, list) else []
    return [part for part in parts if isinstance(part, dict | list)]


def _nested(path: Path) -> InputError:
    return InputError(f"{path}: tables or lists nested more than {_DEEPEST} deep; none needs that")


def read_toml(
    path: Path, kind: str, schema: int, lacks: Callable[[dict[str, Any]], str] = lambda document: ""
) -> dict[str, Any]:
    """The tables of a TOML file of a kind, its schema number checked and taken out.

    lacks: words on what else is missing in the tables, for the line about a missing schema.
    Raises InputError, one line that names the file, where it is missing, cannot be read, is no
    TOML, or is of another schema.
    """
    try:
        _, document = toml_text(path)
    except FileNotFoundError:
        hint = nearest(str(path), data_names(kind))
        raise InputError(f"{path}: no such {kind} file, nor a shipped one; {hint}") from None
    if "schema" not in document:
        more = f"; {words}" if (words := lacks(document)) else ""
        raise InputError(
            f"{path}: schema is missing; write schema = {schema} on the first line{more}"
        )
    found = document.pop("schema")
    if type(found) is not int or found != schema:
        raise InputError(f"{path}: schema = {found!r}: unknown; this version reads {schema}")
    return document
