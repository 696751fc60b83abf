"""The engine's steps are those of a plain numpy engine: no lists, no blocks, all pairs."""

import numpy as np
import pytest
from damper_beds import DOWN, NOWHERE, acrylic, bed
from plain_bed import PlainBed

STEPS = 700
LAWS = {
    "thesis": {},
    "stored force": {"tangential": "force"},
    "no pull": {"end": "force"},
    "no tangential dashpot": {"tangential_damping": False},
}


def error(found, expected):
    """Largest difference over the largest value."""
    return np.abs(found - expected).max() / np.abs(expected).max()


@pytest.mark.parametrize(
    ("shape", "options", "direction", "gravity"),
    [
        ("cylinder", "thesis", (0, 0, 1), DOWN),
        ("box", "thesis", (0.6, 0.0, 0.8), (1.0, -9.0, 3.0)),
        ("cylinder", "stored force", (0, 0, 1), NOWHERE),
        ("box", "stored force", (0, 1, 0), DOWN),
        ("cylinder", "no pull", (0, 0, 1), DOWN),
        ("box", "no tangential dashpot", (0, 0, 1), DOWN),
    ],
)
def test_steps_are_those_of_the_plain_engine(shape, options, direction, gravity):
    """Motion, wall forces and all books of a vigorous bed, with its pairs and walls of different
    laws.

    Rounding grows with each impact, of which a sphere has one or two in 0.7 ms: 2e-14 is found.
    Mistakes are larger than the overlaps, 1e-3, in something.
    """
    pair = acrylic(**LAWS[options])
    wall = acrylic(0.3, 0.7, **LAWS[options])._replace(hertz=1.3 * pair.hertz)
    sim = bed(shape, 16, direction=direction, gravity=gravity, pair_law=pair, wall_law=wall,
              speed=3.0, steps_per_sample=STEPS)  # fmt: skip
    plain = PlainBed(sim)
    forces = sim.run(1)["wall_force"][0]
    for _ in range(STEPS):
        plain.step()
    world, n = sim.world, sim.n_particles
    assert (np.abs(plain.books) > 1e-9).sum() >= (9 if options == "no tangential dashpot" else 11)
    assert error(world.spheres.position[:n, :3], plain.x) < 1e-10
    for arrays, linear, angular in ((world.particles, plain.v, plain.w),
                                    (world.spheres, plain.u, plain.w_now)):  # fmt: skip
        assert error(arrays.velocity[:n, :3], linear) < 1e-10
        assert error(arrays.angular_velocity[:n, :3], angular) < 1e-10
    assert error(forces, plain.wall_force / STEPS) < 1e-10
    assert error(world.balance, plain.books) < 1e-10
    pairs, walls = (plain.books[first : first + 3].sum() for first in (0, 5))
    assert world.particles.dissipated.sum() == pytest.approx(pairs + walls, rel=1e-10)
    assert world.particles.dissipated[n] == pytest.approx(
        walls / 2, rel=1e-10
    )  # the enclosure's half
    touched = np.abs(plain.wall_force).max(axis=1) > 0.0
    assert touched.sum() >= 2
