"""A tidy table of rows as files: CSV for eyes and spreadsheets, HDF5 with every bit."""

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granulab.campaign.runs.folder import write_atomic

Row = Mapping[str, Any]


def write_table(folder: Path, rows: Sequence[Row]) -> None:
    """Write table.csv and table.h5, each as one whole file; what a row lacks is empty or NaN.

    The columns are all keys in the order in which they first appear; in HDF5 each is a dataset,
    of integers, of floating-point numbers, or of texts. Raises FolderError where they cannot be
    written.
    """
    names = list(dict.fromkeys(name for row in rows for name in row))
    write_atomic(folder / "table.csv", as_csv(rows))
    image = io.BytesIO()  # not on disk: HDF5 that meets a full disk itself ends the process
    with h5py.File(image, "w", track_order=True) as file:
        for name in names:
            file.create_dataset(name, data=_column([row.get(name) for row in rows]))
    write_atomic(folder / "table.h5", image.getvalue())


def as_csv(rows: Sequence[Row], left_out: tuple[str, ...] = ()) -> str:
    """Rows as CSV, but for the columns whose names begin with one of `left_out`."""
    names = dict.fromkeys(n for row in rows for n in row if not n.startswith(left_out))
    text = io.StringIO()
    writer = csv.DictWriter(text, list(names), extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: _cell(value) for name, value in row.items()} for row in rows)
    return text.getvalue()


def _cell(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return json.dumps(value)  # such as a number for each cycle
    return str(value).lower() if isinstance(value, bool) else value


def _column(values: list[Any]) -> Any:
    """The values of a column in one type."""
    values = [value.item() if isinstance(value, np.generic) else value for value in values]
    kinds = {type(value) for value in values if value is not None}
    if kinds and kinds <= {int, float}:
        whole = kinds == {int} and None not in values
        return np.array(values, np.int64) if whole else np.array(values, float)  # None: NaN
    if kinds == {bool} and None not in values:
        return np.array(values)
    texts = ["" if value is None else str(_cell(value)) for value in values]
    return np.array(texts, dtype=h5py.string_dtype())
