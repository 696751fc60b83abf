"""Data files: the folder of the shipped ones, in a checkout or installed, and reading TOML."""

import tomllib
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


def is_file(path: Path) -> bool:
    """True where there is such a file; False also for a name that no file can have."""
    try:
        return path.is_file()
    except OSError:  # too long
        return False


def find(name: str, kind: str, folder: Path) -> str | Path:
    """A file in the folder of the case, else a shipped one of a kind, else the name as it is."""
    return folder / name if is_file(folder / name) else data_file(kind, name) or name


def read_toml(path: Path, kind: str, schema: int) -> dict[str, Any]:
    """The tables of a TOML file of a kind, its schema number checked and taken out.

    Raises InputError, one line that names the file, where it is missing, cannot be read, is no
    TOML, or is of another schema.
    """
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        hint = nearest(str(path), data_names(kind))
        raise InputError(f"{path}: no such {kind} file, nor a shipped one; {hint}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give a TOML file") from None
    except ValueError as error:  # also bytes that are not text
        raise InputError(f"{path}: not valid TOML: {error}") from None
    if "schema" not in document:
        raise InputError(f"{path}: schema is missing; write schema = {schema} on the first line")
    found = document.pop("schema")
    if type(found) is not int or found != schema:
        raise InputError(f"{path}: schema = {found!r}: unknown; this version reads {schema}")
    return document
