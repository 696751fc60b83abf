"""One step of spheres, and which lists it takes them out of.

In the processor's vectors: as three numbers of a row are told apart for the lists, a compiler would
take all rows number by number.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from damper3d.engine.geometry import copy_rows
from damper3d.engine.simd import NOTHING, begin_of, data, filled, load, row_of, square, store
from damper3d.engine.state import (
    CLOSE_MADE,
    KINETIC,
    POSITION_X,
    POTENTIAL,
    STALE_CLOSE,
    STALE_WALL,
    STEP,
    VELOCITY_X,
    VELOCITY_Z,
)
from granulab.contact.jit import inlined_inner, inner


@inlined_inner
def move(world, shift):
    """One step of spheres; wipes their loads and marks the lists that they have left.

        v += a dt,   x += v dt,   u = v + a dt/2,   and of the spin likewise

    shift is that of the enclosure after the step.
    """
    bodies, spheres, gravity = world.bodies, world.spheres, world.gravity
    counts, dt = world.counts, world.time_step
    close, wall, x, v = world.close_seen, world.wall_seen, spheres.position, bodies.velocity
    fall = dt * gravity[0], dt * gravity[1], dt * gravity[2]
    since = (counts[STEP] - counts[CLOSE_MADE]) * dt
    drift = since * close.drift[0], since * close.drift[1], since * close.drift[2]
    carried = shift[0] - wall.drift[0], shift[1] - wall.drift[1], shift[2] - wall.drift[2]
    left = left_wall = False
    for i in range(np.uintp(len(v))):
        per_mass, per_inertia = dt * bodies.inverse_mass[i], dt * bodies.inverse_inertia[i]
        _kick(v, spheres.velocity, spheres.force, per_mass, fall, i)
        _kick(bodies.spin, spheres.spin, spheres.torque, per_inertia, (0.0, 0.0, 0.0), i)
        _drift(x, v, dt, i)
        inside, inside_wall = close.leeway[i] ** 2, wall.leeway[i] ** 2
        left |= not _square_off(x, close.place, drift, i) <= inside  # true for NaN as well
        left_wall |= not _square_off(x, wall.place, carried, i) <= inside_wall
    counts[STALE_CLOSE] |= left
    counts[STALE_WALL] |= left_wall


@inner
def note_seen(world, seen):
    """Note where the spheres are now, and how fast they move on the whole."""
    u = world.spheres.velocity
    copy_rows(seen.place, world.spheres.position)
    a = b = c = 0.0
    n = len(seen.place)
    for i in range(np.uintp(n)):
        a += u[i, 0]
        b += u[i, 1]
        c += u[i, 2]
    seen.drift[0], seen.drift[1], seen.drift[2] = a / n, b / n, c / n


@inner
def mean_motion(world, shift, row):
    """Kinetic and potential energy, mean position in the enclosure and mean velocity."""
    bodies, spheres, gravity = world.bodies, world.spheres, world.gravity
    x, u, w = spheres.position, spheres.velocity, spheres.spin
    kinetic = potential = total = 0.0
    row[POSITION_X : VELOCITY_Z + 1] = 0.0
    for i in range(len(bodies.inverse_mass)):
        mass = 1.0 / bodies.inverse_mass[i]
        total += mass
        for c in range(3):
            kinetic += 0.5 * mass * u[i, c] ** 2 + 0.5 * w[i, c] ** 2 / bodies.inverse_inertia[i]
            potential -= mass * gravity[c] * x[i, c]
            row[POSITION_X + c] += mass * (x[i, c] - shift[c])
            row[VELOCITY_X + c] += mass * u[i, c]
    row[KINETIC], row[POTENTIAL] = kinetic, potential
    for c in range(6):
        row[POSITION_X + c] /= total


@intrinsic
def _kick(typingctx, v, u, loads, factor, gain, i):
    """Row i of v += factor loads + gain; u is half of that further on; the loads are wiped."""
    signature = types.void(v, u, loads, factor, gain, i)

    def generate(context, builder, signature, arguments):
        v, u, loads, factor, gain, i = data(context, builder, signature, arguments)
        begin = begin_of(builder, i)
        change = builder.fmul(filled(builder, factor), load(builder, loads, begin))
        change = builder.fadd(change, row_of(builder, _three(builder, gain)))
        moved = builder.fadd(load(builder, v, begin), change)
        half = builder.fmul(filled(builder, ir.Constant(ir.DoubleType(), 0.5)), change)
        store(builder, moved, v, begin)
        store(builder, builder.fadd(moved, half), u, begin)
        store(builder, NOTHING, loads, begin)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def _drift(typingctx, x, v, dt, i):
    """Row i of x += dt v; the fourth number, a radius, gains the zero that v has there."""
    signature = types.void(x, v, dt, i)

    def generate(context, builder, signature, arguments):
        x, v, dt, i = data(context, builder, signature, arguments)
        begin = begin_of(builder, i)
        change = builder.fmul(filled(builder, dt), load(builder, v, begin))
        store(builder, builder.fadd(load(builder, x, begin), change), x, begin)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def _square_off(typingctx, x, place, carried, i):
    """Square of how far x is from its place, but for what it was carried along, in row i."""
    signature = types.float64(x, place, carried, i)

    def generate(context, builder, signature, arguments):
        x, place, carried, i = data(context, builder, signature, arguments)
        begin = begin_of(builder, i)
        off = builder.fsub(load(builder, x, begin), load(builder, place, begin))
        return square(builder, builder.fsub(off, row_of(builder, _three(builder, carried))))

    return signature, generate


def _three(builder, numbers):
    return [builder.extract_value(numbers, c) for c in range(3)]
