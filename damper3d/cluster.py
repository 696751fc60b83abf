"""A particle: a rigid cluster of spheres with the volume and inertia of the smooth shape."""

import math
from dataclasses import dataclass

import numpy as np

from contact.quantity import InputError, nearest, to_si

_LATER = ("prolate", "oblate", "toroid", "mesh")


@dataclass(frozen=True, eq=False)
class Cluster:
    """Spheres that move as one body about its centroid, in its principal axes."""

    name: str  # as in the case file, such as "sphere:5mm"
    offsets: np.ndarray  # (k, 3) centres of the spheres [m]
    radii: np.ndarray  # (k,) [m]
    volume: float  # of the smooth shape: mass over density [m3]
    inertia: np.ndarray  # (3,) principal moments over density [m5]

    @property
    def bounding_radius(self) -> float:
        """Of the ball about the centroid that holds all spheres [m]."""
        return float(np.max(np.linalg.norm(self.offsets, axis=1) + self.radii))

    @property
    def equal_volume_radius(self) -> float:
        """Of the ball of the same volume [m]."""
        return (0.75 * self.volume / math.pi) ** (1 / 3)

    @property
    def smallest_radius(self) -> float:
        """Of the spheres [m]; the Rayleigh step (thesis, eq. 3.31) goes with it."""
        return float(np.min(self.radii))


def sphere(radius: float, name: str = "") -> Cluster:
    """A cluster of one; the radius in m."""
    volume = 4.0 / 3.0 * math.pi * radius**3
    inertia = np.full(3, 0.4 * volume * radius**2)
    name = name or f"sphere:{2e3 * radius:g}mm"
    return Cluster(name, np.zeros((1, 3)), np.array([radius]), volume, inertia)


def parse_particle(text: str, equal_volume_radius: float | None = None) -> Cluster:
    """The particle that a text names: "sphere:5mm", by its diameter.

    equal_volume_radius [m] is the size of a shape that is named without one ("sphere"). Raises
    InputError, one line.
    """
    kind, _, size = (part.strip() for part in text.partition(":"))
    if kind in _LATER:
        raise InputError(
            f"shape = {text!r}: comes in a later version; so far there are spheres, such as "
            "'sphere:5mm'"
        )
    if kind != "sphere":
        raise InputError(
            f"shape = {text!r}: unknown; {nearest(kind, ['sphere'])}; write such as 'sphere:5mm'"
        )
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
