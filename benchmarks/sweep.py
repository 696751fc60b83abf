"""What a sweep costs on top of its runs: wall time of the workers in runs over that of the sweep.

    python benchmarks/sweep.py [RUNS] [WORKERS]

Runs of the small silo of the tests, from a packing that is there. The cost has three parts: once,
to start the workers and load the kernels; for every run, to deal it out; and for every
combination of a study, to read and check its case. From these follows the share for runs of any
length.
"""

import json
import sys
import tempfile
import time
from pathlib import Path

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


if __name__ == "__main__":
    main(*(int(word) for word in (sys.argv[1:] + ["12", "2"][len(sys.argv) - 1 :])))
