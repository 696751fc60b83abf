"""The film of a drop test with what was measured drawn in, so that a person can judge it.

Drawn are the object followed, its recent path, the plate and the contacts; next to the picture
stand frame, time, the restitution of each bounce once it has happened, and a scale bar.
"""

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.drop.result import Drop
from calibration.tracking.film.reader import Film, Frame, Progress
from calibration.tracking.track import Array
from granulab.campaign.output.figure import BLUE, INK, ORANGE, PAPER, VERMILION, round_length
from granulab.campaign.output.film import Image, font, pace, rgb, write_film, write_words

_UNITS = ((1.0, "m"), (1e-2, "cm"), (1e-3, "mm"), (1e-6, "µm"))
_SHIFT = 4  # OpenCV takes positions in sixteenths of a pixel
_TRAIL = 15  # positions of late
_RADIUS = 8.0  # px, of a circle around an object whose size is not known
_WIDEST, _HIGHEST = 960, 720  # px of a picture, as laptops show it
_PANEL, _MARGIN, _LINE = 250, 14, 22  # px


def scale_bar(longest: float) -> tuple[float, str]:
    """The longest of 1, 2, 5 x 10^n [m] that is not above `longest` [m], and its words."""
    length = round_length(longest)
    size, unit = next((one for one in _UNITS if length >= 0.999 * one[0]), _UNITS[-1])
    return length, f"{length / size:.3g} {unit}"


def with_sigma(value: float, sigma: float | None) -> str:
    """Both to the first decimal of sigma, two to four decimals; "0.80" where it is not known."""
    if sigma is None or not sigma > 0:
        return f"{value:.2f}"
    decimals = min(max(-math.floor(math.log10(sigma)), 2), 4)
    return f"{value:.{decimals}f} \N{PLUS-MINUS SIGN} {max(sigma, 10.0**-decimals):.{decimals}f}"


class Still(NamedTuple):
    """A frame with its marks; width and height are those of the film [px]."""

    number: int
    width: int
    height: int
    image: Image


class Marks:
    """The same for all frames: positions in the film, and how much larger it is shown.

    zoom            pixels shown for one of the film
    width, height   of the pictures drawn [px]
    contact_frames  (n,) frame number of each contact
    """

    def __init__(self, drop: Drop, width: int, height: int, widest: int, highest: int) -> None:
        self.zoom = min(widest / width, highest / height)
        self.width, self.height = round(self.zoom * width), round(self.zoom * height)
        found, track = drop.bounces, drop.bounces.track
        self.frames, self.x, self.y = track.frame, track.x, track.y
        n = len(track.frame)
        self.radius = np.full(n, _RADIUS) if track.radius is None else track.radius
        self.camera = np.zeros((n, 2)) if track.camera is None else track.camera
        self.contact_frames = np.array([drop.frame(t) for t in found.contacts[:, 0]])
        self.plate = found.plate[:, 0]
        self._base = track.frame[found.base.rows], found.base.clock

    def clock(self, number: int) -> float:
        """Time of a frame on the clock of the flights; steady beyond them [frames]."""
        frames, clock = self._base
        beyond = min(number - frames[0], 0) + max(number - frames[-1], 0)
        return float(np.interp(number, frames, clock) + beyond)

    def draw(self, frame: Frame) -> Image:
        """The frame, red green blue, with the marks of what is known at it."""
        import cv2

        area = cv2.INTER_AREA if self.zoom < 1 else cv2.INTER_LINEAR
        size = (self.width, self.height)
        shown = cv2.cvtColor(cv2.resize(frame.picture, size, interpolation=area), cv2.COLOR_BGR2RGB)
        image = np.asarray(shown, dtype=np.uint8)
        moved = np.array([np.interp(frame.number, self.frames, c) for c in self.camera.T])
        self._draw_plate(image, frame.number, moved)
        self._draw_track(image, frame.number, moved)
        return image

    def _draw_track(self, image: Image, number: int, moved: Array) -> None:
        """The path of late, and a circle around the object where it was seen in this frame."""
        import cv2

        last = int(np.searchsorted(self.frames, number, side="right"))
        late = np.arange(max(last - _TRAIL, 0), last)
        if len(late) == 0 or number - self.frames[late[-1]] > _TRAIL:
            return
        path = self._shown(self.x[late] + moved[0], self.y[late] + moved[1])
        cv2.polylines(image, [path], False, rgb(BLUE), 1, cv2.LINE_AA, _SHIFT)
        for position in path:
            cv2.circle(image, position, 1 << _SHIFT, rgb(BLUE), -1, cv2.LINE_AA, _SHIFT)
        if self.frames[late[-1]] == number:
            radius = round((self.radius[late[-1]] * self.zoom + 3) * 2**_SHIFT)
            for colour, wide in ((PAPER, 4), (VERMILION, 2)):  # seen on objects of any colour
                cv2.circle(image, path[-1], radius, rgb(colour), wide, cv2.LINE_AA, _SHIFT)

    def _draw_plate(self, image: Image, number: int, moved: Array) -> None:
        """The plate's level under the object, and a tick at each contact that has happened."""
        import cv2

        under = np.interp(self.contact_frames, self.frames, self.radius)
        level = np.interp(number, self.contact_frames, self.plate + under) + moved[1]
        ends = self._shown(np.array([0, image.shape[1] / self.zoom]), np.array([level, level]))
        cv2.line(image, ends[0], ends[1], rgb(ORANGE), 1, cv2.LINE_AA, _SHIFT)
        past = self.contact_frames <= number
        x = np.interp(self.contact_frames, self.frames, self.x)[past] + moved[0]
        y = (self.plate + under)[past] + moved[1]
        for position in self._shown(x, y):
            centre = (int(position[0]) >> _SHIFT, int(position[1]) >> _SHIFT)
            cv2.drawMarker(image, centre, rgb(ORANGE), cv2.MARKER_TRIANGLE_UP, 12, 2, cv2.LINE_AA)

    def _shown(self, x: Array, y: Array) -> np.ndarray:
        """(n, 2) positions of the film in the picture drawn, in sixteenths of a pixel."""
        positions = (np.stack([x, y], axis=1) + 0.5) * self.zoom - 0.5
        return np.rint(np.clip(positions, -1e4, 1e4) * 2**_SHIFT).astype(np.int32)


def annotate(
    drop: Drop, film: Film, path: Path, progress: Progress | None = None
) -> tuple[Path, list[Still]]:
    """Write the annotated film as an mp4; its path, and stills, of one pass over the film.

    The track of `drop` must have been followed in `film`: its frames and pixels are the film's.
    Stills show four moments: let go, first contact, apex after it, last contact.
    """
    kept: dict[int, Still] = {}  # by frame: a film is drawn again where a codec is not to be had
    pictures = partial(_pictures, drop, film, path.stem, kept, progress)
    written = write_film(path.parent, pictures, path.stem)
    return written, [kept[number] for number in sorted(kept)]


def _shown(drop: Drop) -> set[int]:
    contacts = drop.bounces.contacts[:, 0]
    release = drop.bounces.base.clock[drop.bounces.flights.rows[0][0]]
    end = drop.bounces.base.clock[drop.bounces.flights.rows[1][-1]]
    apex = (contacts[0] + (contacts[1] if len(contacts) > 1 else end)) / 2
    return {round(drop.frame(t)) for t in (release, contacts[0], apex, contacts[-1])}


def _pictures(
    drop: Drop, film: Film, name: str, kept: dict[int, Still], progress: Progress | None
) -> Iterator[Image]:
    """All frames with marks and panel; the four moments are kept."""
    marks = Marks(drop, film.width, film.height, _WIDEST, _HIGHEST)
    panel = _Panel(drop, marks, name)
    shown = _shown(drop)
    for frame in film.frames():
        image = marks.draw(frame)
        if frame.number in shown:
            kept[frame.number] = Still(frame.number, film.width, film.height, image)
        yield _even(np.hstack([image, panel.draw(frame.number)]))
        if progress is not None and film.count:
            progress(frame.number / film.count, "annotated film")


def _even(image: Image) -> Image:
    """With a row and a column more where codecs want them."""
    rows, columns = (side % 2 for side in image.shape[:2])
    return np.pad(image, ((0, rows), (0, columns), (0, 0)), mode="edge")


class _Panel:
    """The panel next to the picture."""

    def __init__(self, drop: Drop, marks: Marks, name: str) -> None:
        self.drop, self.marks = drop, marks
        self.font, self.bold = font(15), font(15, bold=True)
        paper = np.full((marks.height, _PANEL, 3), rgb(PAPER), dtype=np.uint8)
        write_words(paper, _short(name), _MARGIN, 10, self.bold)
        if drop.rate is not None:
            words = pace(np.array([0.0, 1 / drop.rate.value]))
            write_words(paper, words, _MARGIN, 10 + 3 * _LINE, self.font)
        if drop.scale is not None:
            self._scale_bar(paper, drop.scale.value / marks.zoom)
        self.paper: Image = paper
        self.rows = max((marks.height - 212) // _LINE, 1)

    def _scale_bar(self, paper: Image, scale: float) -> None:
        import cv2

        length, words = scale_bar(scale * (_PANEL - 2 * _MARGIN))
        end = _MARGIN + round(length / scale)
        y = paper.shape[0] - 18
        cv2.line(paper, (_MARGIN, y), (end, y), rgb(INK), 3)
        write_words(paper, words, _MARGIN, y - 26, self.font)

    def draw(self, number: int) -> Image:
        """The panel next to frame `number`."""
        panel = self.paper.copy()
        write_words(panel, f"frame {number}", _MARGIN, 10 + _LINE, self.font)
        seconds = self.drop.seconds(self.marks.clock(number))
        if seconds is not None:
            write_words(panel, f"{seconds:.3f} s", _MARGIN, 10 + 2 * _LINE, self.font)
        said = _restitutions(self.drop, self.marks.contact_frames <= number)
        if said:
            write_words(panel, "restitution", _MARGIN, 10 + 5 * _LINE, self.bold)
        for k, words in enumerate(said[-self.rows :]):
            write_words(panel, words, _MARGIN, 10 + (6 + k) * _LINE, self.font)
        return panel


def _restitutions(drop: Drop, happened: NDArray[np.bool_]) -> list[str]:
    """e of the bounces that have happened, from times where there are any, else velocities."""
    found = drop.bounces
    inner = np.isfinite(found.times[:, :1])
    known = np.where(inner, found.times, found.velocities)
    return [f"bounce {k + 1}   {with_sigma(*known[k])}" for k in np.flatnonzero(happened)]


def _short(name: str) -> str:
    """As much of a name as fits in the panel."""
    return name if len(name) <= 24 else f"{name[:22]}\N{HORIZONTAL ELLIPSIS}"
