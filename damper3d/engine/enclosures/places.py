"""Contacts of spheres with a triangulated cavity (cavity.py): which features a sphere touches.

Of features whose directions from the centre lie within a small angle only the nearest is touched:
on a seam of one plane both triangles have the foot, and where flat faces stand for a curved one
they are one surface. The angle is the least at which a contact with a face has ended before its
foot leaves the face for the next, so that no elastic energy vanishes with it: at the turn theta the
foot leaves where the other face is nearer by cos theta, and the law holds for overlaps up to a
twentieth of the radius: cos theta = 1 - 1/20. The springs of a contact go from feature to feature
with it: one that begins takes over from one that ends within that angle.
"""

import numpy as np

from damper3d.engine.enclosures.cavity import PLACES
from damper3d.engine.laws.table import hertz_of
from damper3d.engine.motions.host import mobility
from damper3d.engine.state import (
    DAMPING,
    HERTZ,
    LANES,
    MASS,
    N_HISTORY,
    NO_CONTACT,
    RADIUS_I,
    WALL_SKIN,
)
from granulab.contact.jit import inlined_inner, inner, njit
from granulab.contact.vectors import add, cross, dot, norm, scale

_ONE_PLACE = 0.95  # cosine of that angle, 18 degrees
_AROUND = 4.0 * np.pi  # solid angle of all directions [sr]


@inner
def cell_of(surface, x, y, z):
    """Cell of the features near a point."""
    i = min(max(int((x - surface.low[0]) / surface.cell), 0), surface.shape[0] - 1)
    j = min(max(int((y - surface.low[1]) / surface.cell), 0), surface.shape[1] - 1)
    k = min(max(int((z - surface.low[2]) / surface.cell), 0), surface.shape[2] - 1)
    return (i * surface.shape[1] + j) * surface.shape[2] + k


@inner
def to_feature(surface, f, x, y, z):
    """Distance [m] from a point of the plane, line or point of a feature; unit vector to it."""
    ax, ay, az = surface.origin[f, 0] - x, surface.origin[f, 1] - y, surface.origin[f, 2] - z
    tx, ty, tz = surface.along[f, 0], surface.along[f, 1], surface.along[f, 2]
    part = ax * tx + ay * ty + az * tz
    if f < surface.n_faces:
        return -part, (-tx, -ty, -tz)
    ax, ay, az = ax - part * tx, ay - part * ty, az - part * tz
    distance = np.sqrt(ax * ax + ay * ay + az * az)
    far = max(distance, 1e-300)
    return distance, (ax / far, ay / far, az / far)


@inner
def has_foot(surface, f, x, y, z):
    """True where the distance from a point has a minimum on a feature, in front of it."""
    for h in range(surface.first[f], surface.first[f + 1]):
        row = surface.half[h]
        if row[0] * x + row[1] * y + row[2] * z - row[3] < -surface.slack:
            return False
    return f >= surface.n_faces or to_feature(surface, f, x, y, z)[0] >= 0.0


@inner
def at_least(surface, f, x, y, z):
    """Return what the distance of a point from a feature is at least [m]; inf from behind."""
    distance = to_feature(surface, f, x, y, z)[0]
    ends = 3 if f < surface.n_faces else 2 if f < surface.n_faces + surface.n_edges else 0
    if distance < 0.0 and f < surface.n_faces:
        return np.inf
    beyond = 0.0
    for h in range(surface.first[f], surface.first[f] + ends):
        row = surface.half[h]
        beyond = max(beyond, row[3] - row[0] * x - row[1] * y - row[2] * z)
    return np.sqrt(distance * distance + beyond * beyond)


@inner
def push_from_places(surface, centres, radius, n, force):
    """Add twice the overlap with each feature to the force on sphere n; the deepest overlap [m]."""
    x, y, z = centres[n, 0], centres[n, 1], centres[n, 2]
    cell, deepest = cell_of(surface, x, y, z), 0.0
    for m in range(surface.start[cell], surface.start[cell + 1]):
        f = surface.member[m]
        distance, normal = to_feature(surface, f, x, y, z)
        if distance < radius and has_foot(surface, f, x, y, z):
            overlap = radius - distance
            deepest = max(deepest, overlap)
            for c in range(3):
                force[n, c] -= 2.0 * overlap * normal[c]
    return deepest


@inner
def list_places(world, i, b, shift, n):
    """Append the features that sphere i of particle b touches or nearly does; the new length.

    -1 if there is no room.
    """
    wall, walls, spheres, x = world.wall, world.walls, world.spheres, world.spheres.position
    surface, near = walls.surface, x[i, 3] + world.lengths[WALL_SKIN]
    px, py, pz = x[i, 0] - shift[0], x[i, 1] - shift[1], x[i, 2] - shift[2]
    cell = cell_of(surface, px, py, pz)
    for m in range(surface.start[cell], surface.start[cell + 1]):
        f = surface.member[m]
        if at_least(surface, f, px, py, pz) < near:
            if n + LANES >= len(wall.i):
                return np.int64(-1)
            wall.i[n], wall.j[n], wall.group[n] = i, len(spheres.inverse_mass), b
            wall.feature[n] = f
            wall.cutoff[n] = wall.constants[n, RADIUS_I] = x[i, 3]
            hertz = hertz_of(world.wall_law, i, len(spheres.inverse_mass)) * np.sqrt(x[i, 3])
            wall.constants[n, HERTZ] = wall.whole[n, 0] = hertz
            mass = 1.0 / (spheres.inverse_mass[i] + mobility(world.shaker))
            wall.constants[n, MASS] = wall.whole[n, 1] = mass
            recall(surface.held, walls.history, i, f, wall.history, n)
            n += 1
    return n


@inner
def recall(held, kept, i, f, history, n):
    """Give contact n the history that is kept of sphere i at feature f, or none."""
    for h in range(N_HISTORY):
        history[n, h] = 0.0
    history[n, DAMPING] = NO_CONTACT
    for s in range(PLACES):
        if held[i, s] == f:
            for h in range(N_HISTORY):
                history[n, h] = kept[s, i, h]


@inner
def keep_places(wall, walls, n_listed):
    """Keep the histories of the listed contacts, sphere by sphere."""
    held = walls.surface.held
    held[:] = -1
    for n in range(n_listed):
        if wall.history[n, DAMPING] >= 0.0:
            i, s = wall.i[n], 0
            while held[i, s] >= 0:  # at most PLACES act at once
                s += 1
            held[i, s] = wall.feature[n]
            for h in range(N_HISTORY):
                walls.history[s, i, h] = wall.history[n, h]


@inlined_inner
def touching_places(spheres, walls, contacts, first, last):
    """Let `touching` name, from `first` on, those contacts that act, sphere by sphere.

    Of contacts first ... last - 1; returns where they end.
    """
    found = n = first
    while n < last:
        after = n + 1
        while after < last and contacts.i[after] == contacts.i[n]:
            after += 1
        acting = acting_places(spheres, walls.surface, contacts, n, after)
        hand_over(spheres, walls.surface, contacts, n, after, acting)
        for k in range(n, after):
            contacts.touching[found] = k
            found += np.int64(contacts.history[k, DAMPING] >= 0.0)
        for k in range(acting):  # those that begin have no history yet
            m = walls.surface.number[k]
            if contacts.history[m, DAMPING] < 0.0:
                contacts.touching[found] = m
                found += 1
        n = after
    return found


@inner
def centre_of(spheres, i):
    """Centre of sphere i in the enclosure [m]: its row less that of the enclosure."""
    x, last = spheres.position, len(spheres.inverse_mass)
    return x[i, 0] - x[last, 0], x[i, 1] - x[last, 1], x[i, 2] - x[last, 2]


@inner
def acting_places(spheres, surface, contacts, begin, end):
    """Note the contacts of one sphere that act, nearest first, in `number`; how many they are."""
    i = contacts.i[begin]
    (x, y, z), radius = centre_of(spheres, i), spheres.position[i, 3]
    found = 0
    for n in range(begin, end):
        f = contacts.feature[n]
        distance, normal = to_feature(surface, f, x, y, z)
        if distance < radius and has_foot(surface, f, x, y, z):
            found = note_place(surface, found, n, distance, normal)
    return found


@inner
def note_place(surface, found, n, distance, normal):
    """Put a contact among the places, nearest first, unless a nearer one is the same place.

    Farther ones that are the same place go; how many there are then.
    """
    number, near, towards = surface.number, surface.distance, surface.normal
    at = 0
    while at < found and near[at] <= distance:
        if cosine(towards, at, normal) > _ONE_PLACE:
            return found
        at += 1
    kept = at
    for k in range(at, found):  # those behind it
        if cosine(towards, k, normal) <= _ONE_PLACE:
            number[kept], near[kept] = number[k], near[k]
            for c in range(3):
                towards[kept, c] = towards[k, c]
            kept += 1
    if at == PLACES:
        return kept
    kept = min(kept, PLACES - 1)
    for k in range(kept, at, -1):
        number[k], near[k] = number[k - 1], near[k - 1]
        for c in range(3):
            towards[k, c] = towards[k - 1, c]
    number[at], near[at] = n, distance
    for c in range(3):
        towards[at, c] = normal[c]
    return kept + 1


@inner
def cosine(towards, k, normal):
    """Cosine of the angle between the direction to place k and another."""
    return towards[k, 0] * normal[0] + towards[k, 1] * normal[1] + towards[k, 2] * normal[2]


@inner
def hand_over(spheres, surface, contacts, begin, end, acting):
    """Give contacts that begin the histories of those that end in their place; end the others."""
    history, number, towards = contacts.history, surface.number, surface.normal
    i = contacts.i[begin]
    x, y, z = centre_of(spheres, i)
    for n in range(begin, end):
        if history[n, DAMPING] < 0.0 or acts(number, acting, n):
            continue
        normal = to_feature(surface, contacts.feature[n], x, y, z)[1]
        heir, best = -1, _ONE_PLACE
        for k in range(acting):
            likeness = cosine(towards, k, normal)
            if likeness > best and history[number[k], DAMPING] < 0.0:
                heir, best = number[k], likeness
        for h in range(N_HISTORY):
            if heir >= 0:
                history[heir, h] = history[n, h]
            history[n, h] = 0.0
        history[n, DAMPING] = NO_CONTACT


@inner
def acts(number, acting, n):
    """True where contact n is among those that act."""
    among = False
    for k in range(acting):
        among |= number[k] == n
    return among


@njit
def clearances(corners, points):
    """Distance (n,) [m] of points (n, 3) from triangles (m, 3, 3); -inf outside of them."""
    found = np.empty(len(points))
    for p in range(len(points)):
        found[p] = -np.inf
        if solid_angle(corners, points[p]) > 0.5 * _AROUND:
            least = np.inf
            for m in range(len(corners)):
                least = min(least, square_to_triangle(corners, m, points[p]))
            found[p] = np.sqrt(least)
    return found


@inner
def solid_angle(corners, point):
    """Solid angle [sr] under which triangles (m, 3, 3) are seen (van Oosterom, Strackee 1983)."""
    total = 0.0
    for m in range(len(corners)):
        a, b, c = between(point, corners, m, 0), between(point, corners, m, 1), (
            between(point, corners, m, 2))  # fmt: skip
        la, lb, lc = norm(a), norm(b), norm(c)
        over = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
        total += 2.0 * np.arctan2(dot(a, cross(b, c)), over)
    return total


@inner
def between(point, corners, m, k):
    """From a point to corner k of triangle m, a tuple [m]."""
    return (
        corners[m, k, 0] - point[0],
        corners[m, k, 1] - point[1],
        corners[m, k, 2] - point[2],
    )


@inner
def square_to_triangle(corners, m, point):
    """Squared distance [m2] of a point from triangle m: from its face, or the nearest side."""
    a, b, c = between(point, corners, m, 0), between(point, corners, m, 1), (
        between(point, corners, m, 2))  # fmt: skip
    u, v = add(b, scale(-1.0, a)), add(c, scale(-1.0, a))
    uu, uv, vv, wu, wv = dot(u, u), dot(u, v), dot(v, v), -dot(a, u), -dot(a, v)
    size = uu * vv - uv * uv
    s, t = (vv * wu - uv * wv) / size, (uu * wv - uv * wu) / size
    if s >= 0.0 and t >= 0.0 and s + t <= 1.0:
        away = add(a, add(scale(s, u), scale(t, v)))
        return dot(away, away)
    return min(square_to_side(a, b), square_to_side(b, c), square_to_side(c, a))


@inner
def square_to_side(a, b):
    """Squared distance [m2] of the origin from the line between two points, tuples [m]."""
    way = add(b, scale(-1.0, a))
    part = min(max(-dot(a, way) / dot(way, way), 0.0), 1.0)
    away = add(a, scale(part, way))
    return dot(away, away)
