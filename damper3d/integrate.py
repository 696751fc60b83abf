"""Motion: the step loop, leapfrog with the velocity extrapolated to the time of the forces.

    v(n+1/2) = v(n-1/2) + a(n) dt,   x(n+1) = x(n) + v(n+1/2) dt
    u(n+1)   = v(n+1/2) + a(n) dt/2

Dashpots that take the velocity half a step back make the energy books first order in dt; the
extrapolated u makes them second order. The enclosure's motion is known at all times.
"""

import numpy as np

from contact.jit import inlined, uncounted
from damper3d.forces import apply_forces
from damper3d.neighbours import DONE, search
from damper3d.shaker import displacement, velocity
from damper3d.state import (
    CLOSE_MADE,
    CLOSE_SKIN,
    STALE_CLOSE,
    STALE_WALL,
    STEP,
    WALL_SKIN,
)


@uncounted
def advance(world, n_steps):
    """Up to n_steps steps; how many were taken, and DONE or why no more."""
    direction, dt = world.direction, world.time_step
    shift, speed = enclosure_at(world.shaker, direction, world.counts[STEP] * dt)
    for taken in range(n_steps):
        if world.counts[STALE_CLOSE] or world.counts[STALE_WALL]:
            outcome = search(world, shift)
            if outcome != DONE:
                return taken, outcome
        apply_forces(world, shift, speed)
        world.counts[STEP] += 1
        shift, speed = enclosure_at(world.shaker, direction, world.counts[STEP] * dt)
        move(world, shift)
    return n_steps, DONE


@uncounted
def enclosure_at(shaker, d, time):
    """Displacement [m] and velocity [m/s] of the enclosure along the direction d, at a time."""
    along, rate = displacement(shaker, time), velocity(shaker, time)
    return (along * d[0], along * d[1], along * d[2]), (rate * d[0], rate * d[1], rate * d[2])


@inlined
def move(world, shift):
    """One step of bodies that are spheres; wipes their loads and marks the lists they have left.

    shift is that of the enclosure after the step.
    """
    bodies, spheres, gravity = world.bodies, world.spheres, world.gravity
    counts, lengths, dt = world.counts, world.lengths, world.time_step
    x, v, w = spheres.position, bodies.velocity, bodies.spin
    a, b, drift, was = world.close.place, world.wall.place, world.close.drift, world.wall.drift
    since = (counts[STEP] - counts[CLOSE_MADE]) * dt
    dx, dy, dz = since * drift[0], since * drift[1], since * drift[2]
    ex, ey, ez = shift[0] - was[0], shift[1] - was[1], shift[2] - was[2]
    inside = (0.5 * lengths[CLOSE_SKIN]) ** 2
    inside_wall = lengths[WALL_SKIN] ** 2
    left = left_wall = 0
    for i in range(np.uintp(len(v))):
        per_mass, per_inertia = dt * bodies.inverse_mass[i], dt * bodies.inverse_inertia[i]
        for c in range(4):  # the fourth moves the radius by nothing
            dv = per_mass * spheres.force[i, c] + dt * gravity[c]
            dw = per_inertia * spheres.torque[i, c]
            v[i, c] += dv
            w[i, c] += dw
            spheres.velocity[i, c] = v[i, c] + 0.5 * dv
            spheres.spin[i, c] = w[i, c] + 0.5 * dw
            x[i, c] += dt * v[i, c]
            spheres.force[i, c] = 0.0
            spheres.torque[i, c] = 0.0
        px, py, pz = x[i, 0] - a[i, 0] - dx, x[i, 1] - a[i, 1] - dy, x[i, 2] - a[i, 2] - dz
        left |= not px * px + py * py + pz * pz <= inside  # true for NaN as well
        px, py, pz = x[i, 0] - b[i, 0] - ex, x[i, 1] - b[i, 1] - ey, x[i, 2] - b[i, 2] - ez
        left_wall |= not px * px + py * py + pz * pz <= inside_wall
    counts[STALE_CLOSE] |= left
    counts[STALE_WALL] |= left_wall
