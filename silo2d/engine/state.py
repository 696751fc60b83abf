"""The arrays that the kernels work on: bodies, vertices, the three levels of lists, counters.

Particles come first, walls after them: a wall is a body of zero inverse mass with one edge. What a
contact needs from a body stands in one row of sixteen float64, two neighbouring cache lines.
"""

from typing import Any, NamedTuple

import numpy as np

from granulab.contact.compiled import parts

# Columns of Bodies.row: position [m], direction, velocity half a step back and extrapolated to
# now [m/s, rad/s], force [N], torque [N m], 1/mass [1/kg], 1/inertia [1/(kg m2)], angle [rad].
X, Y, COS, SIN, VX, VY, OMEGA, UX = range(8)
UY, UOMEGA, FX, FY, TORQUE, INV_MASS, INV_INERTIA, ANGLE = range(8, 16)
# Columns of Bodies.layout and Bodies.size.
FIRST, N_CORNERS, N_EDGES = range(3)
BOUNDING_RADIUS, SPHERORADIUS = range(2)
# Levels of the lists, see neighbours.py: columns of Bodies.skin and, times three, of Bodies.listed.
BODY_LIST, OUTER_LIST, INNER_LIST = range(3)
# Columns of World.vertices and World.local: a vertex, the edge that leaves it counter-clockwise,
# and 1/length^2 of that edge [1/m2].
VERTEX_X, VERTEX_Y, EDGE_X, EDGE_Y, INV_LENGTH2 = range(5)
# Entries of World.counts. STALE: how many levels of the lists must be made again, from below.
STEP, LIVE, OUT, STALE = range(4)
PARTICLE_PAIRS, PAIRS, PARTICLE_OUTER, OUTER, PARTICLE_INNER, INNER = range(4, 10)
BODY_SEARCHES, OUTER_SEARCHES, INNER_SEARCHES = range(10, 13)
DOOR = 13  # which body is a door that is being drawn; 0, a particle: none
N_COUNTS = 14
# Entries of World.account [J]: what was dissipated how, particle-particle and then particle-wall;
# the energy of particles that were dropped; and what a moving door took, mostly less than nothing.
NORMAL_DAMPING, TANGENTIAL_DAMPING, FRICTION = range(3)
PARTICLE_PARTICLE, PARTICLE_WALL, CARRIED_OUT, GIVEN_TO_DOOR = 0, 3, 6, 7
N_ACCOUNT = 8
# Outcomes of a search for neighbours.
DONE, PAIRS_FULL, OUTER_FULL, NOT_FINITE, TOO_DEEP = range(5)

BLOCK = 256  # inner pairs that the force pass works on at once: their forces fill half of a cache
MAX_VERTICES = 64  # of one shape: a contact's key has six bits for each
_PART = 512  # particles of a part, at least; twice as many at most
NOBODY = np.uint32(2**32 - 1)  # in place of a body whose load is kept for later
WALL_KEY = 1 << 62  # particle-wall keys come after all particle-particle keys


def parts_of(n: int) -> np.ndarray:
    """Bounds of the parts of n particles (n_parts + 1,)."""
    return parts.parts_of(n, n // _PART)


class Bodies(NamedTuple):
    """Particles 0 ... n_particles - 1, then walls."""

    row: np.ndarray  # (n, 16) see above
    layout: np.ndarray  # (n, 3) first vertex row; vertices that touch edges; edges
    size: np.ndarray  # (n, 2) bounding radius, spheroradius included; spheroradius [m]
    listed: np.ndarray  # (n, 9) position and angle when each level of the lists was made
    skin: np.ndarray  # (n, 3) how far any point may move until a level is made again [m]
    out_time: np.ndarray  # (n,) when the centroid passed y = 0 [s]; NaN before
    live: np.ndarray  # (n_particles,) the particles that are still simulated, ascending


class Outer(NamedTuple):
    """Vertex-edge pairs that can touch before the next search, in ascending order of key.

    Particle-particle pairs come first, ordered by body, body, direction, vertex, edge. The order,
    and with it every sum of forces, does not depend on when the lists were made.
    """

    key: np.ndarray  # (capacity,) int64
    vertex: np.ndarray  # (capacity,) uint32, row of the vertex
    edge: np.ndarray  # (capacity,) uint32, row of the edge
    vertex_body: np.ndarray  # (capacity,) uint32
    edge_body: np.ndarray  # (capacity,) uint32
    mass: np.ndarray  # (capacity,) reduced mass [kg]
    cutoff: np.ndarray  # (capacity,) sum of the spheroradii [m]
    depth: np.ndarray  # (capacity,) spheroradius of the vertex's body [m]
    distance2: np.ndarray  # (capacity,) squared distance of vertex and edge [m2]
    slip: np.ndarray  # (capacity,) tangential displacement held by the spring [m]
    old_key: np.ndarray  # (capacity,) the previous list, while a new one is made
    old_slip: np.ndarray  # (capacity,)


class Inner(NamedTuple):
    """Vertex-edge pairs that touch or nearly do: what the force pass reads of them.

    One array a quantity, so that the pass can be vectorised; all (capacity,).
    """

    outer: np.ndarray  # uint32, index in the outer list
    vertex_body: np.ndarray  # uint32
    edge_body: np.ndarray  # uint32
    vertex_x: np.ndarray  # the vertex in its body's frame [m]
    vertex_y: np.ndarray
    start_x: np.ndarray  # the edge in its body's frame: where it starts [m]
    start_y: np.ndarray
    edge_x: np.ndarray  # and where it goes [m]
    edge_y: np.ndarray
    inv_length2: np.ndarray  # [1/m2]
    mass: np.ndarray  # reduced mass [kg]
    cutoff: np.ndarray  # sum of the spheroradii [m]
    depth: np.ndarray  # spheroradius of the vertex's body [m]
    slip: np.ndarray  # tangential displacement held by the spring [m]


class Forces(NamedTuple):
    """Forces of one block of inner pairs, and what they dissipate; all (BLOCK,), so in cache."""

    fx: np.ndarray  # force on the vertex's body [N]
    fy: np.ndarray
    torque_j: np.ndarray  # torque on the vertex's body [N m]
    torque_i: np.ndarray  # torque on the edge's body [N m]
    normal_power: np.ndarray  # dissipated by normal damping [W]
    tangential_power: np.ndarray  # dissipated by tangential damping [W]
    lost: np.ndarray  # dissipated by friction in this step [J]


class Cells(NamedTuple):
    """Square cells over the silo, and the pairs of bodies found with them."""

    pairs: np.ndarray  # (capacity, 2) uint32: particle, particle or wall
    start: np.ndarray  # (n_cells + 1,) particles of a cell, as a range of `particles`
    particles: np.ndarray  # (n_particles,)
    of_particle: np.ndarray  # (n_particles,) cell of a particle
    size: float  # [m]
    columns: int
    rows: int
    left: float  # [m]
    bottom: float  # [m]


class World(NamedTuple):
    """Everything that the step loop works on.

    Particles that follow one another are a part, and the pairs whose first body is in it are the
    part's. What is summed over all pairs of a class is summed by parts: the sums are the same to
    the last bit however many threads work on the parts (shared/steps.py). A small bed is one part.
    """

    bodies: Bodies
    local: np.ndarray  # (n_vertices, 5) vertices and edges in the frames of their bodies [m]
    vertices: np.ndarray  # (n_vertices, 4) the same in the silo's frame [m]
    cells: Cells
    outer: Outer
    inner: Inner
    forces: Forces
    counts: np.ndarray  # (N_COUNTS,) int64
    account: np.ndarray  # (N_ACCOUNT,) [J]
    parts: np.ndarray  # (n_parts + 1,) where the particles of each part begin, see below
    first_pair: np.ndarray  # (2, n_parts + 1) where its inner pairs begin, of each class
    particle_law: Any  # a law, or DrawnLaw of pair_law.py; both laws are of one type
    wall_law: Any
    gravity: float  # [m/s2], downwards
    time_step: float  # [s]
    plates: Any = None  # front and back plate that rub, beds/plates.py
    vibration: Any = None  # of all walls, beds/vibration.py
