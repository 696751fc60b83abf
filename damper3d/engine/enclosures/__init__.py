"""Enclosures: the closed voids that hold the particles, one file each, and their registry.

A new enclosure is a file like cylinder.py, and one call of `register`: below for one of this
package, or in any file that is imported before the case is read. A case then names its shape and
gives its sizes in [enclosure].
"""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

from damper3d.engine import ENGINE
from damper3d.engine.enclosures.box import Box, box
from damper3d.engine.enclosures.cavity import Cavity, Triangles, nearest_triangle
from damper3d.engine.enclosures.cells import Cells, Sides, nearest_side
from damper3d.engine.enclosures.cylinder import Cylinder, cylinder, nearest_round
from damper3d.engine.enclosures.enclosure import Enclosure, Round
from damper3d.engine.enclosures.frustum import Frustum, Mantle, nearest_on_mantle
from damper3d.engine.enclosures.lines import Lines, nearest_line
from damper3d.engine.enclosures.polyhedron import HexagonalPrism, Polyhedron
from damper3d.engine.enclosures.sphere import Ball, Sphere, nearest_in_ball

__all__ = ["ENCLOSURES", "Box", "Cavity", "Cells", "Cylinder", "Enclosure", "Frustum",
           "HexagonalPrism", "Polyhedron", "Round", "Sphere", "box", "cylinder", "nearest_of",
           "register", "register_surface"]  # fmt: skip

ENCLOSURES: dict[str, type[Enclosure]] = {}  # by the shape that a case names
_NEAREST: dict[type, Callable[..., Any]] = {}  # geometry of curved walls, by the type of `surface`


def register(
    enclosure: type[Enclosure],
    surface: type | None = None,
    nearest: Callable[..., Any] | None = None,
    *helpers: str | Path,
) -> None:
    """Let cases have an enclosure.

    surface and nearest are those of its curved walls, where it has any: the type of its `surface`,
    and the geometry, see register_surface. helpers are files with functions that `nearest` calls,
    where they do not stand in the file of `enclosure`: an edit in any of these files compiles the
    kernels again, and calls runs that were made before it outdated.
    """
    ENCLOSURES[enclosure.shape] = enclosure
    sources = [inspect.getfile(enclosure), *helpers]
    if surface is not None and nearest is not None:
        register_surface(surface, nearest, *sources)
    else:
        _extend_by(enclosure.__module__, sources)


def register_surface(surface: type, nearest: Callable[..., Any], *sources: str | Path) -> None:
    """Let walls be curved as `nearest` says, where their numbers are of the type `surface`.

    nearest(surface, wall, x, y, z) is a plain function, which the engine compiles. Of the curved
    wall number `wall` (from 0) and a point in the enclosure's frame [m] it returns the distance to
    the nearest point of the wall [m], negative outside; the unit vector (x, y, z) that points
    there from inside; and the harmonic mean of the wall's radii of curvature [m], np.inf of a flat
    one.
    """
    _NEAREST[surface] = nearest
    _extend_by(surface.__module__, [inspect.getfile(nearest), *sources])


def nearest_of(surface: type) -> Callable[..., Any]:
    """Return the geometry of curved walls with numbers of a type; LookupError if there is none."""
    if surface not in _NEAREST:
        raise LookupError(f"{surface}: not registered; see damper3d.engine.enclosures.register")
    return _NEAREST[surface]


def _extend_by(module: str, sources: list[Any]) -> None:
    """Let the engine's compiled kernels be kept by these files too, where they stand outside."""
    outside = [path for path in map(Path, sources) if ENGINE not in path.resolve().parents]
    if outside:
        from granulab.contact.jit import extend  # numba is not needed before

        extend(ENGINE, module, *outside)


register(Cylinder, Round, nearest_round)
register(Box)
register(Frustum, Mantle, nearest_on_mantle)
register(Sphere, Ball, nearest_in_ball)
register(HexagonalPrism)
register(Polyhedron)
register(Cavity, Triangles, nearest_triangle)
register_surface(Sides, nearest_side)  # of cells, an array of boxes or cylinders
register_surface(Lines, nearest_line)
