"""Options of commands that read films: a part of the picture, and a place in it."""

from contact.quantity import InputError


def region(text: str | None) -> tuple[int, int, int, int] | None:
    """--roi "x,y,w,h" as whole numbers of pixels."""
    found = _numbers("--roi", text, "x,y,width,height", "0,100,640,380")
    if found is None:
        return None
    x, y, width, height = (round(value) for value in found)
    return x, y, width, height


def place(text: str | None) -> tuple[float, float, float] | None:
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
