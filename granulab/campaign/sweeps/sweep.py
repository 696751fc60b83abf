"""Many cases on many cores: what several share is made once, each run has its folder, a row each.

A simulator says in a Simulator what its runs are and what they need; here nobody knows what they
compute. A case is a frozen dataclass with a `name`, a `time_step` [s] and `settings` whose [run]
has a seed; where more follows from the seed it has a method `with_seed`.
"""

import dataclasses
import heapq
import math
import operator
import re
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from granulab.campaign.output import room
from granulab.campaign.output.table import flat
from granulab.campaign.output.terminal import Progress, announce_compilation
from granulab.campaign.runs.folder import BusyError, RunFolder, find_run
from granulab.campaign.runs.protocol import Stop
from granulab.campaign.runs.provenance import Sources, to_stderr
from granulab.campaign.runs.sharing import cores
from granulab.campaign.runs.stages import in_words
from granulab.campaign.sweeps.engine import Tally, run_tasks
from granulab.campaign.sweeps.found.journal import Journal
from granulab.campaign.sweeps.found.origins import Origins
from granulab.campaign.sweeps.report.quantities import Quantities
from granulab.campaign.sweeps.task import EngineError, Function, Outcome
from granulab.errors import Failed, FolderError, InputError, SimulationError, Stopped

_LOOK = 0.5  # [s] between looks whether another process has ended a run
_TRUSTED = 1.0  # [s] of runs, from which on their cost is rather measured than expected
_LONGER = 1.2  # what a run that is still at work will take at least, over what it took so far

Labels = dict[str, Any]
Labelled = tuple[Labels, Any]  # the labels and the case that they name
Row = dict[str, Any]


class Task(NamedTuple):
    """Task of a worker."""

    case: Any
    out: Path
    packing_only: bool  # which several runs wait for
    shared: bool = False  # whether another task makes the packing of this run


@dataclass(frozen=True)
class Simulator:
    """Interface of a simulator for sweeps.

    name           of its command
    digest         names a run of a case, with its seed
    packing_folder where the packing that a case starts from is kept below a folder of runs; it
                   may not be there yet
    packing_from   digest of the sources that made the packing in a file; None where there is none
    work           runs the case of a Task in a worker, or makes its packing; found by its name
    read           what a finished run found, a dataclass; FolderError where it is damaged
    expected_cpu_s CPU time [s] that the packing of a case and its run will take, about
    disk_at_most   bytes that the run of a case takes at most, by what they are of
    stays          those of them that a finished run of a case still takes
    sources        the folders of code that decide what a run computes
    measures       those that make its results from what it stored; None: none do
    made_by        of a case, the sources of its run and of its packing, where they differ
    packages       distributions whose versions matter to the last bit
    quantities     numbers and endings by which a study compares its runs
    compiled       whether its kernels are; what is not compiled yet delays the first runs
    device         within it `work` of some cases goes to a GPU, from threads: so many at once;
                   EngineError where there is no GPU. None: it has none
    """

    name: str
    digest: Callable[[Any], str]
    packing_folder: Callable[[Any, Path], Path]
    packing_from: Callable[[Path], str | None]
    work: Function
    read: Callable[[RunFolder], Any]
    expected_cpu_s: Callable[[Any], tuple[float, float]]
    sources: Sources
    packages: list[str]
    measures: Sources | None = None
    made_by: Callable[[Any], tuple[Sources, Sources]] | None = None
    quantities: Quantities = field(default_factory=Quantities)
    compiled: Callable[[], bool] = lambda: True
    disk_at_most: Callable[[Any], Mapping[str, int]] = lambda case: {}
    stays: Callable[[Any], float] = lambda case: math.inf
    device: Callable[[Sequence[Any]], AbstractContextManager[int]] | None = None

    @property
    def means(self) -> tuple[str, ...]:
        """Columns of the numbers by which runs are compared."""
        return tuple(number.column for number in self.quantities.numbers)

    def run_folder(self, case: Any, out: Path, there: Collection[str] | None = None) -> RunFolder:
        """Return where a case is run, which a single run finds too; it may not exist yet.

        there: the names in `out`, where they are known; what is not among them is not looked for.
        """
        name, digest = f"{case.name}-seed{case.settings.run.seed}", self.digest(case)
        if there is not None and f"{name}-{digest}-2" not in there:  # nor was it begun --again
            return RunFolder(Path(out) / f"{name}-{digest}")
        return find_run(out, name, digest)

    def disk_of(self, cases: Sequence[Any], at_once: int | None = None) -> int:
        """Bytes that the runs of some cases take at most, none of which is there yet.

        at_once: how many run at a time, while each takes more than what stays; None: one a core
        """
        whole = [sum(self.disk_at_most(case).values()) for case in cases]
        stays = [min(self.stays(case), n) for case, n in zip(cases, whole, strict=True)]
        more = heapq.nlargest(at_once or cores(), map(operator.sub, whole, stays))
        return math.ceil(sum(stays) + sum(more))

    def packing_file(self, case: Any, out: Path) -> Path:
        """The packing in its folder."""
        return self.packing_folder(case, out) / "packing.h5"


def over_seeds(labels: Labels, case: Any, seeds: Sequence[int]) -> list[Labelled]:
    """A case once for each seed (0 or more), with the seed among its labels."""
    seeded = getattr(case, "with_seed", partial(_with_seed, case))
    return [({**labels, "seed": seed}, seeded(seed)) for seed in seeds]


def _with_seed(case: Any, seed: int) -> Any:
    run = case.settings.run.model_copy(update={"seed": seed})
    return dataclasses.replace(case, settings=case.settings.model_copy(update={"run": run}))


def run_labelled(
    simulator: Simulator,
    cases: Sequence[Labelled],
    *,
    out: Path,
    engine: str = "processes",
    workers: int | None = None,
    scheduler: str | None = None,
    quiet: bool = False,
    known: Sequence[Row] = (),
    journal: Path | None = None,
) -> list[Row]:
    """Run labelled cases and return a row for each, in their order.

    A row holds the labels, the fields of what `read` gives (nested ones as "dissipated_j.name"; a
    label of the same name goes before a field), "run_folder", "state" ("done", "failed" or
    "interrupted") and "reason" (one line, or ""). A run that is finished below `out` is read, not
    done again; one that is not goes on. After Ctrl-C the runs keep their state and rows that lack
    are "interrupted". A case whose labels a row of `known` has is not run: the row is returned as
    it is. `journal` is a file in which finished runs are listed with their rows: what it lists is
    not opened again. Raises EngineError where the engine cannot start and FolderError where `out`
    cannot be used.
    """
    if known:
        run = partial(run_labelled, simulator, out=out, engine=engine, workers=workers,
                      scheduler=scheduler, quiet=quiet, journal=journal)  # fmt: skip
        labels = [labels for labels, _ in cases]
        return beside_known(labels, known, lambda lacks: run([cases[k] for k in lacks]))
    out = Path(out).resolve()
    there, origins = names_in(out), Origins(simulator, out)
    folders = [simulator.run_folder(case, out, there) for _, case in cases]
    ended: dict[Path, Outcome] = {}
    with Journal(journal) as lines:

        def keep(folder: RunFolder, case: Any, outcome: Outcome) -> None:
            ended[folder.path] = outcome
            if outcome.state == "done" and folder.path in origins.of_these:
                lines.add(folder, origins.digests(case), outcome.value)

        missing: dict[Path, Any] = {}
        for folder, (_, case) in zip(folders, cases, strict=True):
            begun = folder.path.name in there
            if begun and (fields := lines.fields(folder, origins.digests(case))) is not None:
                ended[folder.path] = Outcome("done", {**fields, "reused": True})
                origins.know(folder)
                continue
            outcome = _read(simulator, folder) if begun else None
            origins.look(folder, case, begun=begun)  # after it was read, and perhaps measured again
            if outcome is None:
                missing[folder.path] = case
            else:
                keep(folder, case, outcome)
        if missing:
            _run_missing(simulator, missing, out, len(ended), quiet, keep, engine=engine,
                         workers=workers, scheduler=scheduler)  # fmt: skip
    origins.warn()
    return [
        _row(labels, folder.path, ended[folder.path])
        for folder, (labels, _) in zip(folders, cases, strict=True)
    ]


def names_in(out: Path) -> set[str]:
    """Names of what stands in a folder of runs: one look for all of them; none where it lacks."""
    try:
        return {path.name for path in out.iterdir()}
    except OSError:
        return set()


def _run_missing(
    simulator: Simulator, missing: Mapping[Path, Any], out: Path, before: int, quiet: bool,
    keep: Callable[[RunFolder, Any, Outcome], None], *,
    engine: str, workers: int | None, scheduler: str | None,
) -> None:  # fmt: skip
    """Run the cases that have not been run, by folder; before: how many were.

    keep: takes the folder, the case and the outcome of each as soon as it is known.
    """
    cases = list(missing.values())
    with _place(simulator, cases, engine, workers) as (where, at_once):
        # Of a cluster nobody knows here how many run at a time.
        if short := room.shortage(
            simulator.disk_of(cases, len(cases) if where == "dask" else at_once), out
        ):
            to_stderr(short)
        announce_compilation(quiet, simulator.compiled())
        tasks, needs, costs = _tasks(simulator, cases, out)
        folders = iter(missing)
        runs = {k: RunFolder(next(folders)) for k, t in enumerate(tasks) if not t.packing_only}
        title = f"{len(missing)} runs"
        if len(tasks) > len(missing):
            title += f", {len(tasks) - len(missing)} packings"

        def end(k: int, outcome: Outcome) -> None:
            if k in runs:
                keep(runs.pop(k), tasks[k].case, _with_fields(outcome))

        with Progress(title, quiet=quiet, estimates=False) as bar:
            outcomes = run_tasks(
                simulator.work, tasks, needs=needs, engine=where, workers=at_once,
                scheduler=scheduler, ended=end,
                report=lambda tally: bar.update(*_words(tally, before, costs)),
            )  # fmt: skip
        for k in list(runs):  # what did not end
            end(k, outcomes[k])


@contextmanager
def _place(
    simulator: Simulator, cases: Sequence[Any], engine: str, workers: int | None
) -> Iterator[tuple[str, int | None]]:
    """The engine that works the tasks within, and by how many: on a device these are threads."""
    if engine != "cuda":
        yield engine, workers
        return
    if simulator.device is None:
        raise EngineError(f"engine cuda: {simulator.name} knows no GPU; leave --engine out")
    with simulator.device(cases) as at_once:
        yield "threads", min(workers or at_once, at_once)


def lacking(cases: Sequence[Labelled], known: Sequence[Row]) -> list[Labelled]:
    """The cases whose labels no row has."""
    return [case for case in cases if _with_labels(case[0], known) is None]


def beside_known(
    labels: Sequence[Labels], known: Sequence[Row], make: Callable[[list[int]], Sequence[Row]]
) -> list[Row]:
    """A row for each of the labels, in their order: the known one as it is, or one that is made.

    make: gives the rows of those, by their places, that no known row has; not called without any.
    """
    rows = [_with_labels(one, known) for one in labels]
    lacks = [k for k, row in enumerate(rows) if row is None]
    made = iter(make(lacks) if lacks else ())
    return [next(made) if row is None else row for row in rows]


def refuse_interrupted(rows: Sequence[Row]) -> None:
    """Raise KeyboardInterrupt, for a person at Python, where runs were cut off by Ctrl-C."""
    reasons = [row["reason"] for row in rows if row["state"] == "interrupted"]
    if reasons:
        lacking = f"{len(reasons)} of {len(rows)} runs are not finished ({reasons[0]})"
        raise KeyboardInterrupt(f"{lacking}; the same call goes on from there")


def is_elsewhere(row: Row) -> bool:
    """True for a row of `known`, whose run has no folder here that could be measured again."""
    return row["state"] == "done" and "run_folder" not in row


def _with_labels(labels: Labels, rows: Sequence[Row]) -> Row | None:
    """The row with these labels; None where none has them."""
    return next((row for row in rows if labels.items() <= row.items()), None)


@contextmanager
def as_outcome(*failed: type[Exception]) -> Iterator[None]:
    """Turn what a simulator raises in a worker into what the engine knows; see sweeps.task."""
    try:
        yield
    except failed as error:
        raise Failed(without_again(str(error))) from None


def run_or_pack(
    task: Task, stop: Stop, *, run: Callable[..., Any], get_packing: Callable[..., Any]
) -> Any:
    """Run the case of a task, or make its packing (None); in a worker.

    A run that another process computes is waited for, and its result read. Raises Stopped where
    `stop` says so meanwhile.

    run(case, out=, stop=, warn=) and get_packing(case, out, progress, stop, warn) are the
    simulator's.
    """
    with as_outcome(InputError, FolderError, SimulationError):
        if task.packing_only:
            get_packing(task.case, task.out, lambda fraction, text: None, stop, silent)
            return None
        while True:
            try:
                return run(task.case, out=task.out, stop=stop, warn=silent)
            except BusyError as busy:
                if stop():
                    raise Stopped("the same command goes on from there") from busy
                time.sleep(_LOOK)


def silent(warning: str) -> None:
    """For a simulator's `warn`: a sweep says it for all runs in one line, at the end."""


def without_again(line: str, folder: Path | None = None) -> str:
    """An error line for a sweep, which has no --again."""
    line = re.sub(r",? or use --again.*", "", line)  # another cure stands before it
    what, again, _ = line.partition("; use --again")
    if not again:
        return line
    where = f"the folder {folder}" if folder else "the folder of the run"
    return f"{what}; delete {where} and the same command does it again"


def _read(simulator: Simulator, folder: RunFolder) -> Outcome | None:
    """Return what a finished run found, None of one to be run; damaged, it is left as it is."""
    if folder.state != "finished":
        return None
    try:
        return _with_fields(Outcome("done", simulator.read(folder)))
    except BusyError:  # measured again now: whoever runs it waits for that
        return None
    except FolderError as error:
        return Outcome("failed", reason=without_again(str(error), folder.path))


def _with_fields(outcome: Outcome) -> Outcome:
    """An outcome with the fields of what a run found, in place of the dataclass."""
    if outcome.value is None:
        return outcome
    fields = flat(dataclasses.asdict(outcome.value))
    plain = {name: list(each) if isinstance(each, tuple) else each for name, each in fields}
    return dataclasses.replace(outcome, value=plain)


def _tasks(
    simulator: Simulator, cases: list[Any], out: Path
) -> tuple[list[Task], dict[int, int], list[float]]:
    """Runs in their order; in front of those that share a missing packing, its making.

    The dictionary gives the index of the packing's task by the index of the run that needs it; then
    the expected costs [s]: a run that finds no packing, and shares none, fills it first.
    """
    files = [simulator.packing_file(case, out) for case in cases]
    times = Counter(files)
    lacking = {file for file in times if not file.exists()}
    tasks: list[Task] = []
    costs: list[float] = []
    needs: dict[int, int] = {}
    makings: dict[Path, int] = {}
    for file, case in zip(files, cases, strict=True):
        packing, run = simulator.expected_cpu_s(case)
        shared = file in lacking and times[file] > 1
        if shared:
            if file not in makings:
                makings[file] = len(tasks)
                tasks.append(Task(case, out, packing_only=True))
                costs.append(packing)
            needs[len(tasks)] = makings[file]
        tasks.append(Task(case, out, packing_only=False, shared=shared))
        costs.append(run + (packing if file in lacking and not shared else 0.0))
    return tasks, needs, costs


def _words(tally: Tally, before: int, costs: Sequence[float]) -> tuple[float, str]:
    """Return how far a sweep is, and the same in words."""
    ended = tally.done + tally.failed
    there = f" and {before} before" if before else ""
    done, left = progress_of(tally, costs)
    if tally.stopping:
        return done, f"stopping, {tally.running} running keep their state (Ctrl-C again ends them)"
    return (
        done,
        f"{tally.done} done{there}, {tally.running} running, {tally.failed} failed, "
        f"{tally.total - ended - tally.running} waiting; {in_words(left)} left",
    )


def progress_of(tally: Tally, costs: Sequence[float]) -> tuple[float, float]:
    """Part (0 to 1) of the work of tasks that is done, and the time left [s].

    costs: expected ones of all tasks [s]; those that ended say how they are on this machine.
    """
    measured, expected = sum(tally.took.values()), sum(costs[k] for k in tally.took)
    slowness = (_TRUSTED + measured) / (_TRUSTED + expected)
    overdue = (_LONGER * time / costs[k] for k, time in tally.since.items())
    slowness = max([slowness, *overdue])
    cost = {k: slowness * each for k, each in enumerate(costs) if k not in tally.took}
    left = {k: each - tally.since.get(k, 0.0) for k, each in cost.items()}
    longest = max(left.values(), default=0.0)
    whole = slowness * sum(costs)
    done = 1.0 - sum(left.values()) / whole if whole else 1.0
    return done, max(sum(left.values()) / tally.slots, longest)


def _row(labels: Labels, folder: Path, outcome: Outcome) -> Row:
    fields = outcome.value or {}
    state = {"state": outcome.state, "reason": outcome.reason}
    return {**labels, **fields, "run_folder": str(folder), **labels, **state}  # labels in front
