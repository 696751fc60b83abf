"""Samples of data/media: short films of a drop, a discharge and a pendulum, with their truth.

python -m calibration.rendered NAME FOLDER writes one again.
"""

import json
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

from calibration.rendered.camera import Camera, write_film
from calibration.rendered.drop import Ball, DropScene, film_drop
from calibration.rendered.pendulum import PendulumScene, film_pendulum
from calibration.rendered.strings import Strings

_DROP = DropScene((Ball(diameter=0.03, fall=0.25, restitution=0.75),), width=160, height=320)
_DROP_CAMERA = Camera(rate=100, exposure=0.3, blur=0.8, noise=2.0)
_PENDULUM = PendulumScene(
    Strings(restitution=0.45, mass_ratio=1.0, beta=0.03, contacts=4),
    width=280, height=160, scale=1.7e-3, pivot=-160.0,
)  # fmt: skip
_PENDULUM_CAMERA = Camera(rate=60, noise=1.5)
_SILO = """schema = 1
[silo]
angle = "45 deg"
outlet = "80 mm"
width = "150 mm"
height = "180 mm"
[fill]
level = "135 mm"
"""
_SILO_CAMERA = Camera(rate=120, moments=3)
_INTERVAL = 0.1  # s between profiles of the silo's truth


def write_drop(folder: Path) -> list[Path]:
    """Write drop.mp4 and drop.toml."""
    clip, facts = folder / "drop.mp4", folder / "drop.toml"
    truth = film_drop(_DROP, _DROP_CAMERA, clip, duration=1.3, seed=1)
    ball = _DROP.balls[0]
    facts.write_text(
        "# python -m calibration.rendered drop data/media\n"
        "schema = 1\n"
        f'rate = "{truth.rate:g} 1/s"\n'
        f'scale = "{truth.scale * 1e3:g} mm/px"\n'
        f'diameter = "{ball.diameter * 1e3:g} mm"\n'
        f"restitution = {ball.restitution:g}\n"
        f"contact_frames = {_listed(truth.frame)}\n"
        f"contact_times_s = {_listed(truth.contacts)}\n"
        f"impact_speeds_m_s = {_listed(truth.speeds)}\n",
        encoding="utf-8",
        newline="\n",
    )
    return [clip, facts]


def write_pendulum(folder: Path) -> list[Path]:
    """Write pendulum.mp4 and pendulum.toml, a film of two equal blocks."""
    clip, facts = folder / "pendulum.mp4", folder / "pendulum.toml"
    truth, strings = film_pendulum(_PENDULUM, _PENDULUM_CAMERA, clip), _PENDULUM.strings
    facts.write_text(
        "# python -m calibration.rendered pendulum data/media\n"
        "schema = 1\n"
        f'rate = "{truth.rate:g} 1/s"\n'
        f'scale = "{_PENDULUM.scale * 1e3:g} mm/px"\n'
        f'string = "{strings.length * 1e3:g} mm"\n'
        f'release = "{strings.angle:g} deg"\n'
        f"restitution = {truth.restitution:g}\n"
        f"mass_ratio = {strings.mass_ratio:g}\n"
        f'damping = "{strings.beta:g} 1/s"\n'
        f"contact_frames = {_listed(truth.frame)}\n"
        f"contact_times_s = {_listed(truth.contacts)}\n",
        encoding="utf-8",
        newline="\n",
    )
    return [clip, facts]


def write_flow(folder: Path) -> list[Path]:
    """Write flow.mp4 and flow.json; a small silo of painted layers is simulated first."""
    from calibration.rendered.flow import Look, Stage, film_of_run, simulated, truth

    clip, facts = folder / "flow.mp4", folder / "flow.json"
    with tempfile.TemporaryDirectory() as work:
        case = Path(work) / "sample.toml"
        case.write_text(_SILO, encoding="utf-8", newline="\n")
        run = simulated(case, Path(work) / "runs")
        stage = Stage(run, Look(scale=0.75e-3, lead=0.08, rest=0.3))
        times, pictures = film_of_run(stage, _SILO_CAMERA)
        write_film(pictures, clip, _SILO_CAMERA.rate)
        known = truth(run, stage, times, _SILO_CAMERA, _INTERVAL)
    recipe = {"recipe": "python -m calibration.rendered flow data/media", "schema": 1}
    facts.write_text(json.dumps(recipe | known, indent=1) + "\n", encoding="utf-8", newline="\n")
    return [clip, facts]


SAMPLES = {"drop": write_drop, "flow": write_flow, "pendulum": write_pendulum}


def _listed(values: Iterable[float]) -> str:
    return "[" + ", ".join(f"{value:.6g}" for value in values) + "]"


def main(arguments: list[str]) -> int:
    """Write the sample's clip and its truth; their paths on stdout. 2 for what cannot be done."""
    if len(arguments) != 2 or arguments[0] not in SAMPLES:
        print(f"python -m calibration.rendered {'|'.join(SAMPLES)} FOLDER", file=sys.stderr)
        return 2
    name, folder = arguments
    Path(folder).mkdir(parents=True, exist_ok=True)
    for path in SAMPLES[name](Path(folder)):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
