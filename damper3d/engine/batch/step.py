"""One step of a sphere in a slot: the forces on it, its motion, and its list of neighbours.

Each sphere sums the forces of its own contacts, by the numbers of its neighbours and then of the
walls, so that no two threads add to one number: every contact of two spheres is worked twice, and
counted by the first of them. Nothing depends on how many threads there are. The scheme is that of
forces.py and integrate.py.
"""

import math

import numpy as np

from damper3d.engine.batch.slots import (
    CURVED,
    GRAVITY,
    HEAT,
    IMPACTS,
    PLANES,
    ROUND,
    SKIN,
    SPHERES,
    TIME_STEP,
    WALL_FORCE,
    WALLS,
    YIELDS,
)
from damper3d.engine.enclosures.cylinder import nearest_round
from damper3d.engine.enclosures.enclosure import Round
from damper3d.engine.state import (
    BEGUN,
    BEYOND,
    DAMPING,
    DEEPEST,
    DONE,
    FASTEST,
    FRICTION,
    INNER_FULL,
    LAW_TERM,
    MOVED_X,
    N_HISTORY,
    N_MECHANISMS,
    NO_CONTACT,
    NORMAL_DAMPING,
    NOT_FINITE,
    SLIP_COUNT,
    SPRING_X,
    STIFFNESS,
    TANGENTIAL_DAMPING,
    TOO_DEEP,
    WALL_WORK,
    YIELD,
)
from granulab.contact.hertz import (
    HertzLaw,
    carried_spring,
    damping_of_impact,
    hertz_force,
    mindlin_force,
    spring_work,
)
from granulab.contact.jit import njit
from granulab.contact.vectors import add, cross, dot, scale

_ROUNDING = 1.0 + 1e-12  # as in geometry.py
_to_round = njit(nearest_round)


@njit
def law_in(row):
    """The law whose numbers stand in a row."""
    return HertzLaw(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6] > 0.0, row[7] > 0.0
    )  # fmt: skip


@njit
def three(row):
    """The first three numbers of a row, as a vector."""
    return row[0], row[1], row[2]


@njit
def column(rows, first, i):
    """Three numbers of sphere i, from a row on, as a vector."""
    return rows[first, i], rows[first + 1, i], rows[first + 2, i]


@njit
def put_column(rows, first, i, v):
    """Let a vector stand in three rows of sphere i."""
    rows[first, i], rows[first + 1, i], rows[first + 2, i] = v


@njit
def met(law, hertz, mass, normal, overlap, velocity, history, i, dt):
    """A contact of sphere i with a history (N_HISTORY, n), from its geometry: see forces.apply_law.

    Secant stiffness, overlap rate, slip rate, its b, the spring a step before, as it would be and
    as it is, normal force, tangential force, power of the normal and tangential dashpots, and
    whether it slides (1.0 or 0.0).
    """
    rate = -dot(velocity, normal)
    slip_rate = add(velocity, scale(rate, normal))
    damping = max(history[DAMPING, i], law.damping)
    stiffness, dashpot, f_n, inelastic = hertz_force(law, hertz, mass, damping, overlap, rate)
    held_before, trial = carried_spring(
        law, column(history, SPRING_X, i), column(history, MOVED_X, i), normal,
        history[STIFFNESS, i], law.tangential * stiffness, scale(0.5 * dt, slip_rate),
    )  # fmt: skip
    force, held, power, slides = mindlin_force(law, stiffness, dashpot, f_n, trial, slip_rate)
    return (stiffness, rate, slip_rate, damping, held_before, trial, held, f_n, force,
            inelastic * rate, power, slides)  # fmt: skip


@njit
def pushed(
    law, hertz, mass, normal, overlap, velocity, history, books, i, which, counts, limit, dt
):
    """The force [N] of such a contact on the other, and its couple normal x force [N].

    Its history goes on, and what it dissipates is entered into the books (columns, n) of sphere i,
    in those of class 0 or 1: the heat by half, the rest as far as `counts` (1 or 0).
    """
    known, kt_before = history[DAMPING, i], history[STIFFNESS, i]
    (stiffness, rate, slip_rate, damping, held_before, trial, held, f_n, force, normal_power, power,
     slides) = met(law, hertz, mass, normal, overlap, velocity, history, i, dt)  # fmt: skip
    if not overlap > 0.0:
        put_column(history, SPRING_X, i, (0.0, 0.0, 0.0))
        put_column(history, MOVED_X, i, (0.0, 0.0, 0.0))
        history[STIFFNESS, i], history[DAMPING, i] = 0.0, NO_CONTACT
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    kt = law.tangential * stiffness
    friction, stiffened = spring_work(law, kt_before, kt, held_before, trial, held)
    if known < 0.0 and rate > 0.0:  # it begins
        damping = damping_of_impact(law, hertz, mass, rate)
        own = IMPACTS + which * YIELD
        books[own + FASTEST, i] = max(books[own + FASTEST, i], counts * rate)
        books[own + BEGUN, i] += counts
        books[own + BEYOND, i] += counts if rate > limit else 0.0
    put_column(history, SPRING_X, i, held)
    put_column(history, MOVED_X, i, scale(0.5 * dt, slip_rate))
    history[STIFFNESS, i], history[DAMPING, i] = kt, damping
    books[HEAT, i] += 0.5 * ((normal_power + power) * dt + friction)
    own = which * N_MECHANISMS
    books[own + NORMAL_DAMPING, i] += counts * normal_power * dt
    books[own + TANGENTIAL_DAMPING, i] += counts * power * dt
    books[own + FRICTION, i] += counts * friction
    books[own + LAW_TERM, i] += counts * stiffened
    books[own + SLIP_COUNT, i] -= counts * slides * dot(force, slip_rate) * dt
    return add(force, scale(f_n, normal)), cross(normal, force)


@njit
def distance_of(x, i, j):
    """Square of the distance of two spheres [m2]."""
    a, b, c = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
    return a * a + b * b + c * c


@njit
def to_wall(one, w, point):
    """Distance [m] of a point of the enclosure from wall w, the normal that points to it, its 1/D.

    1/D [1/m] is half of the sum of its curvatures, where these enter the law.
    """
    if w < one.clock[PLANES]:
        plane = one.planes[w]
        inwards = three(plane)
        return dot(inwards, point) - plane[3], scale(-1.0, inwards), 0.0
    numbers = one.numbers
    distance, normal, mean = _to_round(Round(numbers[ROUND]), 0, point[0], point[1], point[2])
    return distance, normal, numbers[CURVED] / mean


@njit
def touching(one, in_use, i, point):
    """The contacts of sphere i that touch or did a step ago, as bits: neighbours, then walls.

    point: its centre in the enclosure. Threads whose spheres touch other entries of their lists
    then work their first, second, ... contacts at once.
    """
    x, near = one.position, one.near[in_use]
    bits, room = one.lasting[i], len(near)
    for k in range(np.uintp(one.listed[in_use, i])):
        j = np.uintp(near[k, i])
        cutoff = x[i, 3] + x[j, 3]
        if distance_of(x, i, j) < _ROUNDING * (cutoff * cutoff):
            bits |= np.int64(1) << np.int64(k)
    for w in range(one.clock[WALLS]):
        if to_wall(one, w, point)[0] < x[i, 3]:
            bits |= np.int64(1) << np.int64(room + w)
    return bits


@njit
def meeting(one, in_use, i, k, point, speed):
    """Contact k of sphere i: 1 of a wall, else 0; 1.0 where it counts, 0.0 from its second sphere.

    Then the normal, the overlap [m], the arm [m] from the centre of i, and the velocity [m/s] of
    the other surface relative to its own; speed: the enclosure's.
    """
    x, u, w, near = (
        one.position,
        one.velocity_now,
        one.spin_now,
        one.near[in_use],
    )
    if k < len(near):
        j = np.uintp(near[k, i])
        separation = add(three(x[j]), scale(-1.0, three(x[i])))
        distance = math.sqrt(dot(separation, separation))
        normal = scale(1.0 / distance, separation)
        overlap = max(x[i, 3] + x[j, 3] - distance, 0.0)
        arm = x[i, 3] - 0.5 * overlap
        rim = add(scale(arm, three(w[i])), scale(x[j, 3] - 0.5 * overlap, three(w[j])))
        moving = add(three(u[j]), scale(-1.0, three(u[i])))
        counts = 1.0 if i < j else 0.0
        return 0, counts, normal, overlap, arm, add(moving, scale(-1.0, cross(rim, normal)))
    arm, normal, _ = to_wall(one, np.int64(k) - len(near), point)
    moving = add(speed, scale(-1.0, three(u[i])))
    rim = scale(arm, three(w[i]))
    velocity = add(moving, scale(-1.0, cross(rim, normal)))
    return 1, 1.0, normal, max(x[i, 3] - arm, 0.0), arm, velocity


@njit
def load_sphere(one, in_use, i, shift, speed):
    """Write the force and torque on sphere i; shift and speed are the enclosure's."""
    books, numbers, room = one.books, one.numbers, one.near.shape[1]
    dt = numbers[TIME_STEP]
    force, torque = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    point = add(three(one.position[i]), scale(-1.0, shift))
    bits, lasting, k = touching(one, in_use, i, point), np.int64(0), np.uintp(0)
    while bits != 0:
        while bits & 1 == 0:
            bits, k = bits >> 1, k + np.uintp(1)
        which, counts, normal, overlap, arm, velocity = meeting(one, in_use, i, k, point, speed)
        law, constants = law_in(one.laws[which]), one.constants[in_use, k]
        push, couple = pushed(
            law, constants[0, i], constants[1, i], normal, overlap, velocity,
            one.history[in_use, k], books, i, which, counts, numbers[YIELDS + which], dt,
        )  # fmt: skip
        force = add(force, scale(-1.0, push))
        torque = add(torque, scale(-arm, couple))
        if which == 1:
            books[WALL_WORK, i] -= dt * dot(push, speed)
            for c in range(3):
                books[WALL_FORCE + 3 * (np.int64(k) - room) + c, i] += push[c]
        lasting |= np.int64(overlap > 0.0) << np.int64(k)
        bits, k = bits >> 1, k + np.uintp(1)
    one.lasting[i] = lasting
    put_column(one.load, 0, i, force)
    put_column(one.load, 3, i, torque)


@njit
def move_sphere(one, i, since):
    """One step of sphere i; whether it has left its list, made so many steps ago [bool].

    v += a dt,   x += v dt,   u = v + a dt/2,   and of the angular velocity likewise
    """
    x, u, w, load = one.position, one.velocity_now, one.spin_now, one.load
    numbers = one.numbers
    dt = numbers[TIME_STEP]
    off = 0.0
    for c in range(3):
        change = dt * u[i, 3] * load[c, i] + dt * numbers[GRAVITY + c]
        v = one.velocity[c, i] + change
        one.velocity[c, i], u[i, c] = v, v + 0.5 * change
        change = dt * w[i, 3] * load[3 + c, i]
        turned = one.spin[c, i] + change
        one.spin[c, i], w[i, c] = turned, turned + 0.5 * change
        x[i, c] += dt * v
        gone = x[i, c] - one.seen[c, i] - since * dt * one.drift[c]
        off += gone * gone
    margin = 0.5 * numbers[SKIN]
    return not off <= margin * margin  # true for NaN as well


@njit
def list_sphere(one, old, i, shift):
    """Make the other of the two lists of sphere i, with the histories of the old one; DONE, or not.

    All spheres are looked at: of some hundred it takes less than to sort them into cells.
    shift: the enclosure's.
    """
    x, u, new, room = one.position, one.velocity_now, 1 - old, one.near.shape[1]
    near, before, skin = one.near[new], one.near[old], one.numbers[SKIN]
    constants, n_before = one.constants[new], one.listed[old, i]
    n, kept, lasting = 0, 0, np.int64(0)
    for j in range(np.uintp(one.clock[SPHERES])):
        both = x[i, 3] + x[j, 3]
        square = distance_of(x, i, j)
        if square < (both + skin) * (both + skin) and j != i:
            if n == room:
                return INNER_FULL
            if square < (1.0 - DEEPEST) * (1.0 - DEEPEST) * both * both:
                return TOO_DEEP
            near[n, i] = j
            while kept < n_before and np.uintp(before[kept, i]) < j:
                kept += 1
            lasts = kept < n_before and np.uintp(before[kept, i]) == j
            lasting |= hand_on(one, old, kept if lasts else -1, n, i)
            constants[n, 0, i] = one.laws[0, 0] * math.sqrt(x[i, 3] * x[j, 3] / both)
            constants[n, 1, i] = 1.0 / (u[i, 3] + u[j, 3])
            n += 1
    one.listed[new, i] = n
    for w in range(one.clock[WALLS]):
        lasting |= hand_on(one, old, room + w, room + w, i)
        point = add(three(x[i]), scale(-1.0, shift))
        distance, _, bend = to_wall(one, w, point)
        if distance < (1.0 - 2.0 * DEEPEST) * x[i, 3]:
            return TOO_DEEP
        radius = x[i, 3] / (1.0 - x[i, 3] * bend)
        constants[room + w, 0, i] = one.laws[1, 0] * math.sqrt(radius)
        constants[room + w, 1, i] = 1.0 / u[i, 3]
    one.lasting[i] = lasting
    for c in range(3):
        one.seen[c, i] = x[i, c]
    return DONE if x[i, 0] + x[i, 1] + x[i, 2] < np.inf else NOT_FINITE


@njit
def hand_on(one, old, k, n, i):
    """Give contact n of the new list of sphere i the history of contact k of the old; -1: none.

    Its bit, where it touched a step ago.
    """
    before, after = one.history[old], one.history[1 - old]
    for h in range(N_HISTORY):
        after[n, h, i] = before[k, h, i] if k >= 0 else 0.0
    if k < 0:
        after[n, DAMPING, i] = NO_CONTACT
    return np.int64(after[n, DAMPING, i] >= 0.0) << np.int64(n)
