"""Making what several processes share: one makes it, the others wait for it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from campaign.folder import writing

_LOOK = 0.5  # [s] between the times that a waiting process asks whether it should stop


@contextmanager
def alone(folder: Path, stop: Callable[[], bool], stopped: Exception) -> Iterator[None]:
    """Wait until no other process makes what a folder holds; a killed one leaves no lock behind.

    Raises `stopped` when `stop` says so while waiting, and FolderError where the lock cannot be
    written.
    """
    from filelock import FileLock, Timeout

    lock = FileLock(folder.with_name(f".{folder.name}.lock"))
    while not lock.is_locked:
        with writing(folder):
            try:
                lock.acquire(timeout=_LOOK)
            except Timeout:
                if stop():
                    raise stopped from None
    try:
        yield
    finally:
        lock.release()
