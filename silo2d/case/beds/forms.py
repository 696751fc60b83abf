"""Forms of particles by name and size, and the classes that a distribution of sizes is made of."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from granulab.contact.files.casefile import of_a_size
from granulab.contact.files.datafile import below_header, is_file
from granulab.contact.files.sizes import Sizes, sieved, spread
from granulab.contact.files.units import located, nearest, to_si
from granulab.errors import InputError
from silo2d.case.shape import Points, Shape, disc, regular_outline, shape_from_outline

# Corners of the regular polygons that have a name; "polygon" gives their number.
REGULAR = {"triangle": 3, "square": 4, "pentagon": 5, "hexagon": 6, "octagon": 8}
FORMS = ("disc", *REGULAR, "polygon", "rectangle")
_DISCS = ("circle", "sphere", "round", "ball")
DISTRIBUTIONS = ("normal", "lognormal", "sieve")
# Classes of equal mass that stand for a distribution, and quantiles that each is made from.
CLASSES, _QUANTILES = 12, 24_000
_PARTS = (np.arange(_QUANTILES) + 0.5) / _QUANTILES
_MOST_CORNERS = 32


def shapes_of_entry(
    entry: Mapping[str, Any], outline: Points | None, spheroradius: float | None, file: Path
) -> tuple[list[Shape], list[float]]:
    """The shapes of one [[shape]] of a file and their shares by number, which add up to 1.

    outline (n, 2) [m], where the entry gives one; spheroradius [m] its own or that of the file. One
    shape, or one for each class of sizes.
    """
    name = str(entry["name"])
    where = f"{file}: [shape {name}]"
    distribution = entry.get("size_distribution")
    if outline is not None or distribution is None:
        for key in ("size_distribution", "size_deviation", "sieve"):
            if key in entry:
                why = "goes with a form" if outline is not None else "needs a size_distribution"
                raise InputError(f"{where} {key}: {why}, such as form = 'disc'")
    if outline is not None:
        radius = _radius(spheroradius, where)
        return [shape_from_outline(name, outline, radius, str(file))], [1.0]
    if distribution is None:
        return [_formed(entry, name, 1.0, spheroradius, file)], [1.0]
    given, mean, sizes = _distributed(entry, spheroradius, file, where)
    found, shares = classes(sizes)
    made = [
        _formed(given, f"{name} {k}", size / mean, spheroradius, file)
        for k, size in enumerate(found.tolist(), start=1)
    ]
    return made, shares.tolist()


def _distributed(
    entry: Mapping[str, Any], spheroradius: float | None, file: Path, where: str
) -> tuple[Mapping[str, Any], float, Sizes]:
    """An entry with a size, that size or width [m], and its distribution."""
    distribution, deviation = entry["size_distribution"], entry.get("size_deviation")
    if distribution not in DISTRIBUTIONS:
        known = nearest(str(distribution), DISTRIBUTIONS)
        raise InputError(f"{where} size_distribution = {distribution!r}: {known}")
    if distribution == "sieve":
        if deviation is not None:
            raise InputError(f"{where} size_deviation: the sieve gives the sizes; leave it out")
        if _form(entry, where) != "rectangle" and "size" in entry:
            raise InputError(f"{where} size: the sieve gives the sizes; leave it out")
        sizes = _of_sieve(entry.get("sieve"), file.parent, where)
        return *_of_mean_width(entry, sizes, spheroradius, file, where), sizes
    if "sieve" in entry:
        raise InputError(f"{where} sieve: goes with size_distribution = 'sieve'; leave it out")
    if deviation is None:
        raise InputError(f"{where} size_deviation: missing, such as '1 mm'")
    width, mean = to_si(deviation, "m", f"{where} size_deviation"), _sizes(entry, where)[0]
    if width <= 0:
        raise InputError(f"{where} size_deviation = {deviation!r}: must be above 0")
    with located(where):
        return entry, mean, spread(distribution, mean, width)


def _of_mean_width(
    entry: Mapping[str, Any], sizes: Sizes, spheroradius: float | None, file: Path, where: str
) -> tuple[Mapping[str, Any], float]:
    """An entry with the size that is as wide [m] as that whose mass is the mean of a sieve's.

    The spheroradius is of that size, as of other distributions that of their mean. A width grows
    linearly with the size: rounding takes the same off the corners. A rectangle says by its size
    how long it is for its width; it passes a sieve by its shorter side.
    """
    if _form(entry, where) == "rectangle":
        tried = _sizes(entry, where)
        tried = [one * 20 * (spheroradius or 1e-3) / min(tried) for one in tried]
    else:
        tried = [20 * (spheroradius or 1e-3)]

    def scaled(factor: float) -> tuple[Mapping[str, Any], float]:
        texts = [f"{factor * one} m" for one in tried]
        changed = {**entry, "size": texts if len(texts) > 1 else texts[0]}
        return changed, _formed(changed, where, 1.0, spheroradius, file).width

    once, twice = (scaled(factor)[1] for factor in (1.0, 2.0))
    mean = math.sqrt(float(np.mean(sizes(_PARTS) ** 2)))
    return scaled(1.0 + (mean - once) / (twice - once))


def classes(sizes: Sizes) -> tuple[np.ndarray, np.ndarray]:
    """Sizes (CLASSES,) [m] and shares by number (CLASSES,) of classes of equal mass.

    A class has the size of the mean mass of its particles, so that number and mass of each are
    those of the distribution.
    """
    own = sizes(_PARTS)
    mass = own**2
    which = np.minimum((np.cumsum(mass) - mass / 2) / mass.sum() * CLASSES, CLASSES - 1).astype(int)
    number = np.bincount(which, minlength=CLASSES)
    total = np.bincount(which, weights=mass, minlength=CLASSES)
    there = number > 0
    return np.sqrt(total[there] / number[there]), number[there] / _QUANTILES


def _form(entry: Mapping[str, Any], where: str) -> str:
    form = entry.get("form")
    if form not in FORMS:
        near = "disc" if form in _DISCS else str(form)
        raise InputError(f"{where} form = {form!r}: {nearest(near, FORMS)}")
    if (form == "polygon") != ("corners" in entry):
        cure = "leave it out" if "corners" in entry else "give their number, such as corners = 7"
        raise InputError(f"{where} corners: goes with form = 'polygon'; {cure}")
    return str(form)


def _sizes(entry: Mapping[str, Any], where: str) -> list[float]:
    """Size [m] of a form: a diameter, a side, or length and width of a rectangle."""
    form, size = _form(entry, where), entry.get("size")
    number = 2 if form == "rectangle" else 1
    given = size if isinstance(size, list) else [size]
    if size is None or len(given) != number:
        example = "['15 mm', '10 mm']" if number == 2 else "'12 mm'"
        what = {"disc": "its diameter", "rectangle": "its length and width"}
        raise InputError(
            f"{where} size = {size!r}: expected {what.get(form, 'its side')}, such as {example}"
        )
    lengths = [to_si(one, "m", f"{where} size") for one in given]
    for length in lengths:
        if length <= 0:
            raise InputError(f"{where} size = {1e3 * length:g} mm: must be above 0")
        try:
            of_a_size(length, "size")
        except ValueError as error:
            raise InputError(f"{where} {error}") from None
    return lengths


def _formed(
    entry: Mapping[str, Any], name: str, scale: float, spheroradius: float | None, file: Path
) -> Shape:
    """The shape of a form, scaled with its spheroradius."""
    where = f"{file}: [shape {entry['name']}]"
    form = _form(entry, where)
    size = [scale * length for length in _sizes(entry, where)]
    if form == "disc":
        if "spheroradius" in entry:
            raise InputError(f"{where} spheroradius: a disc's is half its size; leave it out")
        return disc(name, size[0])
    if form == "rectangle":
        outline = np.array([[0.0, 0.0], [size[0], 0.0], size, [0.0, size[1]]])
    else:
        corners = REGULAR.get(form, entry.get("corners"))
        if not (type(corners) is int and 3 <= corners <= _MOST_CORNERS):
            raise InputError(
                f"{where} corners = {corners!r}: expected a whole number from 3 to {_MOST_CORNERS}"
            )
        outline = regular_outline(corners, size[0])
    return shape_from_outline(name, outline, scale * _radius(spheroradius, where), str(file))


def _radius(spheroradius: float | None, where: str) -> float:
    if spheroradius is None:
        raise InputError(
            f"{where} spheroradius: missing, here or for all shapes of the file, such as '1 mm'"
        )
    return spheroradius


def _of_sieve(given: object, folder: Path, where: str) -> Sizes:
    """Sizes of a table of sieves: rows of opening and passing share, or a CSV file of them."""
    rows = _read(folder / sieve_file(given, where), where) if isinstance(given, str) else given
    if not (isinstance(rows, list) and all(isinstance(r, list) and len(r) == 2 for r in rows)):
        raise InputError(
            f"{where} sieve: expected rows of opening and share of the mass that passes, such as "
            "[['2 mm', 0], ['4 mm', 1]], or a CSV file of them"
        )
    opening = np.array([to_si(row[0], "m", f"{where} sieve") for row in rows])
    passing = np.array([to_si(row[1], "1", f"{where} sieve") for row in rows])
    with located(where):
        return sieved(opening, passing, dimensions=2)


def sieve_file(given: str, where: str) -> str:
    """Name of the CSV file of a table of sieves, which lies next to the shape file."""
    if Path(given).name != given:
        raise InputError(f"{where} sieve = {given!r}: expected a file next to this one")
    return given


def _read(path: Path, where: str) -> list[list[Any]]:
    """Rows of a CSV file: opening with its unit, share of the mass that passes; one header line."""
    if not is_file(path):
        raise InputError(f"{where} sieve = {path.name!r}: no such file in {path.parent or '.'}")
    rows = below_header(path, "the sieves", "opening,passing")
    try:
        return [[opening, float(share)] for opening, share in rows]
    except ValueError:
        raise InputError(
            f"{path}: expected a line 'opening,passing' and rows such as '2 mm,0.15'"
        ) from None


def number_shares(mass_shares: list[float], mean_areas: list[float]) -> list[float]:
    """Shares by number of parts of a mixture with shares by mass, all of one density."""
    number = [share / area for share, area in zip(mass_shares, mean_areas, strict=True)]
    return [one / math.fsum(number) for one in number]
