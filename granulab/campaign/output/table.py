"""A tidy table of rows as files: CSV for eyes and spreadsheets, Parquet and HDF5 with every bit."""

import io
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import takewhile
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from granulab.campaign.output.files import write_atomic

if TYPE_CHECKING:
    from pandas import DataFrame

Row = Mapping[str, Any]


def write_table(folder: Path, rows: Sequence[Row]) -> list[str]:
    """Write table.csv, table.parquet and table.h5, each as one whole file; their names.

    The columns are all keys in the order in which they first appear; what a row lacks is empty or
    NaN. A run_folder is written as seen from the table's folder: both can be moved together. In
    HDF5 each is a dataset, of integers, of floating-point numbers, or of texts. Raises FolderError
    where they cannot be written.
    """
    here, real = folder.resolve(), cache(Path.resolve)  # each folder of runs once, not each run's
    rows = [_from(here, real, row) for row in rows]
    write_atomic(folder / "table.csv", as_csv(rows))
    write_atomic(folder / "table.parquet", as_parquet(rows))
    image = io.BytesIO()  # not on disk: HDF5 that meets a full disk itself ends the process
    with h5py.File(image, "w", track_order=True) as file:
        for name in _names(rows):
            file.create_dataset(name, data=_column([row.get(name) for row in rows]))
    write_atomic(folder / "table.h5", image.getvalue())
    return ["table.csv", "table.parquet", "table.h5"]


def _from(folder: Path, real: Callable[[Path], Path], row: Row) -> Row:
    """The row with its run_folder, if any, seen from a folder; real: gives a path resolved."""
    if not row.get("run_folder"):
        return row
    run = Path(row["run_folder"])
    return {**row, "run_folder": _seen_from(folder, real(run.parent) / run.name)}


def _seen_from(folder: PurePath, path: PurePath) -> str:
    """A path from a folder on, with slashes; whole where it is on another drive (Windows)."""
    here, there = folder.parts, path.parts
    shared = len(list(takewhile(lambda pair: pair[0] == pair[1], zip(here, there, strict=False))))
    if not shared:
        return path.as_posix()
    up = [".."] * (len(here) - shared)
    return type(path)(*up, *there[shared:]).as_posix()


def flat(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """The entries of nested tables, by names with dots: "dissipated_j.friction"."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", value


def as_csv(rows: Sequence[Row], kept: tuple[str, ...] | None = None) -> str:
    """Rows as CSV, all columns or those `kept`: by name, or "shares." for all that begin so."""
    from pandas import DataFrame

    names = _names(rows)
    if kept is not None:
        groups = tuple(name for name in kept if name.endswith("."))
        names = [name for name in names if name in kept or name.startswith(groups)]
    cells = [[_cell(row.get(name)) for name in names] for row in rows]
    frame = DataFrame(cells, columns=names, dtype=object)
    text: str = frame.to_csv(index=False, lineterminator="\n")  # also on Windows
    return text


def numbers_as_csv(names: list[str], shape: list[str], parts: Iterable[np.ndarray]) -> bytes:
    """Arrays (n, c) one below the other as CSV; shape: formats of the columns, such as "%.9g"."""
    text = io.BytesIO()
    text.write((",".join(names) + "\n").encode())
    for rows in parts:
        np.savetxt(text, rows, fmt=shape, delimiter=",")
    return text.getvalue()


def as_parquet(rows: Sequence[Row], about: Mapping[str, str] | None = None) -> bytes:
    """Rows as the bytes of a Parquet file, with words on where they come from (`about`)."""
    from pandas import DataFrame

    table = DataFrame({name: _typed([row.get(name) for row in rows]) for name in _names(rows)})
    table.attrs |= about or {}
    image = io.BytesIO()
    table.to_parquet(image, index=False)
    return image.getvalue()


def read_parquet(path: Path) -> tuple[dict[str, str], "list[dict[str, Any]]"]:
    """The words on where a table comes from and its rows; what a row lacks is None."""
    from pandas import read_parquet as read

    table: DataFrame = read(path, dtype_backend="numpy_nullable")
    columns = {name: [_plain(value) for value in table[name]] for name in table}
    rows = [
        dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)
    ]
    return table.attrs, rows


def _names(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(name for row in rows for name in row))


def _cell(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return json.dumps(value)  # such as a number for each cycle
    return str(value).lower() if isinstance(value, bool) else value


def _typed(values: list[Any]) -> Any:
    """A column of one type for Parquet, missing ones being missing; of several types, texts."""
    from pandas import array

    values = [value.item() if isinstance(value, np.generic) else value for value in values]
    kinds = {type(value) for value in values if value is not None}
    for names, dtype in (({bool}, "boolean"), ({int}, "Int64"), ({int, float}, "Float64")):
        if kinds and kinds <= names:
            return array(values, dtype)
    if kinds <= {list, tuple}:
        return values
    return array([None if value is None else str(_cell(value)) for value in values], "string")


def _plain(value: Any) -> Any:
    """A cell as Python has it; what lacks in a list, which pandas gives as NaN, is None."""
    from pandas import NA

    if value is None or value is NA:
        return None
    if isinstance(value, np.ndarray):
        return [None if one != one else one for one in value.tolist()]
    return value.item() if isinstance(value, np.generic) else value


def _column(values: list[Any]) -> Any:
    """The values of a column in one type for HDF5."""
    values = [value.item() if isinstance(value, np.generic) else value for value in values]
    kinds = {type(value) for value in values if value is not None}
    if kinds and kinds <= {int, float}:
        whole = kinds == {int} and None not in values
        return np.array(values, np.int64) if whole else np.array(values, float)  # None: NaN
    if kinds == {bool} and None not in values:
        return np.array(values)
    texts = ["" if value is None else str(_cell(value)) for value in values]
    return np.array(texts, dtype=h5py.string_dtype())
