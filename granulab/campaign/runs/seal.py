"""Seals: a SHA-256 over what a file of a run holds, in the file; and reading nothing else.

An HDF5 file has its seal in front, in a user block of 512 bytes, where HDF5 looks over it; a JSON
file has it as its last key. Chosen by measurement: SHA-256 takes 0.7 ms/MB, HDF5's own Fletcher32
as much, which covers arrays but neither names nor attributes.
"""

import hashlib
import io
import json
import os
import re
import stat
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import h5py  # --help needs it not

SEAL_BYTES = 512  # the smallest user block of HDF5
_SEAL = re.compile(rb"([a-z]+)\nschema (\d+)\nsha256 ([0-9a-f]{64})\n+")
_HDF5 = b"\x89HDF\r\n\x1a\n"  # a file begins so that has no seal: as versions before wrote
_MOST_COMPRESSED = 1100  # bytes that one compressed byte can be: deflate's limit is 1032
_KEY = "sha256"  # of the seal in a JSON file


class NotSealed(ValueError):
    """A file that holds something else than was sealed, or is no such file."""


class OutsideError(ValueError):
    """An HDF5 file that refers to others, or to more than it can hold."""


def open_kept(path: Path) -> io.BufferedReader:
    """Open a file of a folder that may be a stranger's.

    Raises OSError where it cannot be read, also where it is no file (a pipe would wait for ever)
    or a link that leads out of its folder.
    """
    if path.is_symlink() and Path(os.path.realpath(path)).parent != _real(path.parent):
        raise OSError(None, "a link that leads out of its folder")
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise OSError(None, "not a file")
    return os.fdopen(descriptor, "rb")


def _real(folder: Path) -> Path:
    return Path(os.path.realpath(folder))


def sha256_of(path: Path) -> str:
    """SHA-256 of a whole file; OSError as of open_kept."""
    with open_kept(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def seal_of(kind: str, schema: int, content: "hashlib._Hash") -> bytes:
    """The block in front of an HDF5 file, given the SHA-256 over what follows it."""
    seal = f"{kind}\nschema {schema}\nsha256 {content.hexdigest()}\n"
    return seal.encode().ljust(SEAL_BYTES, b"\n")


def content_digest(file: io.FileIO) -> "hashlib._Hash":
    """SHA-256 over what follows the block in front of an HDF5 file."""
    file.seek(SEAL_BYTES)
    return hashlib.file_digest(file, "sha256")


def schema_by_seal(kind: str, file: io.BufferedReader) -> int | None:
    """The schema of an HDF5 file; None where it has no seal, as versions before made trajectories.

    Raises NotSealed where it holds something else than was sealed. A schema that is not known says
    nothing about what follows, which is checked all the same.
    """
    head = file.read(SEAL_BYTES)
    if head.startswith(_HDF5):
        return None
    seal = _SEAL.fullmatch(head)
    if seal is None or len(head) < SEAL_BYTES or seal[1] != kind.encode():
        raise NotSealed(f"damaged, or not a {kind}")
    if hashlib.file_digest(file, "sha256").hexdigest() != seal[3].decode():
        raise NotSealed("damaged: it holds something else than was written")
    return int(seal[2])


def content(dataset: "h5py.Dataset", rows: slice | None = None) -> Any:
    """The array of an HDF5 file that may be a stranger's, or some rows of it.

    Raises OutsideError where it lies in another file, or says to be so large that what is stored
    of it cannot be all, and reading it would fill the memory.
    """
    if dataset.is_virtual or dataset.external:
        raise OutsideError(f"{dataset.name!r} is an array of another file")
    low = dataset.id
    n_bytes = low.get_space().get_simple_extent_npoints() * low.get_type().get_size()
    if n_bytes > _MOST_COMPRESSED * (low.get_storage_size() + 1):
        raise OutsideError(f"{dataset.name!r} says to be larger than what is stored of it")
    return dataset[()] if rows is None else dataset[rows]


def sealed_json(mapping: Mapping[str, Any], default: Any) -> str:
    """The text of a JSON object, whose last key is the seal over all others.

    default: as of json.dumps. NaN and infinity are refused (ValueError).
    """
    plain = json.loads(_canonical(mapping, default))
    return _canonical({**plain, _KEY: _digest(plain)}) + "\n"


def opened_json(text: str) -> tuple[dict[str, Any], bool]:
    """The object of a JSON text without its seal, and whether it had one.

    Raises NotSealed where the seal is not over what stands there, ValueError where it is no object.
    """
    mapping = json.loads(text)
    if not isinstance(mapping, dict):
        raise ValueError("no JSON object")
    seal = mapping.pop(_KEY, None)
    if seal is not None and seal != _digest(mapping):
        raise NotSealed("changed or damaged: its seal (sha256) is over something else")
    return mapping, seal is not None


def _canonical(mapping: Mapping[str, Any], default: Any = None) -> str:
    return json.dumps(mapping, indent=2, ensure_ascii=False, allow_nan=False, default=default)


def _digest(mapping: Mapping[str, Any]) -> str:
    return hashlib.sha256(_canonical(mapping).encode()).hexdigest()
