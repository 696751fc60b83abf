"""Shape files: particle cross sections from TOML, and the file that `init --shapes` writes."""

import math
from pathlib import Path
from typing import Any

from granulab.contact.files.casefile import of_a_size
from granulab.contact.files.datafile import content_of, data_file, read_toml
from granulab.contact.files.units import nearest, to_si
from granulab.errors import InputError
from silo2d.case.beds.forms import number_shares, shapes_of_entry, sieve_file
from silo2d.case.shape import Points, Shape, ShapeSet, vertex_list

EXAMPLE = """\
# Shapes of particles: cross sections of prisms, with rounded corners. What stands here are
# examples; replace them by your particles.
#
# A shape has a form with a size, or an outline: what a caliper or a photograph gives, the outer
# corners, counter-clockwise, convex, about any origin. Its corners are rounded by the spheroradius.
# Overlaps must stay well below it: a tenth of the particle's size does, or what the corners have,
# if that is not much less.
schema = 1
spheroradius = "1 mm"              # radius of the rounded corners of all shapes without their own
unit = "mm"                        # of the outlines

[[shape]]
name = "cube"                      # each shape has a name of its own
share = 3                          # how often it occurs, against the others; left out: 1
outline = [[0, 0], [12, 0], [12, 12], [0, 12]]

[[shape]]
name = "hexagon"
form = "hexagon"                   # disc, triangle, square, pentagon, hexagon, octagon, rectangle,
size = "7 mm"                      # or polygon with corners = 7; size: side, diameter of a disc,
# spheroradius = "0.5 mm"          # length and width of a rectangle

# [[shape]]
# name = "disc"
# form = "disc"
# size = "12 mm"
# size_distribution = "normal"     # or lognormal: cut at three standard deviations; or sieve
# size_deviation = "1.5 mm"
# sieve = "sieve.csv"              # for sieve: opening and share of the mass that passes; no size
# mass_share = 1                   # in place of share: how much of the mass, for all shapes or none
"""


def load_shapes(name_or_path: str | Path) -> ShapeSet:
    """The shape set of a shipped name ("wood19") or of a TOML file.

    The file holds `schema = 1`, `spheroradius` (a length with its unit), `unit` (of the vertex
    lists) and one `[[shape]]` for each cross section: `name`, `outline` (the outer outline,
    counter-clockwise, see shape_from_outline) or `form` and `size`, and, if not all occur equally
    often, `share` or `mass_share`. Sizes that are spread make several shapes, see forms.py.

    Raises InputError, "FILE: [shape NAME] ...", for whatever is missing, unknown or impossible.
    """
    path = data_file("shapes", str(name_or_path)) or Path(name_or_path)
    table = read_toml(path, "shapes", 1, _missing)
    _refuse_unknown(table, str(path))
    if words := _missing(table):
        raise InputError(f"{path}: {words}")
    unit = table.get("unit", "mm")
    if not (isinstance(unit, str) and unit.isalpha()):
        raise InputError(f"{path}: unit = {unit!r}: expected a unit of length, such as 'mm'")
    length = to_si(f"1 {unit}", "m", f"{path}: unit")
    spheroradius = _spheroradius(table, f"{path}:")
    if not (isinstance(table["shape"], list) and table["shape"]):
        raise InputError(f"{path}: shape: write one [[shape]] for each cross section")

    entries = [_entry(entry, k, str(path)) for k, entry in enumerate(table["shape"], start=1)]
    names = [name for name, _, _ in entries]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{path}: [shape {name}] occurs twice; give each shape its own name")
    made: list[tuple[list[Shape], list[float]]] = []
    for (name, outline, _), entry in zip(entries, table["shape"], strict=True):
        where = f"{path}: [shape {name}]"
        own = _spheroradius(entry, where) or spheroradius
        corners = None if outline is None else length * outline
        made.append(shapes_of_entry(entry, corners, own, path))
    shares = _shares(table["shape"], [share for *_, share in entries], made, str(path))
    return ShapeSet(
        path.stem,
        tuple(shape for shapes, _ in made for shape in shapes),
        tuple(
            share if len(own) == 1 else share * part
            for share, (_, own) in zip(shares, made, strict=True)
            for part in own
        ),
        tuple(name for name, (shapes, _) in zip(names, made, strict=True) for _ in shapes),
    )


def files_beside(shapes_file: str | Path) -> dict[str, Path]:
    """Files that a shape file which was read names, by their names: tables of sieves."""
    path = Path(shapes_file)
    table = read_toml(path, "shapes", 1, _missing)
    named = [entry["sieve"] for entry in table["shape"] if isinstance(entry.get("sieve"), str)]
    return {sieve_file(name, str(path)): path.parent / name for name in named}


def content_with(shapes_file: str | Path) -> bytes:
    """Content of a shape file and of those that it names; see content_of."""
    content = content_of(shapes_file)
    if b"sieve" not in content:
        return content
    return content + b"".join(map(content_of, sorted(Path(shapes_file).parent.glob("*.csv"))))


def _spheroradius(table: dict[str, Any], where: str) -> float | None:
    """The spheroradius [m] of a file or a shape, None where it gives none."""
    if "spheroradius" not in table:
        return None
    radius = to_si(table["spheroradius"], "m", f"{where} spheroradius")
    try:
        return of_a_size(radius, f"{where} spheroradius")
    except ValueError as error:
        raise InputError(str(error)) from None


def _entry(entry: object, number: int, file: str) -> tuple[str, Points | None, float]:
    """Name, outline in the file's unit where there is one, and share of one [[shape]]."""
    where = f"{file}: [shape number {number}]"
    if not isinstance(entry, dict):
        raise InputError(f"{where}: expected a table; write it under [[shape]]")
    name = entry.get("name")
    if isinstance(name, str) and name:
        where = f"{file}: [shape {name}]"
    if not (isinstance(name, str) and name):
        raise InputError(f"{where} name = {name!r}: expected a text, such as '12'")
    key = "mass_share" if "mass_share" in entry else "share"
    share = to_si(entry.get(key, 1), "1", f"{where} {key}")
    if share <= 0:
        raise InputError(f"{where} {key} = {share:g}: must be positive; or leave the shape out")
    if "form" not in entry:
        for key in ("size", "corners"):
            if key in entry:
                raise InputError(f"{where} {key}: goes with a form; an outline has its own size")
        return name, vertex_list(entry["outline"], f"{where} outline"), share
    if "outline" in entry:
        raise InputError(f"{where} form and outline are both given; leave one of them out")
    return name, None, share


def _shares(
    entries: list[dict[str, Any]], given: list[float], made: list[tuple[list[Shape], list[float]]],
    file: str,
) -> list[float]:  # fmt: skip
    """Shares of the entries by number: as given, or from those by mass."""
    by_mass = ["mass_share" in entry for entry in entries]
    if not any(by_mass):
        return given
    if not all(by_mass) or any("share" in entry for entry in entries):
        raise InputError(f"{file}: give every shape a share, or every shape a mass_share")
    areas = [
        math.fsum(shape.area * share for shape, share in zip(*one, strict=True)) for one in made
    ]
    return number_shares(given, areas)


_OF_FILE = {"spheroradius": "such as '1 mm'", "unit": "such as 'mm'", "shape": "a [[shape]] each"}
_OF_SHAPE = {
    "name": "a text",
    "outline": "points, such as [[0, 0], [15, 0], [15, 15]]; or form and size",
}
_OPTIONAL = (
    "share", "mass_share", "form", "size", "corners", "spheroradius", "size_distribution",
    "size_deviation", "sieve",
)  # fmt: skip


def _missing(table: dict[str, Any]) -> str:
    """Words on all keys that a shape file lacks; none where it has all.

    A file whose shapes all have a form needs no unit, and no spheroradius where they have theirs.
    """
    shapes = table.get("shape")
    entries = [e for e in (shapes if isinstance(shapes, list) else []) if isinstance(e, dict)]
    formed = bool(entries) and all("form" in entry for entry in entries)
    spared = {"unit", "spheroradius"} if formed else set()
    absent = [
        f"{key} ({example})"
        for key, example in _OF_FILE.items()
        if key not in table and key not in spared
    ]
    for k, entry in enumerate(shapes if isinstance(shapes, list) else [], start=1):
        if isinstance(entry, dict):
            named = entry.get("name", f"number {k}")
            absent += [
                f"[shape {named}] {key} ({example})"
                for key, example in _OF_SHAPE.items()
                if key not in entry and not (key == "outline" and "form" in entry)
            ]
    return f"missing: {', '.join(absent)}" if absent else ""


def _refuse_unknown(table: dict[str, Any], file: str) -> None:
    """Raise InputError for a key that is not known."""
    shapes = table.get("shape")
    entries = enumerate(shapes if isinstance(shapes, list) else [], start=1)
    of_shape = (*_OF_SHAPE, *_OPTIONAL)
    tables = [(file, table, tuple(_OF_FILE))]
    tables += [(f"{file}: [shape number {k}]", e, of_shape) for k, e in entries if type(e) is dict]
    for where, keys, known in tables:
        for key in keys:
            if key not in known:
                named = f"{file}: [shape {keys['name']}]" if "name" in keys else where
                raise InputError(f"{named}: unknown key {key!r}; {nearest(key, known)}")
