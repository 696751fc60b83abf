"""Frames per second: what a person says, else what the film does."""

from calibration.tracking.film.reader import Film
from granulab.errors import InputError

# A second is what falls, swings and discharges last: it takes frames. Cameras reach a million.
_SLOWEST, _FASTEST = 1.0, 1e6


def said_rate(fps: float | None) -> float | None:
    """--fps, as it is; InputError where no camera has it."""
    if fps is not None and not _SLOWEST <= fps <= _FASTEST:
        raise InputError(
            f"--fps = {fps!r}: frames per second of the camera, from {_SLOWEST:g} to {_FASTEST:g}, "
            "such as 240"
        )
    return fps


def frame_rate(film: Film, fps: float | None) -> float:
    """Frames/s as said, else the file's own; InputError where neither is known."""
    rate = said_rate(fps) or film.rate
    if rate is None:
        raise InputError(f"{film.path}: no frame rate is known; say it: --fps 100")
    return rate
