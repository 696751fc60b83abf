"""Shape files: particle cross sections from TOML, and the file that `init --shapes` writes."""

from pathlib import Path
from typing import Any

from granulab.contact.files.casefile import of_a_size
from granulab.contact.files.datafile import data_file, read_toml
from granulab.contact.files.units import nearest, to_si
from granulab.errors import InputError
from silo2d.case.shape import Points, ShapeSet, shape_from_outline, vertex_list

EXAMPLE = """\
# Shapes of particles: cross sections of prisms, all with one spheroradius. What stands here are
# examples; replace them by your particles.
#
# An outline is what a caliper or a photograph gives: the outer corners, counter-clockwise, convex,
# about any origin. Its corners are rounded by the spheroradius. Overlaps must stay well below it:
# a tenth of the particle's size does, or what the corners have, if that is not much less.
schema = 1
spheroradius = "1 mm"              # radius of the rounded corners of all shapes
unit = "mm"                        # of the outlines

[[shape]]
name = "cube"                      # each shape has a name of its own
share = 3                          # how often it occurs, against the others; left out: 1
outline = [[0, 0], [12, 0], [12, 12], [0, 12]]

[[shape]]
name = "hexagon"
outline = [[7, 0], [3.5, 6.06], [-3.5, 6.06], [-7, 0], [-3.5, -6.06], [3.5, -6.06]]
"""


def load_shapes(name_or_path: str | Path) -> ShapeSet:
    """The shape set of a shipped name ("wood19") or of a TOML file.

    The file holds `schema = 1`, `spheroradius` (a length with its unit), `unit` (of the vertex
    lists) and one `[[shape]]` for each cross section: `name`, `outline` (the outer outline,
    counter-clockwise, see shape_from_outline) and, if not all occur equally often, `share`.

    Raises InputError, "FILE: [shape NAME] ...", for whatever is missing, unknown or impossible.
    """
    path = data_file("shapes", str(name_or_path)) or Path(name_or_path)
    table = read_toml(path, "shapes", 1, _missing)
    _refuse_unknown(table, str(path))
    if words := _missing(table):
        raise InputError(f"{path}: {words}")
    unit = table["unit"]
    if not (isinstance(unit, str) and unit.isalpha()):
        raise InputError(f"{path}: unit = {unit!r}: expected a unit of length, such as 'mm'")
    length = to_si(f"1 {unit}", "m", f"{path}: unit")
    spheroradius = to_si(table["spheroradius"], "m", f"{path}: spheroradius")
    try:
        of_a_size(spheroradius, f"{path}: spheroradius")
    except ValueError as error:
        raise InputError(str(error)) from None
    if not (isinstance(table["shape"], list) and table["shape"]):
        raise InputError(f"{path}: shape: write one [[shape]] for each cross section")

    entries = [_entry(entry, k, str(path)) for k, entry in enumerate(table["shape"], start=1)]
    names = [name for name, _, _ in entries]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{path}: [shape {name}] occurs twice; give each shape its own name")
    shapes = tuple(
        shape_from_outline(name, length * outline, spheroradius, str(path))
        for name, outline, _ in entries
    )
    return ShapeSet(path.stem, shapes, tuple(share for _, _, share in entries))


def _entry(entry: object, number: int, file: str) -> tuple[str, Points, float]:
    """Name, outline in the file's unit, and share of one [[shape]]."""
    where = f"{file}: [shape number {number}]"
    if not isinstance(entry, dict):
        raise InputError(f"{where}: expected a table; write it under [[shape]]")
    name = entry.get("name")
    if isinstance(name, str) and name:
        where = f"{file}: [shape {name}]"
    if not (isinstance(name, str) and name):
        raise InputError(f"{where} name = {name!r}: expected a text, such as '12'")
    share = to_si(entry.get("share", 1), "1", f"{where} share")
    if share <= 0:
        raise InputError(f"{where} share = {share:g}: must be positive; or leave the shape out")
    return name, vertex_list(entry["outline"], f"{where} outline"), share


_OF_FILE = {"spheroradius": "such as '1 mm'", "unit": "such as 'mm'", "shape": "a [[shape]] each"}
_OF_SHAPE = {"name": "a text", "outline": "points, such as [[0, 0], [15, 0], [15, 15]]"}


def _missing(table: dict[str, Any]) -> str:
    """Words on all keys that a shape file lacks; none where it has all."""
    absent = [f"{key} ({example})" for key, example in _OF_FILE.items() if key not in table]
    shapes = table.get("shape")
    for k, entry in enumerate(shapes if isinstance(shapes, list) else [], start=1):
        if isinstance(entry, dict):
            named = entry.get("name", f"number {k}")
            absent += [
                f"[shape {named}] {key} ({example})"
                for key, example in _OF_SHAPE.items()
                if key not in entry
            ]
    return f"missing: {', '.join(absent)}" if absent else ""


def _refuse_unknown(table: dict[str, Any], file: str) -> None:
    """Raise InputError for a key that is not known."""
    shapes = table.get("shape")
    entries = enumerate(shapes if isinstance(shapes, list) else [], start=1)
    of_shape = (*_OF_SHAPE, "share")
    tables = [(file, table, tuple(_OF_FILE))]
    tables += [(f"{file}: [shape number {k}]", e, of_shape) for k, e in entries if type(e) is dict]
    for where, keys, known in tables:
        for key in keys:
            if key not in known:
                named = f"{file}: [shape {keys['name']}]" if "name" in keys else where
                raise InputError(f"{named}: unknown key {key!r}; {nearest(key, known)}")
