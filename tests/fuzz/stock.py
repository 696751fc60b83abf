"""What the campaign spoils: good tables, signals, films, meshes and run folders, made once."""

import sys
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "data"))
from made_meshes import CUBE, CUBE_FACES, cuboid, write_obj
from made_pendulums import made as made_pendulum
from made_signals import Bounces, Room, write_wav
from made_tracks import made_track
from make_kept import make_runs

from calibration.rendered.camera import Camera
from calibration.rendered.drop import Ball, DropScene, film_drop


def _rows(head: str, *columns: object) -> str:
    rows = zip(*(np.asarray(column).tolist() for column in columns), strict=True)
    return "\n".join([head, *(",".join(f"{x:.6g}" for x in row) for row in rows)]) + "\n"


def _tables() -> dict[str, tuple[str, list[str]]]:
    """Good tables by the command that reads them, each with the options it needs."""
    t, x = 0.05 * np.arange(40), 0.01 * np.arange(200)
    load = np.concatenate([25.0 * np.arange(40), 25.0 * np.arange(39, -1, -1)])
    wave = 100 * np.sin(2 * np.pi * 40 * np.arange(2000) / 4000)
    track = made_track([0.8, 0.78, 0.8]).track
    swings = made_pendulum(rate=60).tracks
    pulses = np.zeros(8000)
    for k, at in enumerate(Bounces().times):
        pulses[int(at * 4000) : int(at * 4000) + 4] = 0.8**k
    specimen = ["--constant", "area=100 mm2", "--constant", "length=10 mm"]
    sides = [_rows("", s.frame, np.full(len(s.x), k), s.x, s.y) for k, s in enumerate(swings)]
    return {
        "slide": (_rows("time [s],velocity [m/s]", t, 0.4 * (1 - np.exp(-3 * t))), []),
        "roughness": (_rows("x [mm],z [um]", x, np.sin(40 * x)), []),
        "compression": (_rows("displacement [mm],load [N]", load / 5000, load), specimen),
        "incline": (_rows("angle_deg", [20.0, 20.5, 21.2, 19.7, 20.3]), []),
        "density": (_rows("mass [g],volume [mm3]", [1.1, 1.2, 0.9], [900, 1000, 780]), []),
        "interface": (
            _rows("dx_t [mm],dx_n [mm],sigma_t [MPa],sigma_n [MPa]",
                  [0.03, 0.03, 0.031], [-0.09, -0.03, -0.05], [-4.5, -4.6, -4.4], [-42, -43, -41]),
            [],
        ),
        "drop": (_rows("frame,x,y", track.frame, track.x, track.y), ["--fps", "240"]),
        "pendulum": (
            "frame,particle,x,y\n" + "".join(side.lstrip("\n") for side in sides), ["--fps", "60"],
        ),
        "impacts": (_rows("time [s],force [N]", np.arange(8000) / 4000, pulses), []),
        "shaker": (
            _rows("time [s],force [N],acceleration [m/s2]", np.arange(2000) / 4000,
                  0.05 * wave + 3, wave + np.roll(wave, 3) * 0.01),
            [],
        ),
    }  # fmt: skip


TABLES = _tables()
SHAPES = {
    "schema": 1,
    "spheroradius": "0.5 mm",
    "unit": "mm",
    "shape": [
        {"name": "square", "outline": [[0, 0], [7, 0], [7, 7], [0, 7]]},
        {"name": "rod", "outline": [[0, 0], [10, 0], [10, 5], [0, 5]], "share": 2},
    ],
}
STL = "solid box\n%sendsolid box\n"
FACET = "facet normal 0 0 0\nouter loop\n%sendloop\nendfacet\n"


def make_stock(folder: Path, runs: bool) -> None:
    """Write what is spoilt: films, pictures, sounds, meshes, and runs where they are wanted."""
    ball = Ball(diameter=0.004, fall=0.02, release=0.04, aside=0.0)
    scene = DropScene((ball,), width=80, height=160, scale=2e-4)
    film_drop(scene, Camera(200, moments=2), folder / "film.avi", duration=0.36, codec="MJPG")
    film_drop(scene, Camera(200, moments=2), folder / "film.mp4", duration=0.36, codec="mp4v")
    chance = np.random.default_rng(1)
    picture = cv2.GaussianBlur(chance.integers(0, 255, (96, 96)).astype(np.uint8), (0, 0), 1.5)
    cv2.imwrite(str(folder / "a.png"), picture)
    cv2.imwrite(str(folder / "b.png"), np.roll(picture, 2, axis=1))
    write_wav(folder / "sound.wav", Room(rate=8000.0).record(Bounces(), 1), 8000.0)
    triangles = cuboid((4.0, 5.0, 6.0))
    facets = [
        FACET % "".join(f"vertex {x:g} {y:g} {z:g}\n" for x, y, z in one) for one in triangles
    ]
    (folder / "mesh.stl").write_text(STL % "".join(facets), encoding="utf-8")
    write_obj(folder / "mesh.obj", CUBE * [4.0, 5.0, 6.0], CUBE_FACES)
    if runs:
        (folder / "runs").mkdir()
        make_runs(folder / "runs")


def runs_of(folder: Path, program: str) -> dict[str, Path]:
    """The kept run folders of a program below a folder by the word before their seed."""
    found = (folder / program.removesuffix("2d").removesuffix("3d")).glob("*-seed1-*")
    whole = [path for path in found if (path / "trajectory.h5").exists() or "begun" in path.name]
    return {path.name.partition("-")[0]: path for path in sorted(whole)}
