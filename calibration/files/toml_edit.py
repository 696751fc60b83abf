"""One entry of a TOML file changed or added; every other character stays as it was.

Several commands may edit a file: one at a time, and whole or not at all.
"""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.container import OutOfOrderTableProxy
from tomlkit.items import InlineTable, Table

from granulab.campaign.output.files import write_atomic
from granulab.errors import FolderError, InputError

_LONGEST_WAIT = 60.0  # for another writer, who needs milliseconds [s]


def with_entry(text: str, section: list[str], key: str, entry: Mapping[str, Any]) -> str:
    """The text with `key` of the table [section] holding `entry`, an inline table.

    What is there is replaced where it stands, and its comment stays; what is new comes after the
    last key of its section, and a new section at the end of the text. A text whose layout hinders
    that gives another result, or ValueError (tomlkit's): the caller compares.
    """
    document = tomlkit.parse(text)
    table = _find(document, section)
    if table is None:
        gap = "" if not text or text.endswith("\n\n") else "\n" if text.endswith("\n") else "\n\n"
        return f"{text}{gap}[{'.'.join(section)}]\n{key} = {inline(entry)}\n"
    # tomlkit drops the blank behind a date: it is given marks, which the values then replace.
    mark = "value"
    while mark in text:
        mark += "_"
    put: dict[str, Any] = {}
    if isinstance(old := table.get(key), Table):  # [section.key], or key.value = ...
        for name in [name for name in old if name not in entry]:
            del old[name]
        for name, value in entry.items():
            put[f"{mark} {name}"] = value
            old[name] = f"{mark} {name}"
    else:
        put[mark] = entry
        if key in table or isinstance(table, InlineTable):
            table[key] = mark
        else:
            _add_after_last(table, key, f'"{mark}"')
    edited = _with_lines_of(text, tomlkit.dumps(tomlkit.parse(text)), tomlkit.dumps(document))
    for held, value in put.items():
        edited = edited.replace(f'"{held}"', inline(value))
    return edited


def _with_lines_of(text: str, read: str, edited: str) -> str:
    """The edited text, with the lines that did not change as they are in the first text.

    read is that text as tomlkit gives it back, without the blank behind a date.
    """
    own, before, after = (one.splitlines(keepends=True) for one in (text, read, edited))
    if len(own) != len(before):
        return edited
    lines = []
    for kind, start, end, first, last in SequenceMatcher(None, before, after, False).get_opcodes():
        lines += own[start:end] if kind == "equal" else after[first:last]
    return "".join(lines)


def inline(value: Any) -> str:
    """A value as TOML on one line; but each table of an array on a line of its own."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {inline(held)}" for key, held in value.items()) + " }"
    if isinstance(value, list):
        return "[\n" + "".join(f"    {inline(held)},\n" for held in value) + "]"
    return tomlkit.item(value).as_string()


def _find(document: Any, section: list[str]) -> Any:
    """The table with a head of its own, or an inline one; None where there is none."""
    table = document
    for name in section:
        if name not in table:
            return None
        table = table[name]
    return None if isinstance(table, Table) and table.is_super_table() else table


def _add_after_last(table: Any, key: str, written: str) -> None:
    """Put a key behind the last one of a table, or behind its head.

    Not at the table's end, where tomlkit would: blank lines and comments there belong to the head
    of the next one. The text goes into what trails the last key, so that its position is certain.
    """
    if isinstance(table, OutOfOrderTableProxy):  # other heads stand between it and its own tables
        table = next(part for part in table._tables if not part.is_super_table())
    plain = [item for item in table.values() if not isinstance(item, Table)]
    last = plain[-1] if plain else table
    trail = last.trivia.trail
    line = f"{last.trivia.indent if plain else ''}{key} = {written}\n"
    last.trivia.trail = f"{trail}{line}" if trail.endswith("\n") else f"{trail}\n{line}"


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Keep other writers off a file; remove what a killed one left next to it.

    Raises InputError where one holds it for a minute, or the folder cannot be written.
    """
    from filelock import FileLock, Timeout

    file = path.resolve()  # a link's target: the file has one lock, whatever it is called
    try:
        # The system's own lock: it ends with its process.
        with FileLock(file.with_name(f".{file.name}.lock"), timeout=_LONGEST_WAIT):
            for leftover in file.parent.glob(f".{file.name}.*.tmp"):
                leftover.unlink(missing_ok=True)
            yield
    except Timeout:
        raise InputError(f"{path}: another command is writing it; try again") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None


def write(path: Path, text: str) -> None:
    """Write a file, or what a link points at; it keeps its rights.

    At any moment, also after kill -9, it is the old one or the new one. Raises InputError where
    it cannot be written, or is write-protected.
    """
    file = path.resolve()
    mode = file.stat().st_mode if file.exists() else None
    # The new file takes the old one's name, for which the folder's rights would do.
    if mode is not None and not (mode & 0o222 and os.access(file, os.W_OK)):
        raise InputError(f"{path}: is write-protected; chmod u+w {path}, or name another file")
    try:
        write_atomic(file, text)
    except FolderError as error:
        raise InputError(str(error)) from None
    if mode is not None:
        file.chmod(mode)
