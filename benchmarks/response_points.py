"""Simulated points of responses beside the harmonic balance at just their frequencies and levels.

    damper3d response HOST --field ... --simulate --frequencies ... --json > response.json
    python benchmarks/response_points.py response.json OUT

Of several solutions that are stable the one counts that is nearest at all dampers. Writes OUT, a
CSV with a row a point and damper, and prints the differences.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.studies.field.several import respond_together
from damper3d.studies.field.structure import structures_of
from damper3d.studies.field.table import read_field
from granulab.campaign.output.table import as_csv


def main() -> None:
    """Compare, write the table, print the largest and the median difference."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("response")
    options.add_argument("out")
    given = options.parse_args()
    found = json.loads(Path(given.response).read_text(encoding="utf-8"))
    structures = structures_of(DamperCase.load(found["host"]))
    tables = found.get("fields") or dict.fromkeys(structures, found["field"])
    fields = [read_field(tables[name]) for name in structures]
    rows = []
    for point in found["simulated"]:
        at, level = point["frequency_hz"], point["level"]
        balanced = respond_together(list(structures.values()), fields, [at], [level])
        stable = np.stack([one.stable[0, 0] for one in balanced])  # (d, s)
        dampers = point.get("dampers") or [{**point, "at": name} for name in structures]
        simulated = np.array([one["amplitude_m"] for one in dampers])
        off = np.abs(np.log(stable / simulated[:, None])).max(axis=0)
        nearest = stable[:, int(np.nanargmin(off))]
        rows += [
            {"level": level, "frequency_hz": at, "at": one["at"], "bare_amplitude_m":
             one["bare_amplitude_m"], "balance_amplitude_m": balance, "simulated_amplitude_m":
             one["amplitude_m"], "difference": balance / one["amplitude_m"] - 1.0}
            for one, balance in zip(dampers, nearest.tolist(), strict=True)
        ]  # fmt: skip
    Path(given.out).write_text(as_csv(rows), encoding="utf-8", newline="\n")
    off = np.abs([row["difference"] for row in rows])
    print(
        f"{len(rows)} amplitudes: largest difference {off.max():.3f}, median {np.median(off):.3f}"
    )


if __name__ == "__main__":
    main()
