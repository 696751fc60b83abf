"""Particles of any closed surface, as a file has it in triangles."""

import math
from pathlib import Path

from damper3d.shapes.surfaces.mesh_check import sound
from damper3d.shapes.surfaces.mesh_data import mass_of, principal_axes, read_triangles
from damper3d.shapes.surfaces.solid import Solid
from damper3d.shapes.surfaces.surface import Surface
from granulab.contact.files.casefile import of_a_size
from granulab.contact.files.units import to_si
from granulab.errors import InputError


def read_mesh(path: Path) -> tuple[Solid, float]:
    """The solid in a file, at an equal-volume radius of 1 m, and its own one in the file's unit.

    Raises InputError, one line, where the file cannot be read or holds no sound closed surface.
    """
    surface = sound(read_triangles(path), str(path))
    mass = mass_of(surface.corners)
    moments, axes = principal_axes(mass.inertia)
    radius = (0.75 * mass.volume / math.pi) ** (1 / 3)
    vertices = (surface.vertices - mass.centroid) @ axes / radius
    volume = mass.volume / radius**3
    return Solid(
        surface=Surface(vertices, surface.triangles),
        flatness=0.0,
        volume=volume,
        area=mass.area / radius**2,
        inertia=moments / radius**5,
    ), radius


def unit_of(text: str, key: str = "mesh_unit") -> float:
    """The length [m] that one stands for in a file, from "mm" or "25.4 mm"; InputError else."""
    length = to_si(text if text[:1].isdigit() else f"1 {text}", "m", key)
    if length <= 0.0:
        raise InputError(f"{key} = {text!r}: must be above 0, such as 'mm'")
    try:
        return of_a_size(length, key)
    except ValueError as error:
        raise InputError(str(error)) from None
