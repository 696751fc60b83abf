"""The film of a run: every stored frame, 25 a second, in a format that browsers play."""

import tempfile
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from campaign.folder import write_atomic, writing
from silo2d.scene import GRAIN_EDGE, INK, PAPER, WALL, WOOD, Scene

Image = NDArray[np.uint8]  # (height, width, 3), red green blue

FPS = 25
_LONGEST, _PIXELS = 780, 430 * 780  # of the window in a picture
_NARROWEST = 420  # room for the heading
_HEADING, _MARGIN = 74, 16
_SHIFT = 4  # OpenCV takes corners in sixteenths of a pixel


def make_film(scene: Scene, folder: Path) -> Path:
    """Write film.mp4 into a folder; its path.

    H.264 where imageio-ffmpeg is installed (extra "pictures"), else VP9 where OpenCV can write
    it, else film.gif. Raises FolderError when it cannot be written.
    """
    with tempfile.TemporaryDirectory() as room, writing(folder):
        unfinished = Path(room) / "film.mp4"
        if not (_h264(unfinished, film_frames(scene)) or _vp9(unfinished, film_frames(scene))):
            unfinished = unfinished.with_suffix(".gif")
            _gif(unfinished, film_frames(scene))
        write_atomic(folder / unfinished.name, unfinished.read_bytes())
    return folder / unfinished.name


def film_frames(scene: Scene) -> Iterator[Image]:
    """One picture for each stored frame, all of one even size."""
    canvas = _Canvas(scene)
    for frame in range(len(scene.time)):
        yield canvas.draw(frame)


class _Canvas:
    """What is the same in all pictures of a film, and the scale [px/m]."""

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
        self.colours, self.edge = [_rgb(colour) for colour in WOOD], _rgb(GRAIN_EDGE)
        self.font = _font(17)
        self.background = np.full((height, width, 3), _rgb(PAPER), dtype=np.uint8)
        _write(self.background, scene.headline.partition(":")[0], _MARGIN, 12, _font(19, bold=True))
        pace, right_edge = _pace(scene.time), width - _MARGIN
        _write(self.background, pace, right_edge, 14, _font(14), right=True)
        self._draw_walls(self.background, scene.walls)

    def _draw_walls(self, image: Image, segments: NDArray[np.float64]) -> None:
        import cv2

        for wall in self._pixels(segments):
            cv2.polylines(image, [wall], False, _rgb(WALL), 3, cv2.LINE_AA, _SHIFT)

    def _pixels(self, points: NDArray) -> NDArray[np.int32]:
        across = self.origin + self.scale * points * (1, -1)
        # Pixel k reaches from k to k + 1 here, from k - 1/2 to k + 1/2 in OpenCV.
        return np.rint((across - 0.5) * 2**_SHIFT).astype(np.int32)

    def draw(self, frame: int) -> Image:
        import cv2

        image = self.background.copy()
        for grains, outlines in self.scene.outlines(frame):
            for tone, outline in zip(self.tone[grains], self._pixels(outlines), strict=True):
                # Not antialiased, which would take twice the time: the outline covers its rim.
                cv2.fillConvexPoly(image, outline, self.colours[tone], cv2.LINE_8, _SHIFT)
                cv2.polylines(image, [outline], True, self.edge, 1, cv2.LINE_AA, _SHIFT)
        self._draw_walls(image, self.scene.door(frame))
        n_out = self.scene.trajectory["n_out"][frame]
        words = f"{self.scene.time[frame]:.2f} s     {n_out} of {self.scene.n_grains} out"
        _write(image, words, _MARGIN, 40, self.font)
        return image


def _pace(time: NDArray[np.float64]) -> str:
    """How the film's time runs against that of the run."""
    if len(time) < 2:
        return ""
    factor = 1 / (FPS * float(np.median(np.diff(time))))
    if abs(factor - 1) < 0.05:
        return "real time"
    how = "slower" if factor > 1 else "faster"
    return f"{max(factor, 1 / factor):.3g}\N{MULTIPLICATION SIGN} {how}"


def _rgb(colour: str) -> tuple[int, int, int]:
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def _font(size: int, bold: bool = False):
    from matplotlib import get_data_path
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(get_data_path()) / "fonts" / "ttf" / name), size)


def _write(image: Image, words: str, x: int, y: int, font, right: bool = False) -> None:
    """Write words into a picture, with their upper left or right corner at (x, y) [px].

    Pillow draws them: OpenCV's own letters are strokes.
    """
    from PIL import Image as Picture
    from PIL import ImageDraw

    band = image[y : y + 2 * int(font.size)]
    picture = Picture.fromarray(band)
    ImageDraw.Draw(picture).text((x, 0), words, _rgb(INK), font, anchor="ra" if right else "la")
    band[:] = np.asarray(picture)


def _h264(path: Path, frames: Iterator[Image]) -> bool:
    """Whether H.264 could be written: imageio-ffmpeg is there, with an ffmpeg that can."""
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        return False
    first = next(frames)
    writer = imageio_ffmpeg.write_frames(
        str(path),
        (first.shape[1], first.shape[0]),
        fps=FPS,
        codec="libx264",
        quality=None,  # given below, finer
        macro_block_size=2,
        ffmpeg_log_level="quiet",
        # The index comes first, so that a browser plays while it loads.
        output_params=["-crf", "20", "-preset", "fast", "-movflags", "+faststart"],
    )
    writer.send(None)
    try:
        for image in chain([first], frames):
            writer.send(image)
    except OSError:  # the ffmpeg of a system may lack the encoder, and hangs up
        return False
    writer.close()
    return path.exists() and path.stat().st_size > 0


def _vp9(path: Path, frames: Iterator[Image]) -> bool:
    """Whether VP9 could be written: OpenCV was built with it."""
    import cv2

    first = next(frames)
    size = (first.shape[1], first.shape[0])
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(0)  # it would report a codec that it lacks on the console
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"vp09"), FPS, size)
    cv2.utils.logging.setLogLevel(level)
    if not writer.isOpened():
        return False
    writer.write(first[:, :, ::-1].copy())  # OpenCV's order is blue green red
    for image in frames:
        writer.write(image[:, :, ::-1].copy())
    writer.release()
    return True


def _gif(path: Path, frames: Iterator[Image]) -> None:
    from PIL import Image as Picture

    first, *rest = (Picture.fromarray(image).quantize(64) for image in frames)
    first.save(path, save_all=True, append_images=rest, duration=1000 // FPS, loop=0)
