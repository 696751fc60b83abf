"""The particle that a text names: "sphere:5mm", "prolate:1.5", "toroid:0.2"."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from contact.quantity import InputError, nearest, to_si
from damper3d.cluster import Cluster, sphere
from damper3d.shapes import prolate, toroid

MOST_SUB_SPHERES = 1000  # of one particle: 90 of them are as many spheres as 250 dampers of 358


@dataclass(frozen=True)
class Family:
    """What the members of a family have in common."""

    example: str
    usual_radius: float  # of the ball of equal volume, where none is given [m]
    usual_count: int  # that fill a cylinder of 40 mm x 40 mm at this radius as the thesis's did
    build: Callable[[str, int | None], Cluster]  # at an equal-volume radius of 1 m


def parse_particle(
    text: str, equal_volume_radius: float | None = None, *, sub_spheres: int | None = None
) -> Cluster:
    """The particle that a text names: a sphere by its diameter, another shape by its ratio.

    equal_volume_radius [m] is the size of a shape that is named without one; left out, it is the
    usual one of the family. sub_spheres: how many stand for the shape; left out, the thesis's
    number. Raises InputError, one line.
    """
    kind, _, values = (part.strip() for part in text.partition(":"))
    if kind == "sphere":
        return _sphere(text, values, equal_volume_radius)
    if kind not in FAMILIES:
        raise InputError(
            f"shape = {text!r}: unknown; {nearest(kind, ['sphere', *FAMILIES])}; write such as "
            "'sphere:5mm' or 'prolate:1.5'"
        )
    family = FAMILIES[kind]
    radius = family.usual_radius if equal_volume_radius is None else equal_volume_radius
    return family.build(values, sub_spheres).scaled(radius)


def _sphere(text: str, size: str, equal_volume_radius: float | None) -> Cluster:
    if size and equal_volume_radius is not None:
        raise InputError(
            f"shape = {text!r} has a size, and equal_volume_radius = {equal_volume_radius:g} m is "
            "given too; leave one of them out"
        )
    if equal_volume_radius is not None:
        return sphere(equal_volume_radius)
    if not size:
        raise InputError(f"shape = {text!r}: the size is missing; write such as 'sphere:5mm'")
    try:
        diameter = to_si(size, "m", "shape")
    except InputError:
        raise InputError(f"shape = {text!r}: not a diameter; write such as 'sphere:5mm'") from None
    if diameter <= 0:
        raise InputError(f"shape = {text!r}: the diameter must be above 0, such as 'sphere:5mm'")
    return sphere(0.5 * diameter, text)


def _ratio(kind: str, text: str, low: float, high: float, what: str) -> float:
    """The number after the colon, between two bounds; InputError otherwise."""
    example = FAMILIES[kind].example
    try:
        ratio = float(text)
    except ValueError:
        raise InputError(
            f"shape = '{kind}:{text}': the {what} is not a number; write such as {example!r}"
        ) from None
    if not low <= ratio <= high:
        raise InputError(
            f"shape = '{kind}:{text}': the {what} must be from {low:g} to {high:g}, such as "
            f"{example!r}"
        )
    return ratio


def _number_of(kind: str, given: int | None, usual: int, fewest: int) -> int:
    number = usual if given is None else given
    if not fewest <= number <= MOST_SUB_SPHERES:
        raise InputError(
            f"sub_spheres = {number} of '{kind}': must be from {fewest} to {MOST_SUB_SPHERES}"
        )
    return number


@cache
def _prolate(text: str, sub_spheres: int | None) -> Cluster:
    ratio = _ratio("prolate", text, 1.0, 10.0, "aspect ratio a/b")
    number = _number_of("prolate", sub_spheres, prolate.USUAL_SUB_SPHERES, 3)
    if number % 2 == 0:
        raise InputError(f"sub_spheres = {number} of 'prolate': must be odd, such as {number + 1}")
    if ratio == 1.0:
        return sphere(1.0, "prolate:1", "prolate")
    return prolate.prolate(ratio, number, f"prolate:{text}")


@cache
def _toroid(text: str, sub_spheres: int | None) -> Cluster:
    hole = _ratio("toroid", text, 0.0, 0.8, "hole ratio (a - b)/(a + b)")
    fewest = toroid.fewest_sub_spheres(hole)
    number = _number_of("toroid", sub_spheres, toroid.USUAL_SUB_SPHERES, fewest)
    if hole == 0.0:
        return sphere(1.0, "toroid:0", "toroid")
    return toroid.toroid(hole, number, f"toroid:{text}")


FAMILIES = {
    "prolate": Family("prolate:1.5", 3.8e-3, 90, _prolate),  # thesis, sec. 8.2.1 and 8.3
    "toroid": Family("toroid:0.2", 3.5e-3, 110, _toroid),  # thesis, sec. 8.2.2 and 8.3
}
