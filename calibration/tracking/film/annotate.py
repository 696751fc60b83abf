"""The film of a drop test with what was measured drawn in, so that a person can judge it.

Drawn are the thing followed, its path of late, the plate and the contacts; beside the picture stand
frame, time, the restitution of each bounce once it has happened, and a scale bar.
"""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.drop.result import Drop
from calibration.tracking.film.labels import scale_bar, with_sigma
from calibration.tracking.film.marks import Marks, Still
from calibration.tracking.film.reader import Film, Told
from granulab.campaign.output.figure import INK, PAPER
from granulab.campaign.output.film import Image, font, pace, rgb, write_film, write_words

_WIDEST, _HIGHEST = 960, 720  # px of a picture, as laptops show it
_PANEL, _MARGIN, _LINE = 250, 14, 22  # px


def annotate(
    drop: Drop, film: Film, path: Path, progress: Told | None = None
) -> tuple[Path, list[Still]]:
    """Write the annotated film as an mp4; its path, and stills, of one pass over the film.

    The track of `drop` must have been followed in `film`: its frames and pixels are the film's.
    Stills show the moments that tell: let go, first contact, apex after it, last contact.
    """
    kept: dict[int, Still] = {}  # by frame: a film is drawn again where a codec is not to be had
    pictures = partial(_pictures, drop, film, path.stem, kept, progress)
    written = write_film(path.parent, pictures, path.stem)
    return written, [kept[number] for number in sorted(kept)]


def _telling(drop: Drop) -> set[int]:
    contacts = drop.bounces.contacts[:, 0]
    release = drop.bounces.base.clock[drop.bounces.flights.rows[0][0]]
    end = drop.bounces.base.clock[drop.bounces.flights.rows[1][-1]]
    apex = (contacts[0] + (contacts[1] if len(contacts) > 1 else end)) / 2
    return {round(drop.frame(t)) for t in (release, contacts[0], apex, contacts[-1])}


def _pictures(
    drop: Drop, film: Film, name: str, kept: dict[int, Still], progress: Told | None
) -> Iterator[Image]:
    """All frames with marks and panel; those that tell are kept."""
    marks = Marks(drop, film.width, film.height, _WIDEST, _HIGHEST)
    panel = _Panel(drop, marks, name)
    telling = _telling(drop)
    for frame in film.frames():
        image = marks.draw(frame)
        if frame.number in telling:
            kept[frame.number] = Still(frame.number, film.width, film.height, image)
        yield _even(np.hstack([image, panel.draw(frame.number)]))
        if progress is not None and film.count:
            progress(frame.number / film.count, "annotated film")


def _even(image: Image) -> Image:
    """With a row and a column more where codecs want them."""
    rows, columns = (side % 2 for side in image.shape[:2])
    return np.pad(image, ((0, rows), (0, columns), (0, 0)), mode="edge")


class _Panel:
    """What stands beside the picture."""

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
        """The panel beside frame `number`."""
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
