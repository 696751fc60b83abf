"""What a sweep costs beside its runs: wall time of the workers in runs over that of the sweep.

    python benchmarks/sweep.py [RUNS] [WORKERS]

Runs of the small silo of the tests, from a packing that is there. The cost has two parts: once,
to start the workers and load the kernels; and for every run, to deal it out and take its answer.
From both follows the share for runs of any length.
"""

import json
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from small_silo import write_case

from silo2d.case import SiloCase
from silo2d.sweep import run_cases
from silo2d.warm import compile_kernels

LENGTHS = (5.0, 20.0, 60.0)  # [s] of a run; A4 takes about 20 on a current server
SWEEP = 80  # runs on two workers: 16 silos times five seeds


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


def main(n_runs: int, workers: int) -> None:
    """Print both parts of the cost and what they come to."""
    compile_kernels()
    with tempfile.TemporaryDirectory() as place:
        file = write_case(Path(place), {"output.checkpoint_interval": "0.1 s"})
        cases = [
            ({"mu": mu}, SiloCase.load(file, {"law.mu_wall": mu}))
            for mu in (0.1 + 0.3 * k / n_runs for k in range(n_runs))
        ]
        out = Path(place) / "runs"
        run_cases(cases[:1], out=out, workers=1, quiet=True)  # fills the silo
        few = workers
        wall_few, idle_few = overhead(cases[1 : 1 + few], out, workers)
        wall, idle = overhead(cases[1 + few :], out, workers)
    each = max(idle - idle_few, 0.0) / (len(cases) - 1 - 2 * few) * workers
    print(f"{few} runs: {wall_few:.2f} s, {idle_few:.2f} s of them beside the runs")
    print(f"{len(cases) - 1 - few} runs: {wall:.2f} s, {idle:.2f} s of them beside the runs")
    print(f"once {idle_few:.2f} s, and {1e3 * each:.0f} ms of a worker for each run")
    for length in LENGTHS:
        own = SWEEP * length / workers
        share = (idle_few + SWEEP * each / workers) / own
        print(f"{SWEEP} runs of {length:g} s on {workers} workers: {share:.2%} of the runs' time")


if __name__ == "__main__":
    main(*(int(word) for word in (sys.argv[1:] + ["24", "2"][len(sys.argv) - 1 :])))
