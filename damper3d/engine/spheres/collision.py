"""The kernel of one impact: two spheres, or a sphere and a flat wall, without gravity.

The scheme is the engine's, at much smaller steps: leapfrog with the velocity extrapolated to the
time of the forces (v half a step back, u = v + a dt/2), and springs half a step ahead. The energy
balance is that of granulab/contact/hertz.py.
"""

from typing import NamedTuple

import numpy as np

from granulab.contact.hertz import hertz_force, mindlin_force, spring_work
from granulab.contact.jit import njit
from granulab.contact.mindlin_deresiewicz import partial_slip_force
from granulab.contact.vectors import add, cross, dot, norm, scale

# Columns of the history of a contact: time [s], overlap [m], normal force [N], length of the
# tangential displacement [m], tangential force [N].
TIME, OVERLAP, NORMAL_FORCE, SLIP, TANGENTIAL_FORCE = range(5)
# Totals of a contact: where it ends [s], largest overlap [m], normal force [N], tangential over
# normal force, cosine of tangential force and normal; then dissipated, and gained by the law [J].
CONTACT_TIME, MAX_OVERLAP, MAX_FORCE, MAX_RATIO, MAX_TILT = range(5)
NORMAL_DAMPING, TANGENTIAL_DAMPING, FRICTION, LAW_TERM = range(5, 9)
N_TOTALS = 9


class Meeting(NamedTuple):
    """Two bodies that meet; the second may be a flat wall, with radius and inverses 0."""

    radius: tuple[float, float]  # [m]
    inverse_mass: tuple[float, float]  # [1/kg]
    inverse_inertia: tuple[float, float]  # [1/(kg m2)]
    reduced_radius: float  # [m]
    reduced_mass: float  # [kg]
    hertz: float  # law.hertz sqrt(reduced_radius) [N/m^1.5]
    damping: float  # b of this impact [-]


class Bodies(NamedTuple):
    """Both bodies, (2, 3) each; velocities are half a step behind the positions."""

    position: np.ndarray  # [m]
    velocity: np.ndarray  # [m/s]
    spin: np.ndarray  # [rad/s]
    velocity_step: np.ndarray  # change in the last step
    spin_step: np.ndarray


@njit
def collide(law, meeting, bodies, springs, reach, dt, most_steps, rows):
    """Let two bodies that just touch meet until they part; changes `bodies`.

    springs (N, 3) over `reach` [m]: of the exact Mindlin-Deresiewicz law; (0, 3): the simplified
    law. rows (n, 5): filled with the history, evenly spaced over most_steps. Returns the totals
    and the steps taken; most_steps where they have not parted.
    """
    totals = np.zeros(N_TOTALS)
    every = most_steps // len(rows)
    wall_normal = normal_of(bodies)
    ahead, held, slip = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    kt_before = 0.0
    for step in range(most_steps):
        normal = wall_normal if meeting.radius[1] == 0.0 else normal_of(bodies)
        overlap, arms = touch(meeting, bodies, normal)
        if overlap < 0.0 and step > 0:
            return totals, step
        overlap = max(overlap, 0.0)
        at_contact = surface_velocity(bodies, normal, arms)
        rate = -dot(at_contact, normal)
        slip_rate = add(at_contact, scale(rate, normal))
        half_step = scale(0.5 * dt, slip_rate)
        stiffness, dashpot, f_n, inelastic = hertz_force(
            law, meeting.hertz, meeting.reduced_mass, meeting.damping, overlap, rate
        )
        if len(springs) > 0:
            area = np.sqrt(meeting.reduced_radius * overlap)
            f_t, power, friction_work, _ = partial_slip_force(
                law, stiffness, dashpot, f_n, normal, overlap, area, springs, reach, half_step,
                slip_rate,
            )  # fmt: skip
        else:
            kt = law.tangential * stiffness
            moved = scale(kt if law.stored_force else 1.0, half_step)
            ahead, held = across(ahead, normal), across(held, normal)
            trial = add(ahead, moved)
            f_t, kept, power, _ = mindlin_force(law, stiffness, dashpot, f_n, trial, slip_rate)
            friction_work, stiffness_work = spring_work(law, kt_before, kt, held, trial, kept)
            totals[LAW_TERM] += stiffness_work
            ahead, held, kt_before = add(kept, moved), kept, kt
        totals[NORMAL_DAMPING] += dt * inelastic * rate
        totals[TANGENTIAL_DAMPING] += dt * power
        totals[FRICTION] += friction_work
        if f_n != 0.0:  # ends where the overlap would, or with this step
            parts = overlap < -rate * dt
            totals[CONTACT_TIME] = step * dt + (overlap / -rate if parts else dt)
        keep_largest(totals, overlap, f_n, f_t, normal)
        slip = add(slip, scale(dt, slip_rate))
        if step % every == 0:
            row = rows[step // every]
            row[TIME], row[OVERLAP], row[NORMAL_FORCE] = step * dt, overlap, f_n
            row[SLIP], row[TANGENTIAL_FORCE] = norm(slip), norm(f_t)
        push(meeting, bodies, add(scale(f_n, normal), f_t), cross(normal, f_t), arms, dt)
    return totals, most_steps


@njit
def normal_of(bodies):
    """Unit vector from the first body to the second."""
    line = row_of(bodies.position, 1, 1.0, 0, -1.0)
    return scale(1.0 / norm(line), line)


@njit
def touch(meeting, bodies, normal):
    """Overlap [m] and the arms [m] from both centres to the contact: they add up to the distance.

    Spheres share the overlap; a wall is not dented.
    """
    distance = dot(row_of(bodies.position, 1, 1.0, 0, -1.0), normal)
    radius_i, radius_j = meeting.radius
    overlap = radius_i + radius_j - distance
    if radius_j == 0.0:
        return overlap, (distance, 0.0)
    return overlap, (radius_i - 0.5 * overlap, radius_j - 0.5 * overlap)


@njit
def surface_velocity(bodies, normal, arms):
    """Velocity [m/s] of the second body's surface relative to the first's, at this time."""
    moving = row_of(bodies.velocity, 1, 1.0, 0, -1.0)
    moving = add(moving, row_of(bodies.velocity_step, 1, 0.5, 0, -0.5))
    turning = row_of(bodies.spin, 0, arms[0], 1, arms[1])
    turning = add(turning, row_of(bodies.spin_step, 0, 0.5 * arms[0], 1, 0.5 * arms[1]))
    return add(moving, scale(-1.0, cross(turning, normal)))


@njit
def keep_largest(totals, overlap, f_n, f_t, normal):
    """Return what is asked of a whole contact."""
    totals[MAX_OVERLAP] = max(totals[MAX_OVERLAP], overlap)
    totals[MAX_FORCE] = max(totals[MAX_FORCE], f_n)
    size = norm(f_t)
    if f_n > 0.0:
        totals[MAX_RATIO] = max(totals[MAX_RATIO], size / f_n)
    if size > 0.0:
        totals[MAX_TILT] = max(totals[MAX_TILT], abs(dot(f_t, normal)) / size)


@njit
def push(meeting, bodies, force, turn, arms, dt):
    """One step: force [N] on the second body, its opposite on the first; turn = normal x force."""
    x, v, w = bodies.position, bodies.velocity, bodies.spin
    dv, dw = bodies.velocity_step, bodies.spin_step
    for b in range(2):
        way = 1.0 if b == 1 else -1.0
        for c in range(3):
            dv[b, c] = way * dt * meeting.inverse_mass[b] * force[c]
            dw[b, c] = -dt * meeting.inverse_inertia[b] * arms[b] * turn[c]
            v[b, c] += dv[b, c]
            w[b, c] += dw[b, c]
            x[b, c] += dt * v[b, c]


@njit
def across(a, normal):
    """The part of a vector across a normal."""
    return add(a, scale(-dot(a, normal), normal))


@njit
def row_of(table, first, s, second, t):
    """s times one row and t times another of an (n, 3) array, as a vector."""
    return (
        s * table[first, 0] + t * table[second, 0],
        s * table[first, 1] + t * table[second, 1],
        s * table[first, 2] + t * table[second, 2],
    )
