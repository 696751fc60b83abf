"""Multi-sphere particles: rigid spheres together, with volume and inertia of the smooth shape."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from damper3d.shapes.surfaces.surface import Surface, unit_sphere


@dataclass(frozen=True, eq=False)
class MultiSphere:
    """Spheres that move as one rigid body about its centroid, in its principal axes."""

    name: str  # as in the case file, such as "sphere:5mm"
    kind: str  # the family of its shape, such as "prolate"
    offsets: np.ndarray  # (k, 3) centres of the spheres [m]
    radii: np.ndarray  # (k,) [m]
    volume: float  # of the smooth shape: mass over density [m3]
    area: float  # of its surface [m2]
    inertia: np.ndarray  # (3,) its principal moments over density [m5]
    surface: Surface  # the smooth shape in triangles, for pictures
    # How the spheres lie: one "ball"; a "row" along x in rising order; a "ring" of equal spheres
    # and distances round z, from +x on, as the thesis numbers them; or "any".
    arrangement: Literal["ball", "row", "ring", "any"]
    # Bounds how far the surface of the spheres and that of the smooth shape are apart [m].
    surface_error: float

    @property
    def is_sphere(self) -> bool:
        """True for one sphere about its centroid, which looks alike in every orientation."""
        return len(self.radii) == 1 and not self.offsets.any()

    @property
    def bounding_radius(self) -> float:
        """Radius of the sphere about the centroid that holds all others [m]."""
        return float(np.max(np.linalg.norm(self.offsets, axis=1) + self.radii))

    @property
    def equal_volume_radius(self) -> float:
        """Radius of the sphere of the same volume [m]."""
        return (0.75 * self.volume / math.pi) ** (1 / 3)

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of the spheres [m]; the Rayleigh step (thesis, eq. 3.31) goes with it."""
        return float(np.min(self.radii))

    @property
    def sphericity(self) -> float:
        """Surface of the sphere of the same volume over that of the shape [-] (thesis, eq. 8.3).

        The root there is of the numerator alone: cbrt(36 pi V^2) / S.
        """
        return (36.0 * math.pi * self.volume**2) ** (1 / 3) / self.area

    def scaled(self, factor: float) -> "MultiSphere":
        """The particle, scaled by a factor."""
        return dataclasses.replace(
            self,
            offsets=factor * self.offsets,
            radii=factor * self.radii,
            volume=factor**3 * self.volume,
            area=factor**2 * self.area,
            inertia=factor**5 * self.inertia,
            surface=self.surface.scaled(factor),
            surface_error=factor * self.surface_error,
        )


def sphere(radius: float, name: str = "", kind: str = "sphere") -> MultiSphere:
    """A particle of one sphere; the radius in m."""
    volume = 4.0 / 3.0 * math.pi * radius**3
    return MultiSphere(
        name=name or f"sphere:{2e3 * radius:g}mm",
        kind=kind,
        offsets=np.zeros((1, 3)),
        radii=np.array([radius]),
        volume=volume,
        area=4.0 * math.pi * radius**2,
        inertia=np.full(3, 0.4 * volume * radius**2),
        surface=unit_sphere().scaled(radius),
        arrangement="ball",
        surface_error=0.0,
    )
