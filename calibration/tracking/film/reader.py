"""Frames of a film, one by one: a video file, a folder of pictures, or a pattern of their names.

Its frame rate, given or of the file, and the part of the picture to look at.
"""

import os
import re
from collections.abc import Callable, Collection, Generator, Iterator
from contextlib import closing, suppress
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty, Queue
from threading import Event, Thread
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from calibration.files.dialect import UTF_16
from granulab.errors import InputError

Picture = NDArray[np.uint8]
One = TypeVar("One")
Progress = Callable[[float, str], None]  # share of a film that is read, and a few words

PICTURES = (".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff", ".webp")
FILMS = (".avi", ".m4v", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg", ".mts", ".webm", ".wmv")

# What is wrong with a file is reported in our own lines; FFmpeg reads this when it is first used.
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")

# With which spreadsheets and texts in UTF-16 begin, where no zero byte says that it is a film.
_NO_FILMS = (b"PK", b"\xd0\xcf\x11\xe0", *UTF_16)
_AHEAD = 4  # frames decoded before their use: 25 MB of 1920 x 1080 px
_BAD_IN_A_ROW = 1000  # frames that may be missing before a film is taken to end
# A second is what falls, swings and discharges last: it takes frames. Cameras reach a million.
_SLOWEST, _FASTEST = 1.0, 1e6


class Frame(NamedTuple):
    """One picture of a film.

    number    from 0 on, as a player counts
    stamp     s from the start, as the file says; None for pictures
    picture   (height, width, 3), blue, green, red
    """

    number: int
    stamp: float | None
    picture: Picture


@dataclass(frozen=True)
class Film:
    """A film on disk; no frame of it stays in memory.

    rate     frames/s that the file's header says; None for pictures
    count    frames that the file says, or pictures found; 0 where the header says nothing
    corrupt  numbers of the frames that could not be decoded, as far as `frames` has been read
    """

    path: Path
    width: int
    height: int
    rate: float | None
    count: int
    pictures: tuple[Path, ...] = ()
    corrupt: list[int] = field(default_factory=list)

    def frames(self) -> Generator[Frame, None, None]:
        """All frames in order; one that cannot be decoded is left out, and stands in `corrupt`.

        They are decoded ahead on another core; close the generator (`contextlib.closing`) where
        it is left before its end.
        """
        self.corrupt.clear()
        with closing(ahead(self._of_pictures() if self.pictures else self._of_video())) as found:
            for one in found:
                if isinstance(one, int):
                    self.corrupt.append(one)
                else:
                    yield one

    def some(self, numbers: Collection[int]) -> Iterator[Frame]:
        """Those of these frames that can be read, in order; nothing is used behind the last."""
        with closing(self.frames()) as frames:
            for frame in frames:
                if frame.number in numbers:
                    yield frame
                if frame.number >= max(numbers):
                    break

    def _of_pictures(self) -> Generator[Frame | int, None, None]:
        """Frames; the numbers of those that cannot be read."""
        for number, path in enumerate(self.pictures):
            picture = _picture(path)
            if picture is None or picture.shape[:2] != (self.height, self.width):
                yield number
            else:
                yield Frame(number, None, picture)

    def _of_video(self) -> Generator[Frame | int, None, None]:
        """Frames; the numbers of those that cannot be decoded."""
        import cv2

        capture = _capture(self.path)
        number, failed = 0, 0
        try:
            while failed < min(max(self.count - number, 1), _BAD_IN_A_ROW):
                if not capture.grab():
                    failed += 1  # a bad frame, or the end, which the header may not know
                    continue
                stamp = capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3
                there, picture = capture.retrieve()
                yield from range(number, number + failed)
                number, failed = number + failed, 0
                yield Frame(number, stamp, picture) if there and picture is not None else number
                number += 1
        finally:
            capture.release()


def ahead(source: Generator[One, None, None], depth: int = _AHEAD) -> Generator[One, None, None]:
    """The same items in the same order, made by a thread up to so many ahead of their use.

    OpenCV decodes without Python's lock: on two cores a film is decoded beside its use. An error of
    the source is raised where its item would stand. The thread ends with the last item, or when
    this generator is closed, and closes the source before.
    """
    made: Queue[One | BaseException | None] = Queue(depth)
    left = Event()

    def make() -> None:
        end: BaseException | None = None
        try:
            with closing(source):
                for one in source:
                    made.put(one)
                    if left.is_set():
                        break
        except BaseException as error:
            end = error
        made.put(end)

    thread = Thread(target=make, name="decoding", daemon=True)
    thread.start()
    try:
        while (one := made.get()) is not None:
            if isinstance(one, BaseException):
                raise one
            yield one
    finally:
        left.set()
        while thread.is_alive():  # it may wait for room in the queue
            with suppress(Empty):
                made.get(timeout=0.01)
        thread.join()


def open_film(path: str | Path) -> Film:
    """A film: mp4, avi, mov and whatever else FFmpeg reads, a folder of pictures, or "im*.png".

    Raises InputError, one line, for what is no film or holds no frame.
    """
    path = Path(path)
    if path.is_dir() or is_pattern(path):
        return _open_pictures(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file; a film, a folder of pictures, or 'im*.png'")
    if path.suffix.lower() in PICTURES:
        raise InputError(f"{path}: one picture is no film; name its folder, or a pattern 'im*.png'")
    return _open_video(path)


def open_picture(path: str | Path) -> Film | None:
    """One picture as a film of one frame; None for what is none. InputError if it is unreadable."""
    path = Path(path)
    if path.suffix.lower() not in PICTURES or not path.is_file() or is_pattern(path):
        return None
    picture = _picture(path)
    if picture is None:
        raise InputError(f"{path}: this picture cannot be read")
    height, width = picture.shape[:2]
    return Film(path, width, height, None, 1, (path,))


def is_film(path: str | Path) -> bool:
    """True if a file is to be read as a film: a folder, a pattern, a film's ending, no text."""
    path = Path(path)
    if path.is_dir() or is_pattern(path):
        return True
    if path.suffix.lower() in PICTURES + FILMS:
        return True
    if not path.is_file():
        return False
    with path.open("rb") as file:
        start = file.read(4096)
    return b"\0" in start and not start.startswith(_NO_FILMS)


def is_pattern(path: Path) -> bool:
    """True if a path stands for several pictures: "im*.png"."""
    return any(mark in path.name for mark in "*?[")


def _open_video(path: Path) -> Film:
    import cv2

    capture = _capture(path)
    try:
        there, picture = capture.read()
        if not there or picture is None:
            raise InputError(f"{path}: no frame of this film can be read; is the file cut off?")
        rate = float(capture.get(cv2.CAP_PROP_FPS))
        count = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
        height, width = picture.shape[:2]
    finally:
        capture.release()
    return Film(path, width, height, rate if rate > 0 else None, max(count, 0))


def _open_pictures(path: Path) -> Film:
    names = path.iterdir() if path.is_dir() else path.parent.glob(path.name)
    found = sorted((p for p in names if p.suffix.lower() in PICTURES), key=_natural)
    if len(found) < 2:
        raise InputError(f"{path}: {len(found)} pictures; a film has more than one")
    first = next((p for p in map(_picture, found) if p is not None), None)
    if first is None:
        raise InputError(f"{path}: none of {len(found)} pictures can be read")
    height, width = first.shape[:2]
    return Film(path, width, height, None, len(found), tuple(found))


def _natural(path: Path) -> list[Any]:
    """Order of im2 before im10."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", path.name)]


def _picture(path: Path) -> Picture | None:
    import cv2

    try:
        content = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    except OSError:
        return None
    # OpenCV itself finds no picture on Windows whose path has other letters than English ones.
    picture = cv2.imdecode(content, cv2.IMREAD_COLOR) if len(content) else None
    return None if picture is None else np.asarray(picture, dtype=np.uint8)


def _capture(path: Path) -> Any:
    import cv2

    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    if not capture.isOpened():
        raise InputError(f"{path}: no film that can be read, or cut off (mp4, avi, mov, pictures)")
    return capture


def said_rate(fps: float | None) -> float | None:
    """--fps, as it is; InputError where no camera has it."""
    if fps is not None and not _SLOWEST <= fps <= _FASTEST:
        raise InputError(
            f"--fps = {fps!r}: frames per second of the camera, from {_SLOWEST:g} to {_FASTEST:g}, "
            "such as 240"
        )
    return fps


def frame_rate(film: Film, fps: float | None) -> float:
    """Frames/s as said, else the file's own; InputError where neither is known."""
    rate = said_rate(fps) or film.rate
    if rate is None:
        raise InputError(f"{film.path}: no frame rate is known; say it: --fps 100")
    return rate


class Region(NamedTuple):
    """Part of the picture [px]."""

    x: int
    y: int
    width: int
    height: int


def inside(
    film: Film, roi: Region | tuple[int, int, int, int] | None, smallest: int = 16
) -> Region:
    """The region, or the whole picture; InputError where it is not in it or too small [px]."""
    if roi is None:
        return Region(0, 0, film.width, film.height)
    one = Region(*roi)
    within = one.x + one.width <= film.width and one.y + one.height <= film.height
    if min(one.x, one.y) < 0 or min(one.width, one.height) < smallest or not within:
        raise InputError(
            f"--roi {','.join(map(str, one))}: x,y,width,height, {smallest} px and more, within "
            f"the picture of {film.width} x {film.height} px"
        )
    return one
