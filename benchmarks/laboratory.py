"""The paper's Tables 1 to 3 measured again from films of its own protocol, and silo A4 from them.

    python benchmarks/laboratory.py docs/results/calibration/laboratory.txt

Ninety rendered drops (three particles, three heights, ten drops, 100 frames/s) and 36 rendered
swings of two blocks (three heights, twelve each), whose restitutions are drawn with the means and
standard deviations of Tables 2 and 3, are measured by `calibrate drop` and `calibrate pendulum`;
Table 1 by `calibrate interface`. What no film gives comes from docs/examples/wood. The materials
file then discharges A4.
"""

import argparse
import csv
import math
import re
import shlex
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from calibration.pendulum.measure import measure_pendulum
from calibration.rendered.backdrop import Backdrop
from calibration.rendered.camera import Camera
from calibration.rendered.low_drop import Block, LowDrop, film_low_drop
from calibration.rendered.pendulum import PendulumScene, film_pendulum
from calibration.rendered.strings import Strings
from granulab.contact.files.datafile import data_root

WOOD = Path(__file__).parents[1] / "docs" / "examples" / "wood"
PARTICLES = {"A": 0, "B": 5, "C": 10}  # of data/shapes/wood19.toml, which the paper does not name
DROPS, SWINGS, STRING = 10, 12, 0.5  # a height; a height; m
START = """schema = 1

[material.wood]
length = { value = "120 mm", source = "as sawn" }

[material.methacrylate]
density = { value = "1.19 g/cm3", source = "typical of the polymer" }
"""
BLOCK = ('--constant "area=100 mm2" --constant "length=10 mm" --constant "contact_area=1200 mm2" '
         '--constant "contact_length=20 mm"')  # fmt: skip


def published(name: str) -> list[dict[str, str]]:
    """Rows of a table of data/published."""
    with (data_root() / "published" / name).open(encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def block(random: np.random.Generator, outline: np.ndarray, fall: float, wanted: float) -> Block:
    """A drop whose first contact gives the restitution that is wanted, sqrt(H1/H0).

    It is let go as it comes; the corner's own restitution is then that which gives it.
    """
    while True:
        one = Block(outline, fall, angle=random.uniform(0, 2 * math.pi), release=0.15,
                    spin=random.normal(0, 0.3))  # fmt: skip
        low, high = 0.02, 1.0
        if replace(one, restitution=high).rebound < wanted:
            continue
        for _ in range(30):
            middle = (low + high) / 2
            if replace(one, restitution=middle).rebound < wanted:
                low = middle
            else:
                high = middle
        one = replace(one, restitution=high)
        times = one.contact_times
        if times[1] - times[0] > 0.05 and abs(one.rebound - wanted) < 1e-4:
            return one


def film_drops(folder: Path, random: np.random.Generator) -> list[float]:
    """Write PARTICLE/HEIGHT/drop.avi of Table 2; means of the restitutions drawn, by its rows."""
    drawn = []
    with (data_root() / "shapes" / "wood19.toml").open("rb") as file:
        shapes = tomllib.load(file)["shape"]
    for row in published("drop_test_restitution.csv"):
        outline = np.array(shapes[PARTICLES[row["particle"]]]["outline"], dtype=float) * 1e-3
        mean, height = float(row["mean"]), float(row["H0_mm"])
        wanted = random.normal(mean, float(row["sd_percent"]) / 100 * mean, DROPS)
        drawn.append(float(wanted.mean()))
        for k in range(DROPS):
            one = block(random, outline, height * 1e-3, min(wanted[k], 0.95))
            scene = LowDrop(one, scale=4e-4, backdrop=Backdrop(seed=k + 1))
            path = folder / row["particle"] / f"{height:g}mm" / f"{k + 1:02}.avi"
            path.parent.mkdir(parents=True, exist_ok=True)
            film_low_drop(scene, Camera(100.0), path, duration=one.contact_times[0] + 0.3,
                          seed=k, codec="MJPG")  # fmt: skip
    return drawn


def swings(folder: Path, random: np.random.Generator) -> tuple[Path, list[float]]:
    """Film and measure the pendulum of Table 3; a table of H0, mean, sd, trials; means drawn."""
    lines, drawn = ["H0 [mm],mean,sd,trials"], []
    for row in published("pendulum_restitution.csv"):
        mean, height = float(row["mean"]), float(row["H0_mm"])
        wanted = random.normal(mean, float(row["sd_percent"]) / 100 * mean, SWINGS)
        drawn.append(float(wanted.mean()))
        found = []
        for k in range(SWINGS):
            angle = math.degrees(math.acos(1 - height * 1e-3 / STRING))
            strings = Strings(
                length=STRING, angle=angle, beta=0.03, contacts=3, mass_ratio=1.0,
                restitution=min(wanted[k], 0.95),
            )  # fmt: skip
            scene = PendulumScene(strings, width=320, height=160, scale=1.7e-3, pivot=-160.0)
            path = folder / "swing.mp4"
            film_pendulum(scene, Camera(100.0), path, seed=k)
            found.append(measure_pendulum(path).restitution.value)
        sd = float(np.std(found, ddof=1))
        lines.append(f"{height:g},{np.mean(found):.5f},{sd:.5f},{SWINGS}")
    path = folder / "pendulum.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    return path, drawn


def run(command: str) -> str:
    """What a command prints, after its own line; RuntimeError where it fails."""
    name, *rest = shlex.split(command)
    module = {"calibrate": "calibration", "silo2d": "silo2d"}[name]
    done = subprocess.run(
        [sys.executable, "-m", module, *rest], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f"{command}: {done.stderr}")
    return f"\n$ {command}\n{done.stdout.rstrip()}"


def commands(drops: Path, pendulum: Path, into: Path, runs: Path) -> Sequence[str]:
    """The way from films and tables to A4."""
    markers = f"{data_root() / 'published' / 'interface_markers.csv'} --group surface"
    wood, wall = (f"--into {into} --pair wood-{other}" for other in ("wood", "methacrylate"))
    interface = f'calibrate interface {markers} --only rough --constant "kn=16640 N/mm"'
    return (
        f"calibrate interface {markers}",
        f"calibrate drop {drops} --fps 100 --quiet {wall}",
        f"calibrate heights {pendulum} {wood}",
        f"calibrate density {WOOD / 'weighed.csv'} --into {into} --material wood",
        f'calibrate incline {WOOD / "tilt_wood.csv"} --instrument "angle=0.2 deg" {wood}',
        f'calibrate incline {WOOD / "tilt_wall.csv"} --instrument "angle=0.2 deg" {wall}',
        f"calibrate compression {WOOD / 'cubes.csv'} {BLOCK} {wood}",
        f"calibrate compression {WOOD / 'cubes.csv'} {BLOCK} {wall}",
        f"{interface} {wood}",
        f"{interface} {wall}",
        f"calibrate slide {WOOD / 'slide.csv'} {wood}",
        f"calibrate slide {WOOD / 'slide.csv'} {wall}",
        f'calibrate damping --pair wood-wood --area "200 mm2" --contacts 8 --into {into}',
        f'calibrate damping --pair wood-methacrylate --area "200 mm2" --wall --into {into}',
        f"calibrate report {into}",
        f"silo2d run A4 --materials {into} --out {runs} --quiet --no-figures",
    )


def beside(said: str, drops: list[float], blocks: list[float]) -> Iterator[str]:
    """Lines of Tables 1 to 3: as the paper prints them, as films were drawn, and as measured."""
    rows = [
        *((f"1 {row['surface']}, point {row['point']}", row["kt_over_kn_printed"], None)
          for row in published("interface_markers.csv")),
        *((f"2 {row['particle']}, {row['H0_mm']} mm", row["mean"], mean)
          for row, mean in zip(published("drop_test_restitution.csv"), drops, strict=True)),
        *((f"3 {float(row['H0_mm']):.4g} mm", row["mean"], mean)
          for row, mean in zip(published("pendulum_restitution.csv"), blocks, strict=True)),
    ]  # fmt: skip
    number = r"([\d.]+(?: \+- [\d.]+)?)"
    groups = (
        rf"^  (?:flat|rough), line \d+ +{number}$", rf"^  [ABC], [\d.]+mm +{number}, \d+ trials",
        rf"^  [\d.]+ mm +{number}, {SWINGS} trials",
    )  # fmt: skip
    once = said.split("calibrate interface", 2)[1] + said[said.index("$ calibrate drop") :]
    once = once.partition("$ calibrate density")[0]
    measured = [one for group in groups for one in re.findall(group, once, re.MULTILINE)]
    yield f"\n{'Table':24} {'printed':>8} {'drawn':>8}  measured"
    for (name, printed, mean), found in zip(rows, measured, strict=True):
        yield f"{name:24} {printed:>8} {'' if mean is None else f'{mean:.4f}':>8}  {found}"


def main() -> None:
    """Film, measure, run, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", type=Path)
    options = parser.parse_args()
    random = np.random.default_rng(1)
    said = [f"python benchmarks/laboratory.py {options.file}"]
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        drops = film_drops(folder / "drops", random)
        pendulum, blocks = swings(folder, random)
        into = folder / "wood.toml"
        into.write_text(START, encoding="utf-8", newline="\n")
        for command in commands(folder / "drops", pendulum, into, folder / "runs"):
            said.append(run(command).replace(f"{folder}/", "").replace(f"{WOOD.parents[2]}/", ""))
            print(said[-1], flush=True)
    said += beside("\n".join(said), drops, blocks)
    options.file.write_text("\n".join(said) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
