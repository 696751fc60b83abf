"""Work that one process does for all, such as compiling kernels, while the others wait."""

from collections.abc import Callable
from pathlib import Path

from filelock import FileLock


def once(folder: Path, name: str, work: Callable[[], None]) -> None:
    """Do a work unless it was done before; whoever else is about to waits until it is done.

    That it is done is kept in a folder, which is there, as the file `name`.
    """
    done = folder / name
    if done.exists():
        return
    with FileLock(folder / ".lock"):
        if not done.exists():
            work()
            done.touch()
