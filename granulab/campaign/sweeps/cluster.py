"""A Dask cluster that runs tasks; the extra `cluster` installs what it needs."""

import logging
import math
import socket
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager, suppress
from ipaddress import ip_address
from typing import Any, Self
from urllib.parse import urlsplit
from uuid import uuid4

from granulab.campaign.runs.provenance import to_stderr
from granulab.campaign.sweeps.task import EngineError, Function, Outcome, call
from granulab.errors import Failed

_PATIENCE = 10.0  # [s] for a scheduler to respond
_REPEAT = 2.0  # [s] workers that come late are stopped too, and counted
_LOOK = 1.0  # [s] for a scheduler to say how many there are
_AHEAD = 1.1  # tasks of a thread: what Dask itself sends ahead (worker-saturation)
# For Dask's developers each connection keeps its last 1000 messages, with the cases in them, some
# 0.2 MB each. A scheduler is told by its environment (docs/runs/sweeps.md).
_NO_LOG = {"distributed.admin.low-level-log-length": 0}

_stopping: set[str] = set()  # in a worker: the sweeps that are to stop


class DaskCluster:
    """The workers of a scheduler at an address; see sweeps.engine for the calls."""

    def __init__(self, scheduler: str) -> None:
        self._scheduler = scheduler
        self._threads, self._counted = 0, 0.0
        self._name = uuid4().hex
        self._asked = 0.0
        self._is_lost = False

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            self._client = _connect(self._scheduler, stack)
            self._threads, self._counted = _total(self._client.ncores()), time.monotonic()
            if not self._threads:
                raise EngineError(
                    f"scheduler {self._scheduler}: has no workers; start one with: "
                    f"dask worker {self._scheduler} --host 127.0.0.1 --dashboard-address "
                    "127.0.0.1:0 --nthreads 1"
                )
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def slots(self) -> int:
        """Tasks that its threads work on, and a few that wait there; workers come and go.

        No more: the scheduler keeps what it holds in memory, and all of that counts as running.
        """
        if time.monotonic() - self._counted > _REPEAT and not self.lost():
            self._counted = time.monotonic()
            ask = self._client.scheduler.ncores
            with suppress(OSError):  # of a scheduler that has just gone, or has much to do
                found = self._client.sync(ask, workers=None, callback_timeout=_LOOK)
                self._threads = _total(found)
        return math.ceil(_AHEAD * self._threads)

    def submit(self, function: Function, task: Any) -> Future:
        """The future outcome of a task; one whose worker is killed goes to another by itself."""
        outcome: Future = Future()
        remote = self._client.submit(_work, self._name, function, task, pure=False)

        def pass_on(remote: Any) -> None:
            if remote.status == "finished":
                try:
                    outcome.set_result(remote.result())
                except Exception as lost:  # what was found did not get here
                    outcome.set_exception(lost)
                return
            error = remote.exception() if remote.status == "error" else None
            if error is None:
                self._is_lost = True
                error = Failed("cancelled")
            elif type(error).__name__ == "KilledWorker":
                error = Failed("every worker that took it ended under it")
            outcome.set_exception(error)

        remote.add_done_callback(pass_on)
        return outcome

    def ask_to_stop(self) -> None:
        """Make the running tasks keep their state and end."""
        if time.monotonic() - self._asked > _REPEAT and not self._is_lost:
            self._asked = time.monotonic()
            self._client.run(_ask, self._name, wait=False)

    def give_up(self) -> bool:
        """Nothing: the workers of a cluster are its own, and end their tasks by themselves."""
        return False

    def lost(self) -> str:
        """Return why no more outcomes can come, in one line, or nothing."""
        if not self._is_lost and self._client.status == "running":
            return ""
        return f"scheduler {self._scheduler} went away"


def _total(threads: Mapping[str, int]) -> int:
    """Threads of all workers, by address."""
    return sum(threads.values())


def _connect(scheduler: str, stack: ExitStack) -> Any:
    """A client of a scheduler, closed with the stack; EngineError where none responds."""
    try:
        import dask
        from distributed import Client
    except ImportError:
        raise EngineError(
            "engine dask needs the package distributed: pip install 'granulab[cluster]'"
        ) from None
    stack.enter_context(_silence())
    stack.enter_context(dask.config.set(_NO_LOG))
    try:
        # A look first: a client that cannot connect leaves a traceback on stderr when it goes.
        address = urlsplit(scheduler if "://" in scheduler else f"tcp://{scheduler}")
        if address.scheme not in ("tcp", "tls") or address.hostname is None or address.port is None:
            raise ValueError(scheduler)
        if address.scheme == "tcp" and not _is_loopback(address.hostname):
            to_stderr(
                f"scheduler {scheduler}: whoever reaches it or a worker can run any code there; on "
                "a trusted network only, or with TLS (docs/runs/sweeps.md)"
            )
        socket.create_connection((address.hostname, address.port), _PATIENCE).close()
        client = Client(scheduler, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError):
        raise EngineError(
            f"scheduler {scheduler}: does not respond; start one with: dask scheduler --host "
            "127.0.0.1 --dashboard-address 127.0.0.1:8787, and give the address that it prints, "
            "such as tcp://127.0.0.1:8786"
        ) from None
    stack.callback(_close, client)
    return client


def _is_loopback(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:  # a name
        return host == "localhost"


def _close(client: Any) -> None:
    with suppress(OSError):  # of a scheduler that is gone
        client.close(timeout=_PATIENCE)


@contextmanager
def _silence() -> Iterator[None]:
    """One line from us, not tens from the library, when a scheduler goes away."""
    names = [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]
    levels = {logger: logger.level for logger in map(logging.getLogger, names)}
    try:
        for logger in levels:
            logger.setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)


async def _ask(name: str) -> None:
    _stopping.add(name)


def _work(name: str, function: Function, task: Any) -> Outcome:
    return call(function, task, lambda: name in _stopping)
