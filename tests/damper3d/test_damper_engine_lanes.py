"""Four contacts at once, in vectors, do what the plain form does one by one: bit for bit."""

import numpy as np
import pytest

from damper3d.engine.geometry import touching_pairs
from damper3d.engine.simd import add_loads, gather, keep_history, separate
from damper3d.engine.state import BLOCK, DAMPING, N_CONSTANTS, N_HISTORY, NO_CONTACT, Spheres
from damper3d.engine.world import block as empty_block
from damper3d.engine.world import contacts_with_room

SPHERES = 9
BEGIN = 5  # in what is gone through, so that a place in the block is not one in the list
LISTED = 2 * (BEGIN + BLOCK) + 3  # contacts, of which every other one is named as touching


def scene(seed, same=None):
    """Spheres with random rows, contacts of them, a block; all else random.

    same: a sphere that takes part in every contact, on either side.
    """
    rng = np.random.default_rng(seed)
    rows = [rng.normal(size=(SPHERES + 1, 4)) for _ in range(5)]
    spheres = Spheres(*rows, np.ones(SPHERES))
    for array in rows[1:]:
        array[:, 3] = 0.0
    contacts, block = contacts_with_room(LISTED), empty_block()
    for k in range(LISTED):
        pair = np.sort(rng.choice(SPHERES, 2, replace=False))
        if same is not None and same not in pair:
            pair[rng.integers(2)] = same
        contacts.i[k], contacts.j[k] = pair
    contacts.constants[:] = rng.normal(size=contacts.constants.shape)
    contacts.history[:] = rng.normal(size=contacts.history.shape)
    contacts.touching[: BEGIN + BLOCK] = 1 + 2 * np.arange(BEGIN + BLOCK)
    for name in ("push", "couple", "arm_i", "arm_j", "later"):
        getattr(block, name)[:] = rng.uniform(0.1, 1.0, len(getattr(block, name)))
    return spheres, contacts, block


def parts(array):
    """The rows of a vector of a block, as a view (BLOCK, so many)."""
    return array.reshape(-1, BLOCK).T


LENGTHS = [*range(9), BLOCK - 1, BLOCK]


@pytest.mark.parametrize("n", LENGTHS)
def test_separations_to_lanes(n):
    """All remainders of four; what stands beyond the contacts is not touched."""
    spheres, contacts, block = scene(1)
    block.separation[:] = np.nan
    separate(spheres, contacts, BEGIN, n, block)
    i, j = contacts.i[BEGIN : BEGIN + n], contacts.j[BEGIN : BEGIN + n]
    found = parts(block.separation)
    assert np.array_equal(found[:n], (spheres.position[j] - spheres.position[i])[:, :3])
    assert np.isnan(found[n:]).all()


@pytest.mark.parametrize("n", LENGTHS)
def test_rows_to_lanes(n):
    """Of the contacts that are named, and of no other."""
    spheres, contacts, block = scene(2)
    named = contacts.touching[BEGIN : BEGIN + n]
    i, j = contacts.i[named], contacts.j[named]
    x, u, w = spheres.position, spheres.velocity, spheres.spin
    expected = {
        "separation": (x[j] - x[i])[:, :3],
        "passing": (u[j] - u[i])[:, :3],
        "turning": (x[i, 3:] * w[i] + x[j, 3:] * w[j])[:, :3],
        "spin": (w[i] + w[j])[:, :3],
        "constants": contacts.constants[named],
        "history": contacts.history[named],
    }
    for name in expected:
        getattr(block, name)[:] = np.nan
    gather(spheres, contacts, BEGIN, n, block)
    for name, rows in expected.items():
        found = parts(getattr(block, name))
        assert np.array_equal(found[:n], rows), name
        assert np.isnan(found[n:]).all(), name
    assert parts(block.constants).shape[1] == N_CONSTANTS
    assert parts(block.history).shape[1] == N_HISTORY


@pytest.mark.parametrize("n", LENGTHS)
def test_histories_are_kept_by_the_contacts_that_are_named(n):
    """Those of the others stay as they are."""
    _, contacts, block = scene(3)
    expected = contacts.history.copy()
    expected[contacts.touching[BEGIN : BEGIN + n]] = parts(block.later)[:n]
    keep_history(contacts, BEGIN, n, block)
    assert np.array_equal(contacts.history, expected)


@pytest.mark.parametrize("same", [None, 0, 4, SPHERES - 1])
@pytest.mark.parametrize("n", LENGTHS)
def test_lanes_to_rows(n, same):
    """Also where one sphere has several of four contacts: its loads add up in the order of the
    list. Sums of doubles depend on their order, so that bits tell it."""
    spheres, contacts, block = scene(4, same)
    force, torque = spheres.force.copy(), spheres.torque.copy()
    push, couple = parts(block.push), parts(block.couple)
    for k in range(n):
        named = contacts.touching[BEGIN + k]
        i, j = contacts.i[named], contacts.j[named]
        force[i, :3] -= push[k]
        force[j, :3] += push[k]
        torque[i, :3] -= block.arm_i[k] * couple[k]
        torque[j, :3] -= block.arm_j[k] * couple[k]
    add_loads(spheres, contacts, BEGIN, n, block)
    assert np.array_equal(spheres.force, force)
    assert np.array_equal(spheres.torque, torque)


@pytest.mark.parametrize("n", [*LENGTHS, LISTED])
def test_what_touches_or_did_a_step_ago_is_named_in_the_order_of_the_list(n):
    """A contact's last step is the one after its surfaces have parted."""
    spheres, contacts, block = scene(5)
    apart = spheres.position[contacts.j] - spheres.position[contacts.i]
    distance = np.linalg.norm(apart[:, :3], axis=1)
    contacts.reach[:] = 1.01 * np.median(distance)  # no pair is just at its reach
    contacts.history[:, DAMPING] = np.where(np.arange(len(distance)) % 5 == 0, 0.1, NO_CONTACT)
    expected = (distance < contacts.reach) | (contacts.history[:, DAMPING] >= 0.0)
    found = touching_pairs(spheres, contacts, np.int64(n), block)
    assert np.array_equal(contacts.touching[:found], np.flatnonzero(expected[:n]))
