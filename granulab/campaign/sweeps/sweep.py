"""Many cases on many cores: what several share is made once, each run has its folder, a row each.

A simulator says in a Simulator what its runs are and what they need; here nobody knows what they
compute. A case is a frozen dataclass with a `name`, a `time_step` [s] and `settings` whose [run]
has a seed; where more follows from the seed it has a method `with_seed`.
"""

import dataclasses
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from granulab.campaign.output import room
from granulab.campaign.output.terminal import Progress, announce_compilation
from granulab.campaign.runs.folder import RunFolder, find_run
from granulab.campaign.runs.protocol import Stop
from granulab.campaign.runs.provenance import Sources, to_stderr
from granulab.campaign.runs.stages import in_words
from granulab.campaign.sweeps.engine import Tally, run_tasks
from granulab.campaign.sweeps.report.quantities import Quantities
from granulab.campaign.sweeps.task import EngineError, Function, Outcome
from granulab.errors import Failed, FolderError, InputError, SimulationError

_TRUSTED = 1.0  # [s] of runs, from which on their cost is rather measured than expected

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
    device: Callable[[Sequence[Any]], AbstractContextManager[int]] | None = None

    @property
    def means(self) -> tuple[str, ...]:
        """Columns of the numbers by which runs are compared."""
        return tuple(number.column for number in self.quantities.numbers)

    def run_folder(self, case: Any, out: Path) -> RunFolder:
        """Return where a case is run, which a single run finds too; it may not exist yet."""
        return find_run(out, f"{case.name}-seed{case.settings.run.seed}", self.digest(case))

    def disk_of(self, cases: Sequence[Any]) -> int:
        """Bytes that the runs of some cases take at most, none of which is there yet."""
        return sum(sum(self.disk_at_most(case).values()) for case in cases)

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
) -> list[Row]:
    """Run labelled cases and return a row for each, in their order.

    A row holds the labels, the fields of what `read` gives (nested ones as "dissipated_j.name"; a
    label of the same name goes before a field), "run_folder", "state" ("done", "failed" or
    "interrupted") and "reason" (one line, or ""). A run that is finished below `out` is read, not
    done again; one that is not goes on. After Ctrl-C the runs keep their state and rows that lack
    are "interrupted". A case whose labels a row of `known` has is not run: the row is returned as
    it is. Raises EngineError where the engine cannot start and FolderError where
    `out` cannot be used.
    """
    if known:
        return beside_known(
            [labels for labels, _ in cases], known,
            lambda lacks: run_labelled(simulator, [cases[k] for k in lacks], out=out, engine=engine,
                                       workers=workers, scheduler=scheduler, quiet=quiet),
        )  # fmt: skip
    out = Path(out).resolve()
    folders = [simulator.run_folder(case, out) for _, case in cases]
    ended: dict[Path, Outcome] = {}
    missing: dict[Path, Any] = {}
    for folder, (_, case) in zip(folders, cases, strict=True):
        if folder.state == "finished":
            ended[folder.path] = _read(simulator, folder)
        else:
            missing[folder.path] = case
    if missing:
        with _place(simulator, list(missing.values()), engine, workers) as (where, at_once):
            ended |= _run_missing(
                simulator, missing, out, len(ended), quiet,
                engine=where, workers=at_once, scheduler=scheduler,
            )  # fmt: skip
    _warn_of_other_sources(simulator, [case for _, case in cases], folders, out)
    return [
        _row(labels, folder.path, ended[folder.path])
        for folder, (labels, _) in zip(folders, cases, strict=True)
    ]


def _run_missing(
    simulator: Simulator, missing: Mapping[Path, Any], out: Path, before: int, quiet: bool,
    **engine: Any,
) -> dict[Path, Outcome]:  # fmt: skip
    """Outcomes of the cases that have not been run, by folder; before: how many were."""
    if short := room.shortage(simulator.disk_of(list(missing.values())), out):
        to_stderr(short)
    announce_compilation(quiet, simulator.compiled())
    tasks, needs = _tasks(simulator, list(missing.values()), out)
    title = f"{len(missing)} runs"
    if len(tasks) > len(missing):
        title += f", {len(tasks) - len(missing)} packings"
    costs = [_expected(simulator, task) for task in tasks]
    with Progress(title, quiet=quiet, estimates=False) as bar:
        outcomes = run_tasks(
            simulator.work, tasks, needs=needs, **engine,
            report=lambda tally: bar.update(*_words(tally, before, costs)),
        )  # fmt: skip
    runs = (o for o, task in zip(outcomes, tasks, strict=True) if not task.packing_only)
    return dict(zip(missing, runs, strict=True))


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

    run(case, out=, stop=, warn=) and get_packing(case, out, progress, stop, warn) are the
    simulator's.
    """
    with as_outcome(InputError, FolderError, SimulationError):
        if task.packing_only:
            get_packing(task.case, task.out, lambda fraction, text: None, stop, silent)
            return None
        return run(task.case, out=task.out, stop=stop, warn=silent)


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


def _warn_of_other_sources(
    simulator: Simulator, cases: list[Any], folders: list[RunFolder], out: Path
) -> None:
    """One line on stderr where runs, packings or results were made by other sources than these."""
    by = simulator.made_by or (lambda case: (simulator.sources, simulator.sources))
    runs, packings, results = {}, {}, {}  # whether others made it, by where it is
    for case, folder in zip(cases, folders, strict=True):
        of_run, of_packing = by(case)
        origin, packing = _origin(folder), simulator.packing_file(case, out)
        runs[folder.path] = origin.get("source_digest") not in (None, of_run.digest)
        packings[packing] = simulator.packing_from(packing) not in (None, of_packing.digest)
        if simulator.measures and "measures_digest" in origin:
            results[folder.path] = origin["measures_digest"] != simulator.measures.digest
    of_others = [
        f"{sum(made.values())} of {len(made)} {what}"
        for what, made in (("runs", runs), ("packings", packings), ("results", results))
        if what != "results" or any(made.values())
    ]
    if any(not words.startswith("0 ") for words in of_others):
        to_stderr(
            f"{' and '.join(of_others)} were made by another version of the sources; delete their "
            "folders and the same command makes them again"
        )


def _origin(folder: RunFolder) -> dict[str, Any]:
    try:
        return folder.read_provenance()
    except FolderError:  # not begun; what is damaged is reported in its row
        return {}


def _read(simulator: Simulator, folder: RunFolder) -> Outcome:
    """Return what a finished run found; damaged, it is refused and left as it is."""
    try:
        return Outcome("done", simulator.read(folder))
    except FolderError as error:
        return Outcome("failed", reason=without_again(str(error), folder.path))


def _tasks(simulator: Simulator, cases: list[Any], out: Path) -> tuple[list[Task], dict[int, int]]:
    """Runs in their order; in front of those that share a missing packing, its making.

    The dictionary gives the index of the packing's task by the index of the run that needs it.
    """
    files = [simulator.packing_file(case, out) for case in cases]
    times = Counter(files)
    tasks: list[Task] = []
    needs: dict[int, int] = {}
    makings: dict[Path, int] = {}
    for file, case in zip(files, cases, strict=True):
        if times[file] > 1 and not file.exists():
            if file not in makings:
                makings[file] = len(tasks)
                tasks.append(Task(case, out, packing_only=True))
            needs[len(tasks)] = makings[file]
        tasks.append(Task(case, out, packing_only=False, shared=file in makings))
    return tasks, needs


def _expected(simulator: Simulator, task: Task) -> float:
    """Expected cost [s] of a task; a run that finds no packing fills it first."""
    packing, run = simulator.expected_cpu_s(task.case)
    if task.packing_only:
        return packing
    alone = not simulator.packing_file(task.case, task.out).exists() and not task.shared
    return run + (packing if alone else 0.0)


def _words(tally: Tally, before: int, costs: Sequence[float]) -> tuple[float, str]:
    """Return how far a sweep is, and the same in words."""
    ended = tally.done + tally.failed
    there = f" and {before} before" if before else ""
    done, left = progress_of(tally, costs)
    if tally.stopping:
        return done, f"stopping, {tally.running} running keep their state"
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
    slowness = max([slowness, *(time / costs[k] for k, time in tally.since.items())])
    cost = {k: slowness * each for k, each in enumerate(costs) if k not in tally.took}
    left = {k: each - tally.since.get(k, 0.0) for k, each in cost.items()}
    longest = max(left.values(), default=0.0)
    whole = slowness * sum(costs)
    done = 1.0 - sum(left.values()) / whole if whole else 1.0
    return done, max(sum(left.values()) / tally.slots, longest)


def _row(labels: Labels, folder: Path, outcome: Outcome) -> Row:
    fields = dict(_flat(dataclasses.asdict(outcome.value))) if outcome.value else {}
    state = {"state": outcome.state, "reason": outcome.reason}
    return {**labels, **fields, "run_folder": str(folder), **labels, **state}  # labels in front


def _flat(table: dict[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", value
