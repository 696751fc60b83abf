"""Many cases on many cores: each packing filled once, each run in its own folder, one row each."""

import dataclasses
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from campaign.engine import Tally, run_tasks
from campaign.folder import FolderError, RunFolder, find_run
from campaign.task import Failed, Interrupted, Outcome, Stop
from campaign.terminal import Progress
from contact.quantity import InputError
from silo2d import protocol
from silo2d.case import SiloCase
from silo2d.discharge import Stopped
from silo2d.packing import load_packing, packing_folder
from silo2d.result import Result
from silo2d.simulation import SimulationError
from silo2d.sources import own_sources, to_stderr
from silo2d.warm import compile_kernels

_MEMORY = 3600.0  # [s] over which the speed is taken that gives the time left

Labels = dict[str, Any]
Labelled = tuple[Labels, SiloCase]


class _Task(NamedTuple):
    """What a worker is given."""

    case: SiloCase
    out: Path
    fill_only: bool  # the packing alone, which several runs wait for


def over_seeds(labels: Labels, case: SiloCase, seeds: Sequence[int]) -> list[Labelled]:
    """A case once for each seed (0 or more), with the seed among its labels."""
    settings = case.settings
    return [
        (
            {**labels, "seed": seed},
            dataclasses.replace(
                case,
                settings=settings.model_copy(
                    update={"run": settings.run.model_copy(update={"seed": seed})}
                ),
            ),
        )
        for seed in seeds
    ]


def run_cases(
    cases: Sequence[Labelled],
    *,
    out: Path,
    engine: str = "processes",
    workers: int | None = None,
    scheduler: str | None = None,
    quiet: bool = False,
) -> list[dict[str, Any]]:
    """Run labelled cases and return a row for each, in their order.

    A row holds the labels, the fields of Result (nested ones as "dissipated_j.name"; a label of
    the same name goes before a field), "state" ("done", "failed" or "interrupted") and "reason"
    (one line, or ""). A run that is finished below `out` is read, not done again; one that is not
    goes on. After Ctrl-C the runs keep their state and rows that lack are "interrupted".
    Raises EngineError where the engine cannot start and FolderError where `out` cannot be used.
    """
    out = Path(out).resolve()
    folders = [run_folder(case, out) for _, case in cases]
    ended: dict[Path, Outcome] = {}
    missing: dict[Path, SiloCase] = {}
    for folder, (_, case) in zip(folders, cases, strict=True):
        if folder.state == "finished":
            ended[folder.path] = _read(folder)
        else:
            missing[folder.path] = case
    if missing:
        tasks, needs = _tasks(list(missing.values()), out)
        before = len(ended)
        title = f"{len(missing)} runs"
        if len(tasks) > len(missing):
            title += f", {len(tasks) - len(missing)} packings"
        with Progress(title, quiet=quiet, memory=_MEMORY) as bar:
            outcomes = run_tasks(
                run_task, tasks, needs=needs, engine=engine, workers=workers,
                scheduler=scheduler, report=lambda tally: bar.update(*_words(tally, before)),
            )  # fmt: skip
        runs = (o for o, task in zip(outcomes, tasks, strict=True) if not task.fill_only)
        ended |= dict(zip(missing, runs, strict=True))
    _warn_of_other_sources([case for _, case in cases], folders, out)
    return [
        _row(labels, folder.path, ended[folder.path])
        for folder, (labels, _) in zip(folders, cases, strict=True)
    ]


def run_task(task: _Task, stop: Stop) -> Result | None:
    """Run a case, or fill its packing; in a worker."""
    compile_kernels(drawn=task.case.disorder is not None and not task.fill_only)
    try:
        if task.fill_only:
            protocol.get_packing(task.case, task.out, lambda fraction, text: None, stop, _ignore)
            return None
        return protocol.run(task.case, out=task.out, stop=stop, warn=_ignore)
    except Stopped as error:
        raise Interrupted(str(error)) from None
    except (InputError, FolderError, SimulationError) as error:
        raise Failed(_without_again(str(error))) from None


def _ignore(warning: str) -> None:
    """Said for all runs in one line, at the end."""


def _warn_of_other_sources(cases: list[SiloCase], folders: list[RunFolder], out: Path) -> None:
    """One line on stderr where runs or packings were made by other sources than these."""
    runs = {folder.path: folder for folder in folders}.values()
    packings = {packing_folder(case, out) for case in cases}
    of_others = [
        f"{sum(made not in (None, own_sources()) for made in known)} of {len(known)} {what}"
        for what, known in (
            ("runs", [_sources_of_run(folder) for folder in runs]),
            ("packings", [_sources_of_packing(folder) for folder in packings]),
        )
    ]
    if any(not words.startswith("0 ") for words in of_others):
        to_stderr(
            f"{' and '.join(of_others)} were made by another version of the sources; delete their "
            "folders and the same command makes them anew"
        )


def _sources_of_run(folder: RunFolder) -> str | None:
    try:
        return folder.read_provenance().get("source_digest")
    except FolderError:  # not begun; what is damaged is told in its row
        return None


def _sources_of_packing(folder: Path) -> str | None:
    try:
        packing = load_packing(folder)
    except FolderError:
        return None
    return packing.sources if packing else None


def run_folder(case: SiloCase, out: Path) -> RunFolder:
    """Where a case is run, which a single run finds too; it may not exist yet."""
    name = f"{case.name}-seed{case.settings.run.seed}"
    return find_run(out, name, protocol.run_digest(case))


def _read(folder: RunFolder) -> Outcome:
    """What a finished run found; damaged, it is refused and left as it is."""
    try:
        return Outcome("done", Result.read(folder, reused=True))
    except FolderError as error:
        return Outcome("failed", reason=_without_again(str(error), folder.path))


def _without_again(line: str, folder: Path | None = None) -> str:
    """An error line for a sweep, which has no --again."""
    line = re.sub(r",? or use --again.*", "", line)  # another cure stands before it
    what, again, _ = line.partition("; use --again")
    if not again:
        return line
    place = f"the folder {folder}" if folder else "the folder of the run"
    return f"{what}; delete {place} and the same command does it again"


def _tasks(cases: list[SiloCase], out: Path) -> tuple[list[_Task], dict[int, int]]:
    """Runs in their order; in front of those that share a missing packing, its filling.

    The dictionary gives the index of the filling by the index of the run that needs it.
    """
    packings = [packing_folder(case, out) for case in cases]
    times = Counter(packings)
    tasks: list[_Task] = []
    needs: dict[int, int] = {}
    fillings: dict[Path, int] = {}
    for packing, case in zip(packings, cases, strict=True):
        if times[packing] > 1 and not (packing / "packing.h5").exists():
            if packing not in fillings:
                fillings[packing] = len(tasks)
                tasks.append(_Task(case, out, fill_only=True))
            needs[len(tasks)] = fillings[packing]
        tasks.append(_Task(case, out, fill_only=False))
    return tasks, needs


def _words(tally: Tally, before: int) -> tuple[float, str]:
    """How far a sweep is, and the same in words."""
    ended = tally.done + tally.failed
    there = f" and {before} before" if before else ""
    return (
        ended / tally.total,
        f"{tally.done} done{there}, {tally.running} running, {tally.failed} failed, "
        f"{tally.total - ended - tally.running} waiting",
    )


def _row(labels: Labels, folder: Path, outcome: Outcome) -> dict[str, Any]:
    fields = dict(_flat(dataclasses.asdict(outcome.value))) if outcome.value else {}
    state = {"state": outcome.state, "reason": outcome.reason}
    return {**labels, **fields, "run_folder": str(folder), **labels, **state}  # labels in front


def _flat(table: dict[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", value
