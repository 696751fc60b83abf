"""The frames of a run on disk: parts while it goes on, one compressed file at its end.

    parts/static.h5, parts/00000.h5, parts/00001.h5, ...   ->   trajectory.h5

Every file appears whole or not at all, and parts go only after trajectory.h5 stands, so a run
killed at any moment can be read. A frame may bring tables of any length (contacts); they stand in
the same files and share their fate.
"""

import shutil
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np

from granulab.campaign.output.files import writing
from granulab.campaign.runs import ragged
from granulab.campaign.runs.h5file import merge, opened, save
from granulab.campaign.runs.ragged import Columns, Tables, in_words, joined, laid_end_to_end
from granulab.campaign.runs.seal import content
from granulab.errors import DamagedError, FolderError

T = TypeVar("T")
Choose = Callable[[str, h5py.Dataset], slice | None]


@dataclass(frozen=True)
class Trajectory(Mapping[str, np.ndarray]):
    """The frames of a run, all in memory: traj["x"] has shape (n_frames, ...)."""

    frames: dict[str, np.ndarray]
    static: dict[str, np.ndarray]  # what does not change from frame to frame
    attributes: dict[str, Any]
    part_frames: list[int]  # frames of each flush, to take a finished file apart again

    def __getitem__(self, key: str) -> np.ndarray:
        return self.frames[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.frames)

    def __len__(self) -> int:
        return len(self.frames)


class TrajectoryWriter:
    """Writes the frames of one run; the holder of the run's lock makes it.

    `parts` is the number of parts that the checkpoint knows; later ones are dropped. 0 starts
    the trajectory again. Raises FolderError when a known part is missing or nothing can be
    written.
    """

    def __init__(self, folder: str | Path, parts: int = 0) -> None:
        self._merged = Path(folder) / "trajectory.h5"
        self._folder = Path(folder) / "parts"
        self._n_parts = parts
        self._n_frames = 0  # that were flushed
        self._pending: list[dict[str, np.ndarray]] = []  # blocks of frames
        self._n_pending = 0  # frames in them
        self._pending_tables: dict[str, dict[int, dict[str, np.ndarray]]] = {}
        self._layout: dict[str, str] | None = None
        self._tables_layout: dict[str, str] = {}
        with writing(self._folder):
            if parts == 0:
                self._merged.unlink(missing_ok=True)
                if self._folder.exists():
                    shutil.rmtree(self._folder)
            _refuse_link(self._folder)
            self._folder.mkdir(parents=True, exist_ok=True)
            if self._merged.exists():
                self._take_apart()
            for path in _part_files(self._folder)[parts:]:
                path.unlink()
        if parts:
            self._go_on_after(parts)

    def _go_on_after(self, parts: int) -> None:
        """Take over how many frames the parts have, and the layout of frames and tables."""
        known = _part_paths(self._folder)[:parts]
        counts: list[int] = []
        for path in known:
            with opened(path) as file:
                counts.extend(map(int, file.attrs["part_frames"]))
                for name, group in file.get("tables", {}).items():
                    columns = group["columns"].items()
                    self._tables_layout |= ragged.layout({name: {k: v[:0] for k, v in columns}})
        if len(counts) < parts:
            raise FolderError(
                f"{self._folder}: {len(counts)} parts where the checkpoint knows {parts}; use "
                "--again to compute the run again"
            )
        self._n_frames = sum(counts)
        with opened(known[-1]) as file:
            self._layout = _layout({key: data[-1] for key, data in file["frames"].items()})

    def append(self, frame: Mapping[str, Any], tables: Mapping[str, Columns] | None = None) -> None:
        """Take a copy of one frame: numbers or arrays, of the same keys and shapes every time.

        `tables` are those that come with this frame: columns of one length each, whose names and
        types are the same every time.
        """
        self.extend({key: np.array(value)[None] for key, value in frame.items()}, tables)

    def extend(
        self, frames: Mapping[str, np.ndarray], tables: Mapping[str, Columns] | None = None
    ) -> None:
        """Take a copy of k frames, arrays of (k, ...); `tables` come with the last of them."""
        copied = {key: np.array(values) for key, values in frames.items()}
        layout = _layout({key: values[0] for key, values in copied.items()})
        if self._layout is None:
            self._layout = layout
        if layout != self._layout:
            raise FolderError(
                f"{self._folder}: a frame of {layout} after frames of {self._layout}; "
                "use --again to compute the run again"
            )
        after = self._n_pending + len(next(iter(copied.values())))
        self._take_tables(tables or {}, self._n_frames + after - 1)
        self._pending.append(copied)
        self._n_pending = after

    def _take_tables(self, tables: Mapping[str, Columns], frame: int) -> None:
        """Take a copy of the tables of a frame, by its number."""
        layout = ragged.layout(tables)
        known = {k: v for k, v in self._tables_layout.items() if k.partition(".")[0] in tables}
        if known and layout != known:
            raise FolderError(
                f"{self._folder}: tables of {layout} after tables of {known}; "
                "use --again to compute the run again"
            )
        self._tables_layout |= layout
        for name, columns in tables.items():
            copied = {key: np.array(column) for key, column in columns.items()}
            self._pending_tables.setdefault(name, {})[frame] = copied

    def flush(self) -> int:
        """Write the frames taken since the last flush as the next part; the number of parts."""
        if self._pending:
            blocks, keys = self._pending, self._pending[0]
            frames = {key: np.concatenate([block[key] for block in blocks]) for key in keys}
            tables = {
                name: laid_end_to_end(list(taken), list(taken.values()))
                for name, taken in self._pending_tables.items()
            }
            save(part_file(self._folder, self._n_parts), frames=frames, tables=tables)
            self._n_frames += self._n_pending
            self._n_pending = 0
            self._pending.clear()
            self._pending_tables.clear()
            self._n_parts += 1
        return self._n_parts

    def write_static(self, static: Mapping[str, Any], attributes: Mapping[str, Any]) -> None:
        """Keep what does not change, so that an unfinished run can be drawn too."""
        save(self._folder / "static.h5", static=static, attributes=attributes)

    def finish(self, static: Mapping[str, Any], attributes: Mapping[str, Any]) -> Path:
        """Merge all parts into trajectory.h5 and remove them; the path of the file."""
        self.flush()
        self.write_static(static, attributes)
        merge(self._merged, _part_paths(self._folder)[: self._n_parts], static, attributes)
        # What cannot be removed does no harm: trajectory.h5 is read first.
        shutil.rmtree(self._folder, ignore_errors=True)
        return self._merged

    def _take_apart(self) -> None:
        """Undo finish(): the run was cut off after it and before its summary."""
        with opened(self._merged) as file:
            self.write_static(
                {k: content(data) for k, data in file["static"].items()}, _attributes(file)
            )
            start = 0
            for k, n_frames in enumerate(map(int, file.attrs["part_frames"])):
                end = start + n_frames
                rows = slice(start, end)
                frames = {key: content(stored, rows) for key, stored in file["frames"].items()}
                pieces = {
                    name: ragged.read_of_frames(group, start, end)
                    for name, group in file.get("tables", {}).items()
                }
                save(part_file(self._folder, k), frames=frames, tables=pieces)
                start = end
        self._merged.unlink()


def read_trajectory(folder: str | Path, choose: Choose | None = None) -> Trajectory:
    """The frames of a run, finished or not, also while it goes on.

    choose: the rows to read of an array as it is stored in each file, by its name; None for none
    of it. Raises FolderError when there are no frames, or when a file is damaged.
    """
    return _from_run(Path(folder), partial(_read, choose=choose or _everything))


def read_tables(folder: str | Path, name: str) -> Tables:
    """The tables of a name that came with some of the frames of a run, finished or not.

    Raises FolderError as read_trajectory does, and where the run holds no such tables.
    """
    tables = stored_tables(folder)
    if name not in tables:
        raise FolderError(
            f"{folder}: holds no {name}, as an earlier version or an engine without them made it; "
            "--again computes a run again"
        )
    return tables[name]


def stored_tables(
    folder: str | Path, only: Mapping[str, Collection[str]] | None = None
) -> dict[str, Tables]:
    """All tables of a run, finished or not, by name, or only some columns of some of them.

    Raises FolderError as read_trajectory.
    """
    return _from_run(Path(folder), partial(_read_tables, only=only))


def whole_parts(folder: Path) -> tuple[int, int, str]:
    """Parts of an unfinished run before the first that is damaged or missing, parts that there
    are, and what is wrong with that one ("" where none is).

    Of a run that was cut off between its last frame and its results the parts are those of
    trajectory.h5.
    """
    merged, parts = folder / "trajectory.h5", folder / "parts"
    if merged.exists():
        try:
            with opened(merged) as file:
                n_parts = len(file.attrs["part_frames"])
            return n_parts, n_parts, ""
        except DamagedError as error:
            return 0, 0, str(error).partition(";")[0]
    _refuse_link(parts)
    files = _part_files(parts)
    for k, path in enumerate(files):
        if path != part_file(parts, k):
            return k, len(files), f"{part_file(parts, k)}: missing"
        try:
            with opened(path):
                pass
        except DamagedError as error:
            return k, len(files), str(error).partition(";")[0]
    return len(files), len(files), ""


def _refuse_link(parts: Path) -> None:
    if parts.is_symlink():
        raise FolderError(f"{parts}: a link that leads out of the run folder; remove it")


def _from_run(folder: Path, read: Callable[[list[Path]], T]) -> T:
    """Return the arrays in the files of a run: the parts while it goes on, else the whole."""
    merged, parts = folder / "trajectory.h5", folder / "parts"
    _refuse_link(parts)
    if not merged.exists() and parts.is_dir():
        try:
            unfinished = read(_part_paths(parts))
        except FileNotFoundError as error:
            if not merged.exists():
                raise FolderError(f"{parts}: changed while it was read; try again") from error
        else:
            if not merged.exists():  # else the run has finished meanwhile
                return unfinished
    if not merged.exists():
        raise FolderError(f"{folder}: no trajectory here; give the folder of a run")
    return read([merged])


def part_file(folder: Path, k: int) -> Path:
    """Place of part k in the folder of the parts."""
    return folder / f"{k:05d}.h5"


def _part_files(folder: Path) -> list[Path]:
    return sorted(folder.glob("[0-9]*.h5"), key=lambda path: int(path.stem))


def _part_paths(folder: Path) -> list[Path]:
    """The parts in turn, and last what does not change; FolderError where one is missing."""
    parts = _part_files(folder)
    for k, path in enumerate(parts):
        if path != part_file(folder, k):
            raise FolderError(
                f"{part_file(folder, k)}: missing; use --again to compute the run again"
            )
    static = folder / "static.h5"
    return [*parts, static] if static.exists() else parts


def _everything(name: str, stored: h5py.Dataset) -> slice | None:
    return slice(None)


def _read(paths: Iterable[Path], choose: Choose) -> Trajectory:
    pieces: dict[str, list[np.ndarray]] = {}
    whole = Trajectory({}, {}, {}, [])
    for path in paths:
        with opened(path) as file:
            whole.part_frames.extend(map(int, file.attrs["part_frames"]))
            whole.attributes.update(_attributes(file))
            lengths = {stored.shape[:1] for stored in file["frames"].values()}
            if len(lengths) > 1 or () in lengths:
                raise ValueError("not a row a frame in all of them")
            for key, stored in file["frames"].items():
                if (rows := choose(key, stored)) is not None:
                    pieces.setdefault(key, []).append(content(stored, rows))
            whole.static.update({k: content(data) for k, data in file["static"].items()})
    whole.frames.update({key: np.concatenate(pieces.pop(key)) for key in list(pieces)})
    return whole


def _attributes(file: h5py.File) -> dict[str, Any]:
    """Those that its writer was given."""
    return {k: v for k, v in file.attrs.items() if k not in ("schema", "part_frames")}


def _read_tables(
    paths: Iterable[Path], only: Mapping[str, Collection[str]] | None = None
) -> dict[str, Tables]:
    pieces: dict[str, list[Tables]] = {}
    for path in paths:
        with opened(path) as file:
            for name, group in file.get("tables", {}).items():
                if only is None or name in only:
                    columns = None if only is None else only[name]
                    pieces.setdefault(name, []).append(ragged.read(group, columns))
    return {name: joined(found) for name, found in pieces.items()}


def _layout(frame: Mapping[str, np.ndarray]) -> dict[str, str]:
    return {key: in_words(v.dtype, v.shape) for key, v in sorted(frame.items())}
