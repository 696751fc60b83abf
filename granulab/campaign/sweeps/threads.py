"""Threads of this process, for tasks that wait for a device and share it."""

import threading
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Self

from granulab.campaign.sweeps.task import Function, call


class Threads:
    """So many threads; see granulab.campaign.sweeps.engine for the calls."""

    def __init__(self, workers: int) -> None:
        self.slots = workers
        self._stop = threading.Event()
        self._executor = ThreadPoolExecutor(workers)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._executor.shutdown()

    def submit(self, function: Function, task: Any) -> Future:
        """The future outcome of a task."""
        return self._executor.submit(call, function, task, self._stop.is_set)

    def ask_to_stop(self) -> None:
        """Make the running tasks keep their state and end."""
        self._stop.set()

    def give_up(self) -> bool:
        """Return whether the running tasks were ended: threads cannot be."""
        return False

    def lost(self) -> str:
        """Return why no more outcomes can come; nothing here."""
        return ""
