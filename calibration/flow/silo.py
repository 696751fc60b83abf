"""Inside of the silo in the picture, and the axes and scale that follow from it.

x counts from the silo's left side, y from the outlet's level upwards, as silo2d measures.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.flow.survey import CLEAR, Survey, find_tones, to_grey
from calibration.statistics.quantity import measured_quantity, metres_per_pixel
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.film.reader import Film, inside
from granulab.contact.files.units import to_si
from granulab.errors import InputError

COLUMNS = 11  # two particles wide each in the paper's silo


@dataclass(frozen=True)
class Settings:
    """Options of a measurement; lengths as text with units, roi as x, y, width, height [px]."""

    fps: float | None = None
    scale: str | None = None
    width: str | None = None
    roi: tuple[int, int, int, int] | None = None
    interval: str | None = None
    columns: int = COLUMNS
    layer_height: str | None = None
    velocity: bool = True


Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Roi = tuple[int, int, int, int] | None

_SOME = 0.05  # of a side that must have changed for a row or column to be of the inside
_NARROWEST = 3  # px of a column, for particles of a pixel and a half
SMALLEST = 40  # px across, for a profile in a few columns of a few pixels' particles
_EDGE = 0.41  # px, of a found side: whole pixels, 1/sqrt(12), for the edge and for the limit each
_NEAR = 7  # px about an edge in which its whole change is found
_PLAIN = 0.5  # of the usual roughness of a row, below which it shows a door and not particles


@dataclass(frozen=True)
class Silo:
    """The inside of a silo in the picture, outlet to top [px], and m/px; scale 1 and px without.

    edge    px by which its sides are uncertain
    """

    left: float
    top: float
    width: float
    height: float
    edge: float
    scale: Estimate
    unit: str

    @property
    def outlet(self) -> float:
        """Row of the outlet's level [px]."""
        return self.top + self.height

    def metres(self, pixels: Floats) -> Floats:
        """Points (..., 2) of the picture [px] along the silo's axes [m, or px without a scale]."""
        return (pixels - (self.left, self.outlet)) * (1, -1) * self.scale.value

    def pixels(self, metres: Floats) -> Floats:
        """The inverse of metres."""
        return np.asarray(metres / self.scale.value * (1, -1) + (self.left, self.outlet))

    @property
    def box(self) -> tuple[slice, slice]:
        """Rows and columns of the inside in a picture."""
        top, left = max(round(self.top), 0), max(round(self.left), 0)
        return slice(top, round(self.outlet)), slice(left, round(self.left + self.width))


def check_options(film: Film, roi: Roi, scale: str | None, width: str | None) -> None:
    """Raise InputError, before the film is read, for what find_silo would refuse after it."""
    if scale is not None and width is not None:
        raise InputError("--scale and --width: give one; each gives the scale by itself")
    scale_of(scale, width, 1.0, 0.0)
    inside(film, roi, SMALLEST)


def check_columns(columns: int, pixels: float) -> None:
    """Raise InputError where so many columns across a silo are none, or too narrow."""
    if columns < 3 or columns % 2 == 0:
        raise InputError(f"--columns {columns}: an odd number, 3 at least")
    if pixels / columns < _NARROWEST:
        raise InputError(
            f"--columns {columns}: on {pixels:.0f} px each, two particles wide, would have "
            f"{pixels / columns:.2g} px; {_NARROWEST} px at least: take fewer"
        )


def layer_height(settings: Settings) -> float | None:
    """Height of the layers to draw [m]; InputError for one that is none, or without a scale."""
    if settings.layer_height is None:
        return None
    height = to_si(settings.layer_height, "m", "--layer-height")
    if not height > 0:
        raise InputError(f"--layer-height {settings.layer_height!r}: must be above 0")
    if settings.scale is None and settings.width is None:
        raise InputError("--layer-height: needs a scale: --scale '0.8 mm/px' or --width")
    return height


def find_silo(film: Film, seen: Survey, roi: Roi, scale: str | None, width: str | None) -> Silo:
    """The inside, given or found, and the scale, given or from the silo's inner width.

    Found: the part of the picture that differs between the first and the last frame.
    """
    check_options(film, roi, scale, width)
    said = None if roi is None else inside(film, roi, SMALLEST)
    x, y, w, h = said or _changed_box(seen)
    edge = _EDGE if said is None else 0.5  # px: whoever wrote whole pixels
    known, unit = scale_of(scale, width, w, edge)
    return Silo(x, y, w, h, edge, known, unit)


def scale_of(
    scale: str | None, width: str | None, pixels: float, edge: float
) -> tuple[Estimate, str]:
    """Metres a pixel, given or by the silo's width, whose sides are known to `edge` px; and unit.

    1 px without either.
    """
    if scale is not None:
        return Estimate(metres_per_pixel(scale), 0.0, 1), "m"
    if width is not None:
        known = measured_quantity(width, "m", "--width")
        if not known.value > 0:
            raise InputError(f"--width {width!r}: must be above 0; write such as '300 mm'")
        relative = np.hypot((known.sigma or 0.0) / known.value, np.sqrt(2) * edge / pixels)
        return Estimate(known.value / pixels, float(known.value / pixels * relative), 1), "m"
    return Estimate(1.0, 0.0, 1), "px"


def changes(seen: Survey, limit: float) -> tuple[NDArray[np.float32], Mask]:
    """Difference of each pixel's colour from the first to the last picture [grey levels].

    And where the mean of it over 3 x 3 pixels is above a limit.
    """
    import cv2

    apart = seen.last.astype(np.float32) - seen.first.astype(np.float32)
    size = np.sqrt(np.square(apart).sum(axis=2))
    return size, np.asarray(cv2.blur(size, (3, 3)) > limit)


def _changed_box(seen: Survey) -> tuple[float, float, float, float]:
    """Box of what differs by more than noise, and in it by half of the contrast."""
    rows, columns = _patch(seen, CLEAR * seen.noise * np.sqrt(2))[0]
    limit = find_tones(seen, (rows, columns)).limit(seen.noise)
    (rows, columns), there = _patch(seen, limit)
    x0, x1 = _ends(there.mean(axis=0) > _SOME)
    y0, y1 = _ends(there.mean(axis=1) > _SOME)
    left, top = columns.start + x0, rows.start + y0
    grey = to_grey(seen.first)[top : rows.start + y1, left : columns.start + x1]
    height = _without_door(grey, there[y0:y1, x0:x1])
    if min(x1 - x0, height) < SMALLEST:
        raise InputError(
            f"only {x1 - x0} x {height:.0f} px differ between the first and the last frame: "
            "nothing flows there; say where the silo is: --roi x,y,w,h"
        )
    return float(left), float(top), float(x1 - x0), height


def _patch(seen: Survey, limit: float) -> tuple[tuple[slice, slice], Mask]:
    """Rows and columns of the largest patch that changed, and its pixels in them."""
    import cv2

    apart, changed = changes(seen, limit)
    size = max(3, min(changed.shape) // 100)
    kernel = np.ones((size, size), np.uint8)
    closed = cv2.morphologyEx(changed.astype(np.uint8), cv2.MORPH_CLOSE, kernel)
    count, label, stats, _ = cv2.connectedComponentsWithStats(closed)
    if count < 2:
        raise InputError("nothing differs between the first and the last frame: nothing flows")
    biggest = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    left, top, w, h = (int(v) for v in stats[biggest, :4])
    part = slice(top, top + h), slice(left, left + w)
    # Blur smears an edge to both sides; it stands where half of the change is reached.
    half = apart > cv2.dilate(apart, np.ones((_NEAR, _NEAR), np.uint8)) / 2
    return part, np.asarray((label == biggest) & half)[part]


def _ends(holds: Mask) -> tuple[int, int]:
    where = np.flatnonzero(holds)
    return (int(where[0]), int(where[-1]) + 1) if len(where) else (0, 0)


def _without_door(grey: NDArray[np.uint8], there: Mask) -> float:
    """Rows down to where particles end: a door that is taken away is plain.

    Blur smears that edge: it stands midway between the roughness of particles and that of the door.
    A row of which hardly anything changed shows nothing: a codec's errors are rough, too.
    """
    steps = np.abs(np.diff(grey.astype(np.float32), axis=1))
    both = there[:, 1:] & there[:, :-1]
    count = both.sum(axis=1)
    rough = (steps * both).sum(axis=1) / np.maximum(count, 1)
    rough[count <= _SOME * both.shape[1]] = 0.0
    usual = float(np.median(rough))
    end = _ends(rough > _PLAIN * usual)[1]
    if end == len(rough):
        return float(end)
    middle = (usual + float(np.median(rough[end:]))) / 2
    rougher = np.flatnonzero(rough[:end] > middle)
    if not len(rougher):  # nothing is rough: no particles that a door could be told from
        return float(end)
    last = int(rougher[-1])
    # A row's value stands at its middle.
    part = (rough[last] - middle) / (rough[last] - rough[last + 1])
    return last + 0.5 + float(part)
