"""The film of a run: a picture of every stored frame."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import PAPER, WALL
from granulab.campaign.output.film import Image, counted, font, pace, rgb, write_film, write_words
from silo2d.view.scene import PARTICLE_EDGE, WOOD, Scene

_LONGEST, _PIXELS = 780, 430 * 780  # of the window in a picture
_NARROWEST = 420  # for the heading
_HEADING, _MARGIN = 74, 16
_WITH_EDGES = 6.0  # [px] size of a particle whose edges have their own colour
_SHIFT = 4  # OpenCV takes corners in sixteenths of a pixel


def make_film(scene: Scene, folder: Path, report: Callable[[int], None] | None = None) -> Path:
    """Write film.mp4 into a folder; its path. See granulab.campaign.output.film.write_film.

    report: called with the number of pictures that are made.
    """
    return write_film(folder, lambda: counted(film_frames(scene), report))


def film_frames(scene: Scene) -> Iterator[Image]:
    """One picture for each stored frame, all of one even size."""
    canvas = _Canvas(scene)
    for frame in range(len(scene.time)):
        yield canvas.draw(frame)


class _Canvas:
    """Canvas of a film: what is the same in all pictures, and the scale [px/m]."""

    def __init__(self, scene: Scene) -> None:
        left, right, bottom, top = scene.window
        wide, high = right - left, top - bottom
        self.scale = min(_LONGEST / max(wide, high), np.sqrt(_PIXELS / (wide * high)))
        width = max(int(wide * self.scale), _NARROWEST) + 2 * _MARGIN
        height = int(high * self.scale) + _HEADING + _MARGIN
        width, height = width + width % 2, height + height % 2  # video codecs want even sizes
        centre = width / 2 - self.scale * (left + right) / 2
        self.origin = np.array([centre, _HEADING + self.scale * top])
        self.scene = scene
        self.tone = scene.trajectory.static["layer"] % len(WOOD)
        self.colours = [rgb(colour) for colour in WOOD]
        # Small particles have faint edges: else these would hide the layers.
        seen = float(np.clip(scene.particle_size * self.scale / _WITH_EDGES, 0.0, 1.0)) ** 2
        dark = np.array(rgb(PARTICLE_EDGE))
        self.edges = [
            tuple((seen * dark + (1 - seen) * np.array(c)).tolist()) for c in self.colours
        ]
        self.font = font(17)
        self.background = np.full((height, width, 3), rgb(PAPER), dtype=np.uint8)
        name, right_edge = scene.headline.partition(":")[0], width - _MARGIN
        write_words(self.background, name, _MARGIN, 12, font(19, bold=True))
        write_words(self.background, pace(scene.time), right_edge, 14, font(14), right=True)
        self._draw_walls(self.background, scene.walls)

    def _draw_walls(self, image: Image, segments: NDArray[np.float64]) -> None:
        import cv2

        for wall in self._pixels(segments):
            cv2.polylines(image, [wall], False, rgb(WALL), 3, cv2.LINE_AA, _SHIFT)

    def _pixels(self, points: NDArray) -> NDArray[np.int32]:
        across = self.origin + self.scale * points * (1, -1)
        # Pixel k reaches from k to k + 1 here, from k - 1/2 to k + 1/2 in OpenCV.
        return np.rint((across - 0.5) * 2**_SHIFT).astype(np.int32)

    def draw(self, frame: int) -> Image:
        import cv2

        image = self.background.copy()
        for particles, outlines in self.scene.outlines(frame):
            for tone, outline in zip(self.tone[particles], self._pixels(outlines), strict=True):
                # Not antialiased, which would take twice the time: the outline covers its rim.
                cv2.fillConvexPoly(image, outline, self.colours[tone], cv2.LINE_8, _SHIFT)
                cv2.polylines(image, [outline], True, self.edges[tone], 1, cv2.LINE_AA, _SHIFT)
        self._draw_walls(image, self.scene.door(frame))
        n_out = self.scene.trajectory["n_out"][frame]
        words = f"{self.scene.time[frame]:.2f} s     {n_out} of {self.scene.in_all} out"
        write_words(image, words, _MARGIN, 40, self.font)
        return image
