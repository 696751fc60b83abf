"""Runs many tasks on the cores of a machine or on a Dask cluster; knows nothing of what they do.

A task that fails is an outcome with its reason. A worker that is killed loses the task it had,
which is tried again; the others go on. Ctrl-C makes the running tasks keep their state.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from time import monotonic
from typing import Any

from granulab.campaign.output.terminal import StopRequest
from granulab.campaign.sweeps.task import EngineError, Function, Outcome, WorkerLost, in_one_line

TRIES = 3  # of a task whose worker is killed
_GRACE = 0.5  # [s] for tasks to keep their state and end
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


@dataclass
class _Work:
    """The tasks of one call of run_tasks and what became of them."""

    function: Function
    tasks: Sequence[Any]
    needs: Mapping[int, int]
    outcomes: dict[int, Outcome] = field(default_factory=dict)
    running: dict[Future, int] = field(default_factory=dict)
    began: dict[int, float] = field(default_factory=dict)
    tries: dict[int, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.waiting = list(range(len(self.tasks)))

    def ready(self) -> int | None:
        """The first task that may start; those that wait for a failed one fail with it."""
        for k in list(self.waiting):
            before = self.needs.get(k)
            if before is None or before in self.outcomes:
                self.waiting.remove(k)
                ended = None if before is None else self.outcomes[before]
                if ended is None or ended.state == "done":
                    return k
                self.outcomes[k] = Outcome(ended.state, reason=ended.reason)
        return None

    def take(self, future: Future) -> None:
        """Keep what a future brought, or put its task back where the worker was lost."""
        k = self.running.pop(future)
        error = future.exception()
        if error is None:
            self.outcomes[k] = future.result()
            return
        self.tries[k] = self.tries.get(k, 0) + 1
        if not isinstance(error, WorkerLost):
            self.outcomes[k] = Outcome("failed", reason=in_one_line(error))
        elif self.tries[k] < TRIES:
            self.waiting.insert(0, k)
        else:
            self.outcomes[k] = Outcome("failed", reason=f"{error}, {TRIES} times")

    def tally(self, slots: int, stopping: bool) -> Tally:
        states = [outcome.state for outcome in self.outcomes.values()]
        return Tally(
            len(self.tasks),
            states.count("done"),
            len(self.running),
            states.count("failed"),
            slots,
            {k: outcome.wall_s for k, outcome in self.outcomes.items()},
            {k: monotonic() - self.began[k] for k in self.running.values()},
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
) -> list[Outcome]:
    """Call function(task, stop) for every task and return the outcomes in their order.

    `needs` gives, by index, the task that must be done before another starts. `engine` is
    "processes" (`workers` of them, one per core by default), "threads" of this process, for tasks
    that wait for a device, or "dask" (the cluster whose `scheduler` has this address). After
    Ctrl-C, SIGTERM or the loss of the scheduler, what did not end is "interrupted": tasks have half
    a second to keep their state; processes that go on (they compile, grow particles, or have long
    frames) are killed, and go on from their last checkpoint the next time. Raises EngineError where
    the engine cannot start.
    """
    work = _Work(function, tasks, needs or {})
    reason, asked = "not started", 0.0
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
                k = work.ready()
                if k is None:
                    break
                work.began[k] = monotonic()
                work.running[pool.submit(function, tasks[k])] = k
            report(work.tally(pool.slots, request.requested))
            if not work.running:
                break
            ended = wait(work.running, _LOOK, FIRST_COMPLETED).done
            for future in ended:
                if not (pool.lost() and future.exception()):
                    work.take(future)
    return [work.outcomes.get(k, Outcome("interrupted", reason=reason)) for k in range(len(tasks))]


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

        return Threads(max(min(workers or _cores(), n_tasks), 1))
    from granulab.campaign.sweeps.processes import Processes

    return Processes(max(min(workers or _cores(), n_tasks), 1))


def _cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
