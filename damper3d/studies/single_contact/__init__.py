"""One contact: the impact of a sphere, and studies with figures, each a module of this package.

impact.py is what `damper3d impact` and the studies run, collision.py its kernel. A
study is a module with

    compute() -> Found                 its numbers (SI, ready for JSON) and the rows of its curves
    draw(found) -> Figure              the same as a matplotlib figure
"""

import importlib
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, cast

from granulab.contact.files.units import nearest
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# name as in `damper3d contact STUDY`: module of this package, what it shows
STUDIES: dict[str, tuple[str, str]] = {
    "aluminium-ball": ("aluminium_ball", "200 mm aluminium ball on a rigid wall (Fig. 5.21)"),
    "contact-limit": ("contact_limit", "overlaps up to which sub-spheres will do (Fig. 5.12)"),
    "damping": ("damping", "damping ratio and restitution of the three dashpots (Fig. 5.19)"),
    "force": ("force", "normal and tangential force, simplified and exact law (Fig. 5.4)"),
    "free-rotation": ("free_rotation", "free bodies against Jacobi's functions and a precession"),
    "oblique": ("oblique", "oblique impact by each tangential law, against gross sliding"),
    "orientation": ("orientation", "rebound of particles from a wall, by orientation"),
    "shape-force": ("shape_force", "normal force of particles, and of smooth ones (Figs 5.6-5.13)"),
    "shape-shear": ("shape_shear", "tangential force likewise (Figs 5.6b, 5.8b)"),
    "steel-ball": ("steel_ball", "40 mm steel ball at 2.4 m/s on a steel block (Fig. 5.20)"),
    "yield": ("yielding", "yield velocities, and restitution above them (eq. 5.26, Fig. 5.15)"),
}


class Found(NamedTuple):
    """What a study found."""

    numbers: dict[str, Any]  # SI, unit in the key
    rows: list[dict[str, Any]]  # the curves, for a CSV
    remarks: tuple[str, ...] = ()  # how the numbers are meant


class Study(Protocol):
    """What a module of this package offers."""

    def compute(self) -> Found:
        """Numbers, and rows of the curves."""

    def draw(self, found: Found) -> "Figure":
        """The study as a picture."""


def find(name: str) -> Study:
    """The study of a name; InputError with the names there are."""
    if name not in STUDIES:
        raise InputError(f"contact {name!r}: no such study; {nearest(name, list(STUDIES))}")
    return cast(
        Study, importlib.import_module(f"damper3d.studies.single_contact.{STUDIES[name][0]}")
    )
