"""Curves of a drawing: straight and cubic pieces as polylines, joined where their ends meet."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granulab.contact.files.units import nearest, to_si
from granulab.errors import InputError

Points = NDArray[np.float64]
# Control points, of a straight piece (2, 2) or a cubic Bezier (4, 2).
Piece = NDArray[np.float64]

FLATNESS = 5e-4  # largest distance of a curve from its polyline, over the curve's extent
_MEETING = 1e-4  # distance of ends that meet, over the drawing's extent
MOST_BYTES = 2**25
MOST_CURVES = 5000


@dataclass(frozen=True, eq=False)
class Curve:
    """A polyline in the drawing's own unit, y upwards; names: of its layer, or of its groups."""

    points: Points  # (n, 2); the first is not repeated at the end of a closed one
    closed: bool
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Drawing:
    """Content of a drawing.

    unit      its unit [m], or None where the file does not say
    unread    what draws lines and was left out: its kind, and its names as of a curve
    """

    curves: list[Curve]
    unit: float | None
    unread: list[tuple[str, tuple[str, ...]]] = field(default_factory=list)


def read_drawing(path: str | Path, unit: str | None = None, layer: str | None = None) -> Drawing:
    """The curves of an SVG or DXF file, with a unit [m] for certain.

    unit    of the drawing ("mm"), in place of what the file says
    layer   its curves alone, by the name of a layer (DXF), or of an element or group (SVG)

    Raises InputError, one line that begins with the file, for another kind of file, one that holds
    no curve or one that is not read, or one without a unit where none is given.
    """
    from silo2d.drawings import dxf, svg

    text = _text(Path(path))
    if text.lstrip("\ufeff \t\r\n").startswith("<"):
        drawing = svg.read(text, str(path))
    elif dxf.looks_like_it(text):
        drawing = dxf.read(text, str(path))
    else:
        raise InputError(f"{path}: neither SVG nor DXF; export the drawing as one of them")
    if layer is not None:
        drawing = _of_layer(drawing, layer, path)
    if drawing.unread:
        kinds = Counter(kind for kind, _ in drawing.unread)
        left = ", ".join(f"{number} {kind}" for kind, number in kinds.items())
        raise InputError(
            f"{path}: holds {left}, not read as a curve; convert to polylines or paths, or name a "
            "layer without such"
        )
    if not drawing.curves:
        raise InputError(f"{path}: holds no curve; draw lines, arcs or polylines")
    if len(drawing.curves) > MOST_CURVES:
        raise InputError(f"{path}: more than {MOST_CURVES} curves; leave the outline alone in it")
    if unit is not None:
        return replace(drawing, unit=to_si(f"1 {unit}", "m", f"{path}: unit"))
    if drawing.unit is None:
        raise InputError(f"{path}: does not say its unit of length; give it, such as --unit mm")
    return drawing


def _of_layer(drawing: Drawing, layer: str, path: str | Path) -> Drawing:
    """A drawing of what is named by a layer alone; InputError where nothing is."""
    everything = [*(one.names for one in drawing.curves), *(names for _, names in drawing.unread)]
    known = dict.fromkeys(name for names in everything for name in names)
    if layer not in known:
        raise InputError(f"{path}: no layer {layer!r}; {nearest(layer, known)}")
    return Drawing(
        [curve for curve in drawing.curves if layer in curve.names],
        drawing.unit,
        [one for one in drawing.unread if layer in one[1]],
    )


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InputError(f"{path}: larger than {MOST_BYTES >> 20} MB; simplify the drawing")
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give an SVG or DXF") from None
    if content.startswith(b"AutoCAD Binary DXF"):
        raise InputError(f"{path}: a binary DXF; save it as an ASCII DXF")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        if b"\0" in content:
            raise InputError(f"{path}: not text; give an SVG or an ASCII DXF") from None
        return content.decode("cp1252", errors="replace")  # of a DXF before 2007


def line(start: Sequence[float] | Points, end: Sequence[float] | Points) -> Piece:
    """A straight piece."""
    return np.array([start, end], dtype=float)


def arc(centre: Sequence[float], axes: Points, start: float, sweep: float) -> list[Piece]:
    """Cubic pieces of an arc centre + axes (cos t, sin t), t from `start` by `sweep` [rad].

    axes: (2, 2), its columns the half axes. Each piece covers at most an eighth of a turn, where
    the cubic with handles (4/3) tan(sweep/4) is within 4e-6 of the radius.
    """
    n = max(1, math.ceil(abs(sweep) / (math.pi / 4) - 1e-9))
    step = sweep / n
    handle = 4 / 3 * math.tan(step / 4)
    pieces = []
    for k in range(n):
        a, b = start + k * step, start + (k + 1) * step
        at_a, at_b = np.array([math.cos(a), math.sin(a)]), np.array([math.cos(b), math.sin(b)])
        along_a, along_b = np.array([-at_a[1], at_a[0]]), np.array([-at_b[1], at_b[0]])
        unit = np.array([at_a, at_a + handle * along_a, at_b - handle * along_b, at_b])
        pieces.append(np.asarray(centre, dtype=float) + unit @ axes.T)
    return pieces


def polyline(pieces: Sequence[Piece]) -> Points:
    """Points (n, 2) of pieces that follow each other, both ends included.

    A cubic with second differences of its control points of at most M is within (6/8) M/n^2 of n
    chords.
    """
    extent = np.ptp(np.concatenate(list(pieces)), axis=0).max()
    points = [pieces[0][:1]]
    for piece in pieces:
        if len(piece) == 2:
            points.append(piece[1:])
            continue
        bend = np.hypot(*np.diff(piece, n=2, axis=0).T).max()
        n = math.ceil(math.sqrt(0.75 * bend / (FLATNESS * extent))) if bend else 1
        t = np.linspace(0, 1, n + 1)[1:, None]
        a, b, c, d = piece
        points.append(
            a * (1 - t) ** 3 + 3 * b * t * (1 - t) ** 2 + 3 * c * t**2 * (1 - t) + d * t**3
        )
    return np.concatenate(points)


def curve(pieces: Sequence[Piece], closed: bool, names: tuple[str, ...] = ()) -> Curve | None:
    """A curve of pieces, closed also where its ends meet; None where it has no extent."""
    points = polyline(pieces)
    extent = np.ptp(points, axis=0).max()
    if not extent > 0:
        return None
    apart = np.hypot(*np.diff(points, axis=0).T) > 1e-9 * extent
    points = points[np.concatenate([[True], apart])]
    if np.hypot(*(points[0] - points[-1])) <= 1e-6 * extent and len(points) > 2:
        points, closed = points[:-1], True
    return Curve(points, closed, names)


def joined(drawing: Drawing, where: str) -> list[Curve]:
    """The curves of a drawing, open ones that share their ends made one.

    Raises InputError where three ends meet: nobody knows which of them go on.
    """
    done = [one for one in drawing.curves if one.closed]
    left = [one for one in drawing.curves if not one.closed]
    everything = np.concatenate([one.points for one in drawing.curves])
    near = _MEETING * np.ptp(everything, axis=0).max()
    ends = np.array([one.points[k] for one in left for k in (0, -1)]).reshape(-1, 2)
    for end in ends:
        if np.count_nonzero(np.hypot(*(ends - end).T) <= near) > 2:
            x, y = end
            raise InputError(f"{where}: three lines end at ({x:.6g}, {y:.6g}); leave two of them")
    while left:
        chain = left.pop().points
        grown = True
        while grown and np.hypot(*(chain[0] - chain[-1])) > near:
            grown = False
            for k, other in enumerate(left):
                if (longer := _appended(chain, other.points, near)) is not None:
                    chain, grown = longer, True
                    del left[k]
                    break
        closed = len(chain) > 2 and bool(np.hypot(*(chain[0] - chain[-1])) <= near)
        done.append(Curve(chain[:-1] if closed else chain, closed))
    return done


def _appended(chain: Points, other: Points, near: float) -> Points | None:
    """Two polylines as one, where an end of one is near an end of the other."""
    for first in (chain, chain[::-1]):
        for second in (other, other[::-1]):
            if np.hypot(*(first[-1] - second[0])) <= near:
                return np.concatenate([first, second[1:]])
    return None


def signed_area(points: Points) -> float:
    """Area of a polygon (n, 2), positive where it is counter-clockwise."""
    x, y = points.T
    return 0.5 * float(x @ np.roll(y, -1) - np.roll(x, -1) @ y)
