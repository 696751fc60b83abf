"""SVG files: paths and basic shapes with their transforms, as curves with y upwards."""

import math
import re
from collections.abc import Callable, Iterator
from xml.etree import ElementTree

import numpy as np

from granulab.contact.files.units import to_si
from granulab.errors import InputError
from silo2d.drawings.curves import Curve, Drawing, Piece, arc, curve, line

# Groups whose content is not drawn where it stands, and what draws curves that are not read.
_HIDDEN = {"defs", "symbol", "clipPath", "mask", "marker", "pattern"}
_UNREAD = {"use", "svg", "foreignObject"}
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_COMMAND = re.compile(r"([MmZzLlHhVvCcSsQqTtAa])([^MmZzLlHhVvCcSsQqTtAa]*)")
_COUNT = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7}
_SMOOTH = {"S": "CS", "T": "QT"}
_PER_INCH = 96  # of a CSS pixel, which is the unit of lengths without one
_SQUARE = 1.001  # scale across over that along: the rounding of sizes in a file
_EVEN = np.eye(3)


def read(text: str, where: str) -> Drawing:
    """The curves of an SVG document; where: the file, for refusals.

    Its unit is known where the document has a width with a unit of length, such as "210mm".
    """
    if "<!ENTITY" in text:
        raise InputError(f"{where}: defines entities, which no drawing needs; export it again")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f"{where}: not valid XML ({error}); export the drawing again") from None
    if _tag(root) != "svg":
        raise InputError(f"{where}: XML, but no SVG (it is {_tag(root)!r}); give an SVG or DXF")
    curves: list[Curve] = []
    unread: list[tuple[str, tuple[str, ...]]] = []
    upright = np.diag([1.0, -1.0, 1.0])
    for element, matrix, names in _drawn(root, upright, (), where):
        shape = _SHAPES.get(_tag(element))
        if shape is None:
            if _tag(element) in _UNREAD and element is not root:
                unread.append((_tag(element), names))
            continue
        for pieces, closed in shape(element, where):
            moved = [piece @ matrix[:2, :2].T + matrix[:2, 2] for piece in pieces]
            if not all(np.isfinite(piece).all() for piece in moved):
                raise InputError(f"{where}: a {_tag(element)} is not finite; export it again")
            if (found := curve(moved, closed, names)) is not None:
                curves.append(found)
    return Drawing(curves, _unit(root, where), unread)


def _unit(root: ElementTree.Element, where: str) -> float | None:
    """The user unit [m]: size over that of the view box, which keeps its form (SVG 1.1, 7.8)."""
    sizes = [_size(root, side, where) for side in ("width", "height")]
    if sizes == [None, None]:
        return None
    box = _numbers(root.get("viewBox", ""))
    if len(box) != 4:  # user units are CSS pixels
        return 0.0254 / _PER_INCH
    if not min(box[2], box[3], *(size for size in sizes if size is not None)) > 0:
        raise InputError(f"{where}: viewBox and width must be above 0; export the drawing again")
    units = [size / of for size, of in zip(sizes, box[2:], strict=True) if size is not None]
    fit = root.get("preserveAspectRatio", "")
    if fit.startswith("none") and max(units) > _SQUARE * min(units):
        raise InputError(
            f"{where}: width and height stretch the viewBox unequally; export the drawing again"
        )
    return max(units) if "slice" in fit else min(units)


def _size(root: ElementTree.Element, side: str, where: str) -> float | None:
    """Width or height of the document [m]; None where it has no unit of length."""
    found = re.fullmatch(rf"\s*({_NUMBER.pattern})\s*([a-zA-Z%]*)\s*", root.get(side, ""))
    if found is None or found[2] not in ("mm", "cm", "m", "in", "pt", "pc"):
        return None
    unit = {"pt": "in", "pc": "in"}.get(found[2], found[2])
    parts = {"pt": 72, "pc": 6}.get(found[2], 1)
    return to_si(f"1 {unit}", "m", f"{where}: {side}") / parts * float(found[1])


def _drawn(
    element: ElementTree.Element, matrix: np.ndarray, names: tuple[str, ...], where: str
) -> Iterator[tuple[ElementTree.Element, np.ndarray, tuple[str, ...]]]:
    """The elements that are drawn, each with its matrix and the names of itself and its groups."""
    style = _style(element)
    shown = element.attrib | style  # a style goes before an attribute
    hidden = shown.get("display") == "none" or shown.get("visibility") == "hidden"
    if _tag(element) in _HIDDEN or hidden:
        return
    if style.get("transform"):
        raise InputError(f"{where}: a transform within a style is not read; export plain paths")
    matrix = matrix @ _transform(element.get("transform", ""), where)
    own = [value for key, value in element.attrib.items() if key == "id" or key.endswith("}label")]
    names = (*names, *own)
    yield element, matrix, names
    for child in element:
        if isinstance(child.tag, str):  # no comment
            yield from _drawn(child, matrix, names, where)


def _style(element: ElementTree.Element) -> dict[str, str]:
    """The properties in an element's style; of one that stands twice the first."""
    parts = [part.partition(":") for part in element.get("style", "").split(";")]
    return {key.strip(): value.strip() for key, _, value in reversed(parts)}


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _numbers(text: str) -> list[float]:
    return [float(number) for number in _NUMBER.findall(text)]


def _transform(text: str, where: str) -> np.ndarray:
    """The matrix (3, 3) of a transform attribute."""
    matrix = _EVEN
    for name, inner, other in re.findall(r"(\w+)\s*\(([^)]*)\)|([^\s,])", text):
        try:
            matrix = matrix @ _TRANSFORMS[name](*map(float, inner.replace(",", " ").split()))
        except (KeyError, TypeError, ValueError):
            raise InputError(
                f"{where}: transform {other or f'{name}({inner})'} is not known; export plain paths"
            ) from None
    return matrix


def _affine(a: float, b: float, c: float, d: float, e: float, f: float) -> np.ndarray:
    return np.array([[a, c, e], [b, d, f], [0.0, 0.0, 1.0]])


def _rotate(degrees: float, x: float = 0.0, y: float = 0.0) -> np.ndarray:
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return _affine(cos, sin, -sin, cos, x - cos * x + sin * y, y - sin * x - cos * y)


_TRANSFORMS: dict[str, Callable[..., np.ndarray]] = {
    "matrix": _affine,
    "translate": lambda x, y=0.0: _affine(1, 0, 0, 1, x, y),
    "scale": lambda x, y=None: _affine(x, 0, 0, x if y is None else y, 0, 0),
    "rotate": _rotate,
    "skewX": lambda degrees: _affine(1, 0, math.tan(math.radians(degrees)), 1, 0, 0),
    "skewY": lambda degrees: _affine(1, math.tan(math.radians(degrees)), 0, 1, 0, 0),
}

Shape = Iterator[tuple[list[Piece], bool]]  # pieces, and whether they are closed


def _length(element: ElementTree.Element, name: str, where: str, usual: float = 0.0) -> float:
    """A length of a basic shape in user units."""
    text = element.get(name)
    if text is None:
        return usual
    found = re.fullmatch(rf"\s*({_NUMBER.pattern})\s*(px)?\s*", text)
    if found is None:
        raise InputError(
            f"{where}: {name} = {text!r} of a {_tag(element)}: lengths with units are not read "
            "within a drawing; export plain paths"
        )
    return float(found[1])


def _rectangle(element: ElementTree.Element, where: str) -> Shape:
    x, y, width, height = (_length(element, key, where) for key in ("x", "y", "width", "height"))
    rx, ry = (_length(element, key, where, math.nan) for key in ("rx", "ry"))
    rx, ry = (ry if math.isnan(rx) else rx), (rx if math.isnan(ry) else ry)
    rx, ry = min(rx, width / 2), min(ry, height / 2)
    if not (rx > 0 and ry > 0):
        corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
        yield [line(corners[k - 1], corners[k]) for k in range(4)], True
        return
    pieces: list[Piece] = []
    for k, (cx, cy) in enumerate(
        [(x + width - rx, y + ry), (x + width - rx, y + height - ry),
         (x + rx, y + height - ry), (x + rx, y + ry)]
    ):  # fmt: skip
        corner = arc((cx, cy), np.diag([rx, ry]), (k - 1) * math.pi / 2, math.pi / 2)
        if pieces:
            pieces.append(line(pieces[-1][-1], corner[0][0]))
        pieces += corner
    yield [*pieces, line(pieces[-1][-1], pieces[0][0])], True


def _ellipse(element: ElementTree.Element, where: str) -> Shape:
    r = _length(element, "r", where)
    rx, ry = (_length(element, key, where, r) for key in ("rx", "ry"))
    centre = _length(element, "cx", where), _length(element, "cy", where)
    yield arc(centre, np.diag([rx, ry]), 0.0, 2 * math.pi), True


def _straight(element: ElementTree.Element, where: str) -> Shape:
    ends = [[_length(element, f"{axis}{k}", where) for axis in "xy"] for k in (1, 2)]
    yield [line(*ends)], False


def _points(element: ElementTree.Element, where: str) -> Shape:
    numbers = _numbers(element.get("points", ""))
    corners = np.array(numbers[: len(numbers) // 2 * 2]).reshape(-1, 2)
    if len(corners) > 1:
        closed = _tag(element) == "polygon"
        pieces = [line(*corners[k : k + 2]) for k in range(len(corners) - 1)]
        yield pieces, closed


def _path(element: ElementTree.Element, where: str) -> Shape:
    """The sub-paths of a path: SVG 1.1, 8.3."""
    at, begin, handle, before = np.zeros(2), np.zeros(2), None, ""
    pieces: list[Piece] = []
    for command, numbers in _commands(element.get("d", ""), where):
        kind, origin = command.upper(), at if command.islower() else np.zeros(2)
        if kind in "MZ":
            if pieces:
                yield pieces, kind == "Z"
            pieces, before = [], kind
            at = begin = begin if kind == "Z" else origin + numbers
            continue
        if kind == "A":
            new = _elliptical(at, numbers[:5], origin + numbers[5:])
        else:
            smooth = _SMOOTH.get(kind, "")  # mirrors the handle of a curve of its own degree
            new, handle = _piece(kind, at, numbers, origin, handle if before in smooth else None)
        before = kind
        pieces += new
        at = new[-1][-1] if new else at
    if pieces:
        yield pieces, False


def _commands(text: str, where: str) -> Iterator[tuple[str, np.ndarray]]:
    """Commands of a path with the numbers that each takes, repeated ones taken apart."""
    for command, inner in _COMMAND.findall(text):
        kind = command.upper()
        if kind == "Z":
            yield command, np.zeros(0)
            continue
        numbers = _flagged(inner) if kind == "A" else _numbers(inner)
        count = _COUNT[kind]
        if not numbers or len(numbers) % count or re.search(r"[^\d\s.,eE+-]", inner):
            raise InputError(f"{where}: path command {command}{inner.strip()[:30]}: damaged")
        for k in range(0, len(numbers), count):
            if k and kind == "M":  # further pairs are lines
                command = "l" if command == "m" else "L"
            yield command, np.array(numbers[k : k + count])


def _flagged(text: str) -> list[float]:
    """Numbers of arcs, whose two flags may stand without a space: "a1 1 0 01.5.5"."""
    found: list[float] = []
    at = 0
    while match := (re.compile(r"[01]") if len(found) % 7 in (3, 4) else _NUMBER).search(text, at):
        found.append(float(match[0]))
        at = match.end()
    return found


def _piece(
    kind: str, at: np.ndarray, numbers: np.ndarray, origin: np.ndarray, handle: np.ndarray | None
) -> tuple[list[Piece], np.ndarray | None]:
    """A straight or cubic piece, and the handle that a smooth one after it mirrors."""
    if kind == "H":
        return [line(at, [origin[0] + numbers[0], at[1]])], None
    if kind == "V":
        return [line(at, [at[0], origin[1] + numbers[0]])], None
    points = origin + numbers.reshape(-1, 2)
    if kind == "L":
        return [line(at, points[0])], None
    if kind in "ST":
        points = np.concatenate([[at if handle is None else 2 * at - handle], points])
    if kind in "CS":
        return [np.array([at, *points])], points[1]
    control, end = points  # a quadratic one as a cubic
    return [
        np.array([at, at + 2 / 3 * (control - at), end + 2 / 3 * (control - end), end])
    ], control


def _elliptical(start: np.ndarray, shape: np.ndarray, end: np.ndarray) -> list[Piece]:
    """Pieces of an elliptical arc from its end points (SVG 1.1, F.6.5, F.6.6)."""
    rx, ry, rotation, large, sweeps = np.abs(shape[0]), np.abs(shape[1]), *shape[2:]
    if not (rx and ry) or np.array_equal(start, end):
        return [line(start, end)]
    turn = _rotate(float(rotation))[:2, :2]
    half = turn.T @ (start - end) / 2 / [rx, ry]
    size = math.hypot(*half)
    rx, ry, half = (rx, ry, half) if size <= 1 else (rx * size, ry * size, half / size)
    length = min(half @ half, 1.0)
    aside = math.sqrt((1 - length) / length) * (-1 if large == sweeps else 1)
    middle = aside * np.array([half[1], -half[0]])  # in units of the half axes
    axes = turn @ np.diag([rx, ry])
    centre = axes @ middle + (start + end) / 2
    a, b = (math.atan2(*(side - middle)[::-1]) for side in (half, -half))
    turned = (b - a) % (2 * math.pi) if sweeps else -((a - b) % (2 * math.pi))
    return arc(centre, axes, a, turned)


_SHAPES: dict[str, Callable[[ElementTree.Element, str], Shape]] = {
    "path": _path,
    "polygon": _points,
    "polyline": _points,
    "line": _straight,
    "rect": _rectangle,
    "circle": _ellipse,
    "ellipse": _ellipse,
}
