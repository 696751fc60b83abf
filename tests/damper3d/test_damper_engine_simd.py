"""The processor's vectors do what the plain forms here do number by number: bit for bit."""

import numpy as np
import pytest
from inner_kernels import called

from damper3d.engine import geometry, simd
from damper3d.engine.simd import drift_on, kick, place_sphere, square_off, take_load
from damper3d.engine.state import BLOCK, DAMPING, N_CONSTANTS, N_HISTORY, NO_CONTACT, Spheres
from damper3d.engine.world import block as empty_block
from damper3d.engine.world import empty_contacts
from granulab.contact.jit import njit

# Only kernels call these.
separate, gather, keep_history = (
    called(f) for f in (simd.separate, simd.gather, simd.keep_history)
)
add_loads, touching_pairs = called(simd.add_loads), called(geometry.touching_pairs)

SPHERES = 9
BEGIN = 5  # in what is gone through, so that a place in the block is not one in the list
LOST = ("normal_power", "tangential_power", "friction_work", "stiffness_work", "slip_power")
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
    contacts, block = empty_contacts(LISTED), empty_block()
    for k in range(LISTED):
        pair = np.sort(rng.choice(SPHERES, 2, replace=False))
        if same is not None and same not in pair:
            pair[rng.integers(2)] = same
        contacts.i[k], contacts.j[k] = pair
    contacts.constants[:] = rng.normal(size=contacts.constants.shape)
    contacts.history[:] = rng.normal(size=contacts.history.shape)
    contacts.touching[: BEGIN + BLOCK] = 1 + 2 * np.arange(BEGIN + BLOCK)
    for name in ("push", "couple", "lost", "arm_i", "arm_j", "next_history", *LOST):
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
    x, u, w = spheres.position, spheres.velocity, spheres.angular_velocity
    expected = {
        "separation": (x[j] - x[i])[:, :3],
        "relative_velocity": (u[j] - u[i])[:, :3],
        "rim_velocity": (x[i, 3:] * w[i] + x[j, 3:] * w[j])[:, :3],
        "angular_velocity": (w[i] + w[j])[:, :3],
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
    expected[contacts.touching[BEGIN : BEGIN + n]] = parts(block.next_history)[:n]
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
        torque[[i, j], 3] -= block.lost[k]
    before = 1.0, 2.0, 3.0, 4.0, 5.0
    sums = add_loads(spheres, contacts.i, contacts.j, contacts.touching, BEGIN, n, block, before)
    assert np.array_equal(spheres.force, force)
    assert np.array_equal(spheres.torque, torque)
    for name, first, found in zip(LOST, before, sums, strict=True):
        assert found == sum(getattr(block, name)[:n].tolist(), first), name


@pytest.mark.parametrize("n", [*LENGTHS, LISTED])
def test_what_touches_or_did_a_step_ago_is_named_in_the_order_of_the_list(n):
    """A contact's last step is the one after its surfaces have parted."""
    spheres, contacts, block = scene(5)
    apart = spheres.position[contacts.j] - spheres.position[contacts.i]
    distance = np.linalg.norm(apart[:, :3], axis=1)
    contacts.cutoff[:] = 1.01 * np.median(distance)  # no pair is just at its cutoff
    contacts.history[:, DAMPING] = np.where(np.arange(len(distance)) % 5 == 0, 0.1, NO_CONTACT)
    expected = (distance < contacts.cutoff) | (contacts.history[:, DAMPING] >= 0.0)
    first = np.int64(2)
    end = touching_pairs(spheres, contacts, first, np.int64(n), block)
    assert np.array_equal(contacts.touching[first:end], first + np.flatnonzero(expected[first:n]))


ROWS = 5  # of each array that the vectors of a step are tried on
ROW = 3  # the one that changes


@njit
def kicked(v, u, loads, per_mass, gain, row):
    """Call the vectors' kick from a kernel, as the step does."""
    kick(v, u, loads, per_mass, gain, np.int64(row))


@njit
def drifted(x, v, dt, row):
    """Call the vectors' drift."""
    drift_on(x, v, dt, np.int64(row))


@njit
def squared(x, other, carried, row):
    """Call the vectors' square of a distance."""
    return square_off(x, other, carried, np.int64(row))


@njit
def placed(x, u, w, axes, offset, position, velocity, rotation, b, s, i):
    """Call the vectors' placing of a sphere of a particle."""
    b, s, i = np.int64(b), np.int64(s), np.int64(i)
    place_sphere(x, u, w, axes, offset, position, velocity, rotation, b, s, i)


@njit
def taken(force, torque, position, x, total, torques, i, b):
    """Call the vectors' adding of a sphere's load to its particle's."""
    take_load(force, torque, position, x, total, torques, np.int64(i), np.int64(b))


def rows(rng, width=4):
    """Random rows; the fourth number of four is 0, as of all vectors but positions."""
    made = rng.normal(size=(ROWS, width))
    made[:, 3] = 0.0
    return made


def test_a_kick_changes_one_velocity_and_wipes_its_load():
    """v += f dt/m + g dt, and u half of that further on."""
    rng = np.random.default_rng(6)
    v, u, loads = rows(rng), rows(rng), rng.normal(size=(ROWS, 4))  # the fourth: heat
    per_mass, gain = 0.37, (0.1, -0.2, 0.3)
    v_plain, u_plain, loads_plain = v.copy(), u.copy(), loads.copy()
    for c in range(3):
        change = per_mass * loads[ROW, c] + gain[c]
        v_plain[ROW, c] = v[ROW, c] + change
        u_plain[ROW, c] = v_plain[ROW, c] + 0.5 * change
    u_plain[ROW, 3] = loads_plain[ROW, :] = 0.0
    kicked(v, u, loads, per_mass, gain, ROW)
    assert np.array_equal(v, v_plain)
    assert np.array_equal(u, u_plain)
    assert np.array_equal(loads, loads_plain)


def test_a_drift_moves_one_sphere_and_keeps_its_radius():
    rng = np.random.default_rng(7)
    x, v = rng.normal(size=(ROWS, 4)), rows(rng)
    plain = x.copy()
    plain[ROW, :3] += 0.01 * v[ROW, :3]
    drifted(x, v, 0.01, ROW)
    assert np.array_equal(x, plain)


def test_the_square_of_a_distance_leaves_radii_out():
    rng = np.random.default_rng(8)
    x, other, carried = rng.normal(size=(ROWS, 4)), rng.normal(size=(ROWS, 4)), (0.3, -0.1, 0.7)
    a, b, c = (x[ROW, k] - other[ROW, k] - carried[k] for k in range(3))
    assert squared(x, other, carried, ROW) == a * a + b * b + c * c


def crossed(a, b):
    """a x b, each product by itself."""
    x = a[1] * b[2] - a[2] * b[1]
    y = a[2] * b[0] - a[0] * b[2]
    return np.array([x, y, a[0] * b[1] - a[1] * b[0]])


def test_a_sphere_of_a_particle_moves_with_it():
    """x + r, u + w x r and w, with r the own offset along the axes; its radius is the offset's."""
    rng = np.random.default_rng(9)
    x, u, w, axes = rng.normal(size=(ROWS, 4)), rows(rng), rows(rng), rows(rng, 12)
    axes[:, [3, 7, 11]] = 0.0
    offset, spheres = rng.normal(size=(2, 4)), [rng.normal(size=(2 * ROWS, 4)) for _ in range(3)]
    plain, i, s = [array.copy() for array in spheres], 2 * ROW + 1, 1
    along = [offset[s, k] * axes[ROW, 4 * k : 4 * k + 3] for k in range(3)]
    arm = along[0] + along[1] + along[2]
    plain[0][i] = [*(x[ROW, :3] + arm), offset[s, 3]]
    plain[1][i] = [*(u[ROW, :3] + crossed(w[ROW], arm)), 0.0]
    plain[2][i] = w[ROW]
    placed(x, u, w, axes, offset, *spheres, ROW, s, i)
    for array, expected in zip(spheres, plain, strict=True):
        assert np.array_equal(array, expected)


def test_the_load_of_a_sphere_goes_to_its_particle():
    """Force f and torque t + r x f about the centroid; those of the sphere are wiped."""
    rng = np.random.default_rng(10)
    force, torque = rows(rng), rows(rng)
    position, x = rng.normal(size=(ROWS, 4)), rng.normal(size=(ROWS, 4))
    total, torques = rows(rng), rows(rng)
    plain = total.copy(), torques.copy()
    arm = position[ROW, :3] - x[1, :3]
    plain[0][1, :3] += force[ROW, :3]
    plain[1][1, :3] += torque[ROW, :3] + crossed(arm, force[ROW])
    taken(force, torque, position, x, total, torques, ROW, 1)
    assert np.array_equal(total[:, :3], plain[0][:, :3])
    assert np.array_equal(torques[:, :3], plain[1][:, :3])
    assert not force[ROW].any()
    assert not torque[ROW].any()
    assert force.any(axis=1).sum() == ROWS - 1
