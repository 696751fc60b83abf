"""What a sweep costs on top of its runs: wall time of the workers in runs over that of the sweep.

    python benchmarks/sweep.py [RUNS] [WORKERS]
    python benchmarks/sweep.py --stand-ins 100,1000,10000 [--write FILE]

Runs of the small silo of the tests, from a packing that is there. The cost has three parts: once,
to start the workers and load the kernels; for every run, to deal it out; and for every
combination of a study, to read and check its case. From these follows the share for runs of any
length.

With --stand-ins dampers that compute nothing, but write their folders: studies of so many runs, on
one and two processes and on a Dask cluster of eight on this machine, each in a process of its own.
It tells a cost for each run from one that grows with their number. TMPDIR says where they run.
"""

import argparse
import json
import logging
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from importlib.metadata import version
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from small_silo import write_case

from granulab.campaign.runs.protocol import Stop
from granulab.campaign.sweeps.engine import run_tasks
from silo2d.case.case import SiloCase
from silo2d.run.sweep import compile_kernels, run_cases

LENGTHS = (5.0, 20.0, 60.0)  # [s] of a run; A4 takes about 20 on a current server
SWEEP, SEEDS = 80, 5  # runs in all, and of each combination: 16 silos times five seeds


def overhead(cases, out: Path, workers: int) -> tuple[float, float]:
    """Wall time of a sweep [s], and of it what no worker spent in a run [s]."""
    begun = time.perf_counter()
    rows = run_cases(cases, out=out, workers=workers, quiet=True)
    wall = time.perf_counter() - begun
    assert all(row["state"] == "done" for row in rows)
    own = [
        json.loads((Path(row["run_folder"]) / "provenance.json").read_text())["wall_s"]
        for row in rows
    ]
    return wall, wall - sum(own) / workers


def nothing(case: SiloCase, stop: Stop) -> None:
    """A run that takes no time."""


def dealing(case: SiloCase, workers: int, count: int = 300) -> float:
    """What a worker waits for between two runs [s]."""
    moments: list[tuple[float, int]] = []
    run_tasks(
        nothing, [case] * count, workers=workers,
        report=lambda tally: moments.append((time.perf_counter(), tally.done)),
    )  # fmt: skip
    begun, done = next(moment for moment in moments if moment[1] > 0)  # the workers are there
    return (moments[-1][0] - begun) * workers / (count - done)


def main(n_runs: int, workers: int) -> None:
    """Print the parts of the cost and what they come to."""
    compile_kernels()
    with tempfile.TemporaryDirectory() as folder:
        file = write_case(Path(folder), {"output.checkpoint_interval": "0.1 s"})
        friction = [0.1 + 0.3 * k / n_runs for k in range(n_runs + 1)]
        cases = [({"mu": mu}, SiloCase.load(file, {"law.mu_wall": mu})) for mu in friction]
        out = Path(folder) / "runs"
        run_cases(cases[:1], out=out, workers=1, quiet=True)  # fills the silo
        wall, once = overhead(cases[1:], out, workers)
    begun = time.perf_counter()
    for k in range(10):
        SiloCase.load("A4", {"law.mu_wall": 0.1 + 0.01 * k})
    reading = (time.perf_counter() - begun) / 10
    each = dealing(cases[0][1], workers)
    print(
        f"a sweep of {n_runs} runs on {workers} workers: {wall:.2f} s, {wall - once:.2f} s in runs"
    )
    print(f"once {once:.2f} s; for each run {1e3 * each:.1f} ms of a worker")
    print(f"for each combination {1e3 * reading:.0f} ms before the first run")
    for length in LENGTHS:
        cost = once + SWEEP * each / workers + SWEEP / SEEDS * reading
        share = cost / (SWEEP * length / workers)
        print(f"{SWEEP} runs of {length:g} s on {workers} workers: {share:.2%} of the runs' time")


def stand_ins(sizes: list[int], file: Path | None) -> None:
    """Print, and perhaps write, a line for each engine and size."""
    where = os.environ.get("TMPDIR", tempfile.gettempdir())
    lines = [
        "Sweeps of dampers that compute nothing (tests/helpers/stand_in.py), in "
        f"{where} of {platform.machine()}, {os.cpu_count()} cores.",
        f"Python {platform.python_version()}, distributed {version('distributed')}.",
        "",
        f"python {' '.join(sys.argv)}",
        "",
        *COLUMNS.values(),
        "",
        "engine       runs" + "".join(f"{name:>8}" for name in COLUMNS),
    ]
    print("\n".join(lines))
    for engine, workers in ENGINES:
        for runs in sizes:
            words = [sys.executable, __file__, "--one", engine, str(workers), str(runs)]
            found = subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True).stdout
            cost = json.loads(found.splitlines()[-1])
            cells = "".join(f"{cost[name]:8.3g}" for name in COLUMNS)
            lines.append(f"{engine + ' ' + str(workers):11} {runs:5d}{cells}")
            print(lines[-1], flush=True)
    if file is not None:
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")


ENGINES = (("processes", 1), ("processes", 2), ("dask", 8))
COLUMNS = {
    "wall": "wall     time of the sweep for each run, on a machine with other work [ms]",
    "own": "own      CPU time of a worker for a run: its folder [ms]",
    "worker": "worker   CPU time of the workers beside it, for each run, with their start [ms]",
    "sweep": "sweep    CPU time of the sweep's process, and of the scheduler, for each run [ms]",
    "MB": "MB       the most memory of that process, with the scheduler",
    "again": "again    CPU time of the same sweep once more, for each run that is there [ms]",
    "read": "read     the same without the journal: folders are read [ms]",
    "list": "list     CPU time of `list`, for each run [ms]",
    "report": "report   CPU time of ranking, picture and page, for each run [ms]",
    "files": "files    of a run",
    "kB": "kB       of a run's files",
    "journal": "journal  kB of a run's line in the journal",
}


def one(engine: str, workers: int, runs: int) -> dict[str, float]:
    """The cost of a study of stand-ins, by the names of COLUMNS."""
    from stand_in import STAND_IN, STUDY

    from damper3d.commands.library import listing
    from damper3d.run.sweep import load_study
    from granulab.campaign.sweeps.cases import run_study

    cost: dict[str, float] = {}
    rows: list[dict[str, Any]] = []
    with ExitStack() as stack:
        root = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        study, out = root / "study.toml", root / "runs"
        study.write_text(STUDY.format(seeds=10, number=runs // 10))
        loaded = load_study(study)
        options: dict[str, Any] = {"workers": workers}
        if engine == "dask":
            options = {"engine": "dask", "scheduler": cluster(workers, stack)}

        def sweep() -> Path:
            folder, rows[:] = run_study(STAND_IN, loaded, out=out, quiet=True, **options)
            assert all(row["state"] == "done" for row in rows)
            return folder

        begun = time.perf_counter()
        cost["sweep"] = cpu_of(sweep, runs)
        cost["wall"] = 1e3 * (time.perf_counter() - begun) / runs
        cost["MB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        cost["own"] = 1e3 * sum(row["cpu_s"] for row in rows) / runs
        cost["again"] = cpu_of(sweep, runs)
        folder = sweep()
        cost["journal"] = (folder / "runs.journal").stat().st_size / runs / 1e3
        cost["report"] = cpu_of(lambda: report(folder, loaded, rows), runs)
        (folder / "runs.journal").unlink()
        cost["read"] = cpu_of(sweep, runs)
        cost["list"] = cpu_of(lambda: listing(out), runs)
        sizes = [file.stat().st_size for run in out.glob("*-seed*") for file in run.rglob("*")]
        cost |= {"files": len(sizes) / runs, "kB": sum(sizes) / runs / 1e3}
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)  # workers that have ended
    return cost | {"worker": 1e3 * (ended.ru_utime + ended.ru_stime) / runs - cost["own"]}


def cpu_of(work: Callable[[], object], runs: int) -> float:
    """CPU time of this process for a work, for each run [ms]."""
    begun = time.process_time()
    work()
    return 1e3 * (time.process_time() - begun) / runs


def report(folder: Path, loaded: Any, rows: list[dict[str, Any]]) -> None:
    """What `sweep` makes of the rows, and writes."""
    from damper3d.run.sweep import QUANTITIES
    from granulab.campaign.sweeps.report import summary
    from granulab.campaign.sweeps.report.comparison import Comparison

    comparison = Comparison.of(loaded.study.name, loaded.varied, QUANTITIES, rows)
    table = summary.summary(comparison, folder)
    summary.write_ranking(folder, comparison, table)
    summary.write_pictures(folder, comparison, ["efficiency"])
    summary.as_text(comparison, table)


def cluster(workers: int, stack: ExitStack) -> str:
    """The address of a cluster of processes on this machine, closed with the stack."""
    import dask
    from distributed import LocalCluster

    # As docs/runs/sweeps.md has it: the scheduler keeps no messages in memory.
    stack.enter_context(dask.config.set({"distributed.admin.low-level-log-length": 0}))
    local = LocalCluster(
        n_workers=workers, threads_per_worker=1, dashboard_address="127.0.0.1:0",
        protocol="tcp://", host="127.0.0.1", silence_logs=logging.CRITICAL,
    )  # fmt: skip
    stack.callback(local.close)
    return str(local.scheduler_address)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("runs", nargs="?", type=int, default=12)
    parser.add_argument("workers", nargs="?", type=int, default=2)
    parser.add_argument("--stand-ins", metavar="RUNS,RUNS")
    parser.add_argument("--write", type=Path, metavar="FILE")
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        name, count, size = given.one
        print(json.dumps(one(name, int(count), int(size))))
    elif given.stand_ins:
        stand_ins([int(word) for word in given.stand_ins.split(",")], given.write)
    else:
        main(given.runs, given.workers)
