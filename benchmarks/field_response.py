"""Responses from a field beside simulations of host and bed together, across the onset.

    python benchmarks/field_response.py CASE HOST FIELD OUT

CASE is the bed's case and HOST has its [host] with a force. At 20 levels, evenly in the logarithm
from 0.1 to 8 times that force, the frequency of the largest stable response that the field gives is
simulated with the host. Writes OUT, a CSV with a row a level, and prints the differences.
"""

import argparse
import tomllib
from pathlib import Path

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.run.sweep import run_cases
from damper3d.studies.field.balance import respond, spaced
from damper3d.studies.field.report import of_response
from damper3d.studies.field.structure import structure_of
from damper3d.studies.field.table import read_field
from granulab.campaign.output.table import as_csv

LEVELS = np.geomspace(0.1, 8.0, 20)


def main() -> None:
    """Compare, write the table, print the largest and the median difference."""
    options = argparse.ArgumentParser(description=__doc__)
    for name in ("case", "host", "field", "out"):
        options.add_argument(name)
    given = options.parse_args()
    keys = tomllib.loads(Path(given.host).read_text(encoding="utf-8"))["host"]
    hosted = {f"host.{name}": value for name, value in keys.items()}
    structure = structure_of(DamperCase.load(given.case, hosted))
    field = read_field(given.field)
    frequency = spaced(structure, *field.frequencies[[0, -1]])
    found = of_response(structure, field, respond(structure, field, frequency, LEVELS))
    cases = []
    for one in found:
        host = {**hosted, "host.force": f"{one['level'] * structure.force!r} N"}
        at = {"motion.frequency": one["peak_frequency_hz"], "output.keep": "summary"}
        cases.append(({"level": one["level"]}, DamperCase.load(given.case, {**host, **at})))
    rows = [
        {
            "level": one["level"],
            "frequency_hz": one["peak_frequency_hz"],
            "field_amplitude_m": one["peak_amplitude_m"],
            "field_low_m": one["peak_interval_m"][0],
            "field_high_m": one["peak_interval_m"][1],
            "simulated_amplitude_m": row["host.amplitude_m"],
            "steady": row["steady"],
            "difference": one["peak_amplitude_m"] / row["host.amplitude_m"] - 1.0,
        }
        for one, row in zip(found, run_cases(cases, out=Path("runs"), workers=1), strict=True)
    ]
    Path(given.out).write_text(as_csv(rows), encoding="utf-8", newline="\n")
    off = np.abs([row["difference"] for row in rows])
    print(f"{len(rows)} levels: largest difference {off.max():.3f}, median {np.median(off):.3f}")


if __name__ == "__main__":
    main()
