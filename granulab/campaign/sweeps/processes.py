"""Worker processes of this machine, one thread each; one that is killed is replaced.

Every worker is an executor of its own: the library gives up a whole pool when one process of it
dies, and here the others go on. They are spawned, not forked: numba and HDF5 do not survive a
fork in the middle of their work.
"""

import ctypes
import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from typing import Any, Self

from granulab.campaign.sweeps.task import Function, Outcome, WorkerLost, call

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
_SIGNALS = (signal.SIGINT, signal.SIGTERM)

_flag: Any = None  # in a worker: whether it is to stop


class Processes:
    """So many workers; see granulab.campaign.sweeps.engine for the calls."""

    def __init__(self, workers: int) -> None:
        self.slots = workers
        self._context = multiprocessing.get_context("spawn")
        # Without a lock: a killed worker would keep it for ever.
        self._stop = self._context.RawValue(ctypes.c_bool, False)
        self._idle: list[ProcessPoolExecutor] = []
        self._children: dict[ProcessPoolExecutor, BaseProcess | None] = {}
        # Kept: one that is forgotten while it notes its own end waits for itself (Python 3.12.1).
        self._broken: list[ProcessPoolExecutor] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None:
            self.give_up()
        for executor in list(self._children):
            executor.shutdown()

    def submit(self, function: Function, task: Any) -> Future:
        """The future outcome of a task; WorkerLost where its process ends under it."""
        outcome: Future = Future()
        before = set(multiprocessing.active_children())
        while True:
            # Made with the signals open: making the first one starts a process that opens them.
            executor = self._idle.pop() if self._idle else self._new()
            try:
                with _worker_surroundings():
                    inner = executor.submit(_work, function, task)
                break
            except BrokenProcessPool:  # its process was killed while it had nothing to do
                self._children.pop(executor, None)
        for child in set(multiprocessing.active_children()) - before:
            self._children[executor] = child

        def pass_on(inner: Future) -> None:
            error = inner.exception()
            if isinstance(error, BrokenProcessPool):
                outcome.set_exception(WorkerLost(self._end_of(executor)))
                return
            self._idle.append(executor)
            if error is None:
                outcome.set_result(inner.result())
            else:
                outcome.set_exception(error)

        inner.add_done_callback(pass_on)
        return outcome

    def ask_to_stop(self) -> None:
        """Make the running tasks keep their state and end."""
        self._stop.value = True

    def give_up(self) -> bool:
        """Kill the workers: all that they leave is whole files; whether there are any to kill."""
        for child in filter(None, list(self._children.values())):
            child.kill()
        return True

    def lost(self) -> str:
        """Return why no more outcomes can come; nothing here."""
        return ""

    def _new(self) -> ProcessPoolExecutor:
        executor = ProcessPoolExecutor(
            1, mp_context=self._context, initializer=_begin, initargs=(self._stop, not _masks())
        )
        self._children[executor] = None
        return executor

    def _end_of(self, executor: ProcessPoolExecutor) -> str:
        child = self._children.pop(executor, None)
        self._broken.append(executor)
        if child is not None:
            child.join(1.0)
        code = None if child is None else child.exitcode
        if code is not None and code < 0:
            return f"the worker process was killed (signal {-code}; 9 may mean: out of memory)"
        return f"the worker process ended (exit code {code})"


@contextmanager
def _worker_surroundings() -> Iterator[None]:
    """Let a process that starts here inherit one thread, and leave signals to this process."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS) if _masks() else None
    try:
        yield
    finally:
        if mask is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value


def _masks() -> bool:
    """True where a process can keep signals from the processes that it starts; not on Windows."""
    return hasattr(signal, "pthread_sigmask")


def _begin(flag: Any, deaf: bool) -> None:
    """Begin a worker: it ends with the process that started it, however that one ends.

    deaf: whether it must be kept from Ctrl-C, which a Windows console sends to all its processes.
    """
    global _flag
    _flag = flag
    if deaf:
        signal.signal(signal.SIGINT, signal.SIG_IGN)

    def leave() -> None:
        parent = multiprocessing.parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=leave, daemon=True).start()


def _work(function: Function, task: Any) -> Outcome:
    return call(function, task, lambda: bool(_flag.value))
