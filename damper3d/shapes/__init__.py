"""Shapes of particles, one file a family (thesis, chapter 4), and the registry of families.

A family makes of the numbers of a text such as "prolate:1.5" a multi-sphere particle: spheres
that move as one rigid particle. A new one is a file with its Family and a line in FAMILIES; or,
from outside, a call of `register` before the case is read:

    family = Family("myshape:1.5", build, values=(Value("ratio", 1.0, 3.0),))
    damper3d.shapes.register("myshape", family)
"""

import inspect
from pathlib import Path

from damper3d.shapes import cylinder, oblate, prolate, superquadric, toroid
from damper3d.shapes.family import Build, Family, Numbers, Value, counted
from damper3d.shapes.multisphere import MultiSphere, sphere
from damper3d.shapes.surfaces.solid import Solid, filled
from damper3d.shapes.surfaces.surface import Surface
from granulab.campaign.runs.provenance import extend
from granulab.errors import InputError

__all__ = [
    "FAMILIES",
    "Build",
    "Family",
    "MultiSphere",
    "Numbers",
    "Solid",
    "Surface",
    "Value",
    "counted",
    "filled",
    "register",
    "sphere",
]

# Ranges: what the thesis has and more, as long as 1000 sub-spheres do and nothing is a needle.
FAMILIES = {
    "prolate": prolate.FAMILY,
    "oblate": oblate.FAMILY,
    "oblate_grid": oblate.GRIDDED,
    "toroid": toroid.FAMILY,
    "superquadric": superquadric.FAMILY,
    "cylinder": cylinder.FAMILY,
}
_OWN = ("sphere", "mesh")  # which need no family


def register(name: str, family: Family) -> None:
    """Let cases and commands name a family of shapes, as "name:1.5".

    The file of its `build` counts among the sources of runs: an edit calls them outdated.
    A process that reads the case has to register the family too.
    Raises InputError where the name is taken or is no word, or the family builds nothing.
    """
    if name in FAMILIES or name in _OWN:
        raise InputError(f"shape {name!r}: there is one of that name; give another")
    if not name.isidentifier():
        raise InputError(f"shape {name!r}: must be a word of letters, such as 'myshape'")
    if family.build is None:
        raise InputError(f"shape {name!r}: its family has no build")
    FAMILIES[name] = family
    extend(Path(__file__).parent, inspect.getfile(family.build))
