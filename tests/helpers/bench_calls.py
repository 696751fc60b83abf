"""Tables for the commands of the bench."""

from collections.abc import Sequence
from pathlib import Path


def write(path: Path, head: str, columns: Sequence[Sequence[object]]) -> Path:
    """A table of columns below its head; the floats as repr writes them."""
    rows = [";".join(str(v) for v in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([head, *rows]) + "\n")
    return path
