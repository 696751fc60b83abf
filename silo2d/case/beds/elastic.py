"""Stiffness and damping of pairs whose table has no kn: from E, nu, restitution and the shapes.

A rounded corner on a flat face is a line contact (granulab.contact.prisms.line). Taken by
assumption: each body gives way down to the radius of a disc of the particles' mean area, walls too;
the secant is that at the weight of the column of material above one particle; one contact of mean
particles has the restitution of the table; there is no tangential damping.
"""

import contextlib
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

PAIRS = ("particle_particle", "particle_wall")  # names in JSON
Pairs = tuple[Pair, Pair]  # particle-particle, particle-wall


class Solids(NamedTuple):
    """Elastic constants of the materials of a case, and the contacts of its particles."""

    particle: Elastic | None  # None: not known
    wall: Elastic | None
    lines: tuple[LineContact, LineContact]  # of two particles, and of a particle and a wall
    discs: bool  # particles without a face


class Derived(NamedTuple):
    """Stiffness of a pair as it follows from its materials, and what it was taken from."""

    names: tuple[str, str]
    line: LineContact
    first: Elastic
    second: Elastic
    kn: float  # [N/m]
    kt: float  # [N/m]
    restitution: float | None  # that its damping follows from [-]; None: its damping is given

    @property
    def half_width(self) -> float:
        """Half-width of the contact [m] under the force of the secant."""
        return half_width(self.line, self.first, self.second)

    @property
    def tenth(self) -> float:
        """Stiffness at a tenth of the force, over that at the force [-]."""
        light = self.line._replace(force=self.line.force / 10)
        return line_stiffness(light, self.first, self.second)[0] / self.kn

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
            "kn_ratio_at_a_tenth_of_the_force": self.tenth,
            "restitution": self.restitution,
        }


def solids_of(table: ContactTable, settings: Settings, shapes: ShapeSet) -> Solids:
    """Elastic constants of the materials of a case, and the contacts of its particles."""
    material, wall = (table.material(name) for name in settings.particles.names)
    assert material.length is not None  # table_of has refused that
    length = material.length.value
    of_each = zip(shapes.shapes, shapes.shares, strict=True)
    radius = math.fsum(share * shape.spheroradius for shape, share in of_each)
    depth = math.sqrt(shapes.mean_area / math.pi)
    column = material.density.value * GRAVITY * settings.fill.level * 2 * depth * length
    discs = all(shape.is_disc for shape in shapes.shapes)
    at_wall = LineContact(length, radius, depth, column)
    among = at_wall._replace(radius=radius / 2) if discs else at_wall
    return Solids(_known(material), _known(wall), (among, at_wall), discs)


def _known(material: Material) -> Elastic | None:
    return elastic(material) if material.youngs_modulus and material.poisson else None


def with_elastic(
    pairs: Pairs, table: ContactTable, solids: Solids, settings: Settings, mean_mass: float
) -> tuple[Pairs, tuple[Derived | None, Derived | None]]:
    """The pairs with what follows from E and nu where they have no kn and kt, and what it is.

    What the case gives goes before. Raises InputError for a modulus too low for a line contact.
    """
    (first, one), (second, other) = (
        _with_elastic(k, pair, table, solids, settings, mass)
        for k, (pair, mass) in enumerate(zip(pairs, (mean_mass / 2, mean_mass), strict=True))
    )
    return (first, second), (one, other)


def _with_elastic(
    k: int, pair: Pair, table: ContactTable, solids: Solids, settings: Settings, mass: float
) -> tuple[Pair, Derived | None]:
    """The same of the particles (k = 0), or of a particle and a wall (k = 1)."""
    linear, law = pair.linear or LinearParameters(), settings.law
    own, other = solids.particle, (solids.particle, solids.wall)[k]
    if own is None or other is None or linear.kn or linear.kt:
        return pair, None
    names = settings.particles.names[0], settings.particles.names[k]
    with located(f"{table.path}: [pair.{'-'.join(names)}]"):
        kn, kt = line_stiffness(solids.lines[k], own, other)
    stiffness = law.kn or kn  # kt in the ratio of the derived ones
    damping, restitution = linear.gamma_n, None
    if damping is None and pair.restitution is not None:
        e = pair.restitution.value
        damping = Measured(damping_for_restitution(e, stiffness, mass, end=law.contact_end))
        given = law.gamma_n is not None or (k == 1 and law.gamma_n_wall is not None)
        restitution = None if given else e
    whole = LinearParameters(
        Measured(stiffness), Measured(stiffness * kt / kn), damping,
        linear.gamma_t or Measured(0.0),
    )  # fmt: skip
    derived = Derived(names, solids.lines[k], own, other, kn, kt, restitution)
    return dataclasses.replace(pair, linear=whole), derived


def in_words(derived: Derived) -> str:
    """A sentence on what was derived, and of what."""
    line, (own, other) = derived.line, derived.names
    of = f"E {derived.first[0]:.4g} Pa, nu {derived.first[1]:g}"
    if own != other:
        of = f"{of} of {own}; E {derived.second[0]:.4g} Pa, nu {derived.second[1]:g} of {other}"
    words = (
        f"{own}-{other} from {of}: kn {derived.kn:.4g} N/m, kt {derived.kt:.4g} N/m "
        f"({_line_in_words(line)}, half-width {derived.half_width:.2g} m; at a tenth of the force "
        f"kn is {100 * (1 - derived.tenth):.0f} % lower)"
    )
    if derived.restitution is None:
        return words
    return (
        f"{words}; gamma_n from restitution {derived.restitution:g}, one contact of mean particles"
    )


def assumed(solids: Solids) -> str:
    """A sentence on what a line contact takes for granted."""
    line = solids.lines[0]
    words = (
        f"line contact in plane strain; kn is the secant at {line.force:.3g} N, the weight of the "
        f"column above a particle; each body gives way down to {line.depth:.3g} m, the radius of a "
        "disc of mean area; kt without slip"
    )
    if solids.discs:
        return words
    return (
        f"{words} and without the bending of corners: finite elements of a right-angled one on a "
        "face have a kt/kn some 15 % lower"
    )


class BothWays(NamedTuple):
    """Stiffness of a pair in a case, that of its materials, and the solid that has the case's."""

    names: tuple[str, str]
    line: LineContact
    kn: float  # of the case [N/m]
    kt: float  # [N/m]
    of_materials: tuple[float, float] | None  # kn and kt of the table's E and nu; None: not known
    solid: Elastic | None  # that has kn and kt of the case; None: there is none
    note: str | None  # the reason, where there is none
    by_kn: Elastic | None  # the solid that has the case's kn, and the nu of the table

    def numbers(self) -> dict[str, Any]:
        """All of it under names with units, for JSON."""
        modulus, nu = self.solid or (None, None)
        own_kn, own_kt = self.of_materials or (None, None)
        return {
            "pair": "-".join(self.names),
            **_of_line(self.line),
            "kn_n_per_m": self.kn,
            "kt_n_per_m": self.kt,
            "kn_of_materials_n_per_m": own_kn,
            "kt_of_materials_n_per_m": own_kt,
            "youngs_modulus_pa": modulus,
            "poisson": nu,
            "note": self.note,
            "youngs_modulus_with_poisson_of_material_pa": self.by_kn and self.by_kn[0],
        }

    def lines(self) -> list[str]:
        """All of it for a person, below a head."""
        found = [f"  of the case       kn {self.kn:.4g} N/m, kt {self.kt:.4g} N/m"]
        if self.of_materials:
            kn, kt = self.of_materials
            found.append(f"  of its materials  kn {kn:.4g} N/m, kt {kt:.4g} N/m")
        if self.solid:
            modulus, nu = self.solid
            least, most = ratio_limits(self.line, self.kn)
            of_nu = 0.01 * 0.5 * (self.kt / self.kn) / (most - least)  # of its range, 0 to 0.5
            found.append(
                f"  elastic solid     E {modulus:.4g} Pa, nu {nu:.3f}; 1 % of kt/kn moves nu by "
                f"about {of_nu:.2g}"
            )
        else:
            found.append(f"  elastic solid     {self.note}")
        if self.by_kn:
            modulus, nu = self.by_kn
            found.append(
                f"  by kn alone       E {modulus:.4g} Pa with nu {nu:g} of {self.names[0]}"
            )
        return found


def both_ways(names: tuple[str, str], solids: Solids, laws: tuple[Any, Any]) -> list[BothWays]:
    """Stiffness and solids of the pairs of particles and of a particle and a wall.

    names: of both materials; laws: with kn and kt [N/m].
    """
    found = []
    for k, (line, law) in enumerate(zip(solids.lines, laws, strict=True)):
        own, other = solids.particle, (solids.particle, solids.wall)[k]
        solid, by_kn, note, of_materials = None, None, None, None
        try:
            if own and own == other:
                by_kn = modulus_of_stiffness(line, law.kn, own[1]), own[1]
            solid = solid_of_stiffness(line, law.kn, law.kt)
        except InputError as refused:
            note = str(refused)
        with contextlib.suppress(InputError):  # too soft for a line contact
            of_materials = line_stiffness(line, own, other) if own and other else None
        pair = names[0], names[k]
        found.append(BothWays(pair, line, law.kn, law.kt, of_materials, solid, note, by_kn))
    return found


def in_lines(pairs: list[BothWays], solids: Solids) -> str:
    """All of it for a person: each pair below a head, walls that are as particles with these."""
    particles, walls = pairs
    heads = {f"particles, {'-'.join(particles.names)}": particles}
    if walls == particles:
        heads = {f"particles and walls, {particles.names[0]}": particles}
    else:
        heads[f"walls, {'-'.join(walls.names)}"] = walls
    found = []
    for head, one in heads.items():
        found += [f"{head}: {_line_in_words(one.line)}", *one.lines()]
    found.append(
        f"assumed             {assumed(solids)}; the elastic solid is the material of both bodies"
    )
    return "\n".join(found)


def _of_line(line: LineContact) -> dict[str, float]:
    return {
        "radius_m": line.radius,
        "length_m": line.length,
        "depth_m": line.depth,
        "force_n": line.force,
    }


def _line_in_words(line: LineContact) -> str:
    return f"reduced radius {line.radius:.3g} m, length {line.length:g} m"
