"""Motion: the step loop, leapfrog with the velocity extrapolated to the time of the forces.

    v(n+1/2) = v(n-1/2) + a(n) dt,   x(n+1) = x(n) + v(n+1/2) dt
    u(n+1)   = v(n+1/2) + a(n) dt/2

Dashpots that take the velocity half a step back make the energy balance first order in dt; the
extrapolated u makes them second order. The enclosure's motion is known at all times.
"""

from damper3d.engine.forces import apply_forces
from damper3d.engine.kinds import move
from damper3d.engine.motions import displacement, velocity
from damper3d.engine.neighbours import search_pairs, search_walls
from damper3d.engine.state import DONE, STALE_INNER, STALE_WALL, STEP
from damper3d.engine.walls import drive_walls
from granulab.contact.jit import uncounted


@uncounted
def advance(world, n_steps):
    """Up to n_steps steps; how many were taken, and DONE or why no more."""
    direction, dt = world.direction, world.time_step
    shift, speed = enclosure_at(world.shaker, direction, world.counts[STEP] * dt)
    for taken in range(n_steps):
        if world.counts[STALE_INNER] or world.counts[STALE_WALL]:
            outcome = search(world, shift)
            if outcome != DONE:
                return taken, outcome
        apply_forces(world, shift, speed)
        world.counts[STEP] += 1
        shift, speed = enclosure_at(world.shaker, direction, world.counts[STEP] * dt)
        drive_walls(world)
        move(world, shift)
    return n_steps, DONE


@uncounted
def search(world, shift):
    """Make stale lists again; DONE, or what is wrong."""
    counts = world.counts
    if counts[STALE_INNER]:
        outcome = search_pairs(world, shift)
        if outcome != DONE:
            return outcome
    if counts[STALE_WALL]:
        outcome = search_walls(world, shift)
        if outcome != DONE:
            return outcome
    return DONE


@uncounted
def enclosure_at(shaker, d, time):
    """Displacement [m] and velocity [m/s] of the enclosure along the direction d, at a time."""
    along, rate = displacement(shaker, time), velocity(shaker, time)
    return (along * d[0], along * d[1], along * d[2]), (rate * d[0], rate * d[1], rate * d[2])
