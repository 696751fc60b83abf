"""A text file that several commands may edit: one at a time, and whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from granulab.campaign.runs.folder import FolderError, write_atomic
from granulab.errors import InputError

_LONGEST_WAIT = 60.0  # for another writer, who needs milliseconds [s]


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Keep other writers off a file; remove what a killed one left beside it.

    Raises InputError where one holds it for a minute, or the folder cannot be written.
    """
    from filelock import FileLock, Timeout

    file = path.resolve()  # a link's target: the file has one lock, whatever it is called
    try:
        # The system's own lock: it ends with its process.
        with FileLock(file.with_name(f".{file.name}.lock"), timeout=_LONGEST_WAIT):
            for leftover in file.parent.glob(f".{file.name}.*.tmp"):
                leftover.unlink(missing_ok=True)
            yield
    except Timeout:
        raise InputError(f"{path}: another command is writing it; try again") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None


def write(path: Path, text: str) -> None:
    """Write a file, or what a link points at; it keeps its rights.

    At any moment, also after kill -9, it is the old one or the new one. Raises InputError where
    it cannot be written, or is write-protected.
    """
    file = path.resolve()
    mode = file.stat().st_mode if file.exists() else None
    # The new file takes the old one's name, for which the folder's rights would do.
    if mode is not None and not (mode & 0o222 and os.access(file, os.W_OK)):
        raise InputError(f"{path}: is write-protected; chmod u+w {path}, or name another file")
    try:
        write_atomic(file, text)
    except FolderError as error:
        raise InputError(str(error)) from None
    if mode is not None:
        file.chmod(mode)
