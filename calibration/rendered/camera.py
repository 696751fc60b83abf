"""Camera that films a scene: lens blur, uneven light, noise; and the file that it writes.

A scene is painted as light in [0, 1], (height, width, 3), blue, green, red, without gamma.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.film.reader import Picture

Light = NDArray[np.float32]
Paint = Callable[[float], Light]  # time [s] -> the scene at that time


@dataclass(frozen=True)
class Camera:
    """rate      frames/s
    exposure   share of the frame interval for which the shutter is open; the blur of motion
    blur       standard deviation of the lens' blur [px]
    noise      standard deviation of a pixel's noise [grey levels of 255]
    falloff    light that the corners lack [share]
    moments    times within the exposure that are averaged
    """

    rate: float
    exposure: float = 0.2
    blur: float = 0.7
    noise: float = 2.0
    falloff: float = 0.2
    moments: int = 5

    def film(self, paint: Paint, times: Iterable[float], seed: int) -> Iterator[Picture]:
        """Pictures of a scene at these times, the middle of each exposure [s]."""
        random = np.random.default_rng(seed)
        for time in times:
            yield self.picture(paint, time, random)

    def picture(self, paint: Paint, time: float, random: np.random.Generator) -> Picture:
        """One picture, its exposure about `time` [s]."""
        import cv2

        inner = (np.arange(self.moments) + 0.5) / self.moments - 0.5
        seen = sum(paint(time + s * self.exposure / self.rate) for s in inner)
        light = np.asarray(seen / self.moments, dtype=np.float32)
        if self.blur > 0:
            light = np.asarray(cv2.GaussianBlur(light, (0, 0), self.blur), dtype=np.float32)
        grey = 255 * light * _light(light.shape[0], light.shape[1], self.falloff)
        grey += self.noise * random.standard_normal(grey.shape, dtype=np.float32)
        return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


@lru_cache(maxsize=2)
def _light(height: int, width: int, falloff: float) -> Light:
    """(height, width, 1) light against the position: a parabola, 1 - falloff in the corners."""
    y, x = np.linspace(-1, 1, height), np.linspace(-1, 1, width)
    light = 1 - falloff * (x[None, :, None] ** 2 + y[:, None, None] ** 2) / 2
    return light.astype(np.float32)


def write_film(pictures: Iterable[Picture], path: Path, rate: float, codec: str = "mp4v") -> Path:
    """Pictures into a file of FFmpeg's codec of four letters (mp4v, MJPG, FFV1, ...)."""
    import cv2

    writer = None
    try:
        for picture in pictures:
            if writer is None:
                size = (picture.shape[1], picture.shape[0])
                writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), rate, size)
            writer.write(picture)
    finally:
        if writer is not None:
            writer.release()
    return path
