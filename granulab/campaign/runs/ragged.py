"""Tables whose length changes along a run (contacts): one for some of its frames, laid end to end.

In a file each is a group: `frame` and `length` of the tables (S,), and their rows in `columns`.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import h5py
import numpy as np

from granulab.campaign.runs.folder import Stored
from granulab.campaign.runs.seal import content
from granulab.errors import FolderError

Columns = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Tables:
    """Tables of the same columns.

    frame      of the run's frames, the one that each table belongs to (S,), ascending
    length     rows of each (S,)
    columns    all rows, one table after the other: (sum of length, ...) each
    """

    frame: np.ndarray
    length: np.ndarray
    columns: dict[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.frame)

    @cached_property
    def start(self) -> np.ndarray:
        """Row at which each table starts, and the end of the last (S + 1,)."""
        return np.concatenate([[0], np.cumsum(self.length)])

    def at(self, k: int) -> dict[str, np.ndarray]:
        """The columns of table k; negative k counts from the last."""
        k = range(len(self))[k]
        rows = slice(self.start[k], self.start[k + 1])
        return Stored(
            "stored tables", {name: column[rows] for name, column in self.columns.items()}
        )

    def of_frames(self, first: int, last: int) -> "Tables":
        """The tables of the frames first ... last - 1."""
        low, high = np.searchsorted(self.frame, [first, last])
        rows = slice(self.start[low], self.start[high])
        columns = {name: column[rows] for name, column in self.columns.items()}
        return Tables(self.frame[low:high], self.length[low:high], columns)


def laid_end_to_end(frames: Sequence[int], tables: Sequence[Columns]) -> Tables:
    """Tables, at least one, each of columns of one length, as one."""
    columns = {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
    length = [len(next(iter(table.values()))) for table in tables]
    return Tables(np.array(frames, np.int64), np.array(length, np.int64), columns)


def joined(pieces: Sequence[Tables]) -> Tables:
    """The tables of several files, at least one, in turn."""
    return Tables(
        np.concatenate([piece.frame for piece in pieces]),
        np.concatenate([piece.length for piece in pieces]),
        {
            name: np.concatenate([piece.columns[name] for piece in pieces])
            for name in pieces[0].columns
        },
    )


def layout(tables: Mapping[str, Columns]) -> dict[str, str]:
    """Types of all columns, by table and column."""
    return {
        f"{name}.{column}": in_words(rows.dtype, rows.shape[1:])
        for name, table in sorted(tables.items())
        for column, rows in sorted(table.items())
    }


@cache
def in_words(dtype: np.dtype, shape: tuple[int, ...]) -> str:
    """Such as "float64[3]"; needed for every column of every frame, and numpy takes its time."""
    return f"{dtype}{list(shape)}"


def write(group: h5py.Group, tables: Tables) -> None:
    """Write into a group."""
    group.create_dataset("frame", data=tables.frame)
    group.create_dataset("length", data=tables.length)
    columns = group.create_group("columns")
    for name, rows in tables.columns.items():
        columns.create_dataset(name, data=rows)


def read(group: h5py.Group, only: Collection[str] | None = None) -> Tables:
    """Return what `write` wrote, all columns or some only; FolderError where lengths do not fit."""
    lengths = content(group["length"])
    tables = Tables(content(group["frame"]), lengths, {})
    for name, rows in group["columns"].items():
        if len(rows) != tables.start[-1]:
            raise FolderError(f"{group.file.filename}: damaged, tables of uneven length")
        if only is None or name in only:
            tables.columns[name] = content(rows)
    return tables


def read_of_frames(group: h5py.Group, first: int, last: int) -> Tables:
    """The tables of the frames first ... last - 1, and nothing else, of what `write` wrote."""
    index = Tables(content(group["frame"]), content(group["length"]), {})
    low, high = (int(k) for k in np.searchsorted(index.frame, [first, last]))
    rows = slice(int(index.start[low]), int(index.start[high]))
    columns = {name: content(stored, rows) for name, stored in group["columns"].items()}
    return Tables(index.frame[low:high], index.length[low:high], columns)
