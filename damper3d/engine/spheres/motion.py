"""One step of spheres, and which lists it takes them out of."""

import numpy as np

from damper3d.engine.geometry import copy_rows
from damper3d.engine.laws.balance import take_heat
from damper3d.engine.simd import drift_on, kick, square_off
from damper3d.engine.state import (
    INNER_MADE,
    KINETIC,
    POSITION_X,
    POTENTIAL,
    STALE_INNER,
    STALE_WALL,
    STEP,
    VELOCITY_X,
    VELOCITY_Z,
)
from granulab.contact.jit import inlined_inner, inner


@inlined_inner
def move(world, shift, first, last):
    """One step of spheres first ... last - 1; wipes their loads, marks the lists that they left.

        v += a dt,   x += v dt,   u = v + a dt/2,   and of the angular velocity likewise

    shift is that of the enclosure after the step.
    """
    particles, spheres, gravity = world.particles, world.spheres, world.gravity
    counts, dt = world.counts, world.time_step
    seen, seen_wall, x, v = world.inner_seen, world.wall_seen, spheres.position, particles.velocity
    fall = dt * gravity[0], dt * gravity[1], dt * gravity[2]
    since = (counts[STEP] - counts[INNER_MADE]) * dt
    drift = since * seen.drift[0], since * seen.drift[1], since * seen.drift[2]
    carried = (
        shift[0] - seen_wall.drift[0],
        shift[1] - seen_wall.drift[1],
        shift[2] - seen_wall.drift[2],
    )
    left = left_wall = False
    for i in range(np.uintp(first), np.uintp(last)):
        per_mass, per_inertia = dt * particles.inverse_mass[i], dt * particles.inverse_inertia[i]
        take_heat(particles.dissipated, spheres.torque, i)
        kick(v, spheres.velocity, spheres.force, per_mass, fall, i)
        kick(
            particles.angular_velocity,
            spheres.angular_velocity,
            spheres.torque,
            per_inertia,
            (0.0, 0.0, 0.0),
            i,
        )
        drift_on(x, v, dt, i)
        inside, inside_wall = seen.margin[i] ** 2, seen_wall.margin[i] ** 2
        left |= not square_off(x, seen.position, drift, i) <= inside  # true for NaN as well
        left_wall |= not square_off(x, seen_wall.position, carried, i) <= inside_wall
    counts[STALE_INNER] |= left
    counts[STALE_WALL] |= left_wall


@inner
def note_seen(world, seen):
    """Note where the spheres are now, and how fast they move on the whole."""
    u = world.spheres.velocity
    copy_rows(seen.position, world.spheres.position)
    a = b = c = 0.0
    n = len(seen.position)
    for i in range(np.uintp(n)):
        a += u[i, 0]
        b += u[i, 1]
        c += u[i, 2]
    seen.drift[0], seen.drift[1], seen.drift[2] = a / n, b / n, c / n


@inner
def mean_motion(world, shift, row):
    """Kinetic and potential energy, mean position in the enclosure and mean velocity."""
    particles, spheres, gravity = world.particles, world.spheres, world.gravity
    x, u, w = spheres.position, spheres.velocity, spheres.angular_velocity
    kinetic = potential = total = 0.0
    row[POSITION_X : VELOCITY_Z + 1] = 0.0
    for i in range(len(particles.inverse_mass)):
        mass = 1.0 / particles.inverse_mass[i]
        total += mass
        for c in range(3):
            kinetic += 0.5 * mass * u[i, c] ** 2 + 0.5 * w[i, c] ** 2 / particles.inverse_inertia[i]
            potential -= mass * gravity[c] * x[i, c]
            row[POSITION_X + c] += mass * (x[i, c] - shift[c])
            row[VELOCITY_X + c] += mass * u[i, c]
    row[KINETIC], row[POTENTIAL] = kinetic, potential
    for c in range(6):
        row[POSITION_X + c] /= total
