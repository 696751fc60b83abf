"""From film to number: bias of `calibrate rebound` and `triaxial`, and whether sigma covers.

    python benchmarks/contact_films.py rebound docs/results/calibration [--clips 120]
    python benchmarks/contact_films.py triaxial docs/results/calibration [--clips 120]

Sizes, rates, noise, exposure, codec and all that happens are drawn by chance. Writes
NAME-coverage.csv, a row for each value that has a sigma, and NAME-coverage.txt, the table. Clips
that are in the csv already are not made again.
"""

import argparse
import csv
import math
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from coverage_table import read, report

from calibration.rebound.impact import at_contact, energy
from calibration.rebound.measure import measure_rebound
from calibration.rendered.backdrop import Backdrop
from calibration.rendered.camera import Camera
from calibration.rendered.particle import Contact, Prism, PrismScene, film_prism
from calibration.rendered.triaxial import TriaxialScene, film_triaxial
from calibration.triaxial.measure import measure_triaxial
from granulab.contact.material import Measured
from granulab.errors import InputError

CODECS = ("FFV1", "MJPG", "mp4v")
SHARPEST = math.radians(75)  # corner of a particle: sharper ones are cut off as fingers are
G = 9.80665  # m/s2


class Row(NamedTuple):
    """A value of a clip; what is empty where the clip was refused, and value the reason."""

    clip: int
    what: str
    value: float | str
    sigma: float
    truth: float


def polygon(random: np.random.Generator, size: float) -> tuple[tuple[float, float], ...]:
    """Corners of a convex polygon of about this radius, none too sharp to be followed."""
    while True:
        n = int(random.integers(4, 8))
        angle = 2 * np.pi * (np.arange(n) + random.uniform(-0.3, 0.3, n)) / n
        radius = size * random.uniform(0.75, 1.25, n)
        points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
        along = np.roll(points, -1, axis=0) - points
        turn = np.diff(np.unwrap(np.arctan2(along[:, 1], along[:, 0]), axis=0))
        last = 2 * np.pi - turn.sum()
        bends = np.append(turn, last)
        if bends.min() > 0.1 and np.pi - bends.max() > SHARPEST:
            return tuple((float(x), float(y)) for x, y in points)


def particle(clip: int) -> tuple[PrismScene, Camera, float]:
    """A particle by chance, its camera, and how long to film [s]."""
    random = np.random.default_rng([7, clip])
    radius = random.uniform(12, 32)  # px
    size = random.uniform(3e-3, 9e-3)
    scale = size / radius
    bright, dark = random.uniform(0.6, 0.95, 3), random.uniform(0.05, 0.3, 3)
    own, wall = (bright, dark) if random.random() < 0.5 else (dark, bright)
    prism = Prism(polygon(random, size), rounding=random.uniform(0.02, 0.15) * size,
                  colour=tuple(own))  # fmt: skip
    speed = random.uniform(0.8, 1.6)
    rate = round(speed / (random.uniform(3.5, 7) * scale))
    fall = 210 * scale
    scene = PrismScene(
        prism,
        height=fall + 1.3 * size,
        velocity=(random.uniform(-0.2, 0.2), -math.sqrt(max(speed**2 - 2 * G * fall, 0.04))),
        omega=random.uniform(-0.03, 0.03) * rate, angle=random.uniform(0, 2 * math.pi),
        restitution=random.uniform(0.35, 0.85), tangential=random.uniform(-0.5, 0.3),
        friction=random.uniform(0.1, 0.5), tilt=math.radians(random.normal(0, 0.5)),
        width=240, image_height=240, scale=scale, plate=0.87,
        position=random.uniform(0.4, 0.6),
        backdrop=Backdrop(tuple(wall), tuple(0.7 * wall), seed=int(random.integers(1000))),
    )  # fmt: skip
    camera = Camera(
        rate, exposure=random.uniform(0.05, 0.4), blur=random.uniform(0.5, 1.2),
        noise=random.uniform(1, 8), moments=4,
    )  # fmt: skip
    return scene, camera, 4.0 * fall / speed


def rebound(clip: int) -> list[Row]:
    """Values of one film of a particle, with their truth."""
    scene, camera, duration = particle(clip)
    _, contacts = scene.flights(duration)
    if not contacts:
        return [Row(clip, "", "no contact within the film", 0.0, 0.0)]
    duration = min(duration, contacts[0].time + 30 / camera.rate)
    codec = CODECS[clip % len(CODECS)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"clip.{'mp4' if codec == 'mp4v' else 'avi'}"
        truth = film_prism(
            scene, camera, path, duration=duration, seed=clip, codec=codec, header=100.0
        )
        try:
            found = measure_rebound(path, fps=camera.rate)
        except InputError as error:
            return [Row(clip, "", str(error).replace(str(path), "clip"), 0.0, 0.0)]
    rows = []
    for one in (contact for contact in found.contacts if not contact.doubt):
        true = min(truth.contacts, key=lambda c: abs(c.time * truth.rate - one.frame))
        known = expected(true, truth.gyration)
        for what, value in known.items():
            got = one.values[what]
            if got.sigma is not None and math.isfinite(got.value) and got.sigma < 0.5:
                rows.append(Row(clip, what, got.value, got.sigma, value))
        rate, scale = truth.rate, truth.scale
        rows += [
            Row(clip, name, one.values[name].value * rate, one.values[name].sigma * rate, value)
            for name, value in (
                ("omega_before", true.before.omega),
                ("omega_after", true.after.omega),
            )
        ]
        rows.append(Row(clip, "arm_t [px]", one.values["arm_t"].value,
                        one.values["arm_t"].sigma, true.arm.t / scale))  # fmt: skip
    k, sigma = found.known.gyration
    rows.append(Row(clip, "gyration [px]", k, sigma, truth.gyration / truth.scale))
    return rows


def expected(true: Contact, gyration: float) -> dict[str, float]:
    """Truth of what a contact is measured by."""
    before, after = energy(true.before, gyration), energy(true.after, gyration)
    u, v = at_contact(true.before, true.arm), at_contact(true.after, true.arm)
    found = {
        "restitution": -v[1] / u[1],
        "restitution_centroid": true.apparent,
        "tangential_restitution": -v[0] / u[0],
        "impulse_ratio": (true.after.t - true.before.t) / (true.after.n - true.before.n),
        "energy_lost": 1 - after.whole / before.whole,
    }
    for part in ("normal", "tangential", "rotational"):
        found[f"{part}_before"] = getattr(before, part) / before.whole
        found[f"{part}_after"] = getattr(after, part) / before.whole
    return found


def triaxial(clip: int) -> list[Row]:
    """Values of one film of a triaxial test, with their truth.

    Points are read off the picture to half a pixel, the scale is known to 0.2 to 1 %.
    """
    random = np.random.default_rng([11, clip])
    scale = random.uniform(0.05e-3, 0.12e-3)
    load = random.uniform(500, 3000)
    approach = random.uniform(0.5, 2.5) * scale
    scene = TriaxialScene(
        kn=load / approach, kt=load / approach * random.uniform(0.05, 0.4),
        inclination=math.radians(random.uniform(6, 20)),
        eccentricity=random.uniform(-1, 1) * 1e-3, k_rotation=random.uniform(100, 500),
        load=load, cycles=2, period=4.0, dots=int(random.integers(2, 6)),
        dot=random.uniform(2.5, 5), tremble=random.uniform(0, 0.5), width=200, height=200,
        scale=scale, seed=clip, backdrop=Backdrop(seed=int(random.integers(1000))),
    )  # fmt: skip
    camera = Camera(
        float(random.integers(8, 14)), blur=random.uniform(0.5, 1.2), noise=random.uniform(1, 6),
        moments=1,
    )  # fmt: skip
    codec = CODECS[clip % len(CODECS)]
    late = random.uniform(0, 0.5)
    share = random.uniform(0.002, 0.01)
    contact = np.array(scene.contact) + random.normal(0, 0.5, 4)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"clip.{'mp4' if codec == 'mp4v' else 'avi'}"
        record = Path(folder) / "load.csv"
        film_triaxial(scene, camera, path, record, late=late, seed=clip, codec=codec)
        try:
            found = measure_triaxial(
                path, record, contact=contact, offset=late,
                scale=Measured(scale * (1 + share * random.normal()), share * scale),
                load_line=scene.load_line + 0.5 * random.normal(),
            )  # fmt: skip
        except InputError as error:
            return [Row(clip, "", str(error).replace(folder, ""), 0.0, 0.0)]
    known = {
        "kn": scene.kn, "kt": scene.kt, "kt_over_kn": scene.kt / scene.kn,
        "eccentricity": scene.eccentricity, "rotational_stiffness": scene.k_rotation,
        "rotation_per_load": scene.eccentricity / scene.k_rotation,
    }  # fmt: skip
    rows = [
        Row(clip, name, found.values[name].value, found.values[name].sigma or 0.0, value)
        for name, value in known.items()
        if name in found.values
    ]
    moment = found.moment()
    assert moment is not None
    true = scene.eccentricity * found.peak
    return [*rows, Row(clip, "contact moment", moment.value, moment.sigma or 0.0, true)]


MEASURES: dict[str, Callable[[int], list[Row]]] = {"rebound": rebound, "triaxial": triaxial}


def table(rows: list[Row]) -> Iterator[str]:
    """Lines: for each quantity its errors, the share within one sigma, and the worst in sigmas."""
    refused = [row for row in rows if not row.what]
    yield f"{len({row.clip for row in rows})} films, {len(refused)} refused"
    yield from (f"  film {row.clip}: {row.value}" for row in refused)
    yield f"\n{'':26}{'n':>5}{'median error':>14}{'rms error':>11}{'rms sigma':>11}" + (
        f"{'within sigma':>14}{'worst':>8}"
    )
    for what in dict.fromkeys(row.what for row in rows if row.what):
        chosen = [row for row in rows if row.what == what]
        error = np.array([float(row.value) - row.truth for row in chosen])
        sigma = np.array([row.sigma for row in chosen])
        z = np.abs(error) / sigma
        yield (
            f"{what:26}{len(z):5d}{np.median(error):14.2g}{np.sqrt(np.mean(error**2)):11.2g}"
            f"{np.sqrt(np.mean(sigma**2)):11.2g}{np.mean(z < 1):14.0%}{z.max():8.1f}"
        )


def _row(clip: str, what: str, value: str, sigma: str, truth: str) -> Row:
    return Row(int(clip), what, float(value) if what else value, float(sigma), float(truth))


def main() -> None:
    """Render, measure, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("name", choices=MEASURES)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--clips", type=int, default=120)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    path = options.folder / f"{options.name}-coverage.csv"
    done = {row.clip for row in read(path, Row._fields, _row)}
    with path.open("a", newline="", encoding="utf-8") as file:
        for clip in set(range(options.clips)) - done:
            csv.writer(file).writerows(MEASURES[options.name](clip))
            file.flush()
    report(path, table(read(path, Row._fields, _row)))


if __name__ == "__main__":
    main()
