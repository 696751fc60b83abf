"""DXF files (ASCII): LINE, ARC, CIRCLE, LWPOLYLINE and POLYLINE with bulges, as curves."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from granulab.errors import InputError
from silo2d.drawings.curves import Curve, Drawing, Piece, arc, curve, line

# $INSUNITS: length of a drawing's unit [m].
_UNITS = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 8: 2.54e-8, 9: 2.54e-5, 10: 0.9144,
          13: 1e-6, 14: 0.1}  # fmt: skip
# Kinds that draw no line of the silo: words, dimensions, fillings, pictures.
_SILENT = {"POINT", "TEXT", "MTEXT", "DIMENSION", "HATCH", "LEADER", "VIEWPORT", "ATTDEF", "ATTRIB",
           "MULTILEADER", "TOLERANCE", "IMAGE", "WIPEOUT", "OLE2FRAME", "ACAD_TABLE"}  # fmt: skip


class Entity(NamedTuple):
    """An entity: its kind, and its group codes with their values."""

    kind: str
    codes: list[tuple[int, str]]

    def number(self, code: int, usual: float = 0.0) -> float:
        """The first value of a group code, or the usual one."""
        return next((float(value) for known, value in self.codes if known == code), usual)

    def numbers(self, code: int) -> list[float]:
        """All values of a group code."""
        return [float(value) for known, value in self.codes if known == code]

    @property
    def layer(self) -> str:
        """Name of the layer that it is on."""
        return next((value for known, value in self.codes if known == 8), "0")


def looks_like_it(text: str) -> bool:
    """True for a text that begins as a DXF does: group code 0 or 999, then a section."""
    lines = [one.strip() for one in text[:2000].splitlines()[:200]]
    return "SECTION" in lines and lines[0] in ("0", "999")


def read(text: str, where: str) -> Drawing:
    """The curves of a DXF file; where: the file, for refusals.

    Blocks that are inserted are not read, nor splines and ellipses: they are named as left out.
    Sheets (paper space) are no part of the drawing.
    """
    try:
        sections = _sections(text)
        unit = _UNITS.get(_header(sections.get("HEADER", []), "$INSUNITS"))
        entities = _entities(sections.get("ENTITIES", []))
        curves, unread = _curves((one for one in entities if one.number(67) != 1), where)
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{where}: damaged DXF ({error}); export the drawing again") from None
    return Drawing(curves, unit, unread)


def _sections(text: str) -> dict[str, list[tuple[int, str]]]:
    """Group codes and values of each section, by its name."""
    lines = [one.strip() for one in text.splitlines()]
    pairs = [(int(code), value) for code, value in zip(lines[::2], lines[1::2], strict=False)]
    found: dict[str, list[tuple[int, str]]] = {}
    current: list[tuple[int, str]] = []
    for k, pair in enumerate(pairs):
        if pair == (0, "SECTION") and k + 1 < len(pairs):
            current = found.setdefault(pairs[k + 1][1], [])
        elif pair not in ((0, "ENDSEC"), (0, "EOF")):
            current.append(pair)
    return found


def _header(section: list[tuple[int, str]], name: str) -> int:
    for k, (code, value) in enumerate(section[:-1]):
        if code == 9 and value == name:
            return int(section[k + 1][1])
    return 0


def _entities(section: list[tuple[int, str]]) -> Iterator[Entity]:
    """The entities in turn; the vertices of a POLYLINE follow it as entities of their own."""
    entity = Entity("", [])
    for code, value in section:
        if code == 0:
            if entity.kind:
                yield entity
            entity = Entity(value, [])
        else:
            entity.codes.append((code, value))
    if entity.kind:
        yield entity


def _curves(
    entities: Iterator[Entity], where: str
) -> tuple[list[Curve], list[tuple[str, tuple[str, ...]]]]:
    """The curves of entities; kind and layer of those that are not read."""
    curves: list[Curve] = []
    unread: list[tuple[str, tuple[str, ...]]] = []
    heavy: Entity | None = None  # a POLYLINE, whose vertices follow
    vertices: list[tuple[float, float, float]] = []
    for entity in entities:
        if entity.kind == "POLYLINE":
            heavy, vertices = entity, []
            continue
        if entity.kind == "VERTEX":
            vertices.append((entity.number(10), entity.number(20), entity.number(42)))
            continue
        if entity.kind == "SEQEND":
            if heavy is None:
                continue
            entity, heavy = heavy, None
        found = _pieces(entity, vertices)
        if found is None:
            if entity.kind not in _SILENT:
                unread.append((entity.kind, (entity.layer,)))
            continue
        pieces, closed = found
        if not all(np.isfinite(piece).all() for piece in pieces):
            raise InputError(f"{where}: a {entity.kind} is not finite; export the drawing again")
        # Drawn on the back of the plane x is mirrored, but of lines, which are in the world's axes.
        if entity.kind != "LINE" and entity.number(230, 1.0) < 0:
            pieces = [piece * [-1.0, 1.0] for piece in pieces]
        if pieces and (one := curve(pieces, closed, (entity.layer,))) is not None:
            curves.append(one)
    return curves, unread


def _pieces(
    entity: Entity, vertices: list[tuple[float, float, float]]
) -> tuple[list[Piece], bool] | None:
    """The pieces of an entity and whether they are closed; None for a kind that is not read."""
    number = entity.number
    if entity.kind == "LINE":
        return [line((number(10), number(20)), (number(11), number(21)))], False
    if entity.kind in ("ARC", "CIRCLE"):
        start, end = (math.radians(number(code)) for code in (50, 51))
        sweep = (end - start) % (2 * math.pi) if entity.kind == "ARC" else 0.0
        axes = number(40) * np.eye(2)
        pieces = arc((number(10), number(20)), axes, start, sweep or 2 * math.pi)
        return pieces, entity.kind == "CIRCLE"
    closed = bool(int(number(70)) & 1)
    if entity.kind == "LWPOLYLINE":
        return _bulged(_light(entity), closed), closed
    if entity.kind == "POLYLINE" and not int(number(70)) & ~(1 | 128):  # plane, no spline fit
        return _bulged(vertices, closed), closed
    return None


def _light(entity: Entity) -> list[tuple[float, float, float]]:
    """Vertices of an LWPOLYLINE: x, y, bulge; a bulge may be left out."""
    rows: list[list[float]] = []
    for code, value in entity.codes:
        if code == 10:
            rows.append([float(value), 0.0, 0.0])
        elif code in (20, 42) and rows:
            rows[-1][1 if code == 20 else 2] = float(value)
    return [(x, y, bulge) for x, y, bulge in rows]


def _bulged(vertices: list[tuple[float, float, float]], closed: bool) -> list[Piece]:
    """Pieces between vertices; a bulge is the tangent of a quarter of the angle of an arc."""
    pieces: list[Piece] = []
    ends = vertices[1:] + (vertices[:1] if closed else [])
    for (x, y, bulge), (to_x, to_y, _) in zip(vertices, ends, strict=False):
        if not bulge or (x, y) == (to_x, to_y):
            pieces.append(line((x, y), (to_x, to_y)))
            continue
        sweep, dx, dy = 4 * math.atan(bulge), to_x - x, to_y - y
        aside = (1 - bulge**2) / (4 * bulge)  # of the centre from the chord, over the chord
        cx, cy = x + dx / 2 - aside * dy, y + dy / 2 + aside * dx
        start = math.atan2(y - cy, x - cx)
        pieces += arc((cx, cy), math.hypot(x - cx, y - cy) * np.eye(2), start, sweep)
    return pieces
