"""The thesis's steel particles on a flat wall, and their smooth bodies (sec. 5.4, Table 5.1)."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.particle import parse_particle
from damper3d.studies.single_contact.particles.held import AS_IT_IS, turn
from damper3d.studies.single_contact.particles.smooth_body import (
    Elastic,
    Ellipse,
    ellipse,
    ring_force,
)
from granulab.contact.files.table import load_table
from granulab.contact.hertz import HertzLaw
from granulab.contact.sphere_law import sphere_law

OBLATE, PROLATE = (1.4e-3, 1.5e-3), (6e-3, 3e-3)  # half axes a, b (Figs 5.5, 5.7) [m]
RING, TUBE = 3e-3, 1.15e-3  # a and b of the toroid (Fig. 5.9) [m]
ON_END = turn((0.0, 1.0, 0.0), 0.5 * math.pi)  # its x axis points down

Smooth = Callable[[Elastic, np.ndarray], np.ndarray]


class Setting(NamedTuple):
    """A particle as it stands on the wall, with several numbers of sub-spheres."""

    key: str
    figure: str  # of the thesis
    shape: str  # as in a case file
    size: float  # equal-volume radius [m]
    orientation: np.ndarray
    finenesses: tuple[dict[str, Any], ...]  # options of parse_particle; the last is drawn strongest
    unit: float  # which takes the place of the sphere's radius in eq. 5.17 [m]
    furthest: float  # largest overlap over twice the unit [-]
    smooth: Smooth  # force [N] at overlaps (n,) [m]
    lies: bool = False  # a row or ring on its side, whose grooves the wall meets

    def clusters(self) -> list[MultiSphere]:
        """The particle with each of its numbers of sub-spheres."""
        return [parse_particle(self.shape, self.size, **options) for options in self.finenesses]

    @property
    def overlaps(self) -> np.ndarray:
        """Those of the figure, from nothing on (n,) [m]."""
        return np.linspace(0.0, 2.0 * self.unit * self.furthest, 61)


def steel() -> tuple[Elastic, HertzLaw]:
    """The material, and the law of it on itself without damping."""
    table = load_table("steel")
    solid = table.material("steel")
    modulus = solid.youngs_modulus.value if solid.youngs_modulus else math.nan
    poisson = solid.poisson.value if solid.poisson else math.nan
    friction = table.pair("steel", "steel").friction.value
    law = sphere_law(solid, solid, friction=friction, restitution=1.0)
    return Elastic(modulus, poisson), law


def principal_radii() -> dict[str, tuple[float, float]]:
    """Principal radii of the smooth bodies where they touch the wall at a point [m]."""
    (a_o, b_o), (a_p, b_p) = OBLATE, PROLATE
    return {
        "oblate on its minor axis": (b_o**2 / a_o, b_o**2 / a_o),
        "prolate lying": (a_p**2 / b_p, b_p),
        "prolate standing": (b_p**2 / a_p, b_p**2 / a_p),
        "toroid standing": (RING + TUBE, TUBE),
    }


def contact_of(key: str, material: Elastic) -> Ellipse:
    """The smooth body's point contact, of a setting that has one."""
    return ellipse(material, *principal_radii()[key])


def settings() -> list[Setting]:
    """Settings in the thesis's order."""
    (a_o, b_o), (a_p, b_p) = OBLATE, PROLATE
    prolate = (f"prolate:{a_p / b_p:g}", (a_p * b_p**2) ** (1 / 3))
    hole = (RING - TUBE) / (RING + TUBE)
    toroid = (f"toroid:{hole!r}", (1.5 * math.pi * RING * TUBE**2) ** (1 / 3))
    rows, rings = _numbers(21, 51), _numbers(10, 20, 100, 50)
    return [
        Setting("oblate on its minor axis", "5.6a", f"oblate:{a_o / b_o!r}",
                (a_o * b_o**2) ** (1 / 3), ON_END, ({"tolerance": 0.02}, {"tolerance": 0.005}),
                a_o, 1e-3, _point("oblate on its minor axis")),
        Setting("prolate lying", "5.8a", *prolate, AS_IT_IS, rows, b_p, 1e-3,
                _point("prolate lying"), True),
        Setting("prolate standing", "5.8a", *prolate, ON_END, rows, a_p, 1e-3,
                _point("prolate standing")),
        Setting("toroid lying", "5.10a", *toroid, AS_IT_IS, rings, TUBE, 8e-3, _ring_force,
                True),
        Setting("toroid standing", "5.13", *toroid, ON_END, rings[-1:], RING, 1e-3,
                _point("toroid standing")),
    ]  # fmt: skip


def _numbers(*numbers: int) -> tuple[dict[str, Any], ...]:
    return tuple({"sub_spheres": number} for number in numbers)


def _point(key: str) -> Smooth:
    return lambda material, overlaps: contact_of(key, material).hertz * overlaps**1.5


def _ring_force(material: Elastic, overlaps: np.ndarray) -> np.ndarray:
    return ring_force(material, RING, TUBE, overlaps)
