"""Films: pictures one after the other, 25 a second, in a format that browsers play.

What is written into pictures, and how fast the film runs, is here too.
"""

import tempfile
from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import INK, write_figure
from granulab.campaign.output.files import write_atomic, writing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Image = NDArray[np.uint8]  # (height, width, 3), red green blue; both even, as codecs want it

FPS = 25
CHART = 20  # pictures of a film that are drawn while a chart is


def write_film(folder: Path, pictures: Callable[[], Iterator[Image]], name: str = "film") -> Path:
    """Write NAME.mp4 into a folder; its path. `pictures` gives all of them, on each call.

    H.264 where imageio-ffmpeg is installed (extra "pictures"), else VP9 where OpenCV can write
    it, else NAME.gif. Raises FolderError when it cannot be written.
    """
    with tempfile.TemporaryDirectory() as work, writing(folder):
        unfinished = Path(work) / "film.mp4"
        if not (_h264(unfinished, pictures()) or _vp9(unfinished, pictures())):
            unfinished = unfinished.with_suffix(".gif")
            _gif(unfinished, pictures())
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}{unfinished.suffix}"
        write_atomic(path, unfinished.read_bytes())
    return path


def played_by(path: Path) -> str:
    """Programs that play a film, and what makes one for all; none for H.264, which all play."""
    if path.suffix == ".gif":
        return "browsers and picture viewers play it"
    if b"avc1" in path.read_bytes():
        return ""
    return (
        "VP9: browsers and VLC play it, QuickTime and PowerPoint do not; H.264 comes with "
        "pip install imageio-ffmpeg"
    )


def write_all(
    folder: Path, figures: Mapping[str, Callable[[], "Figure"]], n_pictures: int,
    film: Callable[[Callable[[int], None]], Path], report: Callable[[int, int], None] | None,
) -> list[Path]:  # fmt: skip
    """Write figures as NAME.png into a folder, and a film of so many pictures; their paths.

    film    makes it, and is given what to call with the number of its pictures that are made; not
            called where it has none
    report  called with the pictures done and left, a chart counting as CHART of them
    """
    charts, paths = CHART * len(figures), []

    def reported(done: int) -> None:
        if report is not None:
            report(done, charts + n_pictures - done)

    for k, (name, draw) in enumerate(figures.items(), 1):
        paths.append(write_figure(folder / f"{name}.png", draw))
        reported(CHART * k)
    return [*paths, film(lambda k: reported(charts + k))] if n_pictures else paths


def counted(pictures: Iterator[Image], report: Callable[[int], None] | None) -> Iterator[Image]:
    """The pictures; report is called with the number of those that are made."""
    for k, picture in enumerate(pictures, 1):
        yield picture
        if report is not None:
            report(k)


def pace(time: NDArray[np.float64]) -> str:
    """Return how the film's time runs against that of frames at `time` [s]: "2.5x slower"."""
    if len(time) < 2:
        return ""
    factor = 1 / (FPS * float(np.median(np.diff(time))))
    if abs(factor - 1) < 0.05:
        return "real time"
    how = "slower" if factor > 1 else "faster"
    return f"{max(factor, 1 / factor):.3g}\N{MULTIPLICATION SIGN} {how}"


def rgb(colour: str) -> tuple[int, int, int]:
    """The parts 0 ... 255 of a colour such as "#0072b2"."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def font(size: int, bold: bool = False) -> Any:
    """DejaVu Sans, which comes with matplotlib, in a size [px]."""
    from matplotlib import get_data_path
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(get_data_path()) / "fonts" / "ttf" / name), size)


def write_words(image: Image, words: str, x: int, y: int, font: Any, right: bool = False) -> None:
    """Write words into a picture, with their upper left or right corner at (x, y) [px].

    Pillow draws them: OpenCV's own letters are strokes.
    """
    from PIL import Image as Picture
    from PIL import ImageDraw

    band = image[y : y + 2 * int(font.size)]
    picture = Picture.fromarray(band)
    ImageDraw.Draw(picture).text((x, 0), words, rgb(INK), font, anchor="ra" if right else "la")
    band[:] = np.asarray(picture)


def _h264(path: Path, frames: Iterator[Image]) -> bool:
    """Return whether H.264 could be written: imageio-ffmpeg is there, with an ffmpeg that can."""
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
    """Return whether VP9 could be written: OpenCV was built with it."""
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
