"""Odd films, tracks and signals that are whole as files: still, empty, tiny, constant, or noise.

What a damaged file comes to is in mutations.py; here files can be read, and show no experiment.
"""

from collections.abc import Callable
from pathlib import Path
from random import Random

import cv2
import numpy as np

Array = np.ndarray

# Of a film (frames, height, width) of grey levels; t is the frame over the number of frames.
_SIZES = [(1, 1), (2, 2), (15, 17), (16, 16), (64, 48), (120, 90), (300, 8)]  # width, height
_LENGTHS = [1, 2, 5, 8, 20, 45]


def _spot(size: tuple[int, int], x: float, y: float, radius: float) -> Array:
    rows, columns = np.mgrid[: size[1], : size[0]]
    return np.clip(radius - np.hypot(columns - x, rows - y) + 0.5, 0, 1)


def _path(way: Callable[[float], tuple[float, float]]) -> Callable[..., Array]:
    """A dark disc on a light wall along a path in shares of the picture."""

    def pictures(random: np.random.Generator, count: int, size: tuple[int, int]) -> Array:
        width, height = size
        radius = max(min(size) / 10, 1)
        places = [way(k / count) for k in range(count)]
        return np.array([
            200 - 150 * _spot(size, x * width, y * height, radius) for x, y in places
        ]) + random.normal(0, 1, (count, height, width))  # fmt: skip

    return pictures


CONTENT: dict[str, Callable[..., Array]] = {
    "black": lambda r, n, s: np.zeros((n, s[1], s[0])),
    "white": lambda r, n, s: np.full((n, s[1], s[0]), 255.0),
    "noise": lambda r, n, s: r.uniform(0, 255, (n, s[1], s[0])),
    "still": lambda r, n, s: np.repeat(r.uniform(0, 255, (1, s[1], s[0])), n, axis=0),
    "flicker": lambda r, n, s: np.full((n, s[1], s[0]), 1.0) * r.choice([0, 255], (n, 1, 1)),
    "brightens": lambda r, n, s: np.ones((n, s[1], s[0])) * np.linspace(0, 255, n)[:, None, None],
    "one pixel": lambda r, n, s: 255.0 * (r.random((n, s[1], s[0])) < 1 / (s[0] * s[1])),
    "half changes": lambda r, n, s: 200.0 * (np.arange(n) > n / 2)[:, None, None]
    * np.ones((n, s[1], s[0])),
    "scrolls": lambda r, n, s: np.array(
        [np.roll(np.tile(np.arange(s[0]) * 7 % 256, (s[1], 1)), k, 1) for k in range(n)], float
    ),
    "falls": _path(lambda t: (0.5, 0.1 + t**2)),
    "bounces": _path(lambda t: (0.5, 0.9 - 3.0 * (t % 0.5) * (0.5 - t % 0.5))),
    "swings": _path(lambda t: (0.5 + 0.4 * np.cos(20 * t), 0.5)),
    "circles": _path(lambda t: (0.5 + 0.3 * np.cos(9 * t), 0.5 + 0.3 * np.sin(9 * t))),
    "jumps": _path(lambda t: (0.5 + 0.3 * np.cos(1e4 * t), 0.5 + 0.3 * np.sin(7e4 * t))),
    "stands": _path(lambda t: (0.5, 0.5)),
}  # fmt: skip
_CODECS = [("avi", "MJPG"), ("avi", "FFV1"), ("mp4", "mp4v"), ("avi", "XVID"), ("mkv", "FFV1")]


def odd_film(chance: Random) -> str:
    """Write a film or a folder of pictures; its name."""
    random = np.random.default_rng(chance.randrange(2**32))
    size, count = chance.choice(_SIZES), chance.choice(_LENGTHS)
    grey = CONTENT[chance.choice(list(CONTENT))](random, count, size)
    pictures = np.repeat(np.clip(grey, 0, 255)[..., None], 3, axis=3).astype(np.uint8)
    if chance.random() < 0.3:
        return _folder(pictures, chance)
    end, codec = chance.choice(_CODECS)
    rate = chance.choice([1.0, 25.0, 30.0, 240.0, 1000.0])
    writer = cv2.VideoWriter(f"odd.{end}", cv2.VideoWriter_fourcc(*codec), rate, size)
    for picture in pictures:
        writer.write(picture)
    writer.release()
    Path(f"odd.{end}").touch()
    return f"odd.{end}"


def _folder(pictures: Array, chance: Random) -> str:
    """A folder of pictures: with an alpha channel, of 16 bits, in grey, or of several sizes."""
    Path("odd").mkdir()
    how = chance.choice(["alpha", "16 bits", "grey", "sizes", "empty files", "plain"])
    for k, picture in enumerate(pictures):
        if how == "alpha":
            picture = np.dstack([picture, picture[..., :1] // 2])
        elif how == "16 bits":
            picture = picture.astype(np.uint16) * 257
        elif how == "grey":
            picture = picture[..., 0]
        elif how == "sizes" and k % 3 == 2:
            picture = picture[: max(len(picture) // 2, 1)]
        cv2.imwrite(f"odd/im{k}.png", picture)
        if how == "empty files" and k % 4 == 3:
            Path(f"odd/im{k}.png").write_bytes(b"")
    return "odd"


# Of n numbers; t counts from 0 in steps of 1.
SERIES: dict[str, Callable[[np.random.Generator, int], Array]] = {
    "zero": lambda r, n: np.zeros(n),
    "constant": lambda r, n: np.full(n, 3.7),
    "straight": lambda r, n: 2.0 * np.arange(n),
    "noise": lambda r, n: r.normal(0, 1, n),
    "walk": lambda r, n: np.cumsum(r.normal(0, 1, n)),
    "step": lambda r, n: 1.0 * (np.arange(n) > n / 2),
    "spike": lambda r, n: 1.0 * (np.arange(n) == n // 2),
    "alternates": lambda r, n: (-1.0) ** np.arange(n),
    "saw": lambda r, n: np.arange(n) % 7.0,
    "sine": lambda r, n: 50 * np.sin(0.21 * np.arange(n)),
    "parabola": lambda r, n: 0.3 * np.arange(n) ** 2.0,
    "bounces": lambda r, n: -np.abs(90 * np.sin(0.13 * np.arange(n)) * 0.99 ** np.arange(n)),
    "grows": lambda r, n: np.exp(np.minimum(0.2 * np.arange(n), 690)),
    "huge": lambda r, n: 1e300 * r.normal(0, 1, n),
    "tiny": lambda r, n: 1e-300 * r.normal(0, 1, n),
    "coarse": lambda r, n: np.round(3 * np.sin(0.1 * np.arange(n))),
    "gaps": lambda r, n: np.where(r.random(n) < 0.5, np.nan, np.arange(n)),
    "far off": lambda r, n: 1e15 + np.sin(np.arange(n)),
}
CLOCKS: dict[str, Callable[[np.random.Generator, int], Array]] = {
    "even": lambda r, n: 1e-3 * np.arange(n),
    "frames": lambda r, n: np.arange(n) * 1.0,
    "uneven": lambda r, n: np.cumsum(r.uniform(0.1, 2, n)),
    "backwards": lambda r, n: -np.arange(n) * 1.0,
    "stands": lambda r, n: np.zeros(n),
    "doubled": lambda r, n: np.arange(n) // 2 * 1.0,
    "huge": lambda r, n: 1e200 * np.arange(n),
    "tiny": lambda r, n: 1e-200 * np.arange(n),
    "late": lambda r, n: 1e12 + np.arange(n),
}


def odd_table(heads: list[str], chance: Random, lengths: list[int]) -> str:
    """A table of a clock and as many odd series as there are heads after the first."""
    random, count = np.random.default_rng(chance.randrange(2**32)), chance.choice(lengths)
    clock = "even" if chance.random() < 0.6 else chance.choice(list(CLOCKS))
    columns = [CLOCKS[clock](random, count)]
    columns += [SERIES[chance.choice(list(SERIES))](random, count) for _ in heads[1:]]
    rows = zip(*columns, strict=True)
    lines = [",".join("" if np.isnan(v) else f"{v:.9g}" for v in row) for row in rows]
    Path("odd.csv").write_text("\n".join([",".join(heads), *lines]) + "\n", encoding="utf-8")
    return "odd.csv"
