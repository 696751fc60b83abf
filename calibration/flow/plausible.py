"""What every silo that empties does, and a ball, a pendulum or a camera that moves does not.

Material stands above the outlet before the opening; it only leaves, and by the outlet; and what is
near the outlet falls before what is far from it.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granulab.errors import InputError

Floats = NDArray[np.float64]

# Of plane grains the area that is seen is their mass, and does not grow; shadows and grains that
# tilt change it by a hundredth or two.
_AGAIN = 0.05
# By how much falls differ, over their mean, when a twentieth has left: 0 for a thing that falls as
# one, 1 where they go with the height down to none (in rendered discharges 0.7 to 1.4).
_ALIKE, _LEFT = 0.25, 0.05
_MOST = 0.5  # of what stands above the outlet, and of what leaves, for it to be so on the whole
_ELSE = "is it a silo from before its opening on, and --roi its inside from the outlet up?"


class Plausible:
    """Looks at a film as it goes by; InputError, one line, for what no discharge does."""

    def __init__(self, path: Path, standing: int, wanted: float) -> None:
        """Tracers above the outlet, and how many there would be if all there were grains."""
        self._path = path
        if standing < _MOST * wanted:
            self._refuse("no material stands above the outlet in the first frame")
        self._first: float | None = None
        self._least = np.inf
        self._deforms = False  # as far as has been seen

    def see(self, area: float, share: float, falls: Floats) -> None:
        """Area of the material, NaN where unknown; tracers not yet below the outlet; all falls."""
        if np.isfinite(area):
            self._first = area if self._first is None else self._first
            self._least = min(self._least, area)
            again = (area - self._least) / max(self._first, 1.0)
            if again > _AGAIN:
                self._refuse(f"{again:.0%} of the material comes back after it left")
        if share < 1 - _LEFT and not self._deforms:
            if falls.std() < _ALIKE * abs(falls.mean()):
                self._refuse("all of it falls alike, as a thing and no material does")
            self._deforms = True

    def end(self, across: Floats, ends: tuple[float, float]) -> None:
        """Columns (n,) of tracers that have left, and the outlet's ends, a grain wider [px]."""
        by_it = np.mean((across > ends[0]) & (across < ends[1])) if len(across) else 1.0
        if by_it < _MOST:
            self._refuse(f"{1 - by_it:.0%} of what leaves does not go through the outlet")

    def _refuse(self, what: str) -> None:
        raise InputError(f"{self._path}: {what}: no discharge; {_ELSE}")
