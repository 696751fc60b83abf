"""Geometry: where spheres, and spheres and walls, touch, and how fast they pass there.

Each pass fills the first half of a block: normal from i to j, overlap, arms and the relative
velocity of the two surfaces. The arms add up to the distance, so that angular momentum is kept.
The passes have no branch, so that the compiler vectorises them.
"""

import numpy as np

from contact.jit import njit


@njit
def gap_of(position, i, j):
    """Distance of the surfaces of two spheres [m]; negative where they overlap."""
    dx = position[j, 0] - position[i, 0]
    dy = position[j, 1] - position[i, 1]
    dz = position[j, 2] - position[i, 2]
    return np.sqrt(dx * dx + dy * dy + dz * dz) - (position[i, 3] + position[j, 3])


@njit
def between_spheres(spheres, contacts, begin, n_contacts, block):
    """The contacts begin ... begin + n_contacts - 1 of spheres with spheres."""
    x, u, w = spheres.position, spheres.velocity, spheres.spin
    for k in range(np.uintp(n_contacts)):  # unsigned: numba then need not look for negative ones
        n = np.uintp(begin) + k
        i, j = contacts.i[n], contacts.j[n]
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        distance = np.sqrt(dx * dx + dy * dy + dz * dz)
        overlap = max(x[i, 3] + x[j, 3] - distance, 0.0)
        shrink = 1.0 / distance
        nx, ny, nz = shrink * dx, shrink * dy, shrink * dz
        arm_i, arm_j = x[i, 3] - 0.5 * overlap, x[j, 3] - 0.5 * overlap
        sx = arm_i * w[i, 0] + arm_j * w[j, 0]
        sy = arm_i * w[i, 1] + arm_j * w[j, 1]
        sz = arm_i * w[i, 2] + arm_j * w[j, 2]
        block.velocity_x[k] = u[j, 0] - u[i, 0] - (sy * nz - sz * ny)
        block.velocity_y[k] = u[j, 1] - u[i, 1] - (sz * nx - sx * nz)
        block.velocity_z[k] = u[j, 2] - u[i, 2] - (sx * ny - sy * nx)
        block.normal_x[k], block.normal_y[k], block.normal_z[k] = nx, ny, nz
        block.overlap[k] = overlap
        block.arm_i[k], block.arm_j[k] = arm_i, arm_j


@njit
def with_planes(spheres, planes, contacts, begin, n_contacts, shift, speed, block):
    """The same for contacts of spheres with flat walls.

    shift (3) is the displacement of the enclosure [m], speed (3) its velocity [m/s].
    """
    x = spheres.position
    for k in range(np.uintp(n_contacts)):
        n = np.uintp(begin) + k
        i, j = contacts.i[n], contacts.j[n]
        nx, ny, nz = -planes[j, 0], -planes[j, 1], -planes[j, 2]
        px, py, pz = x[i, 0] - shift[0], x[i, 1] - shift[1], x[i, 2] - shift[2]
        distance = -(nx * px + ny * py + nz * pz) - planes[j, 3]
        wall_contact(spheres, i, (nx, ny, nz), distance, speed, block, k)


@njit
def with_cylinder(spheres, radius, contacts, begin, n_contacts, shift, speed, block):
    """The same for contacts of spheres with the round wall, whose axis is z."""
    x = spheres.position
    for k in range(np.uintp(n_contacts)):
        n = np.uintp(begin) + k
        i = contacts.i[n]
        px, py = x[i, 0] - shift[0], x[i, 1] - shift[1]
        off_axis = np.sqrt(px * px + py * py)
        shrink = 1.0 / max(off_axis, 1e-300)
        normal = (shrink * px, shrink * py, 0.0)
        wall_contact(spheres, i, normal, radius - off_axis, speed, block, k)


@njit
def wall_contact(spheres, i, normal, distance, speed, block, k):
    """Fill place k of a block with a contact of sphere i; normal points to the wall."""
    u, w = spheres.velocity, spheres.spin
    nx, ny, nz = normal
    overlap = max(spheres.position[i, 3] - distance, 0.0)
    block.velocity_x[k] = speed[0] - u[i, 0] - distance * (w[i, 1] * nz - w[i, 2] * ny)
    block.velocity_y[k] = speed[1] - u[i, 1] - distance * (w[i, 2] * nx - w[i, 0] * nz)
    block.velocity_z[k] = speed[2] - u[i, 2] - distance * (w[i, 0] * ny - w[i, 1] * nx)
    block.normal_x[k], block.normal_y[k], block.normal_z[k] = nx, ny, nz
    block.overlap[k] = overlap
    block.arm_i[k], block.arm_j[k] = distance, 0.0
