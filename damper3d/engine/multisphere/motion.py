"""One step of rigid bodies, and of those of their spheres that stand in a list.

    v += (F/m + g) dt,   x += v dt,   u = v + (F/m + g) dt/2
    L += T dt,           q turns freely with L for dt,   w = I^-1 (L + T dt/2)

with F and T the sums over the body's spheres, T about the centroid; a sphere at r from there has
the velocity u + w x r. Free rotation: rotation.py.
"""

import numpy as np

from damper3d.engine.multisphere.rotation import axes_of, freely_turned
from damper3d.engine.simd import place_sphere, take_load
from damper3d.engine.state import (
    CLOSE,
    CLOSE_MADE,
    KINETIC,
    POSITION_X,
    POTENTIAL,
    STALE_CLOSE,
    STALE_WALL,
    STEP,
    VELOCITY_X,
    VELOCITY_Z,
    WALL,
)
from damper3d.engine.walls import gap_to_wall
from granulab.contact.jit import inlined_inner, inner, uncounted


@inlined_inner
def move(world, shift):
    """One step; wipes the loads of the spheres and marks the lists that the bodies have left.

    shift is that of the enclosure after the step.
    """
    counts, dt, arm = world.counts, world.time_step, world.shape.arm
    since, drift = (counts[STEP] - counts[CLOSE_MADE]) * dt, world.close_seen.drift
    carried = since * drift[0], since * drift[1], since * drift[2]
    was = world.wall_seen.drift
    swept = shift[0] - was[0], shift[1] - was[1], shift[2] - was[2]
    left = left_wall = False
    for b in range(len(world.bodies.inverse_mass)):
        take_loads(world, b)
        kick(world, b)
        turn(world, b)
        place_active(world, b)
        left |= has_left(world.bodies, world.close_seen, arm, b, carried)
        left_wall |= has_left(world.bodies, world.wall_seen, arm, b, swept)
    counts[STALE_CLOSE] |= left
    counts[STALE_WALL] |= left_wall


@inlined_inner
def take_loads(world, b):
    """Force on a body and torque about its centroid, from its spheres, whose loads are wiped."""
    bodies, spheres = world.bodies, world.spheres
    for c in range(4):
        bodies.force[b, c] = bodies.torque[b, c] = 0.0
    for n in range(world.shape.active_first[b], world.shape.active_first[b + 1]):
        take_load(
            spheres.force, spheres.torque, spheres.position, bodies.position, bodies.force,
            bodies.torque, np.int64(world.shape.active[n]), b,
        )  # fmt: skip


@inlined_inner
def kick(world, b):
    """Velocity, momentum and position of a body after a step."""
    bodies, gravity, dt = world.bodies, world.gravity, world.time_step
    for c in range(3):
        gain = dt * bodies.inverse_mass[b] * bodies.force[b, c] + dt * gravity[c]
        bodies.velocity[b, c] += gain
        bodies.velocity_now[b, c] = bodies.velocity[b, c] + 0.5 * gain
        bodies.position[b, c] += dt * bodies.velocity[b, c]
        gain = dt * bodies.torque[b, c]
        bodies.momentum[b, c] += gain
        bodies.momentum_now[b, c] = bodies.momentum[b, c] + 0.5 * gain


@inlined_inner
def turn(world, b):
    """Orientation, axes and spin of a body after a step; its angular momentum is that of then."""
    bodies, shape = world.bodies, world.shape
    old, momentum = bodies.orientation, bodies.momentum
    q = old[b, 0], old[b, 1], old[b, 2], old[b, 3]
    about = momentum[b, 0], momentum[b, 1], momentum[b, 2]
    q = freely_turned(q, about, shape.inverse_inertia, shape.odd, world.time_step)
    for c in range(4):
        old[b, c] = q[c]
    note_axes(bodies, b)
    note_spin(bodies, shape, b)


@uncounted
def note_axes(bodies, b):
    """The axes that belong to a body's orientation."""
    q = bodies.orientation
    x, y, z = axes_of((q[b, 0], q[b, 1], q[b, 2], q[b, 3]))
    for c in range(3):
        bodies.axes[b, c], bodies.axes[b, 4 + c], bodies.axes[b, 8 + c] = x[c], y[c], z[c]


@uncounted
def note_spin(bodies, shape, b):
    """w = I^-1 L of a body, now."""
    axes, momentum, spin = bodies.axes, bodies.momentum_now, bodies.spin_now
    spin[b, 0] = spin[b, 1] = spin[b, 2] = 0.0
    for k in range(3):
        x, y, z = axes[b, 4 * k], axes[b, 4 * k + 1], axes[b, 4 * k + 2]
        along = x * momentum[b, 0] + y * momentum[b, 1] + z * momentum[b, 2]
        rate = shape.inverse_inertia[k] * along
        spin[b, 0] += rate * x
        spin[b, 1] += rate * y
        spin[b, 2] += rate * z


@inlined_inner
def place_active(world, b):
    """Position, velocity and spin of the listed spheres of a body."""
    bodies, spheres, offset = world.bodies, world.spheres, world.shape.offset
    first = b * len(offset)
    for n in range(world.shape.active_first[b], world.shape.active_first[b + 1]):
        i = np.int64(world.shape.active[n])
        place_sphere(
            bodies.position, bodies.velocity_now, bodies.spin_now, bodies.axes, offset,
            spheres.position, spheres.velocity, spheres.spin, b, i - first, i,
        )  # fmt: skip


@inner
def arm_of(axes, offset, b, s):
    """From the centroid of body b to the centre of its sphere s, in the laboratory [m]."""
    a, d, e = offset[s, 0], offset[s, 1], offset[s, 2]
    return (
        a * axes[b, 0] + d * axes[b, 4] + e * axes[b, 8],
        a * axes[b, 1] + d * axes[b, 5] + e * axes[b, 9],
        a * axes[b, 2] + d * axes[b, 6] + e * axes[b, 10],
    )


@inlined_inner
def has_left(bodies, seen, arm, b, carried):
    """Return whether a particle may have passed its margin; also if its position is no number."""
    straight, turned = ways_since(bodies, seen, arm, b, carried)
    leeway = seen.leeway[b]
    if 2.0 * (straight + turned) <= leeway * leeway:  # (a + b)^2 <= 2 (a^2 + b^2)
        return False
    return not np.sqrt(straight) + np.sqrt(turned) <= leeway


@inner
def ways_since(bodies, seen, arm, b, carried):
    """Squares of how far a body came, but for what it was carried along, and its spheres turned.

    In m2. A turn by an angle t takes a point at the distance r by 2 r sin(t/2) at most, and the
    quaternion by 2 sin(t/4), of which 2 r times is more.
    """
    x, q = bodies.position, bodies.orientation
    dx = x[b, 0] - seen.place[b, 0] - carried[0]
    dy = x[b, 1] - seen.place[b, 1] - carried[1]
    dz = x[b, 2] - seen.place[b, 2] - carried[2]
    turned = 0.0
    for c in range(4):
        turned += (q[b, c] - seen.turn[b, c]) ** 2
    return dx * dx + dy * dy + dz * dz, 4.0 * arm * arm * turned


@inner
def list_spheres(world, seen):
    """Note where the particles are now, and how fast they move on the whole; see list_active."""
    bodies = world.bodies
    n = len(bodies.inverse_mass)
    for b in range(n):
        for c in range(4):
            seen.place[b, c] = bodies.position[b, c]
            seen.turn[b, c] = bodies.orientation[b, c]
    for c in range(3):
        total = 0.0
        for b in range(n):
            total += bodies.velocity_now[b, c]
        seen.drift[c] = total / n
    list_active(world)


@inner
def list_active(world):
    """Name the spheres of both lists, particle by particle, and bring them up to date."""
    shape, counts = world.shape, world.counts
    listed, size = shape.scratch.listed, len(shape.offset)
    listed[:] = 0
    for n in range(counts[CLOSE]):
        listed[world.close.i[n]] = listed[world.close.j[n]] = 1
    for n in range(counts[WALL]):
        listed[world.wall.i[n]] = 1
    found = 0
    for b in range(len(world.bodies.inverse_mass)):
        shape.active_first[b] = found
        for i in range(b * size, (b + 1) * size):
            shape.active[found] = i
            found += listed[i]
        shape.active_first[b + 1] = found
        place_active(world, b)


@inner
def place_near_walls(world, skin, shift):
    """Bring all spheres of the particles that are near a wall to their positions."""
    spheres, offset, bodies = world.spheres, world.shape.offset, world.bodies
    for b in range(len(bodies.inverse_mass)):
        for w in range(len(world.walls.force)):
            if gap_to_wall(world.walls, bodies.position, w, b, shift) < skin:
                for s in range(len(offset)):
                    r = arm_of(bodies.axes, offset, b, s)
                    for c in range(3):
                        spheres.position[b * len(offset) + s, c] = bodies.position[b, c] + r[c]
                break


@inner
def mean_motion(world, shift, row):
    """Kinetic and potential energy, mean place in the enclosure and mean velocity, into a row."""
    bodies, gravity = world.bodies, world.gravity
    x, u = bodies.position, bodies.velocity_now
    kinetic = potential = total = 0.0
    row[POSITION_X : VELOCITY_Z + 1] = 0.0
    for b in range(len(bodies.inverse_mass)):
        mass = 1.0 / bodies.inverse_mass[b]
        total += mass
        for c in range(3):
            kinetic += 0.5 * mass * u[b, c] ** 2
            kinetic += 0.5 * bodies.spin_now[b, c] * bodies.momentum_now[b, c]
            potential -= mass * gravity[c] * x[b, c]
            row[POSITION_X + c] += mass * (x[b, c] - shift[c])
            row[VELOCITY_X + c] += mass * u[b, c]
    row[KINETIC], row[POTENTIAL] = kinetic, potential
    for c in range(6):
        row[POSITION_X + c] /= total
