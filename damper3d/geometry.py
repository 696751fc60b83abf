"""Geometry: where spheres, and spheres and walls, touch, and how fast they pass there.

Each pass takes what damper3d.lanes.combine has put into a block, and adds normal, overlap, arms and
the relative velocity of the two surfaces. The arms add up to the distance, so that angular momentum
is kept. The passes have no branch, so that the compiler vectorises them.
"""

import numpy as np

from contact.jit import inlined, uncounted
from damper3d.state import BLOCK


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


@inlined
def between_spheres(contacts, begin, n_contacts, block):
    """The contacts begin ... begin + n_contacts - 1 of spheres with spheres."""
    apart, passing, turning, spin = block.separation, block.passing, block.turning, block.spin
    for k in range(np.uintp(n_contacts)):  # unsigned: numba then need not look for negative ones
        n = np.uintp(begin) + k
        dx, dy, dz = apart[place(0, k)], apart[place(1, k)], apart[place(2, k)]
        distance = np.sqrt(dx * dx + dy * dy + dz * dz)
        overlap = max(contacts.radius_i[n] + contacts.radius_j[n] - distance, 0.0)
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
        block.arm_i[k] = contacts.radius_i[n] - half
        block.arm_j[k] = contacts.radius_j[n] - half


@inlined
def with_plane(plane, contacts, begin, n_contacts, block):
    """The same for contacts of spheres with a flat wall; their separation is the origin's."""
    apart = block.separation
    nx, ny, nz, offset = -plane[0], -plane[1], -plane[2], plane[3]
    for k in range(np.uintp(n_contacts)):
        distance = (
            nx * apart[place(0, k)] + ny * apart[place(1, k)] + nz * apart[place(2, k)] - offset
        )
        wall_contact(contacts, begin, (nx, ny, nz), distance, block, k)


@inlined
def with_cylinder(radius, contacts, begin, n_contacts, block):
    """The same for contacts of spheres with the round wall, whose axis is z."""
    apart = block.separation
    for k in range(np.uintp(n_contacts)):
        off_axis = np.sqrt(
            apart[place(0, k)] * apart[place(0, k)] + apart[place(1, k)] * apart[place(1, k)]
        )
        shrink = -1.0 / max(off_axis, 1e-300)
        normal = (shrink * apart[place(0, k)], shrink * apart[place(1, k)], 0.0)
        wall_contact(contacts, begin, normal, radius - off_axis, block, k)


@uncounted
def wall_contact(contacts, begin, normal, distance, block, k):
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
    block.overlap[k] = max(contacts.radius_i[np.uintp(begin) + k] - distance, 0.0)
    block.arm_i[k], block.arm_j[k] = distance, 0.0
