"""Four contacts at once, in vectors, do what the plain form does one by one: bit for bit."""

import numpy as np
import pytest

from damper3d.lanes import add_loads, combine
from damper3d.state import BLOCK, Spheres
from damper3d.world import _block, _contacts

SPHERES = 9
BEGIN = 5  # in the list, so that a place in the block is not the place in the list


def scene(n, seed, same=None):
    """Spheres with random rows, n contacts of them after BEGIN others, a block; all else random.

    same: a sphere that takes part in every contact, on either side.
    """
    rng = np.random.default_rng(seed)
    rows = [rng.normal(size=(SPHERES + 1, 4)) for _ in range(5)]
    spheres = Spheres(*rows, np.ones(SPHERES))
    for array in rows[1:]:
        array[:, 3] = 0.0
    contacts, block = _contacts(SPHERES, BEGIN + BLOCK), _block()
    for k in range(BEGIN + n):
        pair = np.sort(rng.choice(SPHERES, 2, replace=False))
        if same is not None and same not in pair:
            pair[rng.integers(2)] = same
        contacts.i[k], contacts.j[k] = pair
    for name in ("push", "couple", "overlap", "arm_i", "arm_j"):
        getattr(block, name)[:] = rng.uniform(0.1, 1.0, len(getattr(block, name)))
    return spheres, contacts, block


def parts(array):
    """The rows of a vector of a block, as a view (BLOCK, 3)."""
    return array.reshape(3, BLOCK).T


LENGTHS = [*range(9), BLOCK - 1, BLOCK]


@pytest.mark.parametrize("n", LENGTHS)
def test_rows_to_lanes(n):
    """All remainders of four; what stands beyond the contacts is not touched beyond four lanes."""
    spheres, contacts, block = scene(n, 1)
    for name in ("separation", "passing", "turning", "spin"):
        getattr(block, name)[:] = np.nan
    combine(spheres, contacts, BEGIN, n, block)
    i, j = contacts.i[BEGIN : BEGIN + n], contacts.j[BEGIN : BEGIN + n]
    x, u, w = spheres.position, spheres.velocity, spheres.spin
    expected = {
        "separation": x[j] - x[i],
        "passing": u[j] - u[i],
        "turning": x[i, 3:] * w[i] + x[j, 3:] * w[j],
        "spin": w[i] + w[j],
    }
    for name, rows in expected.items():
        found = parts(getattr(block, name))
        assert np.array_equal(found[:n], rows[:, :3]), name
        assert np.isnan(found[n:]).all(), name


@pytest.mark.parametrize("same", [None, 0, 4, SPHERES - 1])
@pytest.mark.parametrize("n", LENGTHS)
def test_lanes_to_rows(n, same):
    """Also where one sphere has several of four contacts: its loads add up in the order of the
    list. Sums of doubles depend on their order, so that bits tell it."""
    spheres, contacts, block = scene(n, 2, same)
    force, torque = spheres.force.copy(), spheres.torque.copy()
    push, couple = parts(block.push), parts(block.couple)
    for k in range(n):
        i, j = contacts.i[BEGIN + k], contacts.j[BEGIN + k]
        force[i, :3] -= push[k]
        force[j, :3] += push[k]
        torque[i, :3] -= block.arm_i[k] * couple[k]
        torque[j, :3] -= block.arm_j[k] * couple[k]
    add_loads(spheres, contacts, BEGIN, n, block)
    assert np.array_equal(spheres.force, force)
    assert np.array_equal(spheres.torque, torque)


@pytest.mark.parametrize("touching", range(4))
def test_one_touching_contact_of_four_is_added(touching):
    """Four that do not touch are passed over; one of them is enough not to."""
    spheres, contacts, block = scene(4, 3)
    others = np.arange(BLOCK) != touching
    for array in (block.push, block.couple):
        parts(array)[others] = 0.0
    block.overlap[others] = 0.0
    before = spheres.force.copy()
    add_loads(spheres, contacts, BEGIN, 4, block)
    i, j = contacts.i[BEGIN + touching], contacts.j[BEGIN + touching]
    before[i, :3] -= parts(block.push)[touching]
    before[j, :3] += parts(block.push)[touching]
    assert np.array_equal(spheres.force, before)
