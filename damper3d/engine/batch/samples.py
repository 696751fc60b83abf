"""Samples of a slot: what each sphere adds, and their sums, a thread a column."""

import numpy as np

from damper3d.engine.batch.slots import (
    GRAVITY,
    IMPACTS,
    MASS,
    N_HELD,
    PER_SAMPLE,
    SPHERES,
    TIME_STEP,
    WALL_FORCE,
    WALLS,
)
from damper3d.engine.batch.step import law_in, meeting, met, three, touching
from damper3d.engine.state import (
    CONTACTS_PP,
    CONTACTS_PW,
    DISPLACEMENT,
    ELASTIC_NORMAL,
    ELASTIC_TANGENTIAL,
    FASTEST,
    IMPACT_PP,
    KINETIC,
    N_BALANCE,
    N_COLUMNS,
    POSITION_X,
    POTENTIAL,
    TIME,
    VELOCITY,
    VELOCITY_Z,
    YIELD,
)
from granulab.contact.hertz import spring_energy
from granulab.contact.jit import njit
from granulab.contact.vectors import add, scale


@njit
def note_parts(one, in_use, i, shift, speed):
    """Write what sphere i adds to the sample of now: energies, contacts, position and velocity."""
    x, u, w, parts = one.position, one.velocity_now, one.spin_now, one.parts
    numbers, mass = one.numbers, 1.0 / one.velocity_now[i, 3]
    kinetic = potential = 0.0
    for c in range(3):
        kinetic += 0.5 * mass * u[i, c] ** 2 + 0.5 * w[i, c] ** 2 / w[i, 3]
        potential -= mass * numbers[GRAVITY + c] * x[i, c]
        parts[N_HELD + c, i] = mass * (x[i, c] - shift[c])
        parts[N_HELD + 3 + c, i] = mass * u[i, c]
    parts[MASS, i] = mass
    parts[0, i], parts[POTENTIAL - KINETIC, i] = kinetic, potential
    stored, pairs, at_walls = (0.0, 0.0), 0.0, 0.0
    point = add(three(x[i]), scale(-1.0, shift))
    bits, k = touching(one, in_use, i, point), np.uintp(0)
    while bits != 0:
        if bits & 1:
            which, counts, normal, overlap, _, velocity = meeting(one, in_use, i, k, point, speed)
            if overlap > 0.0 and counts > 0.0:
                constants = one.constants[in_use, k]
                law, history = law_in(one.laws[which]), one.history[in_use, k]
                held = stored_in(law, constants[0, i], constants[1, i], normal, overlap, velocity,
                                 history, i, numbers[TIME_STEP])  # fmt: skip
                stored = add(stored, held)
                pairs, at_walls = pairs + (1.0 - which), at_walls + which
        bits, k = bits >> 1, k + np.uintp(1)
    parts[CONTACTS_PP - KINETIC, i], parts[CONTACTS_PW - KINETIC, i] = pairs, at_walls
    parts[ELASTIC_NORMAL - KINETIC, i], parts[ELASTIC_TANGENTIAL - KINETIC, i] = stored


@njit
def stored_in(law, hertz, mass, normal, overlap, velocity, history, i, dt):
    """Energies [J] of the normal and tangential spring of a contact: see sampling.add_elastic."""
    state = met(law, hertz, mass, normal, overlap, velocity, history, i, dt)
    stiffness, held = state[0], state[6]
    return 0.4 * stiffness * overlap * overlap, spring_energy(law, stiffness, held)


@njit
def write_column(one, c, written, time, along, rate):
    """Write column c of a sample; along and rate: the enclosure's displacement and velocity."""
    row, parts, books = one.rows[written], one.parts, one.books
    n = one.clock[SPHERES]
    if c == TIME:
        row[c] = time
    elif c == DISPLACEMENT:
        row[c] = along
    elif c == VELOCITY:
        row[c] = rate
    elif c <= CONTACTS_PW:
        row[c] = total(parts, c - KINETIC, n)
    elif c < POSITION_X:
        k = c - IMPACT_PP
        own = IMPACTS + (k % 2) * YIELD + k // 2
        row[c] = largest(books, own, n) if k // 2 == FASTEST else total(books, own, n)
    elif c <= VELOCITY_Z:
        row[c] = total(parts, N_HELD + c - POSITION_X, n) / total(parts, MASS, n)
    elif c < N_COLUMNS + N_BALANCE:
        row[c] = total(books, c - N_COLUMNS, n)
    else:
        force = total(books, WALL_FORCE + c - N_COLUMNS - N_BALANCE, n)
        row[c] = force / one.clock[PER_SAMPLE]


@njit
def forget(one, i):
    """Wipe what sphere i counted since the last sample."""
    books = one.books
    for k in range(IMPACTS, IMPACTS + 2 * YIELD):
        books[k, i] = 0.0
    for k in range(WALL_FORCE, WALL_FORCE + 3 * one.clock[WALLS]):
        books[k, i] = 0.0


@njit
def total(table, row, n):
    """Sum of the first n numbers of a row, in their order."""
    summed = 0.0
    for i in range(n):
        summed += table[row, i]
    return summed


@njit
def largest(table, row, n):
    """The largest of the first n numbers of a row, none below 0."""
    most = 0.0
    for i in range(n):
        most = max(most, table[row, i])
    return most
