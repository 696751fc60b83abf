"""Checkpoints: the arrays from which a run goes on to the same bits, sealed against damage.

The file is HDF5 behind a user block of 512 bytes, which says the schema and the SHA-256 of all
that follows. Nothing of a damaged file reaches HDF5.
"""

import hashlib
import io
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granulab.campaign.runs.folder import SCHEMA, FolderError, plain, write_atomic

_SEAL_BYTES = 512  # the smallest user block of HDF5
_SEAL = re.compile(rb"checkpoint\nschema (\d+)\nsha256 ([0-9a-f]{64})\n")


def save_checkpoint(
    path: str | Path, arrays: Mapping[str, np.ndarray], meta: Mapping[str, Any]
) -> None:
    """Write arrays (any shape, exact to the bit) and meta (numbers and texts) as one whole file.

    Raises FolderError when the file cannot be written; the one before it then stands.
    """
    image = io.BytesIO()  # not on disk: HDF5 that meets a full disk itself ends the process
    with h5py.File(image, "w", userblock_size=_SEAL_BYTES) as file:
        group = file.create_group("arrays")
        for name, array in arrays.items():
            group.create_dataset(name, data=array)
        file["meta"] = json.dumps(meta, default=plain)
    content = image.getvalue()[_SEAL_BYTES:]
    seal = f"checkpoint\nschema {SCHEMA}\nsha256 {hashlib.sha256(content).hexdigest()}\n"
    write_atomic(path, seal.encode().ljust(_SEAL_BYTES, b"\n") + content)


def load_checkpoint(path: str | Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The arrays and meta that save_checkpoint wrote.

    Raises FolderError when the file is missing, damaged or of another schema.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise _refusal(path, f"cannot be read ({error.strerror})") from error
    seal = _SEAL.match(data)
    if seal is None:
        raise _refusal(path, "damaged, or not a checkpoint")
    if int(seal[1]) != SCHEMA:
        other = f"schema {int(seal[1])} of another version (this one reads {SCHEMA})"
        raise _refusal(path, other)
    if hashlib.sha256(data[_SEAL_BYTES:]).hexdigest() != seal[2].decode():
        raise _refusal(path, "damaged")
    arrays: dict[str, np.ndarray] = {}

    def collect(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset):
            arrays[name] = np.asarray(item[()])

    with h5py.File(io.BytesIO(data)) as file:
        file["arrays"].visititems(collect)  # "grains/x" is a name too
        return arrays, json.loads(file["meta"].asstr()[()])


def _refusal(path: str | Path, what: str) -> FolderError:
    return FolderError(
        f"{path}: {what}; delete the file to start this run from its beginning, or use --again"
    )
