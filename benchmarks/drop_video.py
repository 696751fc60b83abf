"""Frames a second at which a drop test is read from a 1080p film, on one core, decoding included.

    python benchmarks/drop_video.py [FILM]

Without a film, one is rendered: a ball of 60 px that bounces before a textured wall.
"""

import sys
import tempfile
import time
from pathlib import Path

import cv2
import scipy.ndimage
import scipy.optimize
import scipy.special  # noqa: F401  these are loaded once, whatever a film's length

from calibration.rendered.camera import Camera
from calibration.rendered.drop import Ball, DropScene, film_drop
from calibration.tracking.film.reader import open_film
from calibration.tracking.follow import follow

_FRAMES = 90
_SCENE = DropScene((Ball(diameter=0.04, fall=0.4),), width=1920, height=1080, scale=0.04 / 60)


def main() -> None:
    """Print the cost of decoding alone, and of following."""
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(sys.argv[1]) if len(sys.argv) > 1 else _rendered(Path(folder))
        film = open_film(path)
        decoding, frames = _timed(lambda: sum(1 for _ in film.frames()))
        whole, tracks = _timed(lambda: follow(film))
    print(f"{path.name}: {film.width} x {film.height} px, {frames} frames, {len(tracks)} tracks")
    for what, seconds in (("decoding", decoding), ("following", whole)):
        print(f"{what:>10} {1e3 * seconds / frames:6.2f} ms of CPU a frame, "
              f"{frames / seconds:6.1f} frames/s")  # fmt: skip


def _rendered(folder: Path) -> Path:
    path = folder / "rendered.mp4"
    film_drop(_SCENE, Camera(60, moments=1), path, duration=_FRAMES / 60)
    return path


def _timed(work):
    start = time.process_time()
    found = work()
    return time.process_time() - start, found


if __name__ == "__main__":
    main()
