"""The sample of a discharge: a small silo of painted layers, simulated and filmed."""

import json
import tempfile
from pathlib import Path

from calibration.rendered.camera import Camera, write_film
from calibration.rendered.flow import Look, Stage, film_of_run, simulated, truth

CASE = """schema = 1
[silo]
angle = "45 deg"
outlet = "80 mm"
width = "150 mm"
height = "180 mm"
[fill]
level = "135 mm"
"""
CAMERA = Camera(rate=120, moments=3)
LOOK = Look(scale=0.75e-3, lead=0.08, rest=0.3)
INTERVAL = 0.1  # s


def write(folder: Path) -> list[Path]:
    """Write flow.mp4 and flow.json; a simulation of some seconds comes first."""
    clip, facts = folder / "flow.mp4", folder / "flow.json"
    with tempfile.TemporaryDirectory() as room:
        case = Path(room) / "sample.toml"
        case.write_text(CASE, encoding="utf-8")
        folder_of_run = simulated(case, Path(room) / "runs")
        stage = Stage(folder_of_run, LOOK)
        times, pictures = film_of_run(stage, CAMERA)
        write_film(pictures, clip, CAMERA.rate)
        known = truth(folder_of_run, stage, times, CAMERA, INTERVAL)
    recipe = {"recipe": "python -m calibration.rendered flow data/media", "schema": 1}
    facts.write_text(json.dumps(recipe | known, indent=1) + "\n", encoding="utf-8")
    return [clip, facts]
