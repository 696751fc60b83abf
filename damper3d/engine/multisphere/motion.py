"""One step of rigid particles, and of those of their spheres that stand in a list.

    v += (F/m + g) dt,   x += v dt,   u = v + (F/m + g) dt/2
    L += T dt,           q turns freely with L for dt,   w = I^-1 (L + T dt/2)

with F and T the sums over the particle's spheres, T about the centroid; a sphere at r from there
has the velocity u + w x r. Free rotation: rotation.py.
"""

import numpy as np

from damper3d.engine.laws.balance import take_heat
from damper3d.engine.multisphere.form import (
    farthest_centre,
    first_row,
    first_sphere,
    rotation_of,
)
from damper3d.engine.multisphere.rotation import axes_of, freely_turned
from damper3d.engine.simd import place_sphere, take_load
from damper3d.engine.state import (
    INNER,
    INNER_MADE,
    KINETIC,
    POSITION_X,
    POTENTIAL,
    STALE_INNER,
    STALE_WALL,
    STEP,
    VELOCITY_X,
    VELOCITY_Z,
    WALL,
)
from damper3d.engine.walls import gap_to_wall
from granulab.contact.jit import inlined_inner, inner, uncounted


@inlined_inner
def move(world, shift, first, last):
    """One step of particles first ... last - 1; wipes the loads of their spheres.

    Marks the lists that they have left; shift is that of the enclosure after the step.
    """
    counts, dt, form = world.counts, world.time_step, world.shape.form
    since, drift = (counts[STEP] - counts[INNER_MADE]) * dt, world.inner_seen.drift
    carried = since * drift[0], since * drift[1], since * drift[2]
    was = world.wall_seen.drift
    swept = shift[0] - was[0], shift[1] - was[1], shift[2] - was[2]
    left = left_wall = False
    for b in range(first, last):
        take_loads(world, b)
        kick(world, b)
        turn(world, b)
        place_active(world, b)
        arm = farthest_centre(form, b)
        left |= has_left(world.particles, world.inner_seen, arm, b, carried)
        left_wall |= has_left(world.particles, world.wall_seen, arm, b, swept)
    counts[STALE_INNER] |= left
    counts[STALE_WALL] |= left_wall


@inlined_inner
def take_loads(world, b):
    """Sum force and torque about the centroid of a particle over its spheres, and wipe theirs."""
    particles, spheres = world.particles, world.spheres
    for c in range(4):
        particles.force[b, c] = particles.torque[b, c] = 0.0
    for n in range(world.shape.active_first[b], world.shape.active_first[b + 1]):
        i = np.int64(world.shape.active[n])
        take_heat(particles.dissipated, spheres.torque, i)
        take_load(
            spheres.force, spheres.torque, spheres.position, particles.position, particles.force,
            particles.torque, i, b,
        )  # fmt: skip


@inlined_inner
def kick(world, b):
    """Velocity, momentum and position of a particle after a step."""
    particles, gravity, dt = world.particles, world.gravity, world.time_step
    for c in range(3):
        gain = dt * particles.inverse_mass[b] * particles.force[b, c] + dt * gravity[c]
        particles.velocity[b, c] += gain
        particles.velocity_now[b, c] = particles.velocity[b, c] + 0.5 * gain
        particles.position[b, c] += dt * particles.velocity[b, c]
        gain = dt * particles.torque[b, c]
        particles.momentum[b, c] += gain
        particles.momentum_now[b, c] = particles.momentum[b, c] + 0.5 * gain


@inlined_inner
def turn(world, b):
    """Orientation, axes and angular velocity of a particle after a step, from its momentum then."""
    particles, form = world.particles, world.shape.form
    old, momentum = particles.orientation, particles.momentum
    q = old[b, 0], old[b, 1], old[b, 2], old[b, 3]
    about = momentum[b, 0], momentum[b, 1], momentum[b, 2]
    inverse_inertia, odd = rotation_of(form, b)
    q = freely_turned(q, about, inverse_inertia, odd, world.time_step)
    for c in range(4):
        old[b, c] = q[c]
    note_axes(particles, b)
    note_angular_velocity(particles, form, b)


@uncounted
def note_axes(particles, b):
    """The axes that belong to a particle's orientation."""
    q = particles.orientation
    x, y, z = axes_of((q[b, 0], q[b, 1], q[b, 2], q[b, 3]))
    for c in range(3):
        particles.axes[b, c], particles.axes[b, 4 + c], particles.axes[b, 8 + c] = x[c], y[c], z[c]


@uncounted
def note_angular_velocity(particles, form, b):
    """w = I^-1 L of a particle, now."""
    axes, momentum, rate = particles.axes, particles.momentum_now, particles.angular_velocity_now
    inverse_inertia, _ = rotation_of(form, b)
    rate[b, 0] = rate[b, 1] = rate[b, 2] = 0.0
    for k in range(3):
        x, y, z = axes[b, 4 * k], axes[b, 4 * k + 1], axes[b, 4 * k + 2]
        along = x * momentum[b, 0] + y * momentum[b, 1] + z * momentum[b, 2]
        along *= inverse_inertia[k]
        rate[b, 0] += along * x
        rate[b, 1] += along * y
        rate[b, 2] += along * z


@inlined_inner
def place_active(world, b):
    """Position, velocity and angular velocity of the listed spheres of a particle."""
    particles, spheres, form = world.particles, world.spheres, world.shape.form
    before = first_sphere(form, b) - first_row(form, b)
    for n in range(world.shape.active_first[b], world.shape.active_first[b + 1]):
        i = np.int64(world.shape.active[n])
        place_sphere(
            particles.position, particles.velocity_now, particles.angular_velocity_now,
            particles.axes, form.offset, spheres.position, spheres.velocity,
            spheres.angular_velocity, b, i - before, i,
        )  # fmt: skip


@inner
def arm_of(axes, form, b, s):
    """From the centroid of particle b to the centre of its sphere s, in the laboratory [m]."""
    offset, row = form.offset, first_row(form, b) + s
    a, d, e = offset[row, 0], offset[row, 1], offset[row, 2]
    return (
        a * axes[b, 0] + d * axes[b, 4] + e * axes[b, 8],
        a * axes[b, 1] + d * axes[b, 5] + e * axes[b, 9],
        a * axes[b, 2] + d * axes[b, 6] + e * axes[b, 10],
    )


@inlined_inner
def has_left(particles, seen, arm, b, carried):
    """Return whether a particle may have passed its margin; also if its position is no number."""
    straight, turned = ways_since(particles, seen, arm, b, carried)
    margin = seen.margin[b]
    if 2.0 * (straight + turned) <= margin * margin:  # (a + b)^2 <= 2 (a^2 + b^2)
        return False
    return not np.sqrt(straight) + np.sqrt(turned) <= margin


@inner
def ways_since(particles, seen, arm, b, carried):
    """Squares of how far a particle moved, but for what carried it, and how far its spheres turned.

    In m2. A turn by an angle t takes a point at the distance r by 2 r sin(t/2) at most, and the
    quaternion by 2 sin(t/4), of which 2 r times is more.
    """
    x, q = particles.position, particles.orientation
    dx = x[b, 0] - seen.position[b, 0] - carried[0]
    dy = x[b, 1] - seen.position[b, 1] - carried[1]
    dz = x[b, 2] - seen.position[b, 2] - carried[2]
    turned = 0.0
    for c in range(4):
        turned += (q[b, c] - seen.orientation[b, c]) ** 2
    return dx * dx + dy * dy + dz * dz, 4.0 * arm * arm * turned


@inner
def list_spheres(world, seen):
    """Note where the particles are now, and how fast they move on the whole; see list_active."""
    particles = world.particles
    n = len(particles.inverse_mass)
    for b in range(n):
        for c in range(4):
            seen.position[b, c] = particles.position[b, c]
            seen.orientation[b, c] = particles.orientation[b, c]
    for c in range(3):
        total = 0.0
        for b in range(n):
            total += particles.velocity_now[b, c]
        seen.drift[c] = total / n
    list_active(world)


@inner
def list_active(world):
    """Name the spheres of both lists, particle by particle, and bring them up to date."""
    shape, counts = world.shape, world.counts
    listed = shape.scratch.listed
    listed[:] = 0
    for n in range(counts[INNER]):
        listed[world.inner.i[n]] = listed[world.inner.j[n]] = 1
    for n in range(counts[WALL]):
        listed[world.wall.i[n]] = 1
    found = 0
    for b in range(len(world.particles.inverse_mass)):
        shape.active_first[b] = found
        for i in range(first_sphere(shape.form, b), first_sphere(shape.form, b + 1)):
            shape.active[found] = i
            found += listed[i]
        shape.active_first[b + 1] = found
        place_active(world, b)


@inner
def place_near_walls(world, skin, shift):
    """Bring all spheres of the particles that are near a wall to their positions."""
    spheres, form, particles = world.spheres, world.shape.form, world.particles
    for b in range(len(particles.inverse_mass)):
        for w in range(len(world.walls.force)):
            if gap_to_wall(world.walls, particles.position, w, b, shift) < skin:
                first = first_sphere(form, b)
                for i in range(first, first_sphere(form, b + 1)):
                    r = arm_of(particles.axes, form, b, i - first)
                    for c in range(3):
                        spheres.position[i, c] = particles.position[b, c] + r[c]
                break


@inner
def mean_motion(world, shift, row):
    """Write kinetic and potential energy, mean position and mean velocity to a row."""
    particles, gravity = world.particles, world.gravity
    x, u = particles.position, particles.velocity_now
    kinetic = potential = total = 0.0
    row[POSITION_X : VELOCITY_Z + 1] = 0.0
    for b in range(len(particles.inverse_mass)):
        mass = 1.0 / particles.inverse_mass[b]
        total += mass
        for c in range(3):
            kinetic += 0.5 * mass * u[b, c] ** 2
            kinetic += 0.5 * particles.angular_velocity_now[b, c] * particles.momentum_now[b, c]
            potential -= mass * gravity[c] * x[b, c]
            row[POSITION_X + c] += mass * (x[b, c] - shift[c])
            row[VELOCITY_X + c] += mass * u[b, c]
    row[KINETIC], row[POTENTIAL] = kinetic, potential
    for c in range(6):
        row[POSITION_X + c] /= total
