"""Costs of a scene in several engines: stretches in turn, medians, and the spread of the ratios."""

import os
import resource
import statistics
import subprocess
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

HERE, BOUND = "here", "bound"


class Contest(NamedTuple):
    """The engines of a scene, ready to go on.

    runs     a name, and what runs one stretch and returns its cost in the scene's unit; "here" is
             the first, and "bound", where there is one, what the core needs for the least of it
    missing  engines that the scene has a deck for and that are not installed
    close    ends what was started
    """

    runs: dict[str, Callable[[], float]]
    missing: Sequence[str] = ()
    close: Callable[[], None] = lambda: None


class Scene(NamedTuple):
    """A row of the table.

    unit      of its costs, such as "us a step"
    prepare   makes its engines
    repeats   stretches of each, if not the command's number
    """

    name: str
    unit: str
    prepare: Callable[[], Contest]
    repeats: int | None = None


def measured(scene: Scene, repeats: int) -> dict[str, Any]:
    """Row of a scene: medians over stretches; medians and quartiles of ratios to neighbours."""
    contest, n = scene.prepare(), scene.repeats or repeats
    try:
        rows = [{name: run() for name, run in contest.runs.items()} for _ in range(n)]
    finally:
        contest.close()
    against = {}
    for name in [name for name in contest.runs if name != HERE]:
        low, ratio, high = quartiles([row[HERE] / row[name] for row in rows])
        cost = statistics.median(row[name] for row in rows)
        against[name] = {"cost": cost, "ratio": ratio, "low": low, "high": high}
    return {
        "scene": scene.name, "unit": scene.unit, "repeats": n,
        "here": statistics.median(row[HERE] for row in rows), "against": against,
        "missing": list(contest.missing),
    }  # fmt: skip


def quartiles(values: Sequence[float]) -> tuple[float, float, float]:
    """First quartile, median and third quartile."""
    if len(values) == 1:
        return (values[0],) * 3
    low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
    return low, middle, high


def user_s() -> float:
    """User CPU time of this process so far [s]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def cost_of(run: Callable[[], object], per: float) -> float:
    """User CPU time of a call [s], over `per`."""
    began = user_s()
    run()
    return (user_s() - began) / per


class Child(NamedTuple):
    """Cost of a process that has ended with the code 0 [s]."""

    cpu_s: float  # user and system
    wall_s: float


def child(command: Sequence[str], environment: dict[str, str] | None = None) -> Child:
    """Run a command without its output; RuntimeError with its last lines where it fails."""
    began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        command, env={**os.environ, **(environment or {})}, stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False,
    )  # fmt: skip
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: code {done.returncode}\n{done.stderr[-2000:]}")
    return Child(after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime, wall)
