"""HDF5 files of a trajectory: written whole, opened only where they are sound and of this schema.

They are made in memory and then written as bytes: HDF5 that meets a full disk itself ends the
process.
"""

import io
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granulab.campaign.runs import ragged
from granulab.campaign.runs.folder import SCHEMA, FolderError, write_atomic
from granulab.campaign.runs.ragged import Tables

_CHUNK_BYTES = 2**19  # half the chunk cache of HDF5: a chunk is compressed once


@contextmanager
def opened(path: Path) -> Iterator[h5py.File]:
    """An HDF5 file of this schema, to be read; FolderError where it is damaged or another's."""
    try:
        with h5py.File(path) as file:
            _check_schema(path, file.attrs["schema"])
            yield file
    except (FileNotFoundError, FolderError):
        raise
    except Exception as error:  # HDF5 raises many kinds for a damaged file
        raise FolderError(
            f"{path}: damaged or no trajectory; use --again to compute the run again"
        ) from error


def _check_schema(path: Path, schema: int) -> None:
    if schema != SCHEMA:
        raise FolderError(
            f"{path}: schema {schema} of another version (this one reads {SCHEMA}); "
            "use --again to compute the run again"
        )


def save(
    path: Path,
    *,
    frames: Mapping[str, np.ndarray] | None = None,
    static: Mapping[str, Any] | None = None,
    attributes: Mapping[str, Any] | None = None,
    part_frames: list[int] | None = None,
    tables: Mapping[str, Tables] | None = None,
) -> None:
    """Write one file; `part_frames` is given for the whole trajectory, which is compressed."""
    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        file.attrs.update(attributes or {})
        moving, constant = file.create_group("frames"), file.create_group("static")
        storage = _compressed if part_frames else _plain
        for key, array in (frames or {}).items():
            moving.create_dataset(key, data=array, **storage(array))
        for name, table in (tables or {}).items():
            ragged.write(file.create_group(f"tables/{name}"), table, storage)
        for key, value in (static or {}).items():
            constant.create_dataset(key, data=value)
        n_frames = [len(array) for array in (frames or {}).values()][:1]
        file.attrs["part_frames"] = np.array(part_frames or n_frames, dtype=np.int64)
        file.attrs["schema"] = SCHEMA
    write_atomic(path, image.getvalue())


def _plain(array: np.ndarray) -> dict[str, Any]:
    return {}


def _compressed(array: np.ndarray) -> dict[str, Any]:
    """Storage of whole frames per chunk, since both films and time series read whole frames."""
    if array.size == 0:  # HDF5 has no chunks of nothing
        return {}
    frame_bytes = array[0].nbytes
    n_frames = min(max(_CHUNK_BYTES // frame_bytes, 1), len(array))
    return {"chunks": (n_frames, *array.shape[1:]), "compression": "gzip", "shuffle": True}
