"""Objects of a rendered scene: a textured wall and plate, shaded discs, a hand."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.rendered.camera import Light

Colour = tuple[float, float, float]  # light of blue, green, red, in [0, 1]

_SKIN = (0.45, 0.55, 0.75)
_LAMP = np.array([-0.4, -0.6, 0.7])  # direction to it: to the left, above, before the scene
_AROUND = 0.5  # share of light that comes from all sides


class Patch(NamedTuple):
    """Something to blend in: its first row and column, its light, and its cover (rows, columns)."""

    row: int
    column: int
    light: Light
    cover: NDArray[np.float32]


@dataclass(frozen=True)
class Backdrop:
    """The wall behind, and the plate before it; texture is the spread of light about a colour.

    grain     size of the texture's spots [px]
    seed      of the texture
    """

    wall: Colour = (0.7, 0.68, 0.66)
    plate: Colour = (0.35, 0.4, 0.45)
    texture: float = 0.04
    grain: float = 5.0
    seed: int = 1

    def paint(
        self, width: int, height: int, edge: float, sunk: float, shift: tuple[float, float]
    ) -> Light:
        """The plate fills what is below y = edge + sunk; then all is shifted (x, y) [px]."""
        light = _scene(self, width, height, edge, sunk)
        return _shifted(light, *shift) if any(shift) else light.copy()


@lru_cache(maxsize=2)  # most scenes stand still
def _scene(look: Backdrop, width: int, height: int, edge: float, sunk: float) -> Light:
    wall = _textured(width, height, look.wall, look.texture, look.grain, 2 * look.seed)
    plate = _textured(width, height, look.plate, look.texture, look.grain / 2, 2 * look.seed + 1)
    if sunk:
        plate = _shifted(plate, 0, sunk)
    cover = np.clip(np.arange(height) + 0.5 - edge - sunk, 0, 1)[:, None, None]
    return np.asarray(wall + cover.astype(np.float32) * (plate - wall))


@lru_cache(maxsize=8)
def _textured(
    width: int, height: int, colour: Colour, spread: float, grain: float, seed: int
) -> Light:
    import cv2

    spots = np.random.default_rng(seed).standard_normal((height, width)).astype(np.float32)
    spots = np.asarray(cv2.GaussianBlur(spots, (0, 0), grain), dtype=np.float32)
    spots *= spread / spots.std()
    return np.clip(np.array(colour, dtype=np.float32) + spots[:, :, None], 0, 1)


def _shifted(light: Light, x: float, y: float) -> Light:
    import cv2

    matrix = np.array([[1, 0, x], [0, 1, y]], dtype=float)
    size = (light.shape[1], light.shape[0])
    return np.asarray(
        cv2.warpAffine(light, matrix, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
    )


def blend(light: Light, patch: Patch) -> None:
    """Put a patch over a scene, as far as it lies within."""
    rows, columns = patch.cover.shape
    top, left = max(-patch.row, 0), max(-patch.column, 0)
    bottom = min(rows, light.shape[0] - patch.row)
    right = min(columns, light.shape[1] - patch.column)
    if bottom <= top or right <= left:
        return
    under = light[patch.row + top : patch.row + bottom, patch.column + left : patch.column + right]
    cover = patch.cover[top:bottom, left:right, None]
    under += cover * (patch.light[top:bottom, left:right] - under)


def disc(
    x: float, y: float, radius: float, colour: Colour, texture: float = 0.0, rotation: float = 0.0
) -> Patch:
    """A ball: shaded by a lamp, with stripes of light that rotate with it [rad]."""
    dx, dy, row, column = _grid(x, y, radius)
    r = np.hypot(dx, dy)
    u, v = dx / radius, dy / radius
    bulge = np.sqrt(np.clip(1 - u**2 - v**2, 0, 1))
    lit = _AROUND + (1 - _AROUND) * np.clip(
        (_LAMP[0] * u + _LAMP[1] * v + _LAMP[2] * bulge) / np.linalg.norm(_LAMP), 0, 1
    )
    along = u * math.cos(rotation) + v * math.sin(rotation)
    lit *= 1 + texture * np.sin(4 * along)
    light = np.clip(lit[:, :, None] * np.array(colour), 0, 1).astype(np.float32)
    return Patch(row, column, light, np.clip(radius - r + 0.5, 0, 1).astype(np.float32))


def hand(x: float, y: float, radius: float) -> Patch:
    """A forearm as wide as 2 radii that comes from above and ends in a round fist at (x, y)."""
    dx, dy, row, column = _grid(x, y, radius, up=y + 2)
    r = np.hypot(dx, np.maximum(dy, 0))
    light = np.broadcast_to(np.array(_SKIN), (*r.shape, 3)).astype(np.float32)
    return Patch(row, column, light, np.clip(radius - r + 0.5, 0, 1).astype(np.float32))


def _grid(
    x: float, y: float, radius: float, up: float | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64], int, int]:
    """dx, dy of the pixels around a position from it, and the first row and column of them."""
    reach = math.ceil(radius) + 2
    above = reach if up is None else max(math.ceil(up), reach)
    row, column = math.floor(y) - above, math.floor(x) - reach
    dy = np.arange(row, math.floor(y) + reach + 1) - y
    dx = np.arange(column, math.floor(x) + reach + 1) - x
    return dx[None, :] + 0 * dy[:, None], dy[:, None] + 0 * dx[None, :], row, column
