"""Beds of unlike particles: several kinds, by count or mass, of shapes and sizes of their own."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.contacts import Ball, Pairing
from damper3d.case.oscillation import equivalent_sphere_radius
from damper3d.case.parts import mesh_copy, particle_wanted
from damper3d.case.settings import Kind, Particles
from damper3d.case.sizes import counts_of, sizes_of
from damper3d.engine.enclosures import Cells, Enclosure
from damper3d.engine.laws.table import Contact, LawTable, law_table
from damper3d.shapes.multisphere import MultiSphere, sphere
from damper3d.shapes.surfaces.surface import Surface
from granulab.contact.files.units import located
from granulab.contact.material import Material
from granulab.errors import InputError

_GRID = 1000  # quantiles that a mean volume is taken over
_NO_SURFACE = Surface(np.zeros((0, 3)), np.zeros((0, 3), np.int64))
_STREAM = 0x5123  # of the sizes: the filling draws from the seed alone


@dataclass(frozen=True, eq=False)
class Sort:
    """One kind of particle."""

    name: str  # such as "sphere:5mm"
    material: Material
    shape: MultiSphere  # of any size
    radius: np.ndarray  # (count,) of the sphere of the same volume [m]
    mesh: dict[str, str]  # file of its shape for the run folder, where it has one: name and text

    @property
    def ball(self) -> Ball:
        """The sphere of the mean radius of the kind, or the particle of that size."""
        radius = float(self.radius.mean()) if np.ptp(self.radius) else float(self.radius[0])
        mass = self.material.density.value * 4.0 / 3.0 * math.pi * radius**3
        return Ball(self.material, self.of_size(radius).smallest_radius, mass)

    @property
    def mass(self) -> float:
        """Mass of all of them [kg]."""
        return self.material.density.value * float((4.0 / 3.0 * math.pi * self.radius**3).sum())

    @property
    def smallest(self) -> MultiSphere:
        """The smallest of them."""
        return self.of_size(float(self.radius.min()))

    def of_size(self, radius: float) -> MultiSphere:
        """The particle of the volume of the sphere of a radius [m]."""
        if self.shape.is_sphere:
            return sphere(radius)
        own = self.shape.equal_volume_radius
        return self.shape if radius == own else self.shape.scaled(radius / own)

    @property
    def particles(self) -> list[MultiSphere]:
        """Each of them (count,), without its surface; those of one size are one object."""
        bare, own = replace(self.shape, surface=_NO_SURFACE), self.shape.equal_volume_radius
        own = float(self.shape.radii[0]) if self.shape.is_sphere else own
        made = {radius: bare.scaled(radius / own) for radius in np.unique(self.radius).tolist()}
        return [made[radius] for radius in self.radius.tolist()]


@dataclass(frozen=True, eq=False)
class Bed:
    """Particles of one kind or more, kind by kind; SI."""

    sorts: tuple[Sort, ...]

    @property
    def of_spheres(self) -> bool:
        """True where all are spheres."""
        return all(sort.shape.is_sphere for sort in self.sorts)

    @cached_property
    def radius(self) -> np.ndarray:
        """Radius of each particle, or of the sphere of its volume (n,) [m]."""
        return np.concatenate([sort.radius for sort in self.sorts])

    @cached_property
    def kind(self) -> np.ndarray:
        """Number of the kind of each particle (n,)."""
        return np.repeat(np.arange(len(self.sorts)), [len(sort.radius) for sort in self.sorts])

    @cached_property
    def density(self) -> np.ndarray:
        """Density of each particle (n,) [kg/m3]."""
        return np.array([sort.material.density.value for sort in self.sorts])[self.kind]

    @cached_property
    def volume(self) -> np.ndarray:
        """Volume of each particle (n,) [m3]."""
        return 4.0 / 3.0 * np.pi * self.radius**3

    @cached_property
    def particles(self) -> list[MultiSphere]:
        """Each particle (n,), as spheres that move together."""
        return [one for sort in self.sorts for one in sort.particles]

    @property
    def sub_spheres(self) -> np.ndarray:
        """Number of spheres of each particle (n,)."""
        return np.array([len(sort.shape.radii) for sort in self.sorts])[self.kind]

    @property
    def bounding_radius(self) -> np.ndarray:
        """Radius of the sphere round each particle (n,) [m]."""
        if self.of_spheres:
            return self.radius
        return np.array([one.bounding_radius for one in self.particles])

    @property
    def mean_density(self) -> float:
        """Mass of all over their volume [kg/m3]."""
        return float((self.volume * self.density).sum() / self.volume.sum())

    @property
    def mean_sphere(self) -> MultiSphere:
        """The sphere of the mean volume, that stands for all where one number is asked.

        No packing is known for its name (random_packing.py): unlike particles pack closer.
        """
        radius = (0.75 * float(self.volume.mean()) / math.pi) ** (1 / 3)
        return sphere(radius, f"mixture: {' + '.join(sort.name for sort in self.sorts)}")

    @property
    def identity(self) -> list[Any]:
        """All of it that a packing depends on."""
        shapes = [[one.offsets, one.radii, one.volume, one.inertia]
                  for one in (sort.shape for sort in self.sorts)]  # fmt: skip
        return [self.radius, self.kind, self.density, *([] if self.of_spheres else [shapes])]

    def described(self) -> list[dict[str, Any]]:
        """The kinds in numbers, for the results of a run."""
        whole = sum(sort.mass for sort in self.sorts)
        return [
            {
                "particles": sort.name,
                "material": sort.material.name,
                "sub_spheres": len(sort.shape.radii),
                "count": len(sort.radius),
                "mass_kg": sort.mass,
                "mass_fraction": sort.mass / whole,
                "diameter_m": {
                    "mean": 2.0 * float(sort.radius.mean()),
                    "sd": 2.0 * float(sort.radius.std()) if np.ptp(sort.radius) else 0.0,
                    "smallest": 2.0 * float(sort.radius.min()),
                    "largest": 2.0 * float(sort.radius.max()),
                },
            }
            for sort in self.sorts
        ]

    def swiftest(self, tangential: float) -> list[tuple[MultiSphere, Material, float]]:
        """Particles that may need the shortest step: the smallest of each kind, its material.

        And how much faster its contacts may oscillate than on a wall: a sphere meets as many
        sub-spheres of another kind at once as that kind does of a wall, at most.
        """
        others = [sort.shape for sort in self.sorts if not sort.shape.is_sphere]
        faster = max((one.equal_volume_radius / equivalent_sphere_radius(one, tangential)
                      for one in others), default=1.0)  # fmt: skip
        return [
            (sort.smallest, sort.material, faster if sort.shape.is_sphere else 1.0)
            for sort in self.sorts
        ]


def table_of_laws(
    walls: np.ndarray, kind: np.ndarray, radii: np.ndarray, pairings: Sequence[Pairing],
    more: tuple[float, tuple[float, float, float]], cohesion: Any,
) -> LawTable:  # fmt: skip
    """The laws of spheres by their kinds (m,), as the engine takes them.

    walls (n_walls,): kind of each, after those of particles; pairings in the order of `pairs_of`;
    more: surface energy [J/m2] and rolling resistance.
    """
    sorts, last = int(walls.min()), int(walls.max())
    number = np.zeros((last + 1, last + 1), np.int64)
    for n, (a, b) in enumerate(pairs_of(sorts, last + 1 - sorts)):
        number[a, b] = number[b, a] = n
    contacts = [Contact(pairing.law, *more) for pairing in pairings]
    return law_table(contacts, number, kind, radii, cohesion, walls=walls)


def pairs_of(sorts: int, walls: int) -> list[tuple[int, int]]:
    """Each two kinds, then each with the walls of each material, the kinds after the last."""
    both = [(a, b) for a in range(sorts) for b in range(a, sorts)]
    return both + [(a, sorts + b) for b in range(walls) for a in range(sorts)]


def is_mixed(particles: Particles) -> bool:
    """True where the particles of a case are not all alike."""
    return particles.kind is not None or _is_distributed(particles)


def _is_distributed(given: Particles | Kind) -> bool:
    keys = (given.size_distribution, given.size_deviation, given.sieve)
    return any(value is not None for value in keys)


def bed_of(
    particles: Particles, materials: Sequence[Material], enclosure: Enclosure, seed: int,
    where: str, folder: Path,
) -> Bed:  # fmt: skip
    """The particles of a mixture, or of a distribution; InputError where there can be none.

    materials: of the kinds, in their order; folder: where their meshes are looked for first.
    """
    kinds = _kinds(particles, where)
    names = [f"{where}: [[particles.kind]] {n + 1}:" for n in range(len(kinds))]
    if particles.kind is None:
        names = [f"{where}: [particles]"]
    shapes, sizes, meshes = [], [], []
    for given, name in zip(kinds, names, strict=True):
        with located(name):
            shape, size = sizes_of(given, folder)
            meshes.append(mesh_copy(particle_wanted(given, folder)))
        shapes.append(shape)
        sizes.append(size)
    _check_names(meshes, names)
    grid = (np.arange(_GRID) + 0.5) / _GRID
    volumes = [math.pi / 6.0 * float((size(grid) ** 3).mean()) for size in sizes]
    counts = counts_of(particles, kinds, materials, volumes, enclosure, where)
    sorts = []
    for n, (given, size, count) in enumerate(zip(kinds, sizes, counts, strict=True)):
        rng = np.random.default_rng([_STREAM, seed, n])
        quantile = (rng.permutation(count) + rng.uniform(size=count)) / count
        radius = 0.5 * size(quantile)
        sorts.append(Sort(_name(given), materials[n], shapes[n], radius, meshes[n]))
    bed = Bed(tuple(sorts))
    _check_room(bed, enclosure, where)
    return bed


def _check_names(meshes: list[dict[str, str]], names: list[str]) -> None:
    """Raise InputError where two meshes would have one name in the run folder."""
    kept: dict[str, str] = {}
    for mesh, name in zip(meshes, names, strict=True):
        for file, text in mesh.items():
            if kept.setdefault(file, text) != text:
                raise InputError(
                    f"{name} shape: another kind's mesh is called {Path(file).stem!r} too, and is "
                    "not the same; rename one of the files"
                )


def _kinds(particles: Particles, where: str) -> list[Particles | Kind]:
    if particles.kind is None:
        return [particles]
    usual = Particles()
    for key in ("shape", "size_distribution", "size_deviation", "sieve", "equal_volume_radius",
                "sub_spheres", "tolerance", "mesh_unit"):  # fmt: skip
        if getattr(particles, key) != getattr(usual, key):
            raise InputError(
                f"{where}: [particles] {key} and [[particles.kind]] are both given; say it in each "
                "kind"
            )
    if not particles.kind:
        raise InputError(f"{where}: [particles] kind: holds no kind; give one, or leave it out")
    return list(particles.kind)


def _name(given: Particles | Kind) -> str:
    shape = given.shape.replace(" ", "")
    return f"{shape} ({given.size_distribution})" if given.size_distribution else shape


def _check_room(bed: Bed, enclosure: Enclosure, where: str) -> None:
    if isinstance(enclosure, Cells):
        raise InputError(
            f"{where}: [enclosure] cells hold particles that are all alike: the first cells would "
            "get the first kind; leave cells out, or give one kind and size"
        )
    largest = 2.0 * float(bed.bounding_radius.max())
    if enclosure.narrowest < largest:
        raise InputError(
            f"{where}: [enclosure] {1e3 * enclosure.narrowest:g} mm at the narrowest: smaller than "
            f"a particle, {1e3 * largest:g} mm; give a larger enclosure or smaller particles"
        )
    fill = float(bed.volume.sum()) / enclosure.volume
    if fill >= 1.0:
        raise InputError(
            f"{where}: [particles] {len(bed.radius)} particles: fill ratio {fill:.3f}, above 1; "
            "give fewer, or a larger enclosure"
        )
