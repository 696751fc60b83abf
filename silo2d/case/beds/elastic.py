"""Stiffness and damping of pairs whose table has no kn: from E, nu, restitution and the shapes.

A rounded corner on a flat face is a line contact (granulab.contact.prisms.line). Taken by
assumption: each body gives way down to the radius of a disc of the particles' mean area, walls too;
the secant is that at the weight of the column of material above one particle; one contact of mean
particles has the restitution of the table; there is no tangential damping.
"""

import dataclasses
import math
from typing import Any, NamedTuple

from granulab.contact.files.table import ContactTable
from granulab.contact.files.units import located
from granulab.contact.material import LinearParameters, Material, Measured, Pair
from granulab.contact.prisms.line import (
    Elastic,
    LineContact,
    half_width,
    line_stiffness,
    modulus_of_stiffness,
    ratio_limits,
    solid_of_stiffness,
)
from granulab.contact.restitution import damping_for_restitution
from granulab.contact.sphere_law import elastic
from granulab.errors import InputError
from silo2d.case.filling import GRAVITY
from silo2d.case.settings import Settings
from silo2d.case.shape import ShapeSet

Pairs = tuple[Pair, Pair]  # particle-particle, particle-wall
_FACE_TO_FACE = 8  # contacts of two aligned faces


class Touching(NamedTuple):
    """Contact of two particles, or of one and a wall."""

    line: LineContact
    faces: int  # contacts of two aligned faces; 0 of discs, and of a wall


# E and nu of particles and walls, None where they are not known; both contacts
Solids = tuple[tuple[Elastic | None, Elastic | None], tuple[Touching, ...]]


class Derived(NamedTuple):
    """Stiffness of a pair as it follows from its materials, and what it was taken from."""

    names: tuple[str, str]
    line: LineContact
    first: Elastic
    second: Elastic
    kn: float  # [N/m]
    kt: float  # [N/m]
    restitution: float | None  # that its damping follows from [-]; None: its damping is given
    faces: int  # see Touching

    @property
    def half_width(self) -> float:
        """Half-width of the contact [m] under the force of the secant."""
        return half_width(self.line, self.first, self.second)

    @property
    def tenth(self) -> float:
        """Stiffness at a tenth of the force, over that at the force [-]."""
        light = self.line._replace(force=self.line.force / 10)
        return line_stiffness(light, self.first, self.second)[0] / self.kn

    @property
    def block(self) -> float:
        """Stiffness [N/m] of two square blocks that touch in a face, from middle to middle."""
        compliance = sum((1 - nu**2) / modulus for modulus, nu in (self.first, self.second))
        return 2 * self.line.length / compliance

    def numbers(self) -> dict[str, Any]:
        """All of it under names with units, for JSON."""
        return {
            "pair": "-".join(self.names),
            "youngs_modulus_pa": [self.first[0], self.second[0]],
            "poisson": [self.first[1], self.second[1]],
            **_of_line(self.line),
            "half_width_m": self.half_width,
            "kn_n_per_m": self.kn,
            "kt_n_per_m": self.kt,
            "kn_at_a_tenth_of_the_force": self.tenth,
            "restitution": self.restitution,
        }


def solids_of(table: ContactTable, settings: Settings, shapes: ShapeSet) -> Solids:
    """Elastic constants of the materials of a case, and how its particles and walls touch."""
    material, wall = (table.material(name) for name in settings.particles.names)
    assert material.length is not None  # table_of has refused that
    length = material.length.value
    of_each = zip(shapes.shapes, shapes.shares, strict=True)
    radius = math.fsum(share * shape.spheroradius for shape, share in of_each)
    depth = math.sqrt(shapes.mean_area / math.pi)
    column = material.density.value * GRAVITY * settings.fill.level * 2 * depth * length
    at_wall = LineContact(length, radius, depth, column)
    if all(shape.is_disc for shape in shapes.shapes):
        among = Touching(at_wall._replace(radius=radius / 2), 0)
    else:
        among = Touching(at_wall, _FACE_TO_FACE)
    return (_known(material), _known(wall)), (among, Touching(at_wall, 0))


def _known(material: Material) -> Elastic | None:
    return elastic(material) if material.youngs_modulus and material.poisson else None


def with_elastic(
    pairs: Pairs, table: ContactTable, solids: Solids, settings: Settings, mean_mass: float
) -> tuple[Pairs, tuple[Derived, ...]]:
    """The pairs with what follows from E and nu where they have no kn and kt, and what it is.

    What the case gives goes before. Raises InputError for a modulus too low for a line contact.
    """
    whole, found = [], []
    for k, (pair, mass) in enumerate(zip(pairs, (mean_mass / 2, mean_mass), strict=True)):
        linear, (particle, wall) = pair.linear or LinearParameters(), solids[0]
        other = wall if k else particle
        if particle and other and linear.kn is None and linear.kt is None:
            names = settings.particles.names[0], settings.particles.names[k]
            with located(f"{table.path}: [pair.{'-'.join(names)}]"):
                derived = _derived(names, pair, particle, other, solids[1][k])
            pair = dataclasses.replace(pair, linear=_linear(linear, derived, mass, settings))
            given = settings.law.gamma_n is not None
            found.append(derived._replace(restitution=None) if given else derived)
        whole.append(pair)
    return (whole[0], whole[1]), tuple(found)


def _derived(
    names: tuple[str, str], pair: Pair, first: Elastic, second: Elastic, touching: Touching
) -> Derived:
    kn, kt = line_stiffness(touching.line, first, second)
    has_damping = pair.linear is not None and pair.linear.gamma_n is not None
    e = None if has_damping or pair.restitution is None else pair.restitution.value
    return Derived(names, touching.line, first, second, kn, kt, e, touching.faces)


def _linear(
    linear: LinearParameters, derived: Derived, mass: float, settings: Settings
) -> LinearParameters:
    """All four constants; of a kn that the case gives, kt in the ratio of the derived ones."""
    law, gamma_n = settings.law, linear.gamma_n
    kn = law.kn or derived.kn
    if derived.restitution is not None:
        gamma = damping_for_restitution(derived.restitution, kn, mass, end=law.contact_end)
        gamma_n = Measured(gamma)
    kt = Measured(kn * derived.kt / derived.kn)
    return LinearParameters(Measured(kn), kt, gamma_n, linear.gamma_t or Measured(0.0))


def in_words(derived: Derived) -> str:
    """A paragraph on what was derived, of what, and what was assumed."""
    line, (own, other) = derived.line, derived.names
    of = f"E {derived.first[0]:.4g} Pa, nu {derived.first[1]:g}"
    if own != other:
        of = f"{of} of {own}; E {derived.second[0]:.4g} Pa, nu {derived.second[1]:g} of {other}"
    words = [
        f"{own}-{other} from {of}: kn {derived.kn:.4g} N/m, kt {derived.kt:.4g} N/m by a line "
        f"contact in plane strain ({_line_in_words(line)}, half-width {derived.half_width:.2g} m)",
        f"each body gives way down to {line.depth:.3g} m, the radius of a disc of mean area",
        f"secant at {line.force:.3g} N, the weight of the column above a particle (at a tenth of "
        f"it kn is {100 * (1 - derived.tenth):.0f} % lower)",
        "kt without slip",
    ]
    if derived.faces:
        words.append(
            f"two faces, {derived.faces} contacts: {derived.faces * derived.kn:.3g} N/m, where "
            f"square blocks that touch in a face have {derived.block:.3g} N/m"
        )
    if derived.restitution is not None:
        words.append(
            f"gamma_n of restitution {derived.restitution:g} by one contact of mean particles, "
            "gamma_t 0"
        )
    return "; ".join(words)


class BothWays(NamedTuple):
    """Stiffness of a pair in a case, that of its materials, and the solid that has the case's."""

    names: tuple[str, str]
    line: LineContact
    kn: float  # of the case [N/m]
    kt: float  # [N/m]
    of_solids: tuple[float, float] | None  # kn and kt of the table's E and nu; None: not known
    solid: Elastic | None  # that has kn and kt of the case; None: there is none
    note: str  # the reason, where there is none
    at_poisson: tuple[float, float] | None  # E that has kn with the table's nu, and that nu

    def numbers(self) -> dict[str, Any]:
        """All of it under names with units, for JSON."""
        modulus, nu = self.solid or (None, None)
        own_kn, own_kt = self.of_solids or (None, None)
        return {
            "pair": "-".join(self.names),
            **_of_line(self.line),
            "kn_n_per_m": self.kn,
            "kt_n_per_m": self.kt,
            "kn_of_materials_n_per_m": own_kn,
            "kt_of_materials_n_per_m": own_kt,
            "youngs_modulus_pa": modulus,
            "poisson": nu,
            "note": self.note or None,
            "youngs_modulus_with_poisson_of_material_pa": self.at_poisson and self.at_poisson[0],
        }

    def lines(self) -> list[str]:
        """All of it for a person."""
        found = [f"{'-'.join(self.names)}: {_line_in_words(self.line)}, {self.line.force:.3g} N"]
        found.append(f"  in the case       kn {self.kn:.4g} N/m, kt {self.kt:.4g} N/m")
        if self.of_solids:
            kn, kt = self.of_solids
            found.append(f"  of its materials  kn {kn:.4g} N/m, kt {kt:.4g} N/m")
        if self.solid:
            modulus, nu = self.solid
            low, high = ratio_limits(self.line, self.kn)
            found.append(
                f"  back              E {modulus:.4g} Pa, nu {nu:.3f} (1 % of kt/kn is "
                f"{0.005 * (self.kt / self.kn) / (high - low):.2g} of nu)"
            )
        else:
            found.append(f"  back              {self.note}")
        if self.at_poisson:
            modulus, nu = self.at_poisson
            found.append(f"                    kn alone, with nu {nu:g}: E {modulus:.4g} Pa")
        return found


def both_ways(
    names: tuple[str, str], solids: Solids, laws: tuple[Any, Any]
) -> tuple[BothWays, BothWays]:
    """Stiffness and solids of the pairs of particles and of a particle and a wall.

    names: of both materials; laws: with kn and kt [N/m].
    """
    first, second = (
        _both_ways((names[0], names[k]), (solids[0][0], solids[0][k]), solids[1][k].line, law)
        for k, law in enumerate(laws)
    )
    return first, second


def _both_ways(
    names: tuple[str, str], solids: tuple[Elastic | None, Elastic | None], line: LineContact,
    law: Any,
) -> BothWays:  # fmt: skip
    own, other = solids
    solid, note, of_solids, at_poisson = None, "", None, None
    try:
        solid = solid_of_stiffness(line, law.kn, law.kt)
    except InputError as refused:
        note = str(refused)
    try:
        of_solids = line_stiffness(line, own, other) if own and other else None
        if own and own == other:
            at_poisson = modulus_of_stiffness(line, law.kn, own[1]), own[1]
    except InputError as refused:
        note = note or str(refused)
    return BothWays(names, line, law.kn, law.kt, of_solids, solid, note, at_poisson)


def _of_line(line: LineContact) -> dict[str, float]:
    return {
        "radius_m": line.radius,
        "length_m": line.length,
        "depth_m": line.depth,
        "force_n": line.force,
    }


def _line_in_words(line: LineContact) -> str:
    return f"reduced radius {line.radius:.3g} m, length {line.length:g} m"
