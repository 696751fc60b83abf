"""What is known of the bed at a moment: energies, mean motion, contacts; a row of it a sample."""

import numpy as np

from contact.hertz import hertz_force, mindlin_force, spring_energy
from contact.jit import njit
from contact.vectors import add, dot, scale
from damper3d.forces import contact_law, without_slip
from damper3d.geometry import between_spheres, with_cylinder, with_planes
from damper3d.integrate import advance, enclosure_at
from damper3d.neighbours import DONE
from damper3d.state import (
    BLOCK,
    CLOSE,
    DAMPING,
    N_BOOKS,
    PLANE,
    STEP,
    STIFFNESS,
    WALL,
)

# Columns of a sample; the books and then the forces on the walls follow.
(
    TIME, DISPLACEMENT, VELOCITY, KINETIC, POTENTIAL, ELASTIC_NORMAL, ELASTIC_TANGENTIAL,
    CONTACTS_PP, CONTACTS_PW, IMPACT_PP, IMPACT_PW, POSITION_X, POSITION_Y, POSITION_Z,
    VELOCITY_X, VELOCITY_Y, VELOCITY_Z,
) = range(17)  # fmt: skip
N_COLUMNS = 17
# Columns of a row of list_contacts.
FORCE, NORMAL, POINT, OVERLAP = 0, 3, 6, 9
N_CONTACT_COLUMNS = 10


@njit
def advance_sampling(world, steps_per_sample, rows):
    """Fill rows, each after steps_per_sample steps; how many were filled, steps over, outcome.

    rows (n, N_COLUMNS + N_BOOKS + 3 n_walls). A step that cannot be taken ends it.
    """
    for k in range(len(rows)):
        taken, outcome = advance(world, steps_per_sample)
        if outcome != DONE:
            return k, taken, outcome
        sample(world, steps_per_sample, rows[k])
    return len(rows), np.int64(0), DONE


@njit
def sample(world, steps, row):
    """One row; forces on the walls are means over the steps since the last."""
    now = world.counts[STEP] * world.time_step
    d = world.direction
    shift, speed = enclosure_at(world.shaker, d, now)
    row[TIME] = now
    row[DISPLACEMENT] = shift[0] * d[0] + shift[1] * d[1] + shift[2] * d[2]
    row[VELOCITY] = speed[0] * d[0] + speed[1] * d[1] + speed[2] * d[2]
    mean_motion(world.spheres, world.bodies, world.gravity, shift, row)
    elastic_energies(world, shift, speed, row)
    for c in range(2):
        row[IMPACT_PP + c] = world.fastest[c]
        world.fastest[c] = 0.0
    row[N_COLUMNS : N_COLUMNS + N_BOOKS] = world.books
    force = world.walls.force
    for w in range(len(force)):
        for c in range(3):
            row[N_COLUMNS + N_BOOKS + 3 * w + c] = force[w, c] / steps
            force[w, c] = 0.0


@njit
def mean_motion(spheres, bodies, gravity, shift, row):
    """Kinetic and potential energy, mean position in the enclosure and mean velocity."""
    x, u, w = spheres.position, spheres.velocity, spheres.spin
    kinetic = potential = total = 0.0
    position, velocity = np.zeros(3), np.zeros(3)
    for i in range(len(x)):
        mass = 1.0 / bodies.inverse_mass[i]
        total += mass
        for c in range(3):
            kinetic += 0.5 * mass * u[i, c] ** 2 + 0.5 * w[i, c] ** 2 / bodies.inverse_inertia[i]
            potential -= mass * gravity[c] * x[i, c]
            position[c] += mass * (x[i, c] - shift[c])
            velocity[c] += mass * u[i, c]
    row[KINETIC], row[POTENTIAL] = kinetic, potential
    for c in range(3):
        row[POSITION_X + c] = position[c] / total
        row[VELOCITY_X + c] = velocity[c] / total


@njit
def elastic_energies(world, shift, speed, row):
    """What the springs of all contacts hold, and how many contacts there are."""
    row[ELASTIC_NORMAL] = row[ELASTIC_TANGENTIAL] = 0.0
    row[CONTACTS_PP] = row[CONTACTS_PW] = 0.0
    block, planes, walls = world.block, world.counts[PLANE], world.walls
    for begin in range(np.int64(0), world.counts[CLOSE], BLOCK):
        n = min(world.counts[CLOSE] - begin, BLOCK)
        between_spheres(world.spheres, world.close, begin, n, block)
        add_elastic(world.pair_law, world.close, begin, n, block, world.time_step, row, CONTACTS_PP)
    for begin in range(np.int64(0), planes, BLOCK):
        n = min(planes - begin, BLOCK)
        with_planes(world.spheres, walls.planes, world.wall, begin, n, shift, speed, block)
        add_elastic(world.wall_law, world.wall, begin, n, block, world.time_step, row, CONTACTS_PW)
    for begin in range(planes, world.counts[WALL], BLOCK):
        n = min(world.counts[WALL] - begin, BLOCK)
        with_cylinder(world.spheres, walls.radius, world.wall, begin, n, shift, speed, block)
        add_elastic(world.wall_law, world.wall, begin, n, block, world.time_step, row, CONTACTS_PW)


@njit
def add_elastic(law, contacts, begin, n_contacts, block, dt, row, count):
    """Add the elastic energies of a block to a row: (2/5) K d^2.5 and that of the spring."""
    history = contacts.history
    for k in range(n_contacts):
        overlap = block.overlap[k]
        if overlap <= 0.0:
            continue
        n = begin + k
        normal = block.normal_x[k], block.normal_y[k], block.normal_z[k]
        velocity = block.velocity_x[k], block.velocity_y[k], block.velocity_z[k]
        rate = -dot(velocity, normal)
        slip_rate = add(velocity, scale(rate, normal))
        damping = max(history[DAMPING, n], law.damping)
        stiffness, dashpot, f_n, _ = hertz_force(
            law, contacts.hertz[n], contacts.mass[n], damping, overlap, rate
        )
        trial = without_slip(
            law, history, n, normal, history[STIFFNESS, n], law.tangential * stiffness,
            scale(0.5 * dt, slip_rate),
        )[1]  # fmt: skip
        held = mindlin_force(law, stiffness, dashpot, f_n, trial, slip_rate)[1]
        row[ELASTIC_NORMAL] += 0.4 * stiffness * overlap * overlap
        row[ELASTIC_TANGENTIAL] += spring_energy(law, stiffness, held)
        row[count] += 1.0


@njit
def list_contacts(world, bodies, numbers):
    """The contacts of now and the forces that the next step will apply; how many there are.

    bodies (capacity, 2): spheres, and walls numbered after them; numbers (capacity,
    N_CONTACT_COLUMNS): force on the second, normal towards it, point in the laboratory, overlap.
    """
    now = world.counts[STEP] * world.time_step
    shift, speed = enclosure_at(world.shaker, world.direction, now)
    block, counts, n_spheres = world.block, world.counts, len(world.spheres.position)
    found = 0
    for begin in range(np.int64(0), counts[CLOSE], BLOCK):
        n = min(counts[CLOSE] - begin, BLOCK)
        between_spheres(world.spheres, world.close, begin, n, block)
        contact_law(world.pair_law, world.close, begin, n, block, world.time_step)
        found = copy_contacts(
            world.spheres.position,
            block,
            world.close,
            begin,
            n,
            np.int64(0),
            bodies,
            numbers,
            found,
        )
    for begin in range(np.int64(0), counts[PLANE], BLOCK):
        n = min(counts[PLANE] - begin, BLOCK)
        with_planes(world.spheres, world.walls.planes, world.wall, begin, n, shift, speed, block)
        contact_law(world.wall_law, world.wall, begin, n, block, world.time_step)
        found = copy_contacts(
            world.spheres.position, block, world.wall, begin, n, n_spheres, bodies, numbers, found
        )
    for begin in range(counts[PLANE], counts[WALL], BLOCK):
        n = min(counts[WALL] - begin, BLOCK)
        with_cylinder(world.spheres, world.walls.radius, world.wall, begin, n, shift, speed, block)
        contact_law(world.wall_law, world.wall, begin, n, block, world.time_step)
        found = copy_contacts(
            world.spheres.position, block, world.wall, begin, n, n_spheres, bodies, numbers, found
        )
    return found


@njit
def copy_contacts(x, block, contacts, begin, n_contacts, offset, bodies, numbers, found):
    """Append the touching contacts of a block; how many there are then."""
    for k in range(n_contacts):
        if block.overlap[k] > 0.0:
            i, j = contacts.i[begin + k], contacts.j[begin + k]
            bodies[found, 0], bodies[found, 1] = i, j + offset
            normal = block.normal_x[k], block.normal_y[k], block.normal_z[k]
            force = block.force_x[k], block.force_y[k], block.force_z[k]
            for c in range(3):
                numbers[found, FORCE + c] = force[c]
                numbers[found, NORMAL + c] = normal[c]
                numbers[found, POINT + c] = x[i, c] + block.arm_i[k] * normal[c]
            numbers[found, OVERLAP] = block.overlap[k]
            found += 1
    return found
