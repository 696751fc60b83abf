"""Sizes of the kinds of a bed, normal, lognormal or by a table of sieves; numbers of each kind."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.parts import particle_wanted, usual_fill_ratio
from damper3d.case.settings import MOST_PARTICLES, Kind, Particles
from damper3d.engine.enclosures import Enclosure
from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.particle import Particle, particle_of
from granulab.contact.files.sizes import Sizes, sieved, spread
from granulab.contact.files.units import to_si
from granulab.contact.material import Material
from granulab.errors import InputError

_ADD_UP = 1e-3  # by which mass fractions may miss 1, as people round thirds


def sizes_of(given: Particles | Kind, folder: Path) -> tuple[MultiSphere, Sizes]:
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
    return particle, spread(distribution, mean, deviation)


def _sieved(table: list[list[Any]] | None) -> Sizes:
    if table is None:
        raise InputError(
            'size_distribution = \'sieve\': sieve is missing, such as [["2 mm", 0], ["4 mm", 1]]'
        )
    sieve = np.array([to_si(row[0], "m", "sieve") for row in table])
    return sieved(sieve, np.array([to_si(row[1], "1", "sieve") for row in table]), dimensions=3)


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
    usual = usual_fill_ratio(*(Particle(kind.shape).kind for kind in kinds))
    fill_ratio = particles.fill_ratio or usual
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
