"""Frames a second at which a drop test is read from a 1080p film, decoding included.

    python benchmarks/drop_video.py [FILM]

Decoding alone, following with decoding in turn, and with decoding beside it (as calibrate drop
does), one after the other, three times; the least of each, as other work on the machine only adds.
Without a film, one is rendered: a ball of 60 px that bounces before a textured wall.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import scipy.ndimage
import scipy.optimize
import scipy.special  # noqa: F401  these are loaded once, whatever a film's length

from calibration.rendered.camera import Camera
from calibration.rendered.drop import Ball, DropScene, film_drop
from calibration.tracking.film import reader
from calibration.tracking.follow import follow

_FRAMES = 90
_RUNS = 3
_SCENE = DropScene((Ball(diameter=0.04, fall=0.4),), width=1920, height=1080, scale=0.04 / 60)


def main() -> None:
    """Print the cost of decoding alone, and of following."""
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(sys.argv[1]) if len(sys.argv) > 1 else _rendered(Path(folder))
        film = reader.open_film(path)
        works: dict[str, Callable[[], object]] = {
            "decoding": lambda: _in_turn(lambda: sum(1 for _ in film.frames())),
            "following, decoding in turn": lambda: _in_turn(lambda: follow(film)),
            "following, decoding beside": lambda: follow(film),
        }
        runs = [{what: _timed(work) for what, work in works.items()} for _ in range(_RUNS)]
        frames = sum(1 for _ in film.frames())
    print(f"{path.name}: {film.width} x {film.height} px, {frames} frames")
    for what in works:
        wall, cpu = (1e3 * min(run[what][k] for run in runs) / frames for k in (0, 1))
        print(
            f"{what:>28} {wall:6.2f} ms a frame, {1e3 / wall:6.1f} frames/s; {cpu:6.2f} ms of CPU"
        )


def _in_turn(work: Callable[[], object]) -> object:
    """The same without a thread that decodes."""
    beside, reader.ahead = reader.ahead, lambda source, depth=0: source
    try:
        return work()
    finally:
        reader.ahead = beside


def _rendered(folder: Path) -> Path:
    path = folder / "rendered.mp4"
    film_drop(_SCENE, Camera(60, moments=1), path, duration=_FRAMES / 60)
    return path


def _timed(work: Callable[[], object]) -> tuple[float, float]:
    """Seconds by the clock, and of CPU time."""
    start, spent = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - start, time.process_time() - spent


if __name__ == "__main__":
    main()
