"""The paper's drop test from films of two renderers: how often sigma holds, and what is refused.

    python benchmarks/low_drops.py docs/results/calibration [--films 900] [--jobs 2]

Blocks and stones of 15 to 60 px fall by 19 to 45 mm and rotate as they bounce, at 100 to 240
frames/s; restitution sqrt(H1/H0) of the first contact from 0.3 to 0.9, as `first_contact` has it.
Even films are of calibration.rendered.low_drop, odd ones of other_drops.py, which shares nothing
with it. Writes low-drops.csv, a row a film, and low-drops.txt. Films that are in the csv already
are not made again.
"""

import argparse
import csv
import tempfile
import tomllib
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
import other_drops

from calibration.drop.measure import measure_drop
from calibration.rendered.backdrop import Backdrop
from calibration.rendered.camera import Camera
from calibration.rendered.low_drop import Block, LowDrop, film_low_drop
from granulab.contact.files.datafile import data_root
from granulab.errors import InputError

RATES = (100.0, 120.0, 150.0, 200.0, 240.0)  # frames/s
BINS = ((0.3, 0.5), (0.5, 0.7), (0.7, 0.9))  # of restitution
SIZES = (15.0, 60.0)  # px, root of the area
SHORTEST = 5.0  # frames of a rebound that must be measured
AFTER = 0.3  # s that are filmed after the first contact


class Row(NamedTuple):
    """A film; value is the refusal where sigma is 0."""

    film: int
    renderer: str
    rate: float
    size: float
    frames: float  # from the first contact to the second
    truth: float
    value: float | str
    sigma: float


def block(random: np.random.Generator, bounds: tuple[float, float]) -> Block:
    """A particle of the paper's kind whose first contact gives a restitution within bounds."""
    with (data_root() / "shapes" / "wood19.toml").open("rb") as file:
        shapes = tomllib.load(file)["shape"]
    while True:
        outline = np.array(shapes[random.integers(len(shapes))]["outline"], dtype=float)
        one = Block(
            outline * 1e-3 * random.uniform(0.8, 1.2), fall=random.uniform(0.019, 0.045),
            angle=random.uniform(0, 2 * np.pi), spin=random.normal(),
            release=random.uniform(0.06, 0.2), restitution=random.uniform(0.3, 1.0),
            friction=random.uniform(0.1, 0.5),
        )  # fmt: skip
        if bounds[0] <= one.rebound <= bounds[1]:
            return one


def first_film(
    random: np.random.Generator, rate: float, size: float, bounds: tuple[float, float], path: Path
) -> tuple[float, float]:
    """Write a film of calibration.rendered; restitution, frames between the contacts."""
    one = block(random, bounds)
    light, dark = random.uniform(0.5, 0.9), random.uniform(0.15, 0.35)
    wall, own = (np.clip(g * random.uniform(0.85, 1.15, 3), 0, 1) for g in (light, dark))
    if random.random() < 0.5:
        wall, own = own, wall
    scene = LowDrop(
        one, scale=one.size / size, tongs=random.random() < 0.4, colour=tuple(own),
        backdrop=Backdrop(tuple(wall), tuple(0.7 * wall), seed=int(random.integers(1000))),
    )  # fmt: skip
    camera = Camera(
        rate, exposure=random.uniform(0.1, 0.6), blur=random.uniform(0.5, 1.2),
        noise=random.uniform(1, 5),
    )  # fmt: skip
    times = one.contact_times
    film_low_drop(scene, camera, path, duration=times[0] + AFTER, seed=int(random.integers(9999)))
    return one.rebound, float((times[1] - times[0]) * rate)


def second_film(
    random: np.random.Generator, rate: float, size: float, bounds: tuple[float, float], path: Path
) -> tuple[float, float]:
    """Write a film of other_drops.py; likewise."""
    while True:
        one = other_drops.stone(random, rate, size)
        truth, frames = other_drops.truth(one)
        if bounds[0] <= truth <= bounds[1]:
            other_drops.film(one, path)
            return truth, frames


def measured(film: int) -> Row:
    """The film, rendered and measured as `calibrate drop FILM` does."""
    random = np.random.default_rng([17, film])
    rate, size = float(random.choice(RATES)), random.uniform(*SIZES)
    first = film % 2 == 0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / ("film.mp4" if first or film % 4 == 1 else "film.avi")
        write = first_film if first else second_film
        truth, frames = write(random, rate, size, BINS[film // 2 % 3], path)
        known = film, "first" if first else "second", rate, size, frames, truth
        try:
            found = measure_drop(path).first.restitution
        except InputError as error:
            return Row(*known, str(error).replace(str(path), "film"), 0.0)
    return Row(*known, found.value, found.sigma or 0.0)


def table(rows: list[Row]) -> Iterator[str]:
    """Lines: all films whose rebound lasts, by renderer and stratum; then the others."""
    lasting = [row for row in rows if row.frames >= SHORTEST]
    yield f"{len(rows)} films; {len(lasting)} with a rebound of {SHORTEST:g} frames and more"
    yield f"{'':34} {'n':>5} {'refused':>8} {'rms error':>10} {'within sigma':>13} {'worst':>6}"
    yield line("all", lasting)
    strata: tuple[tuple[str, Callable[[Row], str]], ...] = (
        ("renderer", lambda row: row.renderer),
        ("restitution", lambda row: next(
            f"{a:g} to {b:g}" for a, b in BINS if row.truth <= b)),
        ("frames/s", lambda row: "100 and 120" if row.rate < 150 else "150 to 240"),
        ("size", lambda row: "15 to 30 px" if row.size < 30 else (
            "30 to 45 px" if row.size < 45 else "45 to 60 px")),
    )  # fmt: skip
    for name, key in strata:
        for value in sorted(set(map(key, lasting))):
            yield line(f"{name} {value}", [row for row in lasting if key(row) == value])
    short = [row for row in rows if row.frames < SHORTEST]
    yield line("a second contact within 5 frames", short)
    for row in lasting:
        if not row.sigma:
            yield f"refused: film {row.film} (e {row.truth:.2f}, {row.rate:g}/s): {row.value}"


def line(name: str, rows: list[Row]) -> str:
    """Number of films, share refused, error, share within sigma, largest error in sigma."""
    known = [row for row in rows if row.sigma]
    if not known:
        return f"  {name:32} {len(rows):5d}"
    error = np.array([float(row.value) - row.truth for row in known])
    z = np.abs(error / np.array([row.sigma for row in known]))
    return (
        f"  {name:32} {len(rows):5d} {1 - len(known) / max(len(rows), 1):8.1%} "
        f"{np.sqrt(np.mean(error**2)):10.2g} {np.mean(z < 1):13.0%} {z.max():6.1f}"
    )


def read(path: Path) -> list[Row]:
    """The rows of earlier runs."""
    if not path.exists():
        path.write_text(",".join(Row._fields) + "\n", encoding="utf-8", newline="\n")
    with path.open(newline="", encoding="utf-8") as file:
        return [
            Row(int(k), who, float(r), float(z), float(f), float(t), float(v) if float(s) else v,
                float(s))
            for k, who, r, z, f, t, v, s in list(csv.reader(file))[1:]
        ]  # fmt: skip


def main() -> None:
    """Render, measure, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--films", type=int, default=900)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    path = options.folder / "low-drops.csv"
    done = {row.film for row in read(path)}
    films = [film for film in range(options.films) if film not in done]
    with (
        ProcessPoolExecutor(options.jobs) as pool,
        path.open("a", newline="", encoding="utf-8") as file,
    ):
        for row in pool.map(measured, films):
            csv.writer(file, lineterminator="\n").writerow(row)
            file.flush()
    text = "\n".join(table(read(path))) + "\n"
    (options.folder / "low-drops.txt").write_text(text, encoding="utf-8", newline="\n")
    print(text, end="")


if __name__ == "__main__":
    main()
