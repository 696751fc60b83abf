"""Making what several processes share, once: one makes it, the others wait for it."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from granulab.campaign.output.files import writing

_LOOK = 0.5  # [s] between the times that a waiting process checks whether it should stop


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


def once(folder: Path, name: str, work: Callable[[], None]) -> None:
    """Do a work unless it was done before; whoever else is about to waits until it is done.

    That it is done is kept in a folder, which is there, as the file `name`.
    """
    from filelock import FileLock

    done = folder / name
    if done.exists():
        return
    with ExitStack() as stack:
        with suppress(OSError):  # a full disk: then nobody waits, and everybody does it
            stack.enter_context(FileLock(folder / ".lock"))
        if not done.exists():
            work()
            with suppress(OSError):
                done.touch()
