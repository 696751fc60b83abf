"""From film to number: bias of `calibrate drop`, and how often its 68 % intervals hold the truth.

    python benchmarks/drop_coverage.py docs/results/calibration [--clips 4] [--jobs 2]

Clips are rendered over a grid of rate, noise and blur. Ball, backdrop, fall, restitution, position
and codec of each are drawn by chance. Writes drop-coverage.csv, a row for each value that has a
sigma, and drop-coverage.txt, the table. Clips that are in the csv already are not made again.
"""

import argparse
import csv
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
from coverage_table import read, report

from calibration.drop.measure import measure_drop
from calibration.rendered.backdrop import Backdrop
from calibration.rendered.camera import Camera
from calibration.rendered.drop import Ball, DropScene, film_drop, sharp
from granulab.errors import InputError

RATES = (25.0, 120.0, 500.0)  # frames/s
NOISE = (1.0, 4.0, 10.0)  # grey levels
BLUR = {"little": (0.6, 0.05), "some": (1.2, 0.5), "much": (2.5, 0.9)}  # lens [px], exposure
ONE_NUMBER = "p of one number"  # restitution is the same at every bounce: small p are false alarms
CODECS = ("FFV1", "MJPG", "mp4v")
FALL = 45  # frames at most: fast cameras film small falls
G = 9.80665  # m/s2


class Row(NamedTuple):
    """A value of a clip; what is None where the clip was refused, and value the reason."""

    rate: float
    noise: float
    blur: str
    clip: int
    what: str | None
    value: float | str
    sigma: float
    truth: float


def clips(rate: float, noise: float, blur: str, clip: int) -> tuple[DropScene, Camera, str]:
    """A scene by chance, its camera, and the codec."""
    random = np.random.default_rng([int(rate), int(noise), list(BLUR).index(blur), clip])
    bright, dark = random.uniform(0.6, 0.95, 3), random.uniform(0.05, 0.3, 3)
    ball_light, wall = (bright, dark) if random.random() < 0.5 else (dark, bright)
    fall = min(random.uniform(0.2, 0.4), G * (FALL / rate) ** 2 / 2)
    scale = fall / random.uniform(150, 230)
    ball = Ball(
        diameter=random.uniform(12, 48) * scale, fall=fall, restitution=random.uniform(0.6, 0.9),
        release=random.uniform(5, 8) / rate, position=random.uniform(0.3, 0.5),
        aside=random.uniform(-20, 20) * scale, colour=tuple(ball_light),
        texture=random.uniform(0, 0.2), rotation=random.uniform(-5, 5),
    )  # fmt: skip
    backdrop = Backdrop(tuple(wall), tuple(0.7 * wall), seed=int(random.integers(1000)))
    scene = DropScene((ball,), width=160, height=320, scale=scale, backdrop=backdrop)
    lens, exposure = BLUR[blur]
    camera = sharp(scene, Camera(rate, exposure=exposure, blur=lens, noise=noise))
    return scene, camera, CODECS[clip % len(CODECS)]


def measured(case: tuple[float, float, str, int]) -> list[Row]:
    """Every value of a clip that has a sigma, with its truth."""
    scene, camera, codec = clips(*case)
    ball = scene.balls[0]
    duration = ball.contacts()[0][4]  # the fourth flight ends there
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"clip.{'mp4' if codec == 'mp4v' else 'avi'}"
        truth = film_drop(scene, camera, path, duration=duration, seed=case[3], codec=codec)
        try:
            drop = measure_drop(path)
        except InputError as error:
            return [Row(*case, None, str(error).replace(str(path), "clip"), 0.0, 0.0)]
    e = drop.restitution
    rows = [Row(*case, "restitution (pooled)", e.value, e.sigma or 0.0, ball.restitution)]
    found = drop.bounces
    if found.p is not None:
        rows.append(Row(*case, ONE_NUMBER, found.p, 0.0, 1.0))
    for (time, sigma), velocities, times in zip(
        found.contacts, found.velocities, found.times, strict=True
    ):
        frame = drop.frame(time)
        k = int(np.argmin(np.abs(truth.frame - frame)))
        rows.append(Row(*case, "contact [frames]", frame, sigma, truth.frame[k]))
        rows.append(Row(*case, "restitution (velocities)", *velocities, truth.restitution[k]))
        if np.isfinite(times[0]):
            rows.append(Row(*case, "restitution (times)", *times, truth.restitution[k]))
    return rows


def table(rows: list[Row]) -> Iterator[str]:
    """Lines: for each quantity all clips, then by rate, noise and blur."""
    tried = len({row[:4] for row in rows})
    refused = [row for row in rows if row.what is None]
    yield f"{tried} clips, {len(refused)} refused"
    yield from (f"  {r.rate:g}/s noise {r.noise:g} blur {r.blur}: {r.value}" for r in refused)
    by: tuple[tuple[str, Callable[[Row], object]], ...] = (
        ("rate", lambda row: row.rate),
        ("noise", lambda row: row.noise),
        ("blur", lambda row: row.blur),
    )
    p = np.array([row.value for row in rows if row.what == ONE_NUMBER], dtype=float)
    yield (
        "  "
        + ", ".join(f"p below {a:g} in {np.mean(p < a):.1%}" for a in (0.05, 0.01))
        + (f" of {len(p)} clips of several bounces, whose restitution is one number")
    )
    for what in dict.fromkeys(row.what for row in rows if row.sigma):
        chosen = [row for row in rows if row.what == what]
        yield f"\n{what:34} {'n':>5} {'bias':>9} {'rms':>10} {'bias/sigma':>11} {'covered':>8}"
        yield line("all", chosen)
        for name, key in by:
            for value in dict.fromkeys(map(key, chosen)):
                yield line(f"{name} {value}", [row for row in chosen if key(row) == value])


def line(name: str, rows: list[Row]) -> str:
    """Number, median error, error, median of error over sigma, and share within one sigma."""
    error = np.array([float(row.value) - row.truth for row in rows])
    z = error / np.array([row.sigma for row in rows])
    return (
        f"  {name:32} {len(rows):5d} {np.median(error):9.2g} {np.sqrt(np.mean(error**2)):10.2g} "
        f"{np.median(z):11.2f} {np.mean(np.abs(z) < 1):8.0%}"
    )


def _row(r: str, n: str, b: str, c: str, w: str, v: str, s: str, t: str) -> Row:
    value = float(v) if w else v
    return Row(float(r), float(n), b, int(c), w or None, value, float(s), float(t))


def main() -> None:
    """Render, measure, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--clips", type=int, default=4, help="for each point of the grid")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    path = options.folder / "drop-coverage.csv"
    done = {row[:4] for row in read(path, Row._fields, _row)}
    grid = list(product(RATES, NOISE, BLUR))
    cases = [(*point, clip) for clip in range(options.clips) for point in grid]
    cases = [case for case in cases if case not in done]
    with (
        ProcessPoolExecutor(options.jobs) as pool,
        path.open("a", newline="", encoding="utf-8") as file,
    ):
        for found in pool.map(measured, cases):
            csv.writer(file).writerows(found)
            file.flush()
    report(path, table(read(path, Row._fields, _row)))


if __name__ == "__main__":
    main()
