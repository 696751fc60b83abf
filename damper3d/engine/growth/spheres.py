"""Random start of spheres: they grow at random positions in the enclosure and push each other.

Random insertion ends at a fill ratio near 0.38 and the thesis needs 0.466. Here the centres are
drawn at once, the radii grow from small ones in stages, and in each stage the spheres move down the
energy of their overlaps (relaxation.py) until no overlap matters. A step costs a search in linked
cells over the spheres, and their order gives that of the sums: packings, and all that was computed
from them, keep their bits by it, so that this search is not the one of the step loop.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import types

from damper3d.engine.enclosures import Enclosure, Round
from damper3d.engine.enclosures.cavity import Triangles
from damper3d.engine.enclosures.places import push_from_places
from damper3d.engine.growth.relaxation import (
    AT_REST,
    MARGIN,
    PATIENCE,
    PUSHED,
    TOLERANCE,
    Grown,
    displace,
    first_size,
    grow_to_size,
    push_apart,
    relax,
)
from damper3d.engine.walls import nearest
from granulab.contact.jit import inlined_inner, inner, njit, specialised, substituted

_START = 0.1  # fill ratio of the radii that the first stage begins with
# Spheres from which on they are numbered by where they start: fewer stay in the processor's cache
# in any order, and keep the bits of their packings.
_MANY = 100_000
_ROUNDS = 1000  # of random points, after which those of a ball of half the size serve
# Cells at most, so many a sphere and these, and how much wider they are made at a time where there
# would be more: far above what beds need, whose packings keep their bits.
_CELLS, _FEW, _WIDER = 100, 1_000_000, 1.25


class Balls(NamedTuple):
    """Spheres between walls."""

    centres: np.ndarray  # (n, 3) [m]
    radius: Any  # of all, or of each (n,) [m]
    planes: np.ndarray  # as in state.Walls
    surface: Any
    n_curved: int


def grow(
    enclosure: Enclosure,
    count: int,
    radius: float | np.ndarray,
    rng: np.random.Generator,
    grown: Grown | None = None,
) -> tuple[np.ndarray, float]:
    """Centres (count, 3) [m] of spheres without overlap in an enclosure, and how far they grew.

    radius: of all, or of each (count,) [m]. The second that is returned is the part of it that the
    spheres reached: 1, or less where they found no place, and then the centres are those of the
    smaller ones.
    """
    volume = float(4.0 / 3.0 * math.pi * np.mean(radius**3))
    first = first_size(count * volume / enclosure.volume, _START)
    centres = _anywhere(enclosure, count, first * float(np.max(radius)), rng)
    if count >= _MANY and np.ndim(radius) == 0:  # unlike spheres have numbers of their own
        centres = in_columns(centres, 2.0 * float(radius))
    allowed = TOLERANCE * float(np.min(radius))
    velocity, force = np.zeros_like(centres), np.zeros_like(centres)
    surface = enclosure.surface_for(float(np.max(radius)))
    n_curved = len(enclosure.wall_names) - len(enclosure.planes)

    def comes_to_rest(size: float) -> bool:
        larger = size * radius * (1.0 + MARGIN)
        balls = Balls(centres.copy(), larger, enclosure.planes, surface, n_curved)
        outcome, _, _ = relax(balls, velocity, force, allowed, PATIENCE, 0.0)
        if outcome == AT_REST:
            centres[:] = balls.centres
        return bool(outcome == AT_REST)

    reached = grow_to_size(first, comes_to_rest, grown)
    return centres, reached


def _anywhere(
    enclosure: Enclosure, count: int, radius: float, rng: np.random.Generator
) -> np.ndarray:
    """Random points (count, 3), evenly spread over where a ball of a radius fits.

    Cells get as many each, the first ones one more where they cannot. Where such a ball hardly
    fits, as a large one in a pointed void, a smaller one's places serve: the walls push it in.
    """
    cells = enclosure.cells
    if len(cells) > 1:
        share = [len(part) for part in np.array_split(np.arange(count), len(cells))]
        return np.concatenate(
            [
                _anywhere(enclosure.cell, n, radius, rng) + np.array([*centre, 0.0])
                for n, centre in zip(share, cells, strict=True)
            ]
        )
    low = np.array([-0.5 * enclosure.width, -0.5 * enclosure.depth, 0.0]) + radius
    high = np.array([0.5 * enclosure.width, 0.5 * enclosure.depth, enclosure.height]) - radius
    found, rounds = np.zeros((0, 3)), 0
    while len(found) < count:
        points = rng.uniform(low, high, size=(2 * count, 3))
        rounds += 1
        least = radius * 0.5 ** (rounds // _ROUNDS)
        found = np.concatenate([found, points[enclosure.clearance(points) > least]])
    return found[:count].copy()


def in_columns(centres: np.ndarray, width: float) -> np.ndarray:
    """The same points (n, 3), numbered upwards in columns of a width [m], column by column.

    Spheres that will touch then stand near each other in memory.
    """
    x, y, z = centres.T
    return centres[np.lexsort((z, np.floor(y / width), np.floor(x / width)))]


@substituted(push_apart)
def _push_balls(bed, force):
    if bed.instance_class is Balls:
        return lambda bed, force: push_balls(bed, force)
    return None


@njit
def push_balls(balls, force):
    """Set the overlaps of all pairs and walls as forces; see relaxation.push_apart."""
    force[:] = 0.0
    deepest = max(push_pairs(balls.centres, balls.radius, force), push_walls(balls, force))
    return PUSHED, deepest, 0.0


@substituted(displace)
def _displace_balls(bed, velocity, dt):
    if bed.instance_class is Balls:
        return lambda bed, velocity, dt: displace_balls(bed.centres, velocity, dt)
    return None


@njit
def displace_balls(centres, velocity, dt):
    """Move the centres."""
    for n in range(len(centres)):
        for c in range(3):
            centres[n, c] += dt * velocity[n, c]


def largest_of(radius):
    """The largest of the radii, or the one of all [m]."""


def sum_of(radius, n, m):
    """The sum of the radii of spheres n and m [m]."""


@specialised(largest_of)
def _largest_of(radius):
    if isinstance(radius, types.Array):
        return lambda radius: _maximum(radius)
    return lambda radius: radius


@inner
def _maximum(radius):
    largest = 0.0
    for n in range(len(radius)):
        largest = max(largest, radius[n])
    return largest


@specialised(sum_of)
def _sum_of(radius, n, m):
    if isinstance(radius, types.Array):
        return lambda radius, n, m: radius[n] + radius[m]
    return lambda radius, n, m: 2.0 * radius


@njit
def push_pairs(centres, radius, force):
    """Add the overlap of each pair to the force on both; the deepest overlap."""
    size, shape, origin = cells_over(centres, 2.0 * largest_of(radius))
    start, inside = sort_into_cells(centres, size, shape, origin)
    deepest = 0.0
    for n in range(len(centres)):
        x, y, z = centres[n]
        a = int((x - origin[0]) / size), int((y - origin[1]) / size), int((z - origin[2]) / size)
        for i in range(max(a[0] - 1, 0), min(a[0] + 2, shape[0])):
            for j in range(max(a[1] - 1, 0), min(a[1] + 2, shape[1])):
                row = (i * shape[1] + j) * shape[2]
                begin = start[row + max(a[2] - 1, 0)]
                end = start[row + min(a[2] + 2, shape[2])]
                for k in range(begin, end):  # three cells in a row stand end to end
                    m = inside[k]
                    if m <= n:
                        continue
                    dx, dy, dz = centres[m, 0] - x, centres[m, 1] - y, centres[m, 2] - z
                    square = dx * dx + dy * dy + dz * dz
                    reach = sum_of(radius, n, m)
                    if square < reach * reach and square > 0.0:
                        distance = np.sqrt(square)
                        overlap = reach - distance
                        deepest = max(deepest, overlap)
                        push = overlap / distance
                        force[n, 0] -= push * dx
                        force[n, 1] -= push * dy
                        force[n, 2] -= push * dz
                        force[m, 0] += push * dx
                        force[m, 1] += push * dy
                        force[m, 2] += push * dz
    return deepest


@njit
def push_walls(balls, force):
    """Add twice the overlap with each wall, which does not give way; the deepest overlap."""
    centres, planes = balls.centres, balls.planes
    deepest = 0.0
    for n in range(len(centres)):
        radius = 0.5 * sum_of(balls.radius, n, n)
        x, y, z = centres[n]
        for w in range(len(planes)):
            nx, ny, nz, offset = planes[w]
            overlap = radius - (nx * x + ny * y + nz * z - offset)
            if overlap > 0.0:
                deepest = max(deepest, overlap)
                force[n, 0] += 2.0 * overlap * nx
                force[n, 1] += 2.0 * overlap * ny
                force[n, 2] += 2.0 * overlap * nz
        for wall in range(balls.n_curved):
            deepest = max(deepest, push_curved(balls.surface, wall, centres, radius, n, force))
    return deepest


def push_curved(surface, wall, centres, radius, n, force):
    """Add twice the overlap with a curved wall to the force on sphere n; the overlap, or 0."""


@specialised(push_curved)
def _push_curved(surface, wall, centres, radius, n, force):
    if surface.instance_class is Round:
        return lambda surface, wall, centres, radius, n, force: _push_round(
            surface.radius, centres, radius, n, force
        )
    if surface.instance_class is Triangles:
        return lambda surface, wall, centres, radius, n, force: push_from_places(
            surface, centres, radius, n, force
        )
    return lambda surface, wall, centres, radius, n, force: _push_nearest(
        surface, wall, centres, radius, n, force
    )


@inlined_inner
def _push_round(side, centres, radius, n, force):
    """The round wall by itself, as a packing must keep its bits."""
    x, y = centres[n, 0], centres[n, 1]
    distance = np.hypot(x, y)
    overlap = radius + distance - side
    if overlap > 0.0:
        force[n, 0] -= 2.0 * overlap * x / distance
        force[n, 1] -= 2.0 * overlap * y / distance
    return max(overlap, 0.0)


@inlined_inner
def _push_nearest(surface, wall, centres, radius, n, force):
    distance, normal, _ = nearest(surface, wall, centres[n, 0], centres[n, 1], centres[n, 2])
    overlap = max(radius - distance, 0.0)
    for c in range(3):
        force[n, c] -= 2.0 * overlap * normal[c]
    return overlap


@njit
def cells_over(centres, size):
    """Cubic cells over all centres: their size, how many each way, their corner.

    Of the size given, or wider where few spheres have so much room that there would be too many.
    """
    low = centres[:, 0].min(), centres[:, 1].min(), centres[:, 2].min()
    high = centres[:, 0].max(), centres[:, 1].max(), centres[:, 2].max()
    a, b, c = high[0] - low[0], high[1] - low[1], high[2] - low[2]
    while (a / size + 1.0) * (b / size + 1.0) * (c / size + 1.0) > _CELLS * len(centres) + _FEW:
        size *= _WIDER
    return size, (int(a / size) + 1, int(b / size) + 1, int(c / size) + 1), low


@njit
def sort_into_cells(centres, size, shape, origin):
    """Return the begin of each cell (n_cells + 1,) and the spheres by cell (n,), ascending."""
    start = np.zeros(shape[0] * shape[1] * shape[2] + 1, np.int64)
    home = np.empty(len(centres), np.int64)
    for n in range(len(centres)):
        i = int((centres[n, 0] - origin[0]) / size)
        j = int((centres[n, 1] - origin[1]) / size)
        k = int((centres[n, 2] - origin[2]) / size)
        home[n] = (i * shape[1] + j) * shape[2] + k
        start[home[n] + 1] += 1
    start = np.cumsum(start)
    place = start[:-1].copy()
    inside = np.empty(len(centres), np.int64)
    for n in range(len(centres)):
        inside[place[home[n]]] = n
        place[home[n]] += 1
    return start, inside
