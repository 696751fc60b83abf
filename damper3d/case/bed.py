"""Beds of unlike spheres: several kinds, by count or mass, and distributed sizes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from damper3d.case.contacts import Ball, Pairing
from damper3d.case.parts import USUAL_FILL_RATIO
from damper3d.case.settings import MOST_PARTICLES, Kind, Particles
from damper3d.engine.enclosures import Cells, Enclosure
from damper3d.engine.laws.table import Contact, LawTable, law_table
from damper3d.shapes.multisphere import MultiSphere, sphere
from damper3d.shapes.particle import parse_particle
from granulab.contact.files.units import located, to_si
from granulab.contact.material import Material
from granulab.errors import InputError

_CUT = 3.0  # standard deviations at which a distribution is cut off on both sides
_GRID = 1000  # quantiles that a mean volume is taken over
_ADD_UP = 1e-3  # by which mass fractions may miss 1, as people round thirds
_STREAM = 0x5123  # of the sizes: the filling draws from the seed alone


@dataclass(frozen=True, eq=False)
class Sort:
    """One kind of sphere."""

    name: str  # such as "sphere:5mm"
    material: Material
    radius: np.ndarray  # (count,) [m]

    @property
    def ball(self) -> Ball:
        """The sphere of the mean radius of the kind."""
        radius = float(self.radius.mean()) if np.ptp(self.radius) else float(self.radius[0])
        mass = self.material.density.value * 4.0 / 3.0 * math.pi * radius**3
        return Ball(self.material, radius, mass)

    @property
    def mass(self) -> float:
        """Mass of all of them [kg]."""
        return self.material.density.value * float((4.0 / 3.0 * math.pi * self.radius**3).sum())


@dataclass(frozen=True, eq=False)
class Bed:
    """Spheres of one kind or more, kind by kind; SI."""

    sorts: tuple[Sort, ...]

    @cached_property
    def radius(self) -> np.ndarray:
        """Radius of each sphere (n,) [m]."""
        return np.concatenate([sort.radius for sort in self.sorts])

    @cached_property
    def kind(self) -> np.ndarray:
        """Number of the kind of each sphere (n,)."""
        return np.repeat(np.arange(len(self.sorts)), [len(sort.radius) for sort in self.sorts])

    @cached_property
    def density(self) -> np.ndarray:
        """Density of each sphere (n,) [kg/m3]."""
        return np.array([sort.material.density.value for sort in self.sorts])[self.kind]

    @cached_property
    def volume(self) -> np.ndarray:
        """Volume of each sphere (n,) [m3]."""
        return 4.0 / 3.0 * np.pi * self.radius**3

    @property
    def mean_density(self) -> float:
        """Mass of all over their volume [kg/m3]."""
        return float((self.volume * self.density).sum() / self.volume.sum())

    @property
    def mean_sphere(self) -> MultiSphere:
        """The sphere of the mean volume, that stands for all where one number is asked.

        No packing is known for its name (random_packing.py): unlike spheres pack closer.
        """
        radius = (0.75 * float(self.volume.mean()) / math.pi) ** (1 / 3)
        return sphere(radius, f"mixture: {' + '.join(sort.name for sort in self.sorts)}")

    def described(self) -> list[dict[str, Any]]:
        """The kinds in numbers, for the results of a run."""
        whole = sum(sort.mass for sort in self.sorts)
        return [
            {
                "particles": sort.name,
                "material": sort.material.name,
                "count": len(sort.radius),
                "mass_kg": sort.mass,
                "mass_fraction": sort.mass / whole,
                "diameter_m": {
                    "mean": 2.0 * float(sort.radius.mean()),
                    "sd": 2.0 * float(sort.radius.std()),
                    "smallest": 2.0 * float(sort.radius.min()),
                    "largest": 2.0 * float(sort.radius.max()),
                },
            }
            for sort in self.sorts
        ]


def table_of_laws(
    walls: np.ndarray, kind: np.ndarray, radii: np.ndarray, pairings: Sequence[Pairing],
    more: tuple[float, tuple[float, float, float]], cohesion: Any,
) -> LawTable:  # fmt: skip
    """The laws of spheres by their kinds (n,), as the engine takes them.

    walls (n_walls,): kind of each, after those of spheres; pairings in the order of `pairs_of`;
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
    """True where the spheres of a case are not all alike."""
    return particles.kind is not None or _is_distributed(particles)


def _is_distributed(given: Particles | Kind) -> bool:
    keys = (given.size_distribution, given.size_deviation, given.sieve)
    return any(value is not None for value in keys)


def bed_of(
    particles: Particles, materials: Sequence[Material], enclosure: Enclosure, seed: int, where: str
) -> Bed:
    """The spheres of a mixture, or of a distribution; InputError where there can be none.

    materials: of the kinds, in their order.
    """
    kinds = _kinds(particles, where)
    names = [f"{where}: [[particles.kind]] {n + 1}:" for n in range(len(kinds))]
    if particles.kind is None:
        names = [f"{where}: [particles]"]
    sizes = []
    for given, name in zip(kinds, names, strict=True):
        with located(name):
            sizes.append(_diameters_of(given))
    grid = (np.arange(_GRID) + 0.5) / _GRID
    volumes = [math.pi / 6.0 * float((size(grid) ** 3).mean()) for size in sizes]
    counts = _counts(particles, kinds, materials, volumes, enclosure, where)
    sorts = []
    for n, (given, size, count) in enumerate(zip(kinds, sizes, counts, strict=True)):
        rng = np.random.default_rng([_STREAM, seed, n])
        quantile = (rng.permutation(count) + rng.uniform(size=count)) / count
        sorts.append(Sort(_name(given), materials[n], 0.5 * size(quantile)))
    bed = Bed(tuple(sorts))
    _check_room(bed, enclosure, where)
    return bed


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


def _diameters_of(given: Particles | Kind) -> Any:
    """The function from quantiles, 0 to 1, to diameters [m] of a kind."""
    distribution, deviation = given.size_distribution, given.size_deviation
    if distribution == "sieve":
        if given.shape.strip() not in ("sphere", Particles().shape):
            raise InputError(
                f"shape = {given.shape!r}: a sieve table gives the sizes; write shape = 'sphere'"
            )
        if deviation is not None:
            raise InputError("size_deviation goes with 'normal' and 'lognormal'; leave it out")
        return _sieved(given.sieve)
    if given.sieve is not None:
        raise InputError("sieve goes with size_distribution = 'sieve'; give that, or leave it out")
    particle = parse_particle(given.shape)
    if not particle.is_sphere:
        raise InputError(
            f"shape = {given.shape!r}: mixtures and distributions are of spheres, such as "
            "'sphere:5mm'"
        )
    mean = 2.0 * float(particle.radii[0])
    if distribution is None:
        if deviation is not None:
            raise InputError("size_deviation: size_distribution is missing, such as 'normal'")
        return lambda quantile: np.full(len(quantile), mean)
    if deviation is None:
        raise InputError(
            f"size_distribution = {distribution!r}: size_deviation is missing, such as '0.2 mm'"
        )
    _check_width(distribution, mean, deviation)
    return _normal(mean, deviation) if distribution == "normal" else _lognormal(mean, deviation)


def _check_width(distribution: str, mean: float, deviation: float) -> None:
    most = mean / _CUT if distribution == "normal" else mean
    if deviation >= most:
        raise InputError(
            f"size_deviation = {1e3 * deviation:g} mm: wider than its mean of {1e3 * mean:g} mm "
            f"takes; give less than {1e3 * most:.3g} mm"
            + (", or 'lognormal'" if distribution == "normal" else "")
        )


def _between_cuts(quantile: np.ndarray) -> np.ndarray:
    """The standard normal variable of quantiles of its part within the cuts."""
    from scipy.special import ndtr, ndtri

    return ndtri(ndtr(-_CUT) + quantile * (ndtr(_CUT) - ndtr(-_CUT)))


def _normal(mean: float, deviation: float) -> Any:
    return lambda quantile: mean + deviation * _between_cuts(quantile)


def _lognormal(mean: float, deviation: float) -> Any:
    """The diameter has this mean and deviation; its logarithm is normal."""
    width = math.sqrt(math.log1p((deviation / mean) ** 2))
    return lambda quantile: mean * np.exp(width * _between_cuts(quantile) - 0.5 * width**2)


def _sieved(table: list[list[Any]] | None) -> Any:
    """Sizes of a sieve table: between two sieves mass is spread evenly over the diameter.

    The number of spheres is then spread as d^-3: in a class from a to b its share goes as the mass
    times (a^-2 - b^-2)/(2 (b - a)), and d^-2 is even.
    """
    if table is None:
        raise InputError(
            'size_distribution = \'sieve\': sieve is missing, such as [["2 mm", 0], ["4 mm", 1]]'
        )
    sieve = np.array([to_si(row[0], "m", "sieve") for row in table])
    passing = np.array([to_si(row[1], "1", "sieve") for row in table])
    if len(sieve) < 2 or sieve[0] <= 0.0 or (np.diff(sieve) <= 0.0).any():
        raise InputError("sieve: sizes must be above 0 and ascend, two at least")
    if passing[0] != 0.0 or passing[-1] != 1.0 or (np.diff(passing) < 0.0).any():
        raise InputError(
            "sieve: the share of the mass that passes must rise from 0 at the finest to 1 at the "
            "coarsest"
        )
    low, high = sieve[:-1] ** -2.0, sieve[1:] ** -2.0
    number = np.diff(passing) * (low - high) / np.diff(sieve)
    edge = np.append(0.0, np.cumsum(number / number.sum()))

    def diameters(quantile: np.ndarray) -> np.ndarray:
        k = np.clip(np.searchsorted(edge, quantile, side="right") - 1, 0, len(low) - 1)
        part = (quantile - edge[k]) / (edge[k + 1] - edge[k])
        return (low[k] + part * (high[k] - low[k])) ** -0.5

    return diameters


def _counts(
    particles: Particles, kinds: list[Particles | Kind], materials: Sequence[Material],
    volumes: list[float], enclosure: Enclosure, where: str,
) -> list[int]:  # fmt: skip
    """Return how many of each kind there are."""
    if particles.kind is None:
        shares = [1.0]
    else:
        given = [kind.count for kind in particles.kind]
        if all(count is not None for count in given):
            for key in ("count", "fill_ratio"):
                if getattr(particles, key) is not None:
                    raise InputError(
                        f"{where}: [particles] {key} and the count of each kind are both given; "
                        "leave one of them out"
                    )
            return [count for count in given if count is not None]
        fractions = _fractions(particles.kind, where)
        each = [
            fraction / (material.density.value * volume)
            for fraction, material, volume in zip(fractions, materials, volumes, strict=True)
        ]
        shares = [share / sum(each) for share in each]
    mean = sum(share * volume for share, volume in zip(shares, volumes, strict=True))
    fill_ratio = particles.fill_ratio or USUAL_FILL_RATIO
    whole = particles.count or max(round(fill_ratio * enclosure.volume / mean), 1)
    if particles.count and particles.fill_ratio and abs(
        whole * mean - fill_ratio * enclosure.volume
    ) > mean:  # fmt: skip
        raise InputError(
            f"{where}: [particles] count = {whole} and fill_ratio = {fill_ratio:g} are both given, "
            f"and are not the same ({whole * mean / enclosure.volume:.4g}); leave one of them out"
        )
    if whole > MOST_PARTICLES:
        raise InputError(
            f"{where}: [particles] count = {whole}, from the usual fill ratio: must be at most "
            f"{MOST_PARTICLES}; check the units of sizes, or give a count"
        )
    wanted = np.array(shares) * whole
    counts = np.floor(wanted).astype(int)
    rest = np.argsort(counts - wanted, kind="stable")  # the largest remainders first
    counts[rest[: whole - int(counts.sum())]] += 1
    for n, count in enumerate(counts):
        if not count:
            raise InputError(
                f"{where}: [[particles.kind]] {n + 1}: its mass_fraction is less than one sphere "
                f"of {whole}; give more of it, or a larger count"
            )
    return counts.tolist()


def _fractions(kinds: Sequence[Kind], where: str) -> list[float]:
    """Mass fractions that add up to 1."""
    known = [kind.mass_fraction for kind in kinds]
    if any(kind.count is not None for kind in kinds) or None in known:
        raise InputError(
            f"{where}: [[particles.kind]]: give every kind a count, or every kind a mass_fraction"
        )
    fractions = [fraction for fraction in known if fraction is not None]
    if abs(sum(fractions) - 1.0) > _ADD_UP:
        raise InputError(
            f"{where}: [[particles.kind]] mass_fraction: they add up to {sum(fractions):.6g}; they "
            "must add up to 1"
        )
    return [fraction / sum(fractions) for fraction in fractions]


def _check_room(bed: Bed, enclosure: Enclosure, where: str) -> None:
    if isinstance(enclosure, Cells):
        raise InputError(
            f"{where}: [enclosure] cells hold spheres that are all alike: the first cells would "
            "get the first kind; leave cells out, or give one kind and size"
        )
    largest = 2.0 * float(bed.radius.max())
    if enclosure.narrowest < largest:
        raise InputError(
            f"{where}: [enclosure] {1e3 * enclosure.narrowest:g} mm at the narrowest: smaller than "
            f"a particle, {1e3 * largest:g} mm; give a larger enclosure or smaller particles"
        )
    fill = float(bed.volume.sum()) / enclosure.volume
    if fill >= 1.0:
        raise InputError(
            f"{where}: [particles] {len(bed.radius)} spheres: fill ratio {fill:.3f}, above 1; give "
            "fewer, or a larger enclosure"
        )
