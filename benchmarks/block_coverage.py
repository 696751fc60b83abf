"""Rendered films of a block on a plate through `calibrate incline` and `slide`: coverage of sigma.

python benchmarks/block_coverage.py docs/results/calibration --first 0 --films 120

renders films drawn by chance (calibration.rendered.block), measures them, and adds a row for each
quantity to block-coverage.csv; block-coverage.txt is the table of all rows. A 68 % interval covers
where the value is off its truth by less than its sigma.
"""

import argparse
import csv
import math
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from coverage_table import read, report

from calibration.bench.incline import friction
from calibration.bench.measure import Quantity
from calibration.bench.sections import Request
from calibration.bench.slide import damping
from calibration.rendered.block import film_block, slide_by_chance, tilt_by_chance
from granulab.errors import InputError

CODECS = ("mp4v", "MJPG")


class Row(NamedTuple):
    """One quantity of a film; `what` is "refused" where it has none, the line in `note`."""

    kind: str
    seed: int
    what: str
    value: float
    sigma: float
    truth: float
    note: str = ""


def measured(kind: str, seed: int) -> list[Row]:
    """Rows of one film."""
    made = (tilt_by_chance if kind == "incline" else slide_by_chance)(seed)
    codec = CODECS[seed % len(CODECS)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"film.{'mp4' if codec == 'mp4v' else 'avi'}"
        film_block(*made[:3], path, duration=made.duration, seed=seed, codec=codec)
        try:
            found: list[Quantity] = (
                friction([path], Request())
                if kind == "incline"
                else damping([path], Request(), scale=f"{made.scene.scale * 1e3!r} mm/px")
            )
        except InputError as error:
            return [Row(kind, seed, "refused", 0, 0, 0, str(error).replace(str(path), "film"))]
    tilt = made.tilt
    mu, angle = tilt.friction, tilt.angle(tilt.slip)
    gamma = tilt.damping or math.inf
    v0 = 9.80665 * (math.sin(angle) - mu * math.cos(angle)) / gamma
    truths = (mu, angle) if kind == "incline" else (gamma, v0, mu)
    rows = [
        Row(kind, seed, one.name, one.pooled.all.value, one.pooled.all.sigma or 0.0, truth)
        for one, truth in zip(found, truths, strict=True)
    ]
    if kind == "slide":
        incline = found[0].films[0].incline  # type: ignore[attr-defined]
        rows.append(Row(kind, seed, "incline", incline.value, incline.sigma, angle))
    return rows


def table(rows: list[Row]) -> Iterator[str]:
    """Lines: films, refusals, and for each quantity bias, error and coverage."""
    for kind in dict.fromkeys(row.kind for row in rows):
        ours = [row for row in rows if row.kind == kind]
        refused = [row for row in ours if row.what == "refused"]
        yield f"{kind}: {len({row.seed for row in ours})} films, {len(refused)} refused"
        yield from (f"  film {row.seed}: {row.note}" for row in refused)
        yield f"  {'':30} {'n':>4} {'rms error':>10} {'sigma':>9} {'bias/sigma':>10} " + (
            f"{'within sigma':>12} {'worst':>10}"
        )
        for what in dict.fromkeys(row.what for row in ours if row.what != "refused"):
            one = [row for row in ours if row.what == what]
            off = np.array([row.value - row.truth for row in one])
            share = off / [row.truth for row in one]
            sigma = np.array([row.sigma for row in one])
            z = off / sigma
            yield (
                f"  {what:30} {len(one):4d} {100 * np.sqrt(np.mean(share**2)):8.2f} % "
                f"{100 * np.median(sigma / [row.truth for row in one]):7.2f} % "
                f"{np.median(z):10.2f} {np.mean(np.abs(z) < 1):12.0%} {np.abs(z).max():4.1f} sigma"
            )


def _row(kind: str, seed: str, what: str, value: str, sigma: str, truth: str, note: str) -> Row:
    return Row(kind, int(seed), what, float(value), float(sigma), float(truth), note)


def main() -> None:
    """Render, measure, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--first", type=int, default=0, help="number of the first film")
    parser.add_argument("--films", type=int, default=0, help="of each kind")
    parser.add_argument("--kind", nargs="+", default=["incline", "slide"])
    options = parser.parse_args()
    path = options.folder / "block-coverage.csv"
    done = {row[:2] for row in read(path, Row._fields, _row)}
    with path.open("a", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        for kind in options.kind:
            for seed in range(options.first, options.first + options.films):
                if (kind, seed) not in done:
                    writer.writerows(measured(kind, seed))
                    file.flush()
    report(path, table(read(path, Row._fields, _row)))


if __name__ == "__main__":
    main()
