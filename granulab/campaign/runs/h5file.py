"""HDF5 files of a trajectory: written whole, opened only where they are sound and of this schema.

They are written through a file that keeps what goes wrong from HDF5: meeting a full disk itself, it
ends the process.
"""

import errno
import io
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granulab.campaign.output.files import replacing, write_all
from granulab.campaign.runs import ragged
from granulab.campaign.runs.folder import SCHEMA
from granulab.campaign.runs.ragged import Tables
from granulab.campaign.runs.seal import (
    SEAL_BYTES,
    NotSealed,
    OutsideError,
    content,
    content_digest,
    open_kept,
    schema_by_seal,
    seal_of,
)
from granulab.errors import DamagedError, FolderError

_CACHE_BYTES = 2**20  # of chunks of each array
_CHUNK_BYTES = 2**19  # half of it: a chunk is compressed once


class UnreadableError(FolderError):
    """A file that cannot be read now, whatever it holds."""


@contextmanager
def opened(path: Path, kind: str = "trajectory") -> Iterator[h5py.File]:
    """An HDF5 file of this schema, to be read.

    Raises FolderError where it is another's, or would have HDF5 read outside the file;
    DamagedError where it holds something else than was sealed; UnreadableError where the system
    lacks files or memory, or its disk fails, which says nothing about what the file holds.
    """
    cure = _cure(path, kind)
    try:
        with open_kept(path) as raw:
            schema = schema_by_seal(kind, raw)
        with h5py.File(path) as file:
            _refuse_links(file)
            own = schema if kind == "checkpoint" else file.attrs["schema"]
            _check_schema(path, own, cure)
            if schema not in (None, own):
                raise NotSealed("damaged: its seal is of another schema")
            yield file
    except FileNotFoundError as error:
        if kind == "trajectory":  # parts go when a run ends
            raise
        raise FolderError(f"{path}: cannot be read ({error.strerror}); {cure}") from error
    except FolderError:
        raise
    except NotSealed as error:
        raise DamagedError(f"{path}: {error}; {cure}") from error
    except OutsideError as error:
        raise FolderError(f"{path}: {error}; do not use this run folder") from None
    except Exception as error:  # HDF5 raises many kinds for a damaged file
        system = error.errno if isinstance(error, OSError) else None
        # in a damaged file HDF5 looks at places that no file can have: EINVAL
        if system not in (None, errno.EINVAL) or isinstance(error, MemoryError):
            reason = os.strerror(system) if system else "out of memory"
            raise UnreadableError(f"{path}: cannot be read now ({reason}); try again") from error
        reason = f" ({error.strerror})" if isinstance(error, OSError) and error.strerror else ""
        raise DamagedError(f"{path}: damaged or no {kind}{reason}; {cure}") from error


def _cure(path: Path, kind: str) -> str:
    if kind == "checkpoint":
        return "delete the file to start this run from its beginning, or use --again"
    if path.parent.name == "parts":
        return "the run goes on from before it when it is run again"
    return "use --again to compute the run again"


def _check_schema(path: Path, schema: int | None, cure: str) -> None:
    if schema is None:
        raise NotSealed("damaged, or not a checkpoint")
    if schema != SCHEMA:
        raise FolderError(
            f"{path}: schema {schema} of another version (this one reads {SCHEMA}); {cure}"
        )


def _refuse_links(file: h5py.File) -> None:
    """Raise OutsideError for a name that stands for something elsewhere; this program makes none.

    HDF5 would open any file that such a link names.
    """
    links: list[bytes] = []

    def look(name: bytes, info: h5py.h5l.LinkInfo) -> None:
        if info.type != h5py.h5l.TYPE_HARD:
            links.append(name)

    file.id.links.visit(look, info=True)
    if links:
        raise OutsideError(f"{links[0].decode()!r} is a link to elsewhere")


@contextmanager
def made(path: Path, kind: str) -> Iterator[h5py.File]:
    """A new HDF5 file, which takes its place whole and sealed when the enclosed lines end.

    Raises FolderError where it cannot be written; the one before it then stands.
    """
    with replacing(path) as file:
        disk = _Disk(file)
        try:
            with h5py.File(disk, "w", userblock_size=SEAL_BYTES, rdcc_nbytes=_CACHE_BYTES) as image:
                yield image
        except Exception as error:  # of many kinds, once a disk gives back what it did not take
            raise disk.failure or error from None
        if disk.failure:
            raise disk.failure
        seal = seal_of(kind, SCHEMA, content_digest(file))
        file.seek(0)
        write_all(file, seal)


class _Disk:
    """A file for HDF5 to write to, which never fails: the first failure is kept for its owner."""

    def __init__(self, file: io.FileIO) -> None:
        self._file = file
        self.failure: OSError | None = None

    def write(self, data: memoryview) -> int:
        if self.failure is None:
            try:
                write_all(self._file, data)
            except OSError as error:
                self.failure = error
        return len(data)

    def truncate(self, size: int) -> int:
        if self.failure is None:
            try:
                self._file.truncate(size)
            except OSError as error:
                self.failure = error
        return size

    def read(self, size: int = -1) -> bytes:
        return self._file.read(size)  # h5py knows a file by this, and calls the next

    def readinto(self, data: memoryview) -> int:
        return self._file.readinto(data)

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def flush(self) -> None:
        """Nothing is held back."""


def save(
    path: Path,
    *,
    frames: Mapping[str, np.ndarray] | None = None,
    static: Mapping[str, Any] | None = None,
    attributes: Mapping[str, Any] | None = None,
    tables: Mapping[str, Tables] | None = None,
) -> None:
    """Write one part of a trajectory, or what does not change along it."""
    with made(path, "trajectory") as file:
        moving = file.create_group("frames")
        for key, array in (frames or {}).items():
            moving.create_dataset(key, data=array)
        for name, table in (tables or {}).items():
            ragged.write(file.create_group(f"tables/{name}"), table)
        _write_constant(file, static or {}, attributes or {})
        n_frames = [len(array) for array in (frames or {}).values()][:1]
        file.attrs["part_frames"] = np.array(n_frames, dtype=np.int64)


def merge(
    path: Path, parts: Sequence[Path], static: Mapping[str, Any], attributes: Mapping[str, Any]
) -> None:
    """Write the parts of a trajectory as one compressed file.

    An array of a part is in memory at a time. FolderError where a part is damaged, or the file
    cannot be written.
    """
    part_frames: list[int] = []
    shapes: dict[str, tuple[int, ...]] = {}
    types: dict[str, np.dtype] = {}
    for part in parts:
        with opened(part) as file:
            part_frames.extend(map(int, file.attrs["part_frames"]))
            for name, stored in _moving(file):
                before = shapes.get(name, (0,))[0]
                shapes[name], types[name] = (before + len(stored), *stored.shape[1:]), stored.dtype
    with made(path, "trajectory") as whole:
        whole.create_group("frames")
        targets = {
            name: whole.create_dataset(
                name, shape, types[name], **_storage(name, shape, types[name])
            )
            for name, shape in shapes.items()
        }
        filled = dict.fromkeys(shapes, 0)
        for part in parts:
            with opened(part) as file:
                for name, stored in _moving(file):
                    rows = slice(filled[name], filled[name] + len(stored))
                    if stored.size:
                        targets[name][rows] = content(stored)
                    filled[name] = rows.stop
        _write_constant(whole, static, attributes)
        whole.attrs["part_frames"] = np.array(part_frames, dtype=np.int64)


def _moving(file: h5py.File) -> list[tuple[str, h5py.Dataset]]:
    """The arrays of a part that go on in the next, by name in the file: of frames and of tables."""
    found: list[tuple[str, h5py.Dataset]] = []

    def collect(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset) and not name.startswith("static/"):
            found.append((name, item))

    file.visititems(collect)
    return found


def _write_constant(
    file: h5py.File, static: Mapping[str, Any], attributes: Mapping[str, Any]
) -> None:
    constant = file.create_group("static")
    for key, value in static.items():
        constant.create_dataset(key, data=value)
    file.attrs.update(attributes)
    file.attrs["schema"] = SCHEMA


def _storage(name: str, shape: tuple[int, ...], dtype: np.dtype) -> dict[str, Any]:
    """Storage of whole frames per chunk, since both films and time series read whole frames."""
    if name.startswith("tables/") and "/columns/" not in name:  # which frames, and how long each
        return {}
    if 0 in shape:  # HDF5 has no chunks of nothing
        return {}
    frame_bytes = math.prod(shape[1:]) * dtype.itemsize
    n_frames = min(max(_CHUNK_BYTES // frame_bytes, 1), shape[0])
    return {"chunks": (n_frames, *shape[1:]), "compression": "gzip", "shuffle": True}
