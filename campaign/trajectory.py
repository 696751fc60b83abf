"""The frames of a run on disk: parts while it goes on, one compressed file at its end.

    parts/static.h5, parts/00000.h5, parts/00001.h5, ...   ->   trajectory.h5

Every file appears whole or not at all, and parts go only after trajectory.h5 stands, so a run
killed at any moment can be read. HDF5 files are made in memory and then written as bytes: HDF5
that meets a full disk itself ends the process.
"""

import io
import shutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from campaign.folder import SCHEMA, FolderError, write_atomic, writing

_CHUNK_BYTES = 2**19  # half the chunk cache of HDF5: a chunk is compressed once


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
    the trajectory anew. Raises FolderError when a known part is missing or nothing can be
    written.
    """

    def __init__(self, folder: str | Path, parts: int = 0) -> None:
        self._merged = Path(folder) / "trajectory.h5"
        self._folder = Path(folder) / "parts"
        self._n_parts = parts
        self._pending: list[dict[str, np.ndarray]] = []
        self._layout: dict[str, str] | None = None
        with writing(self._folder):
            if parts == 0:
                self._merged.unlink(missing_ok=True)
                if self._folder.exists():
                    shutil.rmtree(self._folder)
            self._folder.mkdir(parents=True, exist_ok=True)
            if self._merged.exists():
                self._take_apart()
            for path in _part_files(self._folder)[parts:]:
                path.unlink()
        if parts:
            known = _read_parts(self._folder)
            if len(known.part_frames) < parts:
                raise FolderError(
                    f"{self._folder}: {len(known.part_frames)} parts where the checkpoint knows "
                    f"{parts}; use --again to compute the run anew"
                )
            self._layout = _layout({key: known[key][-1] for key in known})

    def append(self, frame: Mapping[str, Any]) -> None:
        """Take a copy of one frame: numbers or arrays, of the same keys and shapes every time."""
        copied = {key: np.array(value) for key, value in frame.items()}
        layout = _layout(copied)
        if self._layout is None:
            self._layout = layout
        if layout != self._layout:
            raise FolderError(
                f"{self._folder}: a frame of {layout} after frames of {self._layout}; "
                "use --again to compute the run anew"
            )
        self._pending.append(copied)

    def flush(self) -> int:
        """Write the frames taken since the last flush as the next part; the number of parts."""
        if self._pending:
            frames = {key: np.stack([f[key] for f in self._pending]) for key in self._pending[0]}
            _save(_part(self._folder, self._n_parts), frames=frames)
            self._pending.clear()
            self._n_parts += 1
        return self._n_parts

    def write_static(self, static: Mapping[str, Any], attributes: Mapping[str, Any]) -> None:
        """Keep what does not change, so that an unfinished run can be drawn too."""
        _save(self._folder / "static.h5", static=static, attributes=attributes)

    def finish(self, static: Mapping[str, Any], attributes: Mapping[str, Any]) -> Path:
        """Merge all parts into trajectory.h5 and remove them; the path of the file."""
        self.flush()
        self.write_static(static, attributes)
        whole = _read_parts(self._folder)
        _save(
            self._merged,
            frames=whole.frames,
            static=whole.static,
            attributes=whole.attributes,
            part_frames=whole.part_frames,
        )
        # What cannot be removed does no harm: trajectory.h5 is read first.
        shutil.rmtree(self._folder, ignore_errors=True)
        return self._merged

    def _take_apart(self) -> None:
        """Undo finish(): the run was cut off after it and before its summary."""
        whole = _read([self._merged])
        self.write_static(whole.static, whole.attributes)
        start = 0
        for k, n_frames in enumerate(whole.part_frames):
            frames = {key: whole[key][start : start + n_frames] for key in whole}
            _save(_part(self._folder, k), frames=frames)
            start += n_frames
        self._merged.unlink()


def read_trajectory(folder: str | Path) -> Trajectory:
    """The frames of a run, finished or not, also while it goes on.

    Raises FolderError when there are none, or when a file is damaged.
    """
    merged, parts = Path(folder) / "trajectory.h5", Path(folder) / "parts"
    if not merged.exists() and parts.is_dir():
        try:
            unfinished = _read_parts(parts)
        except FileNotFoundError as error:
            if not merged.exists():
                raise FolderError(f"{parts}: changed while it was read; try again") from error
        else:
            if not merged.exists():  # else the run has finished meanwhile
                return unfinished
    if not merged.exists():
        raise FolderError(f"{folder}: no trajectory here; give the folder of a run")
    return _read([merged])


def _part(folder: Path, k: int) -> Path:
    return folder / f"{k:05d}.h5"


def _part_files(folder: Path) -> list[Path]:
    return sorted(folder.glob("[0-9]*.h5"), key=lambda path: int(path.stem))


def _read_parts(folder: Path) -> Trajectory:
    parts = _part_files(folder)
    for k, path in enumerate(parts):
        if path != _part(folder, k):
            raise FolderError(f"{_part(folder, k)}: missing; use --again to compute the run anew")
    static = folder / "static.h5"
    return _read([*parts, static] if static.exists() else parts)


def _read(paths: Iterable[Path]) -> Trajectory:
    pieces: dict[str, list[np.ndarray]] = {}
    whole = Trajectory({}, {}, {}, [])
    for path in paths:
        try:
            with h5py.File(path) as file:
                attributes = dict(file.attrs)
                _check_schema(path, attributes.pop("schema"))
                whole.part_frames.extend(map(int, attributes.pop("part_frames")))
                whole.attributes.update(attributes)
                for key, dataset in file["frames"].items():
                    pieces.setdefault(key, []).append(dataset[()])
                whole.static.update({k: data[()] for k, data in file["static"].items()})
        except (FileNotFoundError, FolderError):
            raise
        except Exception as error:  # HDF5 raises many kinds for a damaged file
            raise FolderError(
                f"{path}: damaged or no trajectory; use --again to compute the run anew"
            ) from error
    whole.frames.update({key: np.concatenate(pieces[key]) for key in pieces})
    return whole


def _check_schema(path: Path, schema: int) -> None:
    if schema != SCHEMA:
        raise FolderError(
            f"{path}: schema {schema} of another version (this one reads {SCHEMA}); "
            "use --again to compute the run anew"
        )


def _save(
    path: Path,
    *,
    frames: Mapping[str, np.ndarray] | None = None,
    static: Mapping[str, Any] | None = None,
    attributes: Mapping[str, Any] | None = None,
    part_frames: list[int] | None = None,
) -> None:
    """Write one file; `part_frames` is given for the whole trajectory, which is compressed."""
    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        file.attrs.update(attributes or {})
        moving, constant = file.create_group("frames"), file.create_group("static")
        for key, array in (frames or {}).items():
            storage = _compressed(array) if part_frames else {}
            moving.create_dataset(key, data=array, **storage)
        for key, value in (static or {}).items():
            constant.create_dataset(key, data=value)
        n_frames = [len(array) for array in (frames or {}).values()][:1]
        file.attrs["part_frames"] = np.array(part_frames or n_frames, dtype=np.int64)
        file.attrs["schema"] = SCHEMA
    write_atomic(path, image.getvalue())


def _compressed(array: np.ndarray) -> dict[str, Any]:
    """Storage of whole frames per chunk, since both films and time series read whole frames."""
    if array.size == 0:  # HDF5 has no chunks of nothing
        return {}
    frame_bytes = array[0].nbytes
    n_frames = min(max(_CHUNK_BYTES // frame_bytes, 1), len(array))
    return {"chunks": (n_frames, *array.shape[1:]), "compression": "gzip", "shuffle": True}


def _layout(frame: Mapping[str, Any]) -> dict[str, str]:
    return {key: f"{np.asarray(v).dtype}{list(np.shape(v))}" for key, v in sorted(frame.items())}
