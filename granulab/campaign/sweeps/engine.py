"""Runs many tasks on the cores of a machine or on a Dask cluster; knows nothing of what they do.

A task that fails is an outcome with its reason. A worker that is killed loses the task it had,
which is tried again; the others go on. Ctrl-C makes the running tasks keep their state.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field
from heapq import heappop, heappush
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any

from granulab.campaign.output.terminal import StopRequest
from granulab.campaign.runs.sharing import cores
from granulab.campaign.sweeps.task import EngineError, Function, Outcome, WorkerLost, in_one_line

TRIES = 3  # of a task whose worker is killed
_GRACE = 15.0  # [s] for tasks to keep their state and end: a checkpoint of a large bed
_LOOK = 0.2  # [s] between looks for Ctrl-C


@dataclass
class Tally:
    """Number of tasks, and how far they are."""

    total: int
    done: int = 0
    running: int = 0
    failed: int = 0
    slots: int = 1  # tasks that can run at once
    took: dict[int, float] = field(default_factory=dict)  # [s] by index, of those that ended
    since: dict[int, float] = field(default_factory=dict)  # [s] by index, of those that run
    stopping: bool = False  # whether they are to end


class _Work:
    """The tasks of one call of run_tasks and what became of them.

    What a task costs here does not grow with their number.
    """

    def __init__(self, tasks: Sequence[Any], needs: Mapping[int, int]) -> None:
        self.outcomes: dict[int, Outcome] = {}
        self.running: dict[Future, int] = {}
        self._tasks = tasks
        self._began: dict[int, float] = {}
        self._tries: dict[int, int] = {}
        self._took: dict[int, float] = {}
        self._states: Counter[str] = Counter()
        self._ready = [k for k in range(len(tasks)) if k not in needs]  # a heap
        self._behind: dict[int, list[int]] = {}  # that wait for a task
        for k, before in needs.items():
            self._behind.setdefault(before, []).append(k)

    def start(self, pool: Any, function: Function) -> Future | None:
        """Begin the first task that may start; its future, None where there is none."""
        if not self._ready:
            return None
        k = heappop(self._ready)
        self._began[k] = monotonic()
        future: Future = pool.submit(function, self._tasks[k])
        self.running[future] = k
        return future

    def take(self, future: Future) -> list[int]:
        """Keep what a future brought, or put its task back; the tasks that ended with it."""
        k = self.running.pop(future)
        error = future.exception()
        if error is None:
            return self._end(k, future.result())
        self._tries[k] = self._tries.get(k, 0) + 1
        if not isinstance(error, WorkerLost):
            return self._end(k, Outcome("failed", reason=in_one_line(error)))
        if self._tries[k] < TRIES:
            heappush(self._ready, k)
            return []
        return self._end(k, Outcome("failed", reason=f"{error}, {TRIES} times"))

    def _end(self, k: int, outcome: Outcome) -> list[int]:
        """Keep an outcome; those that wait for a failed task fail with it. All that ended."""
        self.outcomes[k], self._took[k] = outcome, outcome.wall_s
        self._states[outcome.state] += 1
        ended = [k]
        for each in self._behind.pop(k, ()):
            if outcome.state == "done":
                heappush(self._ready, each)
            else:
                ended += self._end(each, Outcome(outcome.state, reason=outcome.reason))
        return ended

    def tally(self, slots: int, stopping: bool) -> Tally:
        return Tally(
            len(self._tasks),
            self._states["done"],
            len(self.running),
            self._states["failed"],
            slots,
            self._took,
            {k: monotonic() - self._began[k] for k in self.running.values()},
            stopping,
        )


def run_tasks(
    function: Function,
    tasks: Sequence[Any],
    *,
    needs: Mapping[int, int] | None = None,
    engine: str = "processes",
    workers: int | None = None,
    scheduler: str | None = None,
    report: Callable[[Tally], None] = lambda tally: None,
    ended: Callable[[int, Outcome], None] = lambda k, outcome: None,
) -> list[Outcome]:
    """Call function(task, stop) for every task and return the outcomes in their order.

    `needs` gives, by index, the task that must be done before another starts. `engine` is
    "processes" (`workers` of them, one per core by default), "threads" of this process, for tasks
    that wait for a device, or "dask" (the cluster whose `scheduler` has this address). After
    Ctrl-C, SIGTERM or the loss of the scheduler, what did not end is "interrupted": tasks have 15 s
    to keep their state; processes that go on (they compile, or grow particles) are killed, and go
    on from their last checkpoint the next time. A second Ctrl-C kills them at once. Raises
    EngineError where the engine cannot start.

    report: takes the tally some times a second, and at the end; ended: an index and its outcome
    as soon as it is known, those left out that were interrupted before they began.
    """
    work = _Work(tasks, needs or {})
    arrived: SimpleQueue[Future] = SimpleQueue()  # to wait for all of them costs by their number
    reason, asked = "not started", 0.0
    reported, stopping = -_LOOK, False
    with _pool(engine, workers, scheduler, len(tasks)) as pool, StopRequest() as request:
        while True:
            if request.requested:
                pool.ask_to_stop()
                asked = asked or monotonic()
                if monotonic() - asked > _GRACE and pool.give_up():
                    reason = "stopped between two checkpoints"
                    break
            lost = pool.lost()
            if lost:
                reason = lost
                break
            while not request.requested and len(work.running) < pool.slots:
                future = work.start(pool, function)
                if future is None:
                    break
                future.add_done_callback(arrived.put)
            # The words of a report go over all tasks: some times a second, not for each of them.
            last = not work.running or request.requested != stopping
            if last or monotonic() - reported >= _LOOK:
                reported, stopping = monotonic(), request.requested
                report(work.tally(pool.slots, stopping))
            if not work.running:
                break
            for future in _those_in(arrived):
                if not (pool.lost() and future.exception()):
                    for k in work.take(future):
                        ended(k, work.outcomes[k])
    return [work.outcomes.get(k, Outcome("interrupted", reason=reason)) for k in range(len(tasks))]


def _those_in(arrived: "SimpleQueue[Future]") -> list[Future]:
    """The futures that have ended; where there are none, waits a moment for one."""
    found = []
    with suppress(Empty):
        found.append(arrived.get(timeout=_LOOK))
        while True:
            found.append(arrived.get_nowait())
    return found


def _pool(engine: str, workers: int | None, scheduler: str | None, n_tasks: int) -> Any:
    if engine == "dask":
        from granulab.campaign.sweeps.cluster import DaskCluster

        if workers is not None:
            raise EngineError("workers go with processes; a Dask cluster has its own")
        if scheduler is None:
            raise EngineError(
                "engine dask needs the address of its scheduler, such as tcp://127.0.0.1:8786"
            )
        return DaskCluster(scheduler)
    if engine not in ("processes", "threads"):
        raise EngineError(f"engine {engine!r}: known: processes, threads, dask")
    if scheduler is not None:
        raise EngineError(f"scheduler {scheduler}: goes with engine dask")
    if workers is not None and workers < 1:
        raise EngineError(f"workers = {workers}: must be at least 1")
    if engine == "threads":
        from granulab.campaign.sweeps.threads import Threads

        return Threads(max(min(workers or cores(), n_tasks), 1))
    from granulab.campaign.sweeps.processes import Processes

    return Processes(max(min(workers or cores(), n_tasks), 1))
