"""The part of the picture to look at."""

from typing import NamedTuple

from calibration.tracking.film.reader import Film
from granulab.errors import InputError


class Region(NamedTuple):
    """Part of the picture [px]."""

    x: int
    y: int
    width: int
    height: int


def inside(
    film: Film, roi: Region | tuple[int, int, int, int] | None, smallest: int = 16
) -> Region:
    """The region, or the whole picture; InputError where it is not in it or too small [px]."""
    if roi is None:
        return Region(0, 0, film.width, film.height)
    one = Region(*roi)
    within = one.x + one.width <= film.width and one.y + one.height <= film.height
    if min(one.x, one.y) < 0 or min(one.width, one.height) < smallest or not within:
        raise InputError(
            f"--roi {','.join(map(str, one))}: x,y,width,height, {smallest} px and more, within "
            f"the picture of {film.width} x {film.height} px"
        )
    return one
