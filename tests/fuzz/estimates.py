"""The time left that a run states, compared with what it then takes.

    python tests/fuzz/estimates.py [--workers 2] [--write FILE.csv]

Twenty-two silos of docs/results/own-silos.csv that emptied, twenty published ones with other seeds,
twenty dampers drawn from their number. Of each the first time left that is stated after 5 s and a
twentieth of the work. A run that is over within 2 s of it is left out, and one that clogs, as what
is stated holds if it flows on. Kernels are compiled before.
"""

import argparse
import csv
import multiprocessing
import re
import sys
import tempfile
import time
from pathlib import Path
from random import Random
from typing import Any

from own_silos import table, written_case

from damper3d.case.case import DamperCase
from damper3d.run import protocol as dampers
from silo2d.case.case import SiloCase
from silo2d.run import protocol as silos

ROWS = Path(__file__).parents[2] / "docs" / "results" / "own-silos.csv"
SILOS, PUBLISHED, DAMPERS = 22, 20, 20
WIDE = ["A4", "B4", "C4", "D4", "A3"]  # published silos that empty
FACTOR = 1.5
SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}
_LEFT = re.compile(r"; ([\d.]+) (s|min|h) left")


class Watch:
    """The progress of a run: the first time left that counts."""

    def __init__(self) -> None:
        self.begun = time.monotonic()
        self.at: float | None = None  # [s]
        self.left = 0.0  # stated then [s]

    def __call__(self, fraction: float, words: str) -> None:
        """Take what the run reports."""
        elapsed, found = time.monotonic() - self.begun, _LEFT.search(words)
        if self.at is None and elapsed >= 5.0 and fraction >= 0.05 and found:
            self.at, self.left = elapsed, float(found[1]) * SECONDS[found[2]]


def damper(number: int) -> dict[str, Any]:
    """Changes of the thesis's damper that some ten seconds or a minute are needed for."""
    chance = Random(f"estimate {number}")
    particles = chance.choice(
        ["sphere:5mm", "sphere:4mm", "sphere:6mm", "prolate:1.5", "toroid:0.2"]
    )
    gamma, frequency = chance.uniform(2, 25), chance.uniform(15, 80)
    cycles = chance.randrange(10, 40) if particles.startswith("sphere") else chance.randrange(4, 9)
    return {
        "motion.frequency": f"{frequency:.1f} Hz", "motion.gamma": f"{gamma:.2f}",
        "particles.shape": particles, "run.cycles": cycles, "run.discard": 2,
    }  # fmt: skip


def timed(what: tuple[str, int]) -> dict[str, Any]:
    """The row of a run: when a time left was stated, what it was, and what it should have been."""
    kind, number = what
    with tempfile.TemporaryDirectory() as folder:
        if kind == "own silo":
            case: Any = SiloCase.load(written_case(number, Path(folder)))
        elif kind == "published silo":
            seed = {"run.seed": 2 + number // len(WIDE)}
            case = SiloCase.load(WIDE[number % len(WIDE)], seed)
        else:
            case = DamperCase.load("thesis", damper(number))
        watch, run = Watch(), (dampers if kind == "damper" else silos).run
        result = run(case, out=Path(folder), progress=watch)
        took = time.monotonic() - watch.begun
    row = {"run": f"{kind} {number}", "took_s": took, "outcome": getattr(result, "outcome", "")}
    if watch.at is None or took - watch.at < 2.0:
        return row
    left = took - watch.at
    return row | {
        "at_s": watch.at,
        "stated_s": watch.left,
        "left_s": left,
        "ratio": watch.left / left,
    }


def main() -> None:
    """Time the runs, print how many estimates hold, and keep the table where that is wanted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--write", type=Path)
    args = parser.parse_args()
    with ROWS.open(encoding="utf-8") as file:
        emptied = [row for row in csv.DictReader(file) if row["outcome"] == "empty"]
    numbers = [int(row["case"][3:]) for row in emptied if 12.0 < float(row["cpu_s"]) < 60.0]
    planned = [
        *(("own silo", n) for n in numbers[:SILOS]),
        *(("published silo", n) for n in range(PUBLISHED)),
        *(("damper", n) for n in range(DAMPERS)),
    ]
    compiled = ["sphere" in damper(n)["particles.shape"] for n in range(DAMPERS)]
    for one in (("damper", compiled.index(True)), ("damper", compiled.index(False)), planned[0]):
        timed(one)
    with multiprocessing.get_context("spawn").Pool(args.workers) as pool:
        rows = []
        for row in pool.imap_unordered(timed, planned):
            rows.append(row)
            print(*(f"{v:.3g}" if isinstance(v, float) else v for v in row.values()), flush=True)
    ended = (row for row in rows if not row["outcome"].startswith("clogged"))
    ratios = [row["ratio"] for row in ended if "ratio" in row]
    held = sum(1 / FACTOR <= ratio <= FACTOR for ratio in ratios)
    print(f"{held} of {len(ratios)} times left within a factor of {FACTOR:g}")
    if args.write:
        args.write.write_text(table(rows), encoding="utf-8")
    sys.exit(0 if held >= 0.9 * len(ratios) else 1)


if __name__ == "__main__":
    main()
