"""Kernels of the periodic cell: overlaps of clusters, and how these push and turn their particles.

Frictionless particles in a cubic cell, of which every face is joined to the one across. The energy
is the sum of overlap^2/2 over all pairs of sub-spheres, over `scale`, so that it has a gradient
where contacts go from sub-sphere to sub-sphere; particles have unit mass, and rotations are weighed
by the mean radius of gyration. A list holds the pairs of sub-spheres that are nearer than a skin,
of several images of a particle where the cell is small; it is made again when a particle has moved
and rotated by half of that.
"""

from typing import NamedTuple

import numpy as np

from damper3d.engine.growth.relaxation import INNER_FULL, PUSHED, displace, push_apart, relax
from granulab.contact.jit import inner, njit, substituted

_LEAST_SKIN, _MOST_SKIN = 0.01, 0.3  # over the equal-volume radius
_OFTEN, _SELDOM = 4, 16  # steps between lists, at which the skin grows or shrinks


class Cell(NamedTuple):
    """Bodies in a periodic cube, in units of the equal-volume radius."""

    position: np.ndarray  # (n, 3) centroids, not brought back into the cube
    turn: np.ndarray  # (n, 4) unit quaternions (w, x, y, z)
    offset: np.ndarray  # (k, 4) sub-spheres of a particle in its own axes, and their radii
    arm: np.ndarray  # (n k, 3) sub-spheres from their particle's centroid
    first: np.ndarray  # (capacity,) number b k + s of a sub-sphere
    second: np.ndarray  # (capacity,) of one of another particle, or of its image
    image: np.ndarray  # (capacity, 3) how many sides that image is away
    made_at: np.ndarray  # (n, 3) positions when the list was made
    facing: np.ndarray  # (n, 4) turns when the list was made
    measure: np.ndarray  # side of the cube, radius of the ball round a particle, of gyration, skin
    tally: np.ndarray  # (3,) pairs in the list; most overlaps of a pair of particles; steps since


SIDE, BALL, GYRATION, SKIN = range(4)
PAIRS, MOST, SINCE = range(3)


def relaxed(cell: Cell, allowed: float, patience: int, steady: float) -> tuple[int, float]:
    """Move the particles of a cell down the energy; how it ended, and the deepest overlap.

    See relaxation.relax; the list is made longer by whoever asks.
    """
    n = len(cell.position)
    cell.tally[SINCE] = -1
    outcome, deepest, _ = relax(cell, np.zeros((n, 6)), np.zeros((n, 6)), allowed, patience, steady)
    return int(outcome), float(deepest)


@substituted(push_apart)
def _push_in_cell(bed, force):
    if bed.instance_class is Cell:
        return lambda bed, force: push_in_cell(bed, force)
    return None


@njit
def push_in_cell(cell, force):
    """Set what pushes and turns each particle; see relaxation.push_apart."""
    if cell.tally[SINCE] < 0 or has_moved(cell):
        adapt_skin(cell)
        if not list_pairs(cell):
            return INNER_FULL, 0.0, 0.0
    cell.tally[SINCE] += 1
    deepest, mean_push = push(cell, force)
    return PUSHED, deepest, mean_push


@substituted(displace)
def _displace_in_cell(bed, velocity, dt):
    if bed.instance_class is Cell:
        return lambda bed, velocity, dt: displace_in_cell(bed, velocity, dt)
    return None


@inner
def has_moved(cell):
    """Return whether some particle has used up half of the skin by moving and rotating."""
    for b in range(len(cell.position)):
        way = cosine = 0.0
        for c in range(3):
            way += (cell.position[b, c] - cell.made_at[b, c]) ** 2
        for c in range(4):
            cosine += cell.turn[b, c] * cell.facing[b, c]
        turned = 2.0 * np.sqrt(max(1.0 - cosine * cosine, 0.0))  # chord of the angle, 1e-16 off
        if np.sqrt(way) + turned * cell.measure[BALL] > 0.5 * cell.measure[SKIN]:
            return True
    return False


@inner
def adapt_skin(cell):
    """A wider skin where lists are made often, a narrower one where they last."""
    skin, since = cell.measure[SKIN], cell.tally[SINCE]
    if 0 <= since < _OFTEN:
        cell.measure[SKIN] = min(1.5 * skin, _MOST_SKIN)
    elif since > _SELDOM:
        cell.measure[SKIN] = max(0.7 * skin, _LEAST_SKIN)


@njit
def list_pairs(cell):
    """Make the list anew; False where there is no room for it."""
    position, side, skin = cell.position, cell.measure[SIDE], cell.measure[SKIN]
    n, k, ball = len(position), len(cell.offset), cell.measure[BALL]
    turn_arms(cell)
    near, height = np.empty((2, k), np.int64), np.empty((2, k))
    found = most = np.int64(0)
    few = 0 if side >= 2.0 * (2.0 * ball + skin) else 1  # images beyond the nearest one
    for a in range(n):
        for b in range(a):
            way = (position[b, 0] - position[a, 0], position[b, 1] - position[a, 1],
                   position[b, 2] - position[a, 2])  # fmt: skip
            home = np.rint(way[0] / side), np.rint(way[1] / side), np.rint(way[2] / side)
            for number in range((2 * few + 1) ** 3):
                image = image_of(number, few, home)
                to = way[0] + image[0] * side, way[1] + image[1] * side, way[2] + image[2] * side
                if to[0] * to[0] + to[1] * to[1] + to[2] * to[2] >= (2.0 * ball + skin) ** 2:
                    continue
                found, overlaps = list_bodies(cell, a, b, to, image, near, height, found)
                if found < 0:
                    return False
                most = max(most, overlaps)
    cell.made_at[:] = position
    cell.facing[:] = cell.turn
    cell.tally[PAIRS], cell.tally[MOST], cell.tally[SINCE] = found, max(most, 1), 0
    return True


@inner
def image_of(number, few, home):
    """Return how many sides away an image stands: the nearest one, or up to `few` beyond it."""
    each = 2 * few + 1
    return (number // each**2 - few - home[0], number // each % each - few - home[1],
            number % each - few - home[2])  # fmt: skip


@inner
def list_bodies(cell, a, b, way, image, near, height, found):
    """Append the pairs of spheres of particle a and an image of b; how many now, and overlaps."""
    k, skin, arm, r = len(cell.offset), cell.measure[SKIN], cell.arm, cell.offset
    # Across a direction, only those that reach beyond the other particle's end less the skin.
    apart = np.sqrt(way[0] ** 2 + way[1] ** 2 + way[2] ** 2)
    d = way[0] / apart, way[1] / apart, way[2] / apart
    high, low = -np.inf, np.inf
    for s in range(k):
        i, j = a * k + s, b * k + s
        height[0, s] = arm[i, 0] * d[0] + arm[i, 1] * d[1] + arm[i, 2] * d[2] + r[s, 3]
        height[1, s] = apart + arm[j, 0] * d[0] + arm[j, 1] * d[1] + arm[j, 2] * d[2] - r[s, 3]
        high, low = max(high, height[0, s]), min(low, height[1, s])
    n_a = n_b = 0
    for s in range(k):
        if height[0, s] > low - skin:
            near[0, n_a] = s
            n_a += 1
        if height[1, s] < high + skin:
            near[1, n_b] = s
            n_b += 1
    overlaps = np.int64(0)
    for p in range(n_a):
        s = a * k + near[0, p]
        x, y, z = way[0] - arm[s, 0], way[1] - arm[s, 1], way[2] - arm[s, 2]
        for q in range(n_b):
            t = b * k + near[1, q]
            cutoff = r[near[0, p], 3] + r[near[1, q], 3]
            square = (x + arm[t, 0]) ** 2 + (y + arm[t, 1]) ** 2 + (z + arm[t, 2]) ** 2
            if square < (cutoff + skin) ** 2:
                if found == len(cell.first):
                    return np.int64(-1), overlaps
                cell.first[found], cell.second[found] = s, t
                for c in range(3):
                    cell.image[found, c] = image[c]
                found += 1
                overlaps += square < cutoff * cutoff
    return found, overlaps


@inner
def turn_arms(cell):
    """The sub-spheres from their centroids, by the turns of the particles."""
    k = len(cell.offset)
    for b in range(len(cell.position)):
        w, x, y, z = cell.turn[b]
        xx, xy, xz = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
        yx, yy, yz = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
        zx, zy, zz = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
        for s in range(k):
            u, v, t = cell.offset[s, 0], cell.offset[s, 1], cell.offset[s, 2]
            cell.arm[b * k + s, 0] = xx * u + xy * v + xz * t
            cell.arm[b * k + s, 1] = yx * u + yy * v + yz * t
            cell.arm[b * k + s, 2] = zx * u + zy * v + zz * t


@njit
def push(cell, force):
    """Pushes (n, :3) and torques (n, 3:) of the overlaps; return deepest overlap and mean push."""
    k, gyration, arm = len(cell.offset), cell.measure[GYRATION], cell.arm
    scale = 1.0 / cell.tally[MOST]
    turn_arms(cell)
    force[:] = 0.0
    deepest = total = 0.0
    for m in range(cell.tally[PAIRS]):
        cutoff, square, dx, dy, dz = separation(cell, m)
        if square >= cutoff * cutoff or square == 0.0:
            continue
        distance = np.sqrt(square)
        overlap = cutoff - distance
        deepest = max(deepest, overlap)
        total += scale * overlap
        share = scale * overlap / distance
        way = share * dx, share * dy, share * dz
        add_push(force, cell.first[m] // k, arm[cell.first[m]], way, -1.0, gyration)
        add_push(force, cell.second[m] // k, arm[cell.second[m]], way, 1.0, gyration)
    return deepest, 2.0 * total / len(cell.position)


@inner
def add_push(force, b, arm, push, sign, gyration):
    """Add a push at the end of an arm to what moves and turns particle b."""
    force[b, 0] += sign * push[0]
    force[b, 1] += sign * push[1]
    force[b, 2] += sign * push[2]
    force[b, 3] += sign * (arm[1] * push[2] - arm[2] * push[1]) / gyration
    force[b, 4] += sign * (arm[2] * push[0] - arm[0] * push[2]) / gyration
    force[b, 5] += sign * (arm[0] * push[1] - arm[1] * push[0]) / gyration


@inner
def displace_in_cell(cell, velocity, dt):
    """Move the particles and turn them."""
    half = 0.5 * dt / cell.measure[GYRATION]
    for b in range(len(cell.position)):
        for c in range(3):
            cell.position[b, c] += dt * velocity[b, c]
        x, y, z = half * velocity[b, 3], half * velocity[b, 4], half * velocity[b, 5]
        w = cell.turn[b]
        new = (
            w[0] - x * w[1] - y * w[2] - z * w[3],
            w[1] + x * w[0] + y * w[3] - z * w[2],
            w[2] + y * w[0] + z * w[1] - x * w[3],
            w[3] + z * w[0] + x * w[2] - y * w[1],
        )
        size = np.sqrt(new[0] ** 2 + new[1] ** 2 + new[2] ** 2 + new[3] ** 2)
        for c in range(4):
            w[c] = new[c] / size


@njit
def touching(cell):
    """Return which particles overlap, (n, n) bools, by the list and the arms as they stand."""
    n, k = len(cell.position), len(cell.offset)
    found = np.zeros((n, n), np.bool_)
    for m in range(cell.tally[PAIRS]):
        cutoff, square = separation(cell, m)[:2]
        if square < cutoff * cutoff:
            a, b = cell.first[m] // k, cell.second[m] // k
            found[a, b] = found[b, a] = True
    return found


@inner
def separation(cell, m):
    """Sum of the radii of a pair of the list, square of the distance, and the way between them."""
    k, side, x, arm = len(cell.offset), cell.measure[SIDE], cell.position, cell.arm
    s, t = cell.first[m], cell.second[m]
    a, b = s // k, t // k
    dx = x[b, 0] - x[a, 0] + cell.image[m, 0] * side + arm[t, 0] - arm[s, 0]
    dy = x[b, 1] - x[a, 1] + cell.image[m, 1] * side + arm[t, 1] - arm[s, 1]
    dz = x[b, 2] - x[a, 2] + cell.image[m, 2] * side + arm[t, 2] - arm[s, 2]
    cutoff = cell.offset[s - a * k, 3] + cell.offset[t - b * k, 3]
    return cutoff, dx * dx + dy * dy + dz * dz, dx, dy, dz
