"""Sizes of the kinds of a bed, normal, lognormal or by a table of sieves; numbers of each kind."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.parts import USUAL_FILL_RATIO, particle_wanted
from damper3d.case.settings import MOST_PARTICLES, Kind, Particles
from damper3d.engine.enclosures import Enclosure
from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.particle import Particle, particle_of
from granulab.contact.files.units import to_si
from granulab.contact.material import Material
from granulab.errors import InputError

_CUT = 3.0  # standard deviations at which a distribution is cut off on both sides
_ADD_UP = 1e-3  # by which mass fractions may miss 1, as people round thirds

Diameters = Callable[[np.ndarray], np.ndarray]  # of quantiles, 0 to 1 (n,): diameters (n,) [m]


def sizes_of(given: Particles | Kind, folder: Path) -> tuple[MultiSphere, Diameters]:
    """The shape of a kind, and how its sizes are spread.

    A size is the diameter of the sphere of the same volume; a shape is scaled to it. folder: where
    a mesh is looked for first.
    """
    distribution, deviation = given.size_distribution, given.size_deviation
    if distribution == "sieve":
        shape = given.shape.strip()
        if shape.partition(":")[0].strip() != "sphere":
            raise InputError(
                f"shape = {given.shape!r}: a sieve sorts other shapes than spheres by their width, "
                "not by the sphere of their volume; give size_distribution = 'normal' or "
                "'lognormal'"
            )
        if shape not in ("sphere", Particles().shape) or given.equal_volume_radius is not None:
            raise InputError(
                f"shape = {given.shape!r}: a sieve table gives the sizes; write shape = 'sphere', "
                "and no equal_volume_radius"
            )
        if deviation is not None:
            raise InputError("size_deviation goes with 'normal' and 'lognormal'; leave it out")
        wanted = Particle("sphere", 1.0, given.sub_spheres, given.tolerance, given.mesh_unit)
        return particle_of(wanted), _sieved(given.sieve)
    if given.sieve is not None:
        raise InputError("sieve goes with size_distribution = 'sieve'; give that, or leave it out")
    particle = particle_of(particle_wanted(given, folder))
    mean = 2.0 * (float(particle.radii[0]) if particle.is_sphere else particle.equal_volume_radius)
    if distribution is None:
        if deviation is not None:
            raise InputError("size_deviation: size_distribution is missing, such as 'normal'")
        return particle, lambda quantile: np.full(len(quantile), mean)
    if deviation is None:
        raise InputError(
            f"size_distribution = {distribution!r}: size_deviation is missing, such as '0.2 mm'"
        )
    _check_width(distribution, mean, deviation)
    spread = _normal if distribution == "normal" else _lognormal
    return particle, spread(mean, deviation)


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


def _normal(mean: float, deviation: float) -> Diameters:
    return lambda quantile: mean + deviation * _between_cuts(quantile)


def _lognormal(mean: float, deviation: float) -> Diameters:
    """The diameter has this mean and deviation; its logarithm is normal."""
    width = math.sqrt(math.log1p((deviation / mean) ** 2))
    return lambda quantile: mean * np.exp(width * _between_cuts(quantile) - 0.5 * width**2)


def _sieved(table: list[list[Any]] | None) -> Diameters:
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


def counts_of(
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
                f"{where}: [[particles.kind]] {n + 1}: its mass_fraction is less than one "
                f"particle of {whole}; give more of it, or a larger count"
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
