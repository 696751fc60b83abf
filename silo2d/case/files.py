"""Shape sets and materials tables that cases name, read once while their text stays the same."""

from functools import lru_cache
from pathlib import Path

from granulab.contact.files.table import ContactTable, load_table
from silo2d.case.shape import ShapeSet, load_shapes


def shapes_of(file: str | Path) -> ShapeSet:
    """See load_shapes; the same object for the same text."""
    return _shapes(file, _content(file))


def table_of(file: str | Path) -> ContactTable:
    """See load_table; the same object for the same text."""
    return _table(file, _content(file))


def _content(file: str | Path) -> bytes:
    try:
        return Path(file).read_bytes()
    except OSError:
        return b""  # the reader says what is wrong


@lru_cache(maxsize=8)
def _shapes(file: str | Path, _content: bytes) -> ShapeSet:
    return load_shapes(file)


@lru_cache(maxsize=8)
def _table(file: str | Path, _content: bytes) -> ContactTable:
    return load_table(file)
