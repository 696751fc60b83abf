"""Sharing by processes and threads: work that one does for all, and the steps of one run."""

import multiprocessing
import os
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from granulab.campaign.output.files import writing

_LOOK = 0.5  # [s] between the times that a waiting process checks whether it should stop
# [s] of a step that each thread shall have: they wait for one another three times in it, and two
# begin to pay at a step of twice as much.
_OF_EACH = 20e-6
_QUOTA = Path("/sys/fs/cgroup/cpu.max")  # of a container: microseconds of CPU, and in how many
_wanted: ContextVar[int | None] = ContextVar("threads", default=None)


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


def cores() -> int:
    """Return how many cores this process may use."""
    n = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    with suppress(OSError, ValueError):  # no container, or no limit
        quota, period = _QUOTA.read_text(encoding="ascii").split()
        n = min(n, max(int(quota) // int(period), 1))
    return n


@contextmanager
def wanted(n_threads: int | None) -> Iterator[None]:
    """Let so many threads share each run within; None: as many as outside."""
    before = _wanted.set(_wanted.get() if n_threads is None else n_threads)
    try:
        yield
    finally:
        _wanted.reset(before)


def shared_by(step_s: float) -> int:
    """Return how many threads shall share a run whose step takes one core so long [s].

    As many as are wanted; else as many cores as have enough of the step, but one in a process or
    thread that another one began: it is one of several, as those of a sweep are.
    """
    n_threads = _wanted.get()
    if n_threads is not None:
        return n_threads
    leads = threading.current_thread() is threading.main_thread()
    is_one_of_several = not leads or multiprocessing.parent_process() is not None
    return 1 if is_one_of_several else max(min(int(step_s / _OF_EACH), cores()), 1)


def in_words(n_threads: int) -> list[str]:
    """Line of an echo on so many threads that share each step; none on one."""
    if n_threads < 2:
        return []
    return [f"  threads     up to {n_threads} share each step and change no bit; or --threads 1"]
