"""Several threads that share a silo's steps leave the bits of one thread.

So do more threads than cores, and parts of unlike size, while particles leave, and a door is drawn
or the walls vibrate. The beds are cut into more parts than their size would have, since what is
compared are bits, and these depend on parts but not on threads.
"""

import numpy as np
import pytest
from scenes import G, block, simulation_of

from silo2d.engine import state

PARTS = 7
STEPS = 16_000  # of 5 us: the first particles have left, and the door is gone
DOOR = 1


def silo(vibrates):
    """Bars between vertical walls, which vibrate, or above a door that is drawn; cut into parts."""
    x, y = np.meshgrid(np.linspace(-24e-3, 24e-3, 5), 8e-3 + 11e-3 * np.arange(9))
    rng = np.random.default_rng(3)
    poses = np.column_stack([x.ravel(), y.ravel(), rng.uniform(0.0, 6.3, x.size)])
    corners = [(-3e-2, 0.2), (-3e-2, 0.0), (-1.5e-2, 0.0), (1.5e-2, 0.0), (3e-2, 0.0), (3e-2, 0.2)]
    walls = np.stack([corners[:-1], corners[1:]], axis=1)[[0, 2, 1, 3, 4]]
    sim = simulation_of(
        [block(9e-3, 4e-3)] * len(poses), poses, walls=walls, time_step=5e-6, gravity=G
    )
    cut(sim, PARTS)
    sim.run(6000)
    if vibrates:
        sim.remove_wall(DOOR)
        sim.vibrate((1e-4, 2e-4), 60.0)
    else:
        sim.draw_door(DOOR, 1.0)
    return sim


def cut(sim, n_parts):
    """Cut a bed into so many parts."""
    parts = np.arange(n_parts + 1) * sim.n_particles // n_parts
    sim.world = sim.world._replace(parts=parts, first_pair=np.zeros((2, n_parts + 1), np.int64))


def gone_on(sim, n_threads):
    """All that is kept of a silo but how often it was searched, after steps by so many threads."""
    assert sim.share(n_threads) == n_threads
    for _ in range(80):
        sim.run(STEPS // 80)
        sim.world.counts[state.STALE] = 1
        sim.refresh()  # a look at the silo makes lists without the threads
    saved, counts = sim.save(), sim.world.counts
    saved["counts"] = counts[[state.STEP, state.LIVE, state.OUT]]
    return saved | {name: np.array(energy) for name, energy in sim.energies().items()}


def assert_same_bits(found, expected):
    for what, array in expected.items():
        assert np.array_equal(found[what], array, equal_nan=True), what


@pytest.mark.parametrize(("vibrates", "n_threads"), [(False, 2), (True, 3)])
def test_no_bit_of_a_silo_depends_on_the_number_of_threads(vibrates, n_threads):
    expected = gone_on(silo(vibrates), 1)
    assert 0 < expected["counts"][2] < 45  # some have left, and some are inside
    found = gone_on(silo(vibrates), n_threads)
    assert_same_bits(found, expected)


def test_a_part_of_several_blocks_is_shared():
    """A wall of bricks in two parts, of hundreds of pairs each: forces of a block are kept in its
    place, also beyond the first."""

    def wall():
        x, y = np.meshgrid(4.7e-3 + 9.2e-3 * np.arange(6), 2.003e-3 + 4.003e-3 * np.arange(30))
        poses = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
        walls = np.array([[[0.0, 0.2], [0.0, 0.0]], [[0.0, 0.0], [0.0556, 0.0]],
                          [[0.0556, 0.0], [0.0556, 0.2]]])  # fmt: skip
        sim = simulation_of(
            [block(9e-3, 4e-3)] * len(poses), poses, walls=walls, time_step=1e-6, gravity=G
        )
        cut(sim, 2)
        return sim

    sims = wall(), wall()
    for n_threads, sim in enumerate(sims, start=1):
        assert sim.share(n_threads) == n_threads
        sim.run(4000)
    one, two = (sim.save() for sim in sims)
    assert np.diff(sims[1].world.first_pair[0]).min() > 1.5 * state.BLOCK
    assert_same_bits(two, one)
