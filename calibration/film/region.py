"""The part of the picture to look at."""

from typing import NamedTuple

from calibration.film.reader import Film
from contact.quantity import InputError


class Region(NamedTuple):
    """Part of the picture [px]."""

    x: int
    y: int
    width: int
    height: int


def inside(film: Film, roi: Region | tuple[int, int, int, int] | None) -> Region:
    """The region, checked to lie in the picture and to have a size."""
    if roi is None:
        return Region(0, 0, film.width, film.height)
    one = Region(*roi)
    if one.x < 0 or one.y < 0 or one.width < 16 or one.height < 16 or (
        one.x + one.width > film.width or one.y + one.height > film.height
    ):  # fmt: skip
        raise InputError(
            f"--roi {','.join(map(str, one))}: x,y,width,height, 16 px and more, within "
            f"{film.width} x {film.height} px"
        )
    return one
