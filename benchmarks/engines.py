"""The contact law and pymunk on the same packings: what comes out, and what it costs.

    python benchmarks/engines.py [--out DIR] [--table docs/results/pymunk.csv]

Every row of pymunk is compared with the run by the contact law from the same packing. Runs that
stand in DIR are not done again; their CPU times are those of when they were made.
"""

import argparse
import csv
import io
import sys
from itertools import product
from pathlib import Path
from typing import Any

from granulab.campaign.output.files import write_atomic
from granulab.campaign.output.terminal import Progress, StopRequest
from silo2d.baseline.comparison import run_engines
from silo2d.view.compare import compare

CASES = [("A4", 1), ("A4", 2), ("A4", 3), *((silo, 1) for silo in ("C4", "D4", "A3", "C3", "A2"))]
SETTINGS = [
    *product((10, 30), ("0.5 ms", "0.25 ms"), ("measured",)),
    (30, "0.25 ms", "none"),
]
COLUMNS = ["silo", "seed", "engine", "iterations", "time_step_s", "restitution", "outcome", "n_out",
           "n_particles", "discharge_time_s", "t90_s", "curve_mean_s", "curve_max_s",
           "curve_later_s", "cpu_us_per_step", "discharge_cpu_s"]  # fmt: skip


def rows_of(silo: str, seed: int, out: Path) -> list[dict[str, Any]]:
    """The contact law's row, then pymunk's."""
    rows: list[dict[str, Any]] = []
    for iterations, step, restitution in SETTINGS:
        changes = {
            "pymunk.iterations": iterations,
            "pymunk.time_step": step,
            "pymunk.restitution": restitution,
        }
        with StopRequest() as stop, Progress(f"{silo}-{seed}", quiet=False) as bar:
            (pair,) = run_engines(
                silo, changes, ("dem", "pymunk"), [seed], out, bar.update, lambda: stop.requested
            )
        found = compare(*pair)
        law, impulses = (dict(row) for row in found["runs"])
        rows = rows or [law]
        curve = {f"curve_{name}": value for name, value in (found["curve"] or {}).items()}
        rows.append({**impulses, **curve, "iterations": iterations, "restitution": restitution})
    return rows


def rounded(value: Any) -> Any:
    """A number with the digits that mean something."""
    return f"{value:.4g}" if isinstance(value, float) else value


def main() -> None:
    """Write the table after every silo, so that what was computed is not lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("runs"), help="folder of the runs")
    parser.add_argument("--table", type=Path, default=Path("docs/results/pymunk.csv"))
    given = parser.parse_args()
    text = io.StringIO()
    text.write("# python benchmarks/engines.py; columns: docs/verification/pymunk.md\n")
    writer = csv.DictWriter(text, COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for silo, seed in CASES:
        for row in rows_of(silo, seed, given.out):
            writer.writerow({name: rounded(value) for name, value in row.items()})
        write_atomic(given.table, text.getvalue())
    print(f"wrote {given.table}", file=sys.stderr)


if __name__ == "__main__":
    main()
