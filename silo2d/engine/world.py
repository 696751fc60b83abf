"""Builds the arrays of a world from shapes, poses, walls and laws, and makes them longer."""

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from silo2d.engine import state
from silo2d.engine.pair_law import DrawnLaw, Law, PairConstants, draw_lists
from silo2d.engine.state import Bodies, Cells, Forces, Inner, Outer, World

# At the level of bodies, see neighbours.py: at most, and of a small particle, in its bounding
# radius, so that it lists its neighbours and not theirs. Walls need none.
BODY_SKIN, OF_SMALL = 3e-3, 0.3  # [m], [-]


class CrossSection(Protocol):
    """A rounded convex polygon or a disc, its centroid at the origin: as the engine needs it."""

    @property
    def core(self) -> np.ndarray: ...  # corners (n, 2) [m], counter-clockwise; one of a disc
    @property
    def spheroradius(self) -> float: ...  # [m]
    @property
    def bounding_radius(self) -> float: ...  # [m]
    @property
    def area(self) -> float: ...  # [m2]
    @property
    def polar_moment(self) -> float: ...  # of area [m4]


class WallSegments(Protocol):
    """Straight pieces of wall, the inside on their left: what the engine needs of an outline."""

    @property
    def segments(self) -> np.ndarray: ...  # end points (w, 2, 2) [m]
    @property
    def corners(self) -> np.ndarray: ...  # (w,) end points, first first, that edges can rest on


def build_world(
    shapes: Sequence[CrossSection],
    kinds: np.ndarray,
    poses: np.ndarray,
    walls: WallSegments,
    *,
    surface_density: float,
    particle_law: Law,
    wall_law: Law,
    gravity: float,
    time_step: float,
) -> World:
    """A world of particles at rest; its two laws are of one kind, shared or drawn.

    kinds (n,) indices in `shapes`; poses (n, 3) x, y [m], angle [rad]; surface_density [kg/m2]
    is density times prism length.
    """
    particles = [shapes[kind] for kind in kinds]
    middles = walls.segments.mean(axis=1)
    cores = [particle.core for particle in particles] + list(walls.segments - middles[:, None])
    bodies = _bodies(particles, poses, walls, middles, cores, surface_density)
    local = _local(cores)
    vertices = local[:, : state.EDGE_Y + 1].copy()
    of_walls = slice(bodies.layout[len(particles), state.FIRST] if len(middles) else None, None)
    vertices[of_walls, :2] += np.repeat(middles, 2, axis=0) if len(middles) else 0.0
    parts = state.parts_of(len(particles))
    world = World(
        bodies=bodies,
        local=local,
        vertices=vertices,
        cells=_cells(bodies, np.concatenate([poses[:, :2], walls.segments.reshape(-1, 2)])),
        outer=_outer(1024 + 16 * len(particles)),
        inner=_inner(1024 + 16 * len(particles)),
        forces=Forces(*(np.zeros(state.BLOCK) for _ in Forces._fields)),
        counts=_counts(len(particles)),
        account=np.zeros(state.N_ACCOUNT),
        parts=parts,
        first_pair=np.zeros((2, len(parts)), np.int64),
        particle_law=particle_law,
        wall_law=wall_law,
        gravity=gravity,
        time_step=time_step,
    )
    return with_laws(world, particle_law, wall_law)


def with_laws(world: World, particle_law: Law, wall_law: Law) -> World:
    """The same world with other laws; pairs that draw their constants have drawn them."""
    if isinstance(particle_law, DrawnLaw) and isinstance(wall_law, DrawnLaw):
        n, capacity = len(PairConstants._fields), len(world.outer.key)
        outer = PairConstants(*np.zeros((n, capacity)))
        inner = PairConstants(*_staggered(n, capacity, behind=len(Inner._fields)))
        particle_law = particle_law._replace(outer=outer, inner=inner)
        wall_law = wall_law._replace(outer=outer, inner=inner)
        n_bodies = len(world.bodies.row)
        draw_lists(particle_law, wall_law, world.outer, world.inner, world.counts, n_bodies)
    return world._replace(particle_law=particle_law, wall_law=wall_law)


def _bodies(particles, poses, walls, middles, cores, surface_density) -> Bodies:
    n_particles, n = len(particles), len(cores)
    row = np.zeros((n, 16))
    row[:n_particles, [state.X, state.Y, state.ANGLE]] = poses
    row[n_particles:, [state.X, state.Y]] = middles
    row[:, state.COS], row[:, state.SIN] = np.cos(row[:, state.ANGLE]), np.sin(row[:, state.ANGLE])
    row[:n_particles, state.INV_MASS] = [1.0 / (surface_density * g.area) for g in particles]
    row[:n_particles, state.INV_INERTIA] = [
        1.0 / (surface_density * g.polar_moment) for g in particles
    ]
    layout, size = np.zeros((n, 3), np.int64), np.zeros((n, 2))
    counts = np.array([len(core) for core in cores], dtype=np.int64)
    layout[:, state.FIRST] = np.cumsum(counts) - counts
    layout[:, state.N_CORNERS] = np.concatenate([counts[:n_particles], walls.corners])
    layout[:, state.N_EDGES] = np.where(np.arange(n) < n_particles, counts, 1)
    for i, particle in enumerate(particles):
        size[i] = particle.bounding_radius, particle.spheroradius
    lengths = np.linalg.norm(walls.segments[:, 1] - walls.segments[:, 0], axis=1)
    size[n_particles:, state.BOUNDING_RADIUS] = lengths / 2
    skin = np.zeros((n, 3))
    radius = size[:n_particles, state.BOUNDING_RADIUS]
    skin[:n_particles, state.BODY_LIST] = np.minimum(BODY_SKIN, OF_SMALL * radius)
    out_time = np.full(n, np.nan)
    return Bodies(row, layout, size, np.zeros((n, 9)), skin, out_time, np.arange(n_particles))


def _local(cores) -> np.ndarray:
    edges = np.concatenate([np.roll(core, -1, axis=0) - core for core in cores])
    length2 = (edges**2).sum(axis=1)  # 0 of a disc, whose edge is its centre
    inv_length2 = np.divide(1.0, length2, out=np.zeros_like(length2), where=length2 > 0.0)
    return np.column_stack([np.concatenate(cores), edges, inv_length2])


def _cells(bodies: Bodies, points: np.ndarray) -> Cells:
    n_particles = len(bodies.live)
    radius = bodies.size[:n_particles, state.BOUNDING_RADIUS]
    size = 2 * (radius + bodies.skin[:n_particles, state.BODY_LIST]).max(initial=0.0)
    low, high = points.min(axis=0) - size, points.max(axis=0) + size
    columns, rows = (math.ceil(extent / size) for extent in high - low)
    return Cells(
        pairs=np.zeros((64 + 8 * n_particles, 2), np.uint32),
        start=np.zeros(columns * rows + 1, np.int64),
        particles=np.zeros(n_particles, np.int64),
        of_particle=np.zeros(n_particles, np.int64),
        size=float(size),
        columns=columns,
        rows=rows,
        left=float(low[0]),
        bottom=float(low[1]),
    )


def _outer(capacity: int) -> Outer:
    kinds: dict[str, type] = {"key": np.int64, "old_key": np.int64}
    kinds |= dict.fromkeys(("vertex", "edge", "vertex_body", "edge_body"), np.uint32)
    # One more than can be listed: the end of the previous list is marked behind it.
    return Outer(*(np.zeros(capacity + 1, kinds.get(field, float)) for field in Outer._fields))


def _inner(capacity: int) -> Inner:
    lines = _staggered(len(Inner._fields), capacity)
    integers = ("outer", "vertex_body", "edge_body")
    return Inner(
        *(
            line.view(np.uint32)[:capacity] if field in integers else line[:capacity]
            for field, line in zip(Inner._fields, lines, strict=True)
        )
    )


def _staggered(n: int, capacity: int, behind: int = 0) -> list[np.ndarray]:
    """Arrays of at least `capacity` for the force pass, n of them, read with `behind` others."""
    # Arrays of one size would all start at the same position in a memory page, and the force pass,
    # which reads all of them at once, would wait for cache lines that displace each other: shift
    # each by three cache lines against the one before.
    page, shift = 512, 24
    length = -(-capacity // page) * page + shift
    lines = np.zeros((n, length + behind * shift))
    return [line[behind * shift :] for line in lines]


def _counts(n_particles: int) -> np.ndarray:
    counts = np.zeros(state.N_COUNTS, np.int64)
    counts[state.LIVE], counts[state.STALE] = n_particles, 3
    return counts


def more_pairs(world: World) -> World:
    """The same world with capacity for twice as many pairs of bodies; they are found again."""
    pairs = np.zeros((2 * len(world.cells.pairs), 2), np.uint32)
    return world._replace(cells=world.cells._replace(pairs=pairs))


def longer_lists(world: World) -> World:
    """The same world with capacity for twice as many vertex-edge pairs, the slips kept."""
    capacity, n = 2 * len(world.outer.key), int(world.counts[state.OUTER])
    outer = _outer(capacity)
    outer.key[:n], outer.slip[:n] = world.outer.key[:n], world.outer.slip[:n]
    longer = world._replace(outer=outer, inner=_inner(capacity))
    return with_laws(longer, world.particle_law, world.wall_law)
