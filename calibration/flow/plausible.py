"""What every silo that empties does, and a ball, a pendulum or a camera that moves does not.

Material stands above the outlet before the opening; it only leaves, and by the outlet; and what is
near the outlet falls before what is far from it.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from contact.quantity import InputError

Floats = NDArray[np.float64]

# Of plane grains the area that is seen is their mass, and does not grow; shadows and grains that
# tilt change it by a hundredth or two.
_AGAIN = 0.05
# By how much falls differ, over their mean, when a twentieth has left: 0 for a thing that falls as
# one, 1 where they go with the height down to none (in rendered discharges 0.7 to 1.4).
_ALIKE = 0.25
LEFT = 0.05
_MOST = 0.5  # of what stands above the outlet, and of what leaves, for it to be so on the whole
_ELSE = "is it a silo from before its opening on, and --roi its inside from the outlet up?"


def check_begins_filled(path: Path, seen: int, wanted: float) -> None:
    """Tracers that are above the outlet, and how many there would be if all were grains."""
    if seen < _MOST * wanted:
        raise InputError(f"{path}: no material stands above the outlet in the first frame; {_ELSE}")


class OnlyLeaves:
    """What remains, frame by frame, of which nothing comes back."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._first: float | None = None
        self._least = np.inf

    def see(self, remains: float) -> None:
        """What remains, in any unit; InputError where it has grown again."""
        if self._first is None:
            self._first = remains
        self._least = min(self._least, remains)
        if (again := (remains - self._least) / max(self._first, 1e-12)) > _AGAIN:
            raise InputError(
                f"{self._path}: {again:.0%} of the material comes back after it left: what moves "
                f"is no discharge; {_ELSE}"
            )


def check_deforms(path: Path, falls: Floats) -> None:
    """Falls (n,) of all tracers when a share LEFT of them is below the outlet."""
    if falls.std() < _ALIKE * abs(falls.mean()):
        raise InputError(f"{path}: all of it falls alike: a thing, no material; {_ELSE}")


def check_left_by_outlet(path: Path, across: Floats, ends: tuple[float, float]) -> None:
    """Columns (n,) of tracers below the outlet, and the outlet's ends, a grain wider [px]."""
    by_it = np.mean((across > ends[0]) & (across < ends[1])) if len(across) else 1.0
    if by_it < _MOST:
        raise InputError(
            f"{path}: {1 - by_it:.0%} of what leaves does not go through the outlet: what moves is "
            f"no discharge; {_ELSE}"
        )
