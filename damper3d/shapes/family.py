"""The families of shapes: what their numbers mean, their ranges, and the usual sub-spheres."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from damper3d.shapes import prolate, toroid
from damper3d.shapes.cluster import Cluster, sphere
from damper3d.shapes.cylinder import cylinder
from damper3d.shapes.oblate import oblate
from damper3d.shapes.superquadric import superquadric
from damper3d.shapes.surfaces.filling import MOST_SUB_SPHERES
from damper3d.shapes.surfaces.solid import check_number, checked, filled
from granulab.errors import InputError

SPHEROID_RADIUS, TOROID_RADIUS = 3.8e-3, 3.5e-3  # thesis, sec. 8.2 [m]
SPHEROIDS, TOROIDS = 90, 110  # thesis, sec. 8.3, in a cylinder of 40 mm x 40 mm

Numbers = tuple[float, ...]
Build = Callable[[Numbers, int | None, float | None], Cluster]


class Value(NamedTuple):
    """One of the numbers behind the colon."""

    what: str
    low: float
    high: float


@dataclass(frozen=True)
class Family:
    """What the members of a family have in common."""

    example: str
    build: Build | None  # at an equal-volume radius of 1 m; None: not made from numbers
    radius: float = SPHEROID_RADIUS  # of equal volume, where none is given [m]
    count: int = SPHEROIDS  # of them fill a cylinder of 40 mm x 40 mm as the thesis's did
    values: tuple[Value, ...] = ()

    def numbers(self, kind: str, text: str) -> Numbers:
        """The numbers of a text such as "1.5,0.2"; InputError where they cannot be."""
        words = text.split(",")
        wanted = ", ".join(value.what for value in self.values)
        if len(words) != len(self.values):
            raise InputError(
                f"shape = {f'{kind}:{text}'!r}: takes {wanted}; write such as {self.example!r}"
            )
        return tuple(
            self._number(kind, text, word, value)
            for word, value in zip(words, self.values, strict=True)
        )

    def _number(self, kind: str, text: str, word: str, value: Value) -> float:
        try:
            number = float(word)
        except ValueError:
            raise InputError(
                f"shape = {f'{kind}:{text}'!r}: the {value.what} is not a number; write such as "
                f"{self.example!r}"
            ) from None
        if not value.low <= number <= value.high:
            raise InputError(
                f"shape = {f'{kind}:{text}'!r}: the {value.what} must be from {value.low:g} to "
                f"{value.high:g}, such as {self.example!r}"
            )
        return number


def _fewest(make: Callable[[int], Cluster], low: int, step: int, tolerance: float) -> Cluster:
    """The particle of least sub-spheres, low + step k, with a surface error in a tolerance."""
    few, many = -1, (MOST_SUB_SPHERES - low) // step
    if make(low + step * many).surface_error > tolerance:
        raise InputError(
            f"tolerance = {tolerance:g}: takes more than {MOST_SUB_SPHERES} sub-spheres; give a "
            "larger one"
        )
    while many - few > 1:
        middle = (few + many) // 2
        if make(low + step * middle).surface_error <= tolerance:
            many = middle
        else:
            few = middle
    return make(low + step * many)


def _counted(
    kind: str, make: Callable[[int], Cluster], fewest: int, step: int, usual: int,
    sub_spheres: int | None, tolerance: float | None,
) -> Cluster:  # fmt: skip
    """The particle of so many sub-spheres, the usual number, or as few as the tolerance lets."""
    if tolerance is not None:
        return _fewest(make, fewest, step, checked(tolerance))
    number = usual if sub_spheres is None else sub_spheres
    check_number(kind, number, fewest)
    if (number - fewest) % step:
        raise InputError(f"sub_spheres = {number} of {kind!r}: must be odd, such as {number + 1}")
    return make(number)


def _prolate(numbers: Numbers, sub_spheres: int | None, tolerance: float | None) -> Cluster:
    (ratio,) = numbers
    if ratio == 1.0:
        return sphere(1.0)
    fewest, usual = prolate.fewest_sub_spheres(ratio), prolate.USUAL_SUB_SPHERES
    make = partial(prolate.prolate, ratio)
    return _counted("prolate", make, fewest, 2, usual, sub_spheres, tolerance)


def _toroid(numbers: Numbers, sub_spheres: int | None, tolerance: float | None) -> Cluster:
    (hole,) = numbers
    if hole == 0.0:
        return sphere(1.0)
    fewest, usual = toroid.fewest_sub_spheres(hole), toroid.USUAL_SUB_SPHERES
    make = partial(toroid.toroid, hole)
    return _counted("toroid", make, fewest, 1, usual, sub_spheres, tolerance)


def _oblate(numbers: Numbers, sub_spheres: int | None, tolerance: float | None) -> Cluster:
    (ratio,) = numbers
    if ratio == 1.0:
        return sphere(1.0)
    return filled(oblate(ratio), "oblate", sub_spheres, tolerance)


def _superquadric(numbers: Numbers, sub_spheres: int | None, tolerance: float | None) -> Cluster:
    return filled(superquadric(*numbers), "superquadric", sub_spheres, tolerance)


def _cylinder(numbers: Numbers, sub_spheres: int | None, tolerance: float | None) -> Cluster:
    slenderness, rounding = numbers
    if rounding > slenderness:
        raise InputError(
            f"shape = 'cylinder:{slenderness:g},{rounding:g}': the rounding must be at most the "
            f"length over the diameter, {slenderness:g}"
        )
    return filled(cylinder(*numbers), "cylinder", sub_spheres, tolerance)


# Ranges: what the thesis has and more, as long as 1000 sub-spheres do and nothing is a needle.
FAMILIES = {
    "prolate": Family("prolate:1.5", _prolate, values=(Value("aspect ratio a/b", 1.0, 10.0),)),
    "oblate": Family("oblate:0.7", _oblate, values=(Value("aspect ratio a/b", 0.2, 1.0),)),
    "toroid": Family(
        "toroid:0.2", _toroid, TOROID_RADIUS, TOROIDS,
        (Value("hole ratio (a - b)/(a + b)", 0.0, 0.8),),
    ),
    "superquadric": Family(
        "superquadric:1,1,0.5,0.5", _superquadric,
        values=(
            Value("half axis b/a", 0.2, 5.0), Value("half axis c/a", 0.2, 5.0),
            Value("exponent e1", 0.3, 1.6), Value("exponent e2", 0.3, 1.6),
        ),
    ),
    "cylinder": Family(
        "cylinder:1.5,0.2", _cylinder,
        values=(Value("length over diameter", 0.2, 10.0), Value("rounding", 0.1, 1.0)),
    ),
}  # fmt: skip
