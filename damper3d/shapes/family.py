"""A family of shapes: what its numbers mean, their ranges, and the usual sub-spheres."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.surfaces.filling import MOST_SUB_SPHERES
from damper3d.shapes.surfaces.solid import check_number, checked
from granulab.errors import InputError

SPHEROID_RADIUS = 3.8e-3  # thesis, sec. 8.2 [m]
SPHEROIDS = 90  # thesis, sec. 8.3, in a cylinder of 40 mm x 40 mm

Numbers = tuple[float, ...]
Build = Callable[[Numbers, int | None, float | None], MultiSphere]


class Value(NamedTuple):
    """One of the numbers behind the colon."""

    what: str
    low: float
    high: float


@dataclass(frozen=True)
class Family:
    """Properties that the members of a family have in common.

    build(numbers, sub_spheres, tolerance) makes the particle at an equal-volume radius of 1 m from
    the numbers behind the colon; at most one of the number of sub-spheres and the tolerance of the
    surface (over the equal-volume radius) is given. See solid.filled and `counted`.
    """

    example: str
    build: Build | None  # None: not made from numbers
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


def fewest_within(
    make: Callable[[int], MultiSphere], low: int, step: int, tolerance: float
) -> MultiSphere:
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


def counted(
    kind: str, make: Callable[[int], MultiSphere], fewest: int, step: int, usual: int,
    sub_spheres: int | None, tolerance: float | None,
) -> MultiSphere:  # fmt: skip
    """The particle of so many sub-spheres, the usual number, or as few as the tolerance lets.

    make(number) builds it; `fewest` and every `step` more are possible.
    """
    if tolerance is not None:
        return fewest_within(make, fewest, step, checked(tolerance))
    number = usual if sub_spheres is None else sub_spheres
    check_number(kind, number, fewest)
    if (number - fewest) % step:
        raise InputError(f"sub_spheres = {number} of {kind!r}: must be odd, such as {number + 1}")
    return make(number)
