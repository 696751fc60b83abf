"""Packings as tasks of an engine: each is computed once, and its numbers are kept as JSON."""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from damper3d.shapes.multisphere import MultiSphere
from damper3d.studies.pack import compact, shaken
from granulab.campaign.output.files import refuse_unless_writable
from granulab.campaign.output.terminal import Progress
from granulab.campaign.runs.folder import digest, read_json, write_json
from granulab.campaign.runs.protocol import Stop
from granulab.campaign.sweeps.engine import run_tasks
from granulab.campaign.sweeps.sweep import as_outcome
from granulab.errors import FolderError, InputError, SimulationError

FOLDER = "close-packings"  # below the folder of runs


@dataclass(frozen=True)
class Task:
    """One packing: so many particles in a periodic cell, or the case's own bed (bodies None)."""

    out: Path
    seed: int
    particle: MultiSphere | None = None
    bodies: int | None = None
    name: str = "thesis"
    changes: tuple[tuple[str, Any], ...] = ()  # of the case of that name


def run(tasks: Sequence[Task], *, workers: int | None, quiet: bool) -> list[dict[str, Any]]:
    """A row for each task: what came of it, its seed, "state" and "reason".

    Those that are kept are read. Raises FolderError where they cannot be kept.
    """
    for task in tasks[:1]:
        refuse_unless_writable(task.out, "--out")
    with Progress(f"{len(tasks)} packings", quiet=quiet) as bar:
        outcomes = run_tasks(
            work, tasks, workers=workers,
            report=lambda tally: bar.update(tally.done / tally.total, f"{tally.done} done"),
        )  # fmt: skip
    return [
        {"seed": task.seed, **(outcome.value or {}), "state": outcome.state,
         "reason": outcome.reason}
        for task, outcome in zip(tasks, outcomes, strict=True)
    ]  # fmt: skip


def work(task: Task, stop: Stop) -> dict[str, Any]:
    """The numbers of a packing; in a worker."""
    with as_outcome(InputError, SimulationError):
        if task.bodies is None:
            case = shaken.softened(task.name, {**dict(task.changes), "run.seed": task.seed})
            identity = {**case.packing_identity(), **shaken.protocol()}
            return _kept(task.out, identity, lambda: shaken.shake_down(case, stop))
        assert task.particle is not None
        particle, bodies = task.particle, task.bodies
        return _kept(
            task.out,
            cell_identity(particle, bodies, task.seed),
            lambda: compact.compact(particle, bodies, task.seed, stop),
        )


def cell_identity(particle: MultiSphere, bodies: int, seed: int) -> dict[str, Any]:
    """All that a packing in a periodic cell depends on, in units of the equal-volume radius."""
    unit = particle.scaled(1.0 / particle.equal_volume_radius)
    return {
        "cell": [unit.offsets, unit.radii, unit.volume, unit.inertia],
        "bodies": bodies,
        "seed": seed,
        **compact.protocol(),
    }


def _kept(out: Path, identity: dict[str, Any], make: Callable[[], Any]) -> dict[str, Any]:
    """Result of `make` as a dict; read where it was made before."""
    file = out / FOLDER / f"{digest(identity)}.json"
    try:
        return read_json(file)[0]
    except FolderError:
        pass  # not there, or damaged: it is made again
    made = dataclasses.asdict(make())
    file.parent.mkdir(parents=True, exist_ok=True)
    write_json(file, made)
    return made
