"""Studies of one contact, with figures: impacts of spheres, and particles on a wall.

A study is two functions of a module of spheres/ or particles/, named compute and draw unless one
module has several. spheres/impact.py is also what `damper3d impact` runs.
"""

import importlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from granulab.contact.files.units import nearest
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Entry(NamedTuple):
    """A study of the table below, not yet imported."""

    module: str  # of this package
    text: str  # the study in a line
    compute: str = "compute"
    draw: str = "draw"


# Name as in `damper3d contact STUDY`.
STUDIES = {
    "aluminium-ball": Entry(
        "spheres.large_spheres",
        "200 mm aluminium sphere on a rigid wall (Fig. 5.21)",
        "aluminium",
        "draw_aluminium",
    ),
    "contact-limit": Entry(
        "particles.contact_limit", "overlaps up to which sub-spheres will do (Fig. 5.12)"
    ),
    "damping": Entry(
        "spheres.damping", "damping ratio and restitution of the three dashpots (Fig. 5.19)"
    ),
    "force": Entry(
        "spheres.force", "normal and tangential force, simplified and exact law (Fig. 5.4)"
    ),
    "free-rotation": Entry(
        "particles.free_rotation", "free bodies against Jacobi's functions and a precession"
    ),
    "oblique": Entry(
        "spheres.oblique", "oblique impact by each tangential law, against gross sliding"
    ),
    "orientation": Entry(
        "particles.orientation", "rebound of particles from a wall, by orientation"
    ),
    "ring-shear": Entry(
        "particles.ring_shear", "lying toroid in shear, by finite elements (Fig. 5.10b; a minute)"
    ),
    "shape-force": Entry(
        "particles.shape_force", "normal force of particles, and of smooth ones (Figs 5.6-5.13)"
    ),
    "shape-shear": Entry("particles.shape_shear", "tangential force likewise (Figs 5.6b, 5.8b)"),
    "steel-ball": Entry(
        "spheres.large_spheres",
        "40 mm steel sphere at 2.4 m/s on a steel block (Fig. 5.20)",
        "steel",
        "draw_steel",
    ),
    "yield": Entry(
        "spheres.yielding", "yield velocities, and restitution above them (eq. 5.26, Fig. 5.15)"
    ),
}


class Found(NamedTuple):
    """Results of a study."""

    numbers: dict[str, Any]  # SI, unit in the key
    rows: list[dict[str, Any]]  # the curves, for a CSV
    remarks: tuple[str, ...] = ()  # how the numbers are meant


class Study(NamedTuple):
    """A study that can be run."""

    compute: Callable[[], Found]  # numbers, and rows of the curves
    draw: Callable[[Found], "Figure"]


def find(name: str) -> Study:
    """The study of a name; InputError with the names there are."""
    if name not in STUDIES:
        raise InputError(f"contact {name!r}: no such study; {nearest(name, list(STUDIES))}")
    entry = STUDIES[name]
    module = importlib.import_module(f"damper3d.studies.single_contact.{entry.module}")
    return Study(getattr(module, entry.compute), getattr(module, entry.draw))
