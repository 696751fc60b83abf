"""Geometry: where spheres, and spheres and walls, touch, and how fast they pass there.

Each pass takes what damper3d.lanes.gather has put into a block, and adds normal, overlap, arms and
the relative velocity of the two surfaces. The arms add up to the distance, so that angular momentum
is kept. The passes have no branch, so that the compiler vectorises them.
"""

import numpy as np

from contact.jit import inlined, uncounted
from damper3d.state import BLOCK, RADIUS_I, RADIUS_J


@uncounted
def place(row, k):
    """Where lane k of a row of a block stands.

    Rows lie one behind the other at a distance that the compiler knows, unlike that of the rows of
    an array of two dimensions: it then knows that they do not overlap, and vectorises.
    """
    return np.uintp(row * BLOCK) + k


@uncounted
def gap_of(position, i, j):
    """Distance of the surfaces of two spheres [m]; negative where they overlap."""
    dx = position[j, 0] - position[i, 0]
    dy = position[j, 1] - position[i, 1]
    dz = position[j, 2] - position[i, 2]
    return np.sqrt(dx * dx + dy * dy + dz * dz) - (position[i, 3] + position[j, 3])


@uncounted
def apart(block, k):
    """x_j - x_i of place k of a block [m]."""
    separation = block.separation
    return separation[place(0, k)], separation[place(1, k)], separation[place(2, k)]


@uncounted
def to_plane(plane, separation):
    """Distance of a sphere's centre from a flat wall [m]; the separation is the origin's."""
    x, y, z = separation
    return -plane[0] * x - plane[1] * y - plane[2] * z - plane[3]


@uncounted
def off_axis(separation):
    """Distance of a sphere's centre from the axis of the round wall, z [m]."""
    return np.sqrt(separation[0] * separation[0] + separation[1] * separation[1])


@inlined
def between_spheres(n_contacts, block):
    """The contacts of spheres with spheres in the first lanes of a block."""
    passing, turning, spin = block.passing, block.turning, block.spin
    for k in range(np.uintp(n_contacts)):  # unsigned: numba then need not look for negative ones
        radius_i, radius_j = (
            block.constants[place(RADIUS_I, k)],
            block.constants[place(RADIUS_J, k)],
        )
        dx, dy, dz = apart(block, k)
        distance = np.sqrt(dx * dx + dy * dy + dz * dz)
        overlap = max(radius_i + radius_j - distance, 0.0)
        shrink = 1.0 / distance
        nx, ny, nz = shrink * dx, shrink * dy, shrink * dz
        half = 0.5 * overlap
        sx, sy = (
            turning[place(0, k)] - half * spin[place(0, k)],
            turning[place(1, k)] - half * spin[place(1, k)],
        )
        sz = turning[place(2, k)] - half * spin[place(2, k)]
        block.velocity[place(0, k)] = passing[place(0, k)] - (sy * nz - sz * ny)
        block.velocity[place(1, k)] = passing[place(1, k)] - (sz * nx - sx * nz)
        block.velocity[place(2, k)] = passing[place(2, k)] - (sx * ny - sy * nx)
        block.normal[place(0, k)], block.normal[place(1, k)], block.normal[place(2, k)] = nx, ny, nz
        block.overlap[k] = overlap
        block.arm_i[k], block.arm_j[k] = radius_i - half, radius_j - half


@inlined
def with_plane(plane, n_contacts, block):
    """The same for contacts of spheres with a flat wall."""
    for k in range(np.uintp(n_contacts)):
        distance = to_plane(plane, apart(block, k))
        wall_contact((-plane[0], -plane[1], -plane[2]), distance, block, k)


@inlined
def with_cylinder(radius, n_contacts, block):
    """The same for contacts of spheres with the round wall."""
    for k in range(np.uintp(n_contacts)):
        x, y, z = apart(block, k)
        away = off_axis((x, y, z))
        shrink = -1.0 / max(away, 1e-300)
        wall_contact((shrink * x, shrink * y, 0.0), radius - away, block, k)


@uncounted
def wall_contact(normal, distance, block, k):
    """Fill place k of a block with a contact; the normal points to the wall, at a distance [m]."""
    nx, ny, nz = normal
    spin, passing = block.spin, block.passing
    block.velocity[place(0, k)] = passing[place(0, k)] - distance * (
        spin[place(1, k)] * nz - spin[place(2, k)] * ny
    )
    block.velocity[place(1, k)] = passing[place(1, k)] - distance * (
        spin[place(2, k)] * nx - spin[place(0, k)] * nz
    )
    block.velocity[place(2, k)] = passing[place(2, k)] - distance * (
        spin[place(0, k)] * ny - spin[place(1, k)] * nx
    )
    block.normal[place(0, k)], block.normal[place(1, k)], block.normal[place(2, k)] = nx, ny, nz
    block.overlap[k] = max(block.constants[place(RADIUS_I, k)] - distance, 0.0)
    block.arm_i[k], block.arm_j[k] = distance, 0.0
