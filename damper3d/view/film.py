"""The film of a run: every stored frame of the particles, 25 a second."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from damper3d.view.colouring import colouring
from damper3d.view.scene import Scene
from damper3d.view.spheres import draw_spheres, outline, spheres_drawn, window
from granulab.campaign.output.figure import GREY, INK, PAPER, VERMILION, WALL
from granulab.campaign.output.film import Image, counted, font, pace, rgb, write_film, write_words

_LONGEST, _PIXELS = 640, 460 * 520  # of the part that shows the enclosure
_NARROWEST = 560  # for the words
_HEADING, _MARGIN, _STRIP, _SCALE = 72, 14, 92, 96
_CURVES = 0.7  # of the width, for the velocities; the rest is for their names
_SHIFT = 4  # OpenCV takes corners in sixteenths of a pixel
_SCALE_FRAMES = 60  # of which the scale of colours is made, at most


def make_film(
    scene: Scene,
    folder: Path,
    by: str = "velocity",
    cycles: int | None = None,
    report: Callable[[int], None] | None = None,
) -> Path:
    """Write the film into a folder; its path (see granulab.campaign.output.film.write_film).

    cycles: how many of the last are shown; all if left out. report: called with the number of
    pictures that are made.
    """
    return write_film(folder, lambda: counted(film_frames(scene, by, cycles), report))


def film_frames(scene: Scene, by: str = "velocity", cycles: int | None = None) -> Iterator[Image]:
    """One picture for each stored frame, of the last `cycles` or all, all of one even size.

    Raises InputError where `by` names no colouring.
    """
    canvas = _Canvas(scene, by)
    last = int(scene.frame_sample[-1])
    first = 0 if cycles is None else last - cycles * scene.samples_per_cycle
    for frame in range(len(scene.tables)):
        if scene.frame_sample[frame] >= first:
            yield canvas.draw(frame)


class _Canvas:
    """Parts that are the same in all pictures of a film."""

    def __init__(self, scene: Scene, by: str) -> None:
        self.scene, shown = scene, window(scene, 1.0)
        wide, high = shown.right - shown.left, shown.top - shown.bottom
        scale = min(_LONGEST / max(wide, high), np.sqrt(_PIXELS / (wide * high)))
        self.window, self.outline = window(scene, scale), outline(scene)
        rows, columns = self.window.shape
        width = max(columns + 2 * _MARGIN, _NARROWEST) + _SCALE
        height = _HEADING + rows + _MARGIN + _STRIP + _MARGIN
        width, height = width + width % 2, height + height % 2  # video codecs want even sizes
        self.left, self.top = (width - _SCALE - columns) // 2, _HEADING
        few = max(1, len(scene.tables) // _SCALE_FRAMES)
        self.colours = colouring(scene, by, list(range(0, len(scene.tables), few)))
        self.background = np.full((height, width, 3), rgb(PAPER), dtype=np.uint8)
        write_words(self.background, scene.title, _MARGIN, 12, font(15, bold=True))
        time = pace(scene.time[scene.frame_sample])
        write_words(self.background, time, width - _MARGIN, 42, font(14), right=True)
        self._draw_scale(width)
        self._draw_curves(width, height)

    def _draw_scale(self, width: int) -> None:
        """The colours and what they mean, on the right."""
        top, bottom = _HEADING + 52, _HEADING + min(self.window.shape[0], 300)
        x = width - _SCALE + 14
        name, _, unit = self.colours.label.rpartition("[")
        for k, words in enumerate(name.strip().split("\n")):
            small = font(12)
            write_words(self.background, words, width - _MARGIN, _HEADING + 15 * k, small, True)
        low, high = self.colours.scale.get_clim()
        parts = np.linspace(1.0, 0.0, bottom - top)
        tones = self.colours.scale.get_cmap()(parts)[:, None, :3]
        self.background[top:bottom, x : x + 12] = np.rint(255 * tones)
        write_words(self.background, f"{high:.2g}", x + 18, top - 4, font(12))
        write_words(self.background, f"{low:.2g}", x + 18, bottom - 12, font(12))
        write_words(self.background, f"[{unit}", x + 18, (top + bottom) // 2 - 6, font(12))

    def _draw_curves(self, width: int, height: int) -> None:
        """Velocities of enclosure and bed through the run, below; of which a part is shown."""
        self.strip = (_MARGIN, height - _MARGIN - _STRIP, width - 2 * _MARGIN, _STRIP)
        mean = self.scene.along(self.scene.trajectory["mean_velocity"])
        self.series = [(self.scene.trajectory["velocity"], INK, "enclosure"),
                       (mean, VERMILION, "bed, mean")]  # fmt: skip
        self.fastest = max(float(np.abs(series).max()) for series, _, _ in self.series)

    def draw(self, frame: int) -> Image:
        """The picture of a frame."""
        image, scene = self.background.copy(), self.scene
        red, green, blue = rgb(PAPER)
        paper = (red / 255, green / 255, blue / 255)
        centre, radius, whose = spheres_drawn(scene, frame)
        colours = self.colours.of(frame)[whose]
        spheres = draw_spheres(centre, radius, colours, self.window, paper)
        rows, columns = self.window.shape
        image[self.top : self.top + rows, self.left : self.left + columns] = spheres
        self._draw_enclosure(image, scene.view.project(scene.shift(frame))[:2])
        sample = int(scene.frame_sample[frame])
        part = sample / scene.samples_per_cycle
        words = f"cycle {int(part) + 1}, {part % 1:.2f} of it     {1e3 * scene.time[sample]:.2f} ms"
        write_words(image, words, _MARGIN, 40, font(16))
        self._draw_velocities(image, sample)
        return image

    def _draw_enclosure(self, image: Image, moved: NDArray[np.float64]) -> None:
        import cv2

        corner = np.array([self.left, self.top])
        for line in self.outline:
            points = self._fine(self.window.pixels(line + moved) + corner)
            cv2.polylines(image, [points], False, rgb(WALL), 2, cv2.LINE_AA, _SHIFT)

    @staticmethod
    def _fine(points: NDArray[np.float64]) -> NDArray[np.int32]:
        # Pixel k reaches from k to k + 1 here, from k - 1/2 to k + 1/2 in OpenCV.
        return np.rint((points - 0.5) * 2**_SHIFT).astype(np.int32)

    def _draw_velocities(self, image: Image, sample: int) -> None:
        """Velocities of the cycle before this sample and of it, up to now; a dot where they are."""
        import cv2

        left, top, wide, high = self.strip
        per = self.scene.samples_per_cycle
        shown = np.arange(max(sample - 2 * per, 0), sample + 1)
        x = left + _CURVES * wide * (1 + (shown - sample) / (2 * per))
        middle = top + high / 2
        rest = self._fine(np.array([[left, middle], [left + wide, middle]]))
        cv2.polylines(image, [rest], False, rgb(GREY), 1, cv2.LINE_AA, _SHIFT)
        for row, (series, colour, name) in enumerate(self.series):
            y = middle - 0.47 * high * series[shown] / self.fastest
            points = self._fine(np.stack([x, y], axis=1))
            cv2.polylines(image, [points], False, rgb(colour), 2, cv2.LINE_AA, _SHIFT)
            dot = tuple(int(v) for v in points[-1])
            cv2.circle(image, dot, 4 << _SHIFT, rgb(colour), -1, cv2.LINE_AA, _SHIFT)
            words = f"{name}: {series[sample]:+.2f} m/s"
            at = left + int(_CURVES * wide) + 34, top + (4 if row == 0 else high - 20)
            write_words(image, words, *at, font(12))
            cv2.line(image, (at[0] - 18, at[1] + 8), (at[0] - 6, at[1] + 8),
                     rgb(colour), 2, cv2.LINE_AA)  # fmt: skip
