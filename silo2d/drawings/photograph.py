"""Particles in a photograph: their contours by OpenCV, and the scale by a bar of known length."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from granulab.errors import InputError
from silo2d.case.shape import Points
from silo2d.drawings.curves import signed_area

ENDINGS = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp")
_MOST_BYTES, _MOST_PIXELS = 2**26, 10**8  # pixels of the interpolated picture too
_SPECK = 0.05  # area of what is no particle, over the median area
_STEPS = 0.15  # [px] of the staircase that pixels make of a border, at most
_LEAST = 20.0  # area of a particle [px2]
_SLENDER = 6.0  # length over width of a bar
_FULL = 0.8  # part of its rectangle that a bar fills
_MOST_PARTICLES = 2000

Bar = tuple[float, float, float, float]  # x, y of both ends [px], y down


@dataclass(frozen=True, eq=False)
class Photographed:
    """Particles of a photograph.

    outlines   their contours [m], y upwards, origin at the picture's lower left corner
    scale      [m/px]
    bar        ends of the scale bar [px], or None where the scale was given
    left_out   contours that touch the border or are specks
    size       width and height of the picture [px]
    """

    outlines: list[Points]
    scale: float
    bar: Bar | None
    left_out: int
    size: tuple[int, int]


def read_photograph(
    path: str | Path,
    *,
    scale: float | None = None,
    bar_length: float | None = None,
    bar: Bar | None = None,
) -> Photographed:
    """The particles of a picture that stand out from an even background.

    scale        [m/px]; or else
    bar_length   of a straight bar in the picture [m]
    bar          its ends [px], also with a scale: it is no particle; left out, it is the longest
                 slender rectangle that there is

    Raises InputError, one line that begins with the file, where it is no picture, has no bar, or
    shows no particle.
    """
    if scale is not None and bar_length is not None:
        raise InputError(f"{path}: a scale and the length of a bar; leave one of them out")
    if bar is not None and not math.dist(bar[:2], bar[2:]) > 1:
        raise InputError(f"{path}: the ends of the bar are the same; give both")
    grey = _grey(Path(path))
    contours = _contours(grey)
    found = bar
    if scale is None:
        if bar_length is None:
            raise InputError(f"{path}: no scale; give it, or the length of a bar in the picture")
        found = bar or _longest_bar(contours)
        if found is None:
            raise InputError(
                f"{path}: no scale bar found (a slender rectangle, {_SLENDER:g} times as long as "
                "wide); give its two ends, or the scale"
            )
        scale = bar_length / math.dist(found[:2], found[2:])
    particles, left_out = _particles(contours, grey.shape, found)
    if not particles:
        raise InputError(
            f"{path}: no particle stands out from the background; photograph them apart from each "
            "other, on an even background of another brightness"
        )
    if len(particles) > _MOST_PARTICLES:
        raise InputError(f"{path}: more than {_MOST_PARTICLES} particles; take a part of it")
    height, width = grey.shape
    up = [scale * (contour * [1.0, -1.0] + [0.0, height]) for contour in particles]
    return Photographed(up, scale, found, left_out, (width, height))


def _grey(path: Path) -> np.ndarray:
    """The picture in grey."""
    import cv2

    try:
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(f"{path}: larger than {_MOST_BYTES >> 20} MB; make it smaller")
        content = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give a picture") from None
    try:
        picture = cv2.imdecode(content, cv2.IMREAD_GRAYSCALE) if len(content) else None
    except cv2.error:
        picture = None
    if picture is None:
        raise InputError(f"{path}: not a picture that can be read; give a PNG or JPEG")
    if picture.size > _MOST_PIXELS:
        raise InputError(
            f"{path}: more than {_MOST_PIXELS // 10**6} million pixels; make it smaller"
        )
    return picture


def _contours(grey: np.ndarray) -> list[Points]:
    """Outer contours (n, 2) [px] of all that differs from the background, by Otsu's threshold.

    OpenCV's run through the centres of the outermost pixels, and are moved out by half a pixel; in
    a picture that is interpolated to finer ones, so that a border is known to a part of one.
    """
    import cv2
    from shapely import Polygon

    finer = next(k for k in (4, 2, 1) if k * k * grey.size <= _MOST_PIXELS or k == 1)
    smooth = cv2.GaussianBlur(grey, (3, 3), 0)
    fine = cv2.resize(smooth, None, fx=finer, fy=finer, interpolation=cv2.INTER_LINEAR)
    level, bright = cv2.threshold(fine, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    border = np.concatenate([fine[0], fine[-1], fine[:, 0], fine[:, -1]])
    if np.median(border) > level:
        bright = cv2.bitwise_not(bright)
    found, _ = cv2.findContours(bright, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    contours = []
    for contour in found:
        if cv2.contourArea(contour) >= _LEAST * finer**2:
            wider = Polygon(contour[:, 0].astype(float)).buffer(0.5, join_style="mitre")
            even = wider.simplify(_STEPS * finer)
            if even.geom_type == "Polygon":
                contours.append((np.array(even.exterior.coords)[:-1] + 0.5) / finer)
    return contours


def _longest_bar(contours: list[Points]) -> Bar | None:
    """Ends of the longest slender rectangle among the contours."""
    best: tuple[float, Bar] | None = None
    for contour in contours:
        centre, (width, height), angle = _rectangle(contour)
        length, across = max(width, height), min(width, height)
        if across <= 0 or length < _SLENDER * across:
            continue
        if abs(signed_area(contour)) < _FULL * width * height or (best and best[0] >= length):
            continue
        along = math.radians(angle if width >= height else angle + 90)
        dx, dy = length / 2 * math.cos(along), length / 2 * math.sin(along)
        ends = (centre[0] - dx, centre[1] - dy, centre[0] + dx, centre[1] + dy)
        best = length, ends
    return best[1] if best else None


def _rectangle(contour: Points) -> Any:
    import cv2

    return cv2.minAreaRect(contour.astype(np.float32))


def _particles(
    contours: list[Points], shape: tuple[int, ...], bar: Bar | None
) -> tuple[list[Points], int]:
    """The contours that are whole particles, row by row; and how many are left out.

    What lies under the bar's ends is the bar.
    """
    from shapely import LineString, Polygon

    height, width = shape
    if bar is not None:
        line = LineString([bar[:2], bar[2:]])
        contours = [c for c in contours if Polygon(c).intersection(line).length < 0.5 * line.length]
    inside = [
        c for c in contours
        if c.min() > 1 and c[:, 0].max() < width - 1 and c[:, 1].max() < height - 1
    ]  # fmt: skip
    areas = [abs(signed_area(c)) for c in inside]
    least = _SPECK * float(np.median(areas)) if areas else 0.0
    whole = [c for c, area in zip(inside, areas, strict=True) if area >= least]
    whole.sort(key=lambda c: (round(c[:, 1].mean() / height * 20), c[:, 0].mean()))
    return whole, len(contours) - len(whole)
