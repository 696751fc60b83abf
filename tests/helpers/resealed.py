"""A sealed HDF5 file changed on purpose: what stands in it is wrong, and its seal is right."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from granulab.campaign.runs.folder import SCHEMA
from granulab.campaign.runs.seal import SEAL_BYTES, seal_of


@contextmanager
def resealed(path: Path, kind: str = "trajectory", schema: int = SCHEMA) -> Iterator[h5py.File]:
    """The file, to be changed; then it is sealed again."""
    with h5py.File(path, "r+") as file:
        yield file
    content = path.read_bytes()[SEAL_BYTES:]
    path.write_bytes(seal_of(kind, schema, hashlib.sha256(content)) + content)
