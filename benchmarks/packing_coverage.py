"""Rendered pictures of fillings at rest through `calibrate packing`: bias and coverage of sigma.

python benchmarks/packing_coverage.py docs/results/calibration --pictures 16

fills seven silos with a flat floor (data/shapes/pentagons.toml, 80 to 110 mm wide, 65 to 95 mm
high, layers of 15 to 30 mm), each seen by so many cameras drawn by chance, and adds a row for each
height to packing-coverage.csv; packing-coverage.txt is the table of all rows. Whoever says --roi is
off by up to 0.7 px at each side, evenly, and rounds to whole pixels: 0.5 px together, as sigma has.
"""

import argparse
import csv
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from coverage_table import read, report

from calibration.flow.packing import measure_packing
from calibration.rendered.camera import Camera
from calibration.rendered.flow import Look, Stage, packing_truth, simulated
from granulab.errors import InputError

WIDTHS, LAYERS = (100, 90, 110, 85, 95, 105, 80), (18, 20, 25, 15, 22, 30, 17)  # mm
PARTICLE = 5.1e-3  # m, the disc of their mean area
ERROR = 0.7  # px


class Row(NamedTuple):
    """A height of one picture [m]; `what` is "refused" where it has none, the line in `note`."""

    silo: int
    picture: int
    what: str
    value: float
    sigma: float
    truth: float
    note: str = ""


def filling(silo: int, folder: Path) -> Path:
    """Run folder of a silo."""
    case = folder / f"flat{silo}.toml"
    case.write_text(
        f'schema = 1\n[silo]\nangle = "0 deg"\noutlet = "{WIDTHS[silo] // 2} mm"\n'
        f'width = "{WIDTHS[silo]} mm"\nheight = "130 mm"\n[particles]\nshapes = "pentagons"\n'
        f'[fill]\nlevel = "{65 + 5 * silo} mm"\n[output]\nlayer_height = "{LAYERS[silo]} mm"\n'
        f"[run]\nseed = {silo + 1}\n",
        encoding="utf-8",
    )
    return simulated(case, folder / "runs")


def looks(random: np.random.Generator, width: float) -> Look:
    """Scale and colours drawn by chance: a dark or a white backing, paint, bare wood."""
    dark = random.uniform() < 0.6
    scale = width / (random.uniform(220, 420) + 0.37)
    backing = random.uniform(0.03, 0.1) if dark else random.uniform(0.85, 0.95)
    wood = Look(scale=scale, texture_size=1.5e-3 * width / 0.3, backing=(backing,) * 3)
    tint = random.uniform(0.85, 1.15, 3)
    paint, bare = (
        (np.array(wood.paint) * tint, np.array(wood.bare) * tint)
        if dark
        else (np.array([0.5, 0.2, 0.1]) * tint, np.array([0.35, 0.5, 0.6]) * tint)
    )
    return replace(wood, paint=tuple(paint), bare=tuple(np.clip(bare, 0, 0.95)))


def measured(run: Path, silo: int, picture: int, folder: Path) -> list[Row]:
    """Rows of one picture."""
    random = np.random.default_rng([silo, picture])
    width = WIDTHS[silo] * 1e-3
    stage = Stage(run, looks(random, width), picture)
    camera = Camera(
        30, blur=random.uniform(0.4, 1.3), noise=random.uniform(1, 6),
        falloff=random.uniform(0, 0.3), moments=1,
    )  # fmt: skip
    path = folder / "filling.png"
    cv2.imwrite(str(path), camera.picture(stage.paint, -1.0, random))
    known = packing_truth(stage)
    x, y, w, h = known["silo_px"]
    sides = np.array([x, y, x + w, y + h]) + random.uniform(-ERROR, ERROR, 4)
    left, top, right, floor = np.rint(sides)
    try:
        found = measure_packing(
            path, roi=(int(left), int(top), int(right - left), int(floor - top)),
            width=f"{WIDTHS[silo]} mm", columns=round(width / 2 / PARTICLE),
            layers=len(known["layers_m"]),
        )  # fmt: skip
    except InputError as error:
        return [Row(silo, picture, "refused", 0, 0, 0, str(error).replace(str(path), "picture"))]
    rows = [Row(silo, picture, "height", found.height.value, found.height.sigma or 0.0,
                known["height_m"])]  # fmt: skip
    for one, truth in zip(found.layers, known["layers_m"], strict=True):
        rows.append(Row(silo, picture, "layer", one.value, one.sigma or 0.0, truth))
    return rows


def table(rows: list[Row]) -> Iterator[str]:
    """Lines: pictures, refusals, bias, error and coverage."""
    refused = [row for row in rows if row.what == "refused"]
    yield f"{len({row[:2] for row in rows})} pictures, {len(refused)} refused"
    yield from (f"  silo {row.silo}, picture {row.picture}: {row.note}" for row in refused)
    yield f"  {'':10} {'n':>4} {'bias':>9} {'rms error':>10} {'sigma':>9} " + (
        f"{'within sigma':>12} {'worst':>10}"
    )
    for what in ("height", "layer"):
        one = [row for row in rows if row.what == what]
        off = np.array([row.value - row.truth for row in one])
        sigma = np.array([row.sigma for row in one])
        z = off / sigma
        yield (
            f"  {what:10} {len(one):4d} {1e3 * off.mean():6.2f} mm "
            f"{1e3 * np.sqrt(np.mean(off**2)):7.2f} mm {1e3 * np.median(sigma):6.2f} mm "
            f"{np.mean(np.abs(z) < 1):12.0%} {np.abs(z).max():4.1f} sigma"
        )


def _row(silo: str, picture: str, what: str, value: str, sigma: str, truth: str, note: str) -> Row:
    return Row(int(silo), int(picture), what, float(value), float(sigma), float(truth), note)


def main() -> None:
    """Fill, render, measure, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--pictures", type=int, default=0, help="of each silo")
    parser.add_argument("--runs", type=Path, nargs="*", default=[], help="of the seven silos")
    options = parser.parse_args()
    path = options.folder / "packing-coverage.csv"
    done = {row[:2] for row in read(path, Row._fields, _row)}
    with (
        tempfile.TemporaryDirectory() as work,
        path.open("a", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        for silo in range(len(WIDTHS) if options.pictures else 0):
            run = options.runs[silo] if options.runs else filling(silo, Path(work))
            for picture in range(options.pictures):
                if (silo, picture) not in done:
                    writer.writerows(measured(run, silo, picture, Path(work)))
                    file.flush()
    report(path, table(read(path, Row._fields, _row)))


if __name__ == "__main__":
    main()
