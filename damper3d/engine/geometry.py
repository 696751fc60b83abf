"""Geometry: which contacts of a list touch, where, and how fast the surfaces pass there.

In a bed that flies few of the pairs that may touch do. Finding out takes their positions alone;
what is left out would add exact zeros, so that no bit depends on it. What touched a step ago is
named once more, so that its history ends.

Each pass takes what simd.gather has put into a block, and adds normal, overlap, arms and
the relative velocity of the two surfaces. The arms add up to the distance, so that angular momentum
is kept. The passes have no branch, so that the compiler vectorises them.
"""

import numpy as np

from damper3d.engine.simd import separate, whole
from damper3d.engine.state import BLOCK, DAMPING, RADIUS_I, RADIUS_J
from granulab.contact.jit import inlined_inner, inner
from granulab.contact.vectors import add, cross, dot, scale

_ROUNDING = 1.0 + 1e-12  # squares may say "apart" where the root, rounded, says "touching"


@inner
def entry(row, k):
    """Return where lane k of a row of a block stands.

    Rows lie one behind the other at a distance that the compiler knows, unlike that of the rows of
    an array of two dimensions: it then knows that they do not overlap, and vectorises.
    """
    return np.uintp(row * BLOCK) + k


@inner
def vector(rows, k):
    """The vector in lane k of three rows of a block."""
    return rows[entry(0, k)], rows[entry(1, k)], rows[entry(2, k)]


@inner
def put(rows, k, v):
    """Let a vector stand in lane k of three rows of a block."""
    rows[entry(0, k)], rows[entry(1, k)], rows[entry(2, k)] = v


@inner
def surface_motion(block, k):
    """Of contact k: normal, rate of the overlap [m/s], velocity of slip [m/s]."""
    normal, velocity = vector(block.normal, k), vector(block.velocity, k)
    rate = -dot(velocity, normal)
    return normal, rate, add(velocity, scale(rate, normal))


@inner
def to_plane(plane, separation):
    """Distance of a sphere's centre from a flat wall [m]; the separation is the origin's."""
    x, y, z = separation
    return -plane[0] * x - plane[1] * y - plane[2] * z - plane[3]


@inlined_inner
def between_spheres(n_contacts, block):
    """The contacts of spheres with spheres in the first lanes of a block."""
    for k in range(np.uintp(n_contacts)):  # unsigned: numba then need not look for negative ones
        radius_i = block.constants[entry(RADIUS_I, k)]
        radius_j = block.constants[entry(RADIUS_J, k)]
        separation = vector(block.separation, k)
        distance = np.sqrt(dot(separation, separation))
        overlap = max(radius_i + radius_j - distance, 0.0)
        normal = scale(1.0 / distance, separation)
        half = 0.5 * overlap
        (ax, ay, az), (bx, by, bz) = (
            vector(block.rim_velocity, k),
            vector(block.angular_velocity, k),
        )
        rim_velocity = ax - half * bx, ay - half * by, az - half * bz
        px, py, pz = vector(block.relative_velocity, k)
        tx, ty, tz = cross(rim_velocity, normal)
        put(block.velocity, k, (px - tx, py - ty, pz - tz))
        put(block.normal, k, normal)
        block.overlap[k] = overlap
        block.arm_i[k], block.arm_j[k] = radius_i - half, radius_j - half


@inner
def wall_contact(normal, distance, block, k):
    """Fill lane k of a block with a contact; the normal points to the wall, at a distance [m]."""
    px, py, pz = vector(block.relative_velocity, k)
    tx, ty, tz = cross(vector(block.angular_velocity, k), normal)
    put(block.velocity, k, (px - distance * tx, py - distance * ty, pz - distance * tz))
    put(block.normal, k, normal)
    block.overlap[k] = max(block.constants[entry(RADIUS_I, k)] - distance, 0.0)
    block.arm_i[k], block.arm_j[k] = distance, 0.0


@inlined_inner
def touching_pairs(spheres, contacts, first, last, block):
    """Let `touching` name, from `first` on, those of contacts first ... last - 1 that touch.

    Returns where they end.
    """
    found = first
    for begin in range(first, last, BLOCK):
        n = min(last - begin, BLOCK)
        separate(spheres, contacts, begin, n, block)
        for k in range(np.uintp(whole(n))):
            x, y, z = vector(block.separation, k)
            cutoff = contacts.cutoff[np.uintp(begin) + k]
            block.clearance[k] = x * x + y * y + z * z - _ROUNDING * (cutoff * cutoff)
        found = note_touching(contacts, begin, n, block, found)
    return found


@inlined_inner
def note_touching(contacts, begin, n_contacts, block, found):
    """Append those of a block that touch or did a step ago to `touching`; its new length.

    Each is written, and only counted where it is one of them: a branch that cannot be
    foreseen would cost more.
    """
    for k in range(np.uintp(n_contacts)):
        n = np.uintp(begin) + k
        contacts.touching[found] = n
        lasts = contacts.history[n, DAMPING] >= 0.0
        found += np.int64((block.clearance[k] < 0.0) | lasts)
    return found


@inner
def copy(to, what, n):
    """The first n numbers of an array, into another."""
    for k in range(n):
        to[k] = what[k]


@inner
def copy_rows(to, rows):
    """As many rows of four as there is room for."""
    for i in range(len(to)):
        for c in range(4):
            to[i, c] = rows[i, c]
