"""Motion: the step loop, leapfrog with the velocity extrapolated to the time of the forces.

    v(n+1/2) = v(n-1/2) + a(n) dt,   x(n+1) = x(n) + v(n+1/2) dt
    u(n+1)   = v(n+1/2) + a(n) dt/2

Dashpots that take the velocity half a step back make the energy balance first order in dt; the
extrapolated u makes them second order. The enclosure's motion is known at all times, or it rides on
a host (motions/host.py), which takes the forces of a step as the particles do; several dampers may
ride on one.
"""

import numpy as np

from damper3d.engine.forces import apply_forces
from damper3d.engine.kinds import move
from damper3d.engine.motions import displacement, velocity
from damper3d.engine.motions.crossed import crosses
from damper3d.engine.motions.host import kick, rides
from damper3d.engine.motions.turning import turns, twists, without_shaker, without_walls
from damper3d.engine.neighbours import search_pairs, search_walls
from damper3d.engine.state import DONE, STALE_INNER, STALE_WALL, STEP
from damper3d.engine.walls import drive_walls
from granulab.contact.jit import inlined_inner, inner, specialised, uncounted


@inner
def take_steps(world, n_steps):
    """Up to n_steps steps; how many were taken, and DONE or why no more."""
    room, bed = without_shaker(world), without_walls(world)
    shift, speed = place_now(world)
    for taken in range(n_steps):
        if world.counts[STALE_INNER] or world.counts[STALE_WALL]:
            outcome = search(room, shift)
            if outcome != DONE:
                return taken, outcome
        before = force_so_far(world)
        apply_forces(room, shift, speed)
        ride(world, before)
        world.counts[STEP] += 1
        shift, speed = place_now(world)
        drive_walls(room)
        move(bed, shift, np.int64(0), world.parts[-1])
    return n_steps, DONE


@uncounted
def advance_together(worlds, n_steps):
    """Likewise of dampers on one host, a tuple of worlds of one type, step by step.

    How many steps were taken, DONE or why no more, and of which world.
    """
    outcome, which = np.int64(DONE), np.int64(0)
    for taken in range(n_steps):
        for k, world in enumerate(worlds):
            if outcome == DONE:
                outcome, which = search(without_shaker(world), place_now(world)[0]), k
        if outcome != DONE:
            return taken, outcome, which
        for world in worlds:
            shift, speed = place_now(world)
            before = force_so_far(world)
            apply_forces(without_shaker(world), shift, speed)
            ride(world, before)
        for world in worlds:
            world.counts[STEP] += 1
            drive_walls(without_shaker(world))
            move(without_walls(world), place_now(world)[0], np.int64(0), world.parts[-1])
    return n_steps, outcome, which


@inner
def place_now(world):
    """Displacement and velocity of a world's enclosure at its step."""
    return enclosure_at(world.shaker, world.direction, world.counts[STEP] * world.time_step)


@inner
def search(world, shift):
    """Make stale lists again; DONE, or what is wrong. Best of without_shaker(world), see there."""
    counts = world.counts
    if counts[STALE_INNER]:
        outcome = search_pairs(without_walls(world), shift)
        if outcome != DONE:
            return outcome
    if counts[STALE_WALL]:
        outcome = search_walls(world, shift)
        if outcome != DONE:
            return outcome
    return DONE


@uncounted
def enclosure_at(shaker, d, time):
    """Displacement [m] and velocity [m/s] of the enclosure at a time; d: direction of the motion.

    A motion that crosses another has the direction of the second itself.
    """
    along, rate = displacement(shaker, time), velocity(shaker, time)
    shift = along * d[0], along * d[1], along * d[2]
    return cross_over(shaker, time, shift, (rate * d[0], rate * d[1], rate * d[2]))


def cross_over(shaker, time, shift, speed):
    """Displacement and velocity of the enclosure, with those along a second direction added."""


@specialised(cross_over)
def _cross_over(shaker, time, shift, speed):
    if crosses(shaker):
        return lambda shaker, time, shift, speed: _crossed(shaker, time, shift, speed)
    return lambda shaker, time, shift, speed: (shift, speed)


@inlined_inner
def _crossed(shaker, time, shift, speed):
    d = shaker.direction
    along, rate = displacement(shaker.across, time), velocity(shaker.across, time)
    return (
        (shift[0] + along * d[0], shift[1] + along * d[1], shift[2] + along * d[2]),
        (speed[0] + rate * d[0], speed[1] + rate * d[1], speed[2] + rate * d[2]),
    )


def force_so_far(world):
    """Return the force on the enclosure along its motion, summed over the steps since asked [N]."""


def ride(world, before):
    """Let the enclosure's host take the force of this step; before: what force_so_far gave."""


@specialised(force_so_far)
def _force_so_far(world):
    if rides(world):
        return lambda world: _summed(world)
    return lambda world: 0.0


@specialised(ride)
def _ride(world, before):
    if rides(world):
        return lambda world, before: _kick(world, before)
    if turns(world):
        return lambda world, before: _twist(world)
    return lambda world, before: None


@inlined_inner
def _summed(world):
    total, force, d = 0.0, world.walls.force, world.direction
    for w in range(len(force)):
        total += force[w, 0] * d[0] + force[w, 1] * d[1] + force[w, 2] * d[2]
    return total


@inlined_inner
def _twist(world):
    """The torque of a step, to the host if there is one."""
    push_host(world)
    world.shaker.torque[0] = 0.0


def push_host(world):
    """Let a host that twists take the torque of this step."""


@specialised(push_host)
def _push_host(world):
    if twists(world):
        return lambda world: kick(
            world.shaker.arc,
            world.counts[STEP] * world.time_step,
            world.shaker.torque[0] / world.shaker.radius,
        )
    return lambda world: None


@inlined_inner
def _kick(world, before):
    kick(world.shaker, world.counts[STEP] * world.time_step, _summed(world) - before)
