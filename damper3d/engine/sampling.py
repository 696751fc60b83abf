"""Samples: energies, mean motion and contacts of the bed at a moment, a row each."""

import numpy as np

from damper3d.engine.forces import contact_law, meet_wall
from damper3d.engine.geometry import between_spheres, entry, surface_motion
from damper3d.engine.integrate import place_now, search, take_steps
from damper3d.engine.kinds import find_at_wall, find_pairs, mean_motion
from damper3d.engine.laws.rolling import rolling_energy
from damper3d.engine.laws.table import (
    face_wall,
    halo,
    law_of,
    normal_energy,
    normal_force,
    note_laws,
    without_slip,
)
from damper3d.engine.motions.host import (
    HOST_DAMPING,
    HOST_ENERGY,
    HOST_WORK,
    N_HOST_COLUMNS,
    OWN_DAMPING,
    WORK,
    displacement,
    energy,
    rides,
    velocity,
)
from damper3d.engine.motions.turning import turn_wall, twists, without_shaker, without_walls
from damper3d.engine.simd import gather
from damper3d.engine.state import (
    BLOCK,
    CONTACTS_PP,
    CONTACTS_PW,
    DAMPING,
    DISPLACEMENT,
    DONE,
    ELASTIC_NORMAL,
    ELASTIC_TANGENTIAL,
    HERTZ,
    IMPACT_PP,
    INNER,
    MASS,
    N_BALANCE,
    N_COLUMNS,
    STEP,
    STIFFNESS,
    TIME,
    VELOCITY,
    YIELD,
)
from damper3d.engine.walls import bend, place_wall
from granulab.contact.hertz import mindlin_force, spring_energy
from granulab.contact.jit import inner, specialised, uncounted
from granulab.contact.vectors import scale

# Columns of a row of list_contacts.
FORCE, NORMAL, POINT, OVERLAP = 0, 3, 6, 9
N_CONTACT_COLUMNS = 10


@uncounted
def advance_sampling(world, steps_per_sample, rows):
    """Fill rows, each after steps_per_sample steps; how many were filled, steps over, outcome.

    rows (n, N_COLUMNS + N_BALANCE + 3 n_walls); without any the steps are taken all the same, in
    one kernel for both, and without steps it looks (see look). A step that cannot be taken ends it.
    Lists that are stale by then are made again, as they would be in the next step: a sample that
    counts the contacts of an old list depends on when it was made.
    """
    for k in range(max(len(rows), 1)):
        taken, outcome = take_steps(world, steps_per_sample)
        if len(rows) == 0 and steps_per_sample > 0:
            return 0, taken, outcome
        if outcome == DONE:
            outcome = search(without_shaker(world), place_now(world)[0])
        if outcome != DONE:
            return k, taken, outcome
        if len(rows) > 0:
            sample(world, max(steps_per_sample, 1), rows[k])
    return len(rows), np.int64(0), DONE


@uncounted
def look(world, rows):
    """Make stale lists again, and fill rows, if there are any, as of now; the outcome.

    The same as no step of advance_sampling, for who does not compile that.
    """
    outcome = search(without_shaker(world), place_now(world)[0])
    if outcome == DONE and len(rows) > 0:
        sample(world, 1, rows[0])
    return outcome


@inner
def sample(world, steps, row):
    """One row; forces on the walls are means over the steps since the last."""
    now = world.counts[STEP] * world.time_step
    d = world.direction
    shift, speed = place_now(world)
    row[TIME] = now
    row[DISPLACEMENT] = shift[0] * d[0] + shift[1] * d[1] + shift[2] * d[2]
    row[VELOCITY] = speed[0] * d[0] + speed[1] * d[1] + speed[2] * d[2]
    mean_motion(without_walls(world), shift, row)
    row[ELASTIC_NORMAL] = row[ELASTIC_TANGENTIAL] = 0.0
    row[CONTACTS_PP] = row[CONTACTS_PW] = 0.0
    energies_of_pairs(without_walls(world), row)
    energies_at_walls(without_shaker(world), shift, speed, row)
    for c in range(2):
        for k in range(YIELD):
            row[IMPACT_PP + 2 * k + c] = world.impacts[c, k]
            world.impacts[c, k] = 0.0
    for b in range(N_BALANCE):
        row[N_COLUMNS + b] = world.balance[b]
    force = world.walls.force
    for w in range(len(force)):
        for c in range(3):
            row[N_COLUMNS + N_BALANCE + 3 * w + c] = force[w, c] / steps
            force[w, c] = 0.0
    sample_host(world, now, row)


def sample_host(world, now, row):
    """Write the energy and the books of the enclosure's host to the last columns of a row."""


@specialised(sample_host)
def _sample_host(world, now, row):
    if rides(world):
        return lambda world, now, row: _host_columns(world.shaker, now, row)
    if twists(world):
        return lambda world, now, row: _twisted_columns(world.shaker.arc, now, row)
    return lambda world, now, row: None


@inner
def _twisted_columns(host, now, row):
    """Also the arc in place of a displacement."""
    row[DISPLACEMENT], row[VELOCITY] = displacement(host, now), velocity(host, now)
    _host_columns(host, now, row)


@inner
def _host_columns(host, now, row):
    first = len(row) - N_HOST_COLUMNS
    row[first + HOST_ENERGY] = energy(host, now)
    row[first + HOST_WORK] = host.books[WORK]
    row[first + HOST_DAMPING] = host.books[OWN_DAMPING]


@inner
def energies_of_pairs(world, row):
    """Add what the springs of all pairs hold to a row, and how many touch."""
    block = world.block
    end = find_pairs(world, np.int64(0), world.counts[INNER])
    for begin in range(np.int64(0), end, BLOCK):
        n = min(end - begin, BLOCK)
        gather(world.spheres, world.inner, begin, n, block)
        between_spheres(n, block)
        note_laws(world.pair_law, world.inner, begin, n, block, 2.0 * halo(world.pair_law))
        add_elastic(world, world.pair_law, world.inner, begin, n, row, CONTACTS_PP)


@inner
def energies_at_walls(world, shift, speed, row):
    """Likewise of the contacts with walls."""
    spheres, block, walls = world.spheres, world.block, world.walls
    for w in range(len(walls.force)):
        place_wall(spheres, walls, w, shift, speed)
        face_wall(world.wall_law, w)
        bend(world, w, walls.first[w], walls.first[w + 1])
        end = find_at_wall(world, w, walls.first[w], walls.first[w + 1])
        for begin in range(walls.first[w], end, BLOCK):
            n = min(end - begin, BLOCK)
            meet_wall(spheres, walls, world.wall, w, begin, n, block)
            turn_wall(world, n, block)
            note_laws(world.wall_law, world.wall, begin, n, block, halo(world.wall_law))
            add_elastic(world, world.wall_law, world.wall, begin, n, row, CONTACTS_PW)


@inner
def add_elastic(world, laws, contacts, begin, n_contacts, row, count):
    """Add the elastic energies of a block to a row: (2/5) K d^2.5 and those of the springs."""
    block, dt = world.block, world.time_step
    history = block.history
    for k in range(np.uintp(n_contacts)):
        overlap = block.overlap[k]
        if overlap <= 0.0:
            continue
        law = law_of(laws, k)
        normal, rate, slip_rate = surface_motion(block, k)
        damping = max(history[entry(DAMPING, k)], law.damping)
        hertz, mass = block.constants[entry(HERTZ, k)], block.constants[entry(MASS, k)]
        stiffness, dashpot, _, _, load = normal_force(
            laws, law, hertz, mass, damping, overlap, rate, k
        )
        trial = without_slip(
            law, history, k, normal, history[entry(STIFFNESS, k)], law.tangential * stiffness,
            scale(0.5 * dt, slip_rate),
        )[1]  # fmt: skip
        held = mindlin_force(law, stiffness, dashpot, load, trial, slip_rate)[1]
        row[ELASTIC_NORMAL] += normal_energy(laws, law, stiffness, overlap, k)
        row[ELASTIC_TANGENTIAL] += spring_energy(law, stiffness, held)
        row[ELASTIC_TANGENTIAL] += rolling_energy(world, laws, contacts, begin, k)
        row[count] += 1.0


@uncounted
def list_contacts(world, shift, speed, particles, numbers):
    """The contacts of now and the forces that the next step will apply; how many there are.

    shift, speed: of the enclosure now.
    particles (capacity, 2): spheres, and walls numbered after them; numbers (capacity,
    N_CONTACT_COLUMNS): force on the second, normal towards it, point in the laboratory, overlap.
    """
    found = list_pairs(without_walls(world), particles, numbers)
    return list_at_walls(world, shift, speed, particles, numbers, found)


@inner
def list_pairs(world, particles, numbers):
    """Contacts of particles with each other, see list_contacts; how many there are."""
    spheres, block, dt = world.spheres, world.block, world.time_step
    found = np.int64(0)
    end = find_pairs(world, np.int64(0), world.counts[INNER])
    for begin in range(np.int64(0), end, BLOCK):
        n = min(end - begin, BLOCK)
        gather(spheres, world.inner, begin, n, block)
        between_spheres(n, block)
        reach = 2.0 * halo(world.pair_law)
        note_laws(world.pair_law, world.inner, begin, n, block, reach)
        contact_law(world.pair_law, n, block, dt)
        found = copy_contacts(
            spheres, block, world.inner, begin, n, 0, reach, particles, numbers, found
        )
    return found


@inner
def list_at_walls(world, shift, speed, particles, numbers, found):
    """Append contacts with walls, likewise; how many there are then."""
    spheres, block, walls, dt = world.spheres, world.block, world.walls, world.time_step
    for w in range(len(walls.force)):
        place_wall(spheres, walls, w, shift, speed)
        face_wall(world.wall_law, w)
        bend(world, w, walls.first[w], walls.first[w + 1])
        end = find_at_wall(world, w, walls.first[w], walls.first[w + 1])
        for begin in range(walls.first[w], end, BLOCK):
            n = min(end - begin, BLOCK)
            meet_wall(spheres, walls, world.wall, w, begin, n, block)
            turn_wall(world, n, block)
            reach = halo(world.wall_law)
            note_laws(world.wall_law, world.wall, begin, n, block, reach)
            contact_law(world.wall_law, n, block, dt)
            found = copy_contacts(
                spheres, block, world.wall, begin, n, w, reach, particles, numbers, found
            )
    return found


@inner
def copy_contacts(
    spheres, block, contacts, begin, n_contacts, wall, reach, particles, numbers, found
):
    """Append the touching contacts of a block; how many there are then.

    The enclosure's row stands behind those of the spheres, so that adding a wall's number to it
    numbers the walls after the spheres.
    """
    for k in range(np.uintp(n_contacts)):
        if block.overlap[k] > 0.0:
            n = contacts.touching[np.uintp(begin) + k]
            i, j = contacts.i[n], contacts.j[n]
            particles[found, 0], particles[found, 1] = i, j + wall
            for c in range(3):
                numbers[found, FORCE + c] = block.push[entry(c, k)]
                numbers[found, NORMAL + c] = block.normal[entry(c, k)]
                point = spheres.position[i, c] + block.arm_i[k] * block.normal[entry(c, k)]
                numbers[found, POINT + c] = point
            numbers[found, OVERLAP] = block.overlap[k] - reach
            found += 1
    return found
