"""Options of commands that read films: the camera's rate, a part of the picture, a position."""

from collections.abc import Callable
from typing import Any

import click

from granulab.errors import InputError

Box = tuple[int, int, int, int]  # x, y, width, height [px]


def fps_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """--fps, checked by who uses it (calibration.tracking.film.reader)."""
    words = "Frames per second of the camera."
    return click.option("--fps", type=float, metavar="240", help=words)(command)


def roi_option(words: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """--roi "x,y,w,h" as four whole numbers of pixels; the film checks whether they lie in it."""

    def parsed(
        _context: click.Context, _option: click.Parameter, text: str | None
    ) -> tuple[int, ...] | None:
        found = _numbers("--roi", text, "x,y,width,height", "0,100,640,380")
        return None if found is None else tuple(round(value) for value in found)

    return click.option("--roi", metavar="x,y,w,h", callback=parsed, help=words)


def position(text: str | None) -> tuple[float, float, float] | None:
    """--at "frame,x,y" as numbers."""
    found = _numbers("--at", text, "frame,x,y", "52,430,118")
    return None if found is None else (found[0], found[1], found[2])


def _numbers(option: str, text: str | None, names: str, example: str) -> list[float] | None:
    if text is None:
        return None
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        found = []
    if len(found) != names.count(",") + 1 or not all(abs(value) < 1e9 for value in found):
        raise InputError(f"{option} = {text!r}: {names} in pixels, such as {example}")
    return found
