"""The particle that a text names: "sphere:5mm", "prolate:1.5", "toroid:0.2", "mesh:rock.stl"."""

import dataclasses
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from damper3d.shapes import FAMILIES
from damper3d.shapes.family import Family
from damper3d.shapes.mesh import read_mesh, unit_of
from damper3d.shapes.multisphere import MultiSphere, sphere
from damper3d.shapes.surfaces.solid import filled
from granulab.contact.files.units import nearest, to_si
from granulab.errors import InputError

_MESH = Family("mesh:rock.stl", None)


@dataclass(frozen=True)
class Particle:
    """Shape that a case requests."""

    text: str  # such as "prolate:1.5"
    equal_volume_radius: float | None = None  # [m]; None: the text's or the family's usual one
    sub_spheres: int | None = None  # None: the family's usual number, or by the tolerance
    tolerance: float | None = None  # of the surface, over the equal-volume radius [-]
    mesh_unit: str | None = None  # of a mesh that keeps its size, such as "mm"
    folder: Path = Path()  # where a mesh lies

    @property
    def kind(self) -> str:
        """The family."""
        return self.text.partition(":")[0].strip()

    @property
    def values(self) -> str:
        """Text behind the colon."""
        return self.text.partition(":")[2].strip()

    @property
    def mesh(self) -> Path | None:
        """The file, where there is one."""
        return self.folder / self.values if self.kind == "mesh" else None


def parse_particle(
    text: str, equal_volume_radius: float | None = None, *, sub_spheres: int | None = None,
    tolerance: float | None = None, mesh_unit: str | None = None, folder: Path = Path(),
) -> MultiSphere:  # fmt: skip
    """The particle that a text names, see Particle; InputError, one line, where there is none."""
    return particle_of(
        Particle(text, equal_volume_radius, sub_spheres, tolerance, mesh_unit, folder)
    )


def particle_of(wanted: Particle) -> MultiSphere:
    """The particle of a case; InputError, one line, where there is none."""
    _check(wanted)
    if wanted.kind == "sphere":
        return _sphere(wanted.text, wanted.values, wanted.equal_volume_radius)
    radius = wanted.equal_volume_radius
    if wanted.mesh is not None:
        particle, own = _mesh(wanted.mesh, wanted.sub_spheres, wanted.tolerance)
        if wanted.mesh_unit is not None:
            radius = own * unit_of(wanted.mesh_unit)
    else:
        particle = _shaped(wanted.kind, wanted.values, wanted.sub_spheres, wanted.tolerance)
    return particle.scaled(usual(wanted.kind).radius if radius is None else radius)


def usual(kind: str) -> Family:
    """The family of shapes that are no spheres."""
    return FAMILIES.get(kind, _MESH)


def _check(wanted: Particle) -> None:
    """Raise InputError where the family is unknown or what is given does not go together."""
    text, kinds = wanted.text, ["sphere", *FAMILIES, "mesh"]
    if wanted.kind not in kinds:
        raise InputError(
            f"shape = {text!r}: unknown; {nearest(wanted.kind, kinds)}; write such as 'sphere:5mm' "
            "or 'prolate:1.5'"
        )
    if wanted.sub_spheres is not None and wanted.tolerance is not None:
        raise InputError(
            f"sub_spheres = {wanted.sub_spheres} and tolerance = {wanted.tolerance:g} are both "
            "given; leave one of them out"
        )
    if wanted.kind == "sphere" and (wanted.sub_spheres, wanted.tolerance) != (None, None):
        name = "tolerance" if wanted.sub_spheres is None else "sub_spheres"
        raise InputError(f"{name} goes with other shapes; {text!r} is one sphere; leave it out")
    if wanted.mesh_unit is not None and wanted.kind != "mesh":
        raise InputError(f"mesh_unit goes with a mesh; shape = {text!r} is none; leave it out")
    if wanted.mesh_unit is None:
        return
    unit_of(wanted.mesh_unit)
    if wanted.equal_volume_radius is not None:
        raise InputError(
            f"mesh_unit = {wanted.mesh_unit!r} keeps the size of the mesh, and equal_volume_radius "
            "is given too; leave one of them out"
        )


def _sphere(text: str, size: str, equal_volume_radius: float | None) -> MultiSphere:
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


@cache
def _shaped(
    kind: str, values: str, sub_spheres: int | None, tolerance: float | None
) -> MultiSphere:
    """A particle of a family at an equal-volume radius of 1 m."""
    build = FAMILIES[kind].build
    assert build is not None  # as of a mesh
    made = build(FAMILIES[kind].numbers(kind, values), sub_spheres, tolerance)
    return dataclasses.replace(made, name=f"{kind}:{values}", kind=kind)


def _mesh(
    path: Path, sub_spheres: int | None, tolerance: float | None
) -> tuple[MultiSphere, float]:
    """The particle at an equal-volume radius of 1 m, and its own one in the file's unit."""
    try:
        state = path.stat()
        stamp = (state.st_mtime_ns, state.st_size)
    except (OSError, ValueError):
        stamp = (0, 0)  # reading it says what is wrong
    return _kept_mesh(path.absolute(), stamp, path, sub_spheres, tolerance)


@cache
def _kept_mesh(
    _place: Path, _stamp: tuple[int, int], path: Path, sub_spheres: int | None,
    tolerance: float | None,
) -> tuple[MultiSphere, float]:  # fmt: skip
    solid, own = read_mesh(path)
    return filled(solid, "mesh", sub_spheres, tolerance, f"mesh:{path.stem}"), own
