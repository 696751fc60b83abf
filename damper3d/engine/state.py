"""The arrays that the kernels work on: particles, spheres, walls, lists of contacts, balance.

What moves is a particle, what touches is a sphere: sphere s of particle b has the number b k + s, k
spheres a particle. The type of World.shape says which particles they are: spheres, each its own
centre (spheres/), or multi-sphere particles, all alike, that rotate (multisphere/). Vectors stand
in rows of four numbers; the fourth of a position is the radius, so that one load brings all, that
of others stays zero, but for a torque's: minus the heat of this step.

Particles that follow one another are a part, and the pairs whose first particle is in it are the
part's. What is summed over all pairs is summed by parts: the sums are the same to the last bit
however many threads work on the parts (shared/steps.py). A small bed is one part.

Positions and velocities are those of the laboratory: the enclosure's own frame (its bottom's
centre is the origin, z its axis) plus the displacement of the enclosure.
"""

import math
from typing import Any, NamedTuple

import numpy as np

# Entries of World.counts. STEP: of this phase; OUTER, INNER, WALL: lengths of the lists; STALE_...:
# lists to be made again; ..._MADE: the step when a list was made.
STEP, OUTER, INNER, WALL, STALE_INNER, STALE_WALL = range(6)
OUTER_SEARCHES, INNER_SEARCHES, WALL_SEARCHES, INNER_MADE, WALL_MADE = range(6, 11)
N_COUNTS = 11
# Entries of World.balance [J], for particle-particle and then particle-wall contacts; then the work
# of the enclosure on the bed.
NORMAL_DAMPING, TANGENTIAL_DAMPING, FRICTION, LAW_TERM, SLIP_COUNT = range(5)
N_MECHANISMS = 5
WALL_WORK = 2 * N_MECHANISMS
N_BALANCE = WALL_WORK + 1
# Entries of World.lengths [m]: how far apart spheres may be to be listed, and what was left of
# the outer list's cutoff when the inner one was made.
OUTER_SKIN, INNER_SKIN, WALL_SKIN = range(3)
N_LENGTHS = 3
# Entries of the constants of a contact: radii [m] (none of a wall), (4/3) E sqrt(R) [N/m^1.5], and
# the reduced mass [kg].
RADIUS_I, RADIUS_J, HERTZ, MASS = range(4)
N_CONSTANTS = 4
# Entries of a history: what the tangential spring holds [m or N], half of the displacement in the
# last step [m], tangential stiffness [N/m], and the b of the contact, which is NO_CONTACT where
# there is none.
SPRING_X, SPRING_Y, SPRING_Z, MOVED_X, MOVED_Y, MOVED_Z, STIFFNESS, DAMPING = range(8)
N_HISTORY = 8
NO_CONTACT = -1.0
N_ROLLING = 6  # likewise of rolling: displacement of its spring, half of that of the last step [m]

# How a search ends.
DONE, OUTER_FULL, INNER_FULL, WALL_FULL, NOT_FINITE, TOO_DEEP = range(6)
DEEPEST = 0.25  # overlap over the sum of the radii that is taken for a failure

# Columns of a sample; the energies and then the forces on the walls follow.
(
    TIME, DISPLACEMENT, VELOCITY, KINETIC, POTENTIAL, ELASTIC_NORMAL, ELASTIC_TANGENTIAL,
    CONTACTS_PP, CONTACTS_PW, IMPACT_PP, IMPACT_PW, BEGUN_PP, BEGUN_PW, BEYOND_PP, BEYOND_PW,
    POSITION_X, POSITION_Y, POSITION_Z, VELOCITY_X, VELOCITY_Y, VELOCITY_Z,
) = range(21)  # fmt: skip
N_COLUMNS = 21

# Entries of World.impacts: of the contacts that began since last asked the largest speed [m/s],
# their number, and the number of those faster than the yield velocity, the last entry [m/s].
FASTEST, BEGUN, BEYOND, YIELD = range(4)

BLOCK = 32  # contacts that the force pass works on at once: what it finds stays in the first cache

UNREAD = 256  # rows of force and torque, two in a line of the cache for each thread

LANES = 8  # the vectorised passes go on to a whole number of these: the lists have as much room

_LINE = 8  # numbers in a line of the cache


def zeros(*shape: int) -> np.ndarray:
    """Zeros that begin at a cache line: what lies across two of them costs double to load."""
    size = math.prod(shape)
    room = np.zeros(size + _LINE)
    begin = (-room.ctypes.data // room.itemsize) % _LINE
    return room[begin : begin + size].reshape(shape)


def no_history(*shape: int) -> np.ndarray:
    """Histories of contacts that there are not."""
    history = zeros(*shape, N_HISTORY)
    history[..., DAMPING] = NO_CONTACT
    return history


def most_threads(parts: np.ndarray) -> int:
    """Return how many threads can share a bed whose parts have these bounds."""
    return min(len(parts) - 1, UNREAD // 2)


class Spheres(NamedTuple):
    """The spheres of the particles, all that a contact needs to know and gives back.

    Arrays of (m + 1, 4): the last row is the enclosure, a sphere of no radius that does not rotate.
    """

    position: np.ndarray  # centre [m], radius [m]
    velocity: np.ndarray  # of the centre, extrapolated to the time of the position [m/s]
    angular_velocity: np.ndarray  # of the particle, likewise [rad/s]
    force: np.ndarray  # [N]; with UNREAD rows more, which take what nobody shall read
    torque: (
        np.ndarray
    )  # about the sphere's centre [N m], and minus its heat of this step [J]; likewise
    inverse_mass: np.ndarray  # (m,) of the particle [1/kg]


class OuterList(NamedTuple):
    """The outer list: pairs of particles i < j that may come close, ascending."""

    i: np.ndarray  # (capacity,) uint32
    j: np.ndarray  # (capacity,) uint32
    now: np.ndarray  # (n, 4) positions of the particles at a search, and bounding radii [m]
    made_at: np.ndarray  # (n, 4) those when the list was made


class Contacts(NamedTuple):
    """The inner list: pairs that touch or nearly do, of spheres, or of spheres and walls.

    The pairs of a group are of the same two particles, or of a particle with the same wall.
    """

    i: np.ndarray  # (capacity,) uint32, sphere
    j: np.ndarray  # (capacity,) uint32, sphere; of a wall contact the enclosure's row
    group: np.ndarray  # (capacity,) uint32, index in the outer list, or number of the particle
    cutoff: np.ndarray  # (capacity,) sum of the radii [m]
    constants: np.ndarray  # (capacity, N_CONSTANTS)
    whole: np.ndarray  # (capacity, 2) Hertz constant and mass of a contact that shares with others
    history: np.ndarray  # (capacity, N_HISTORY)
    rolling: Any  # (capacity, N_ROLLING), or None where nothing resists rolling
    touching: np.ndarray  # (capacity,) uint32, those of them that act, and maybe others
    feature: np.ndarray  # (capacity,) uint32, feature of a triangulated wall, see enclosures.cavity


class Seen(NamedTuple):
    """Positions of the particles when an inner list was made."""

    position: np.ndarray  # (n, 4) [m]
    orientation: np.ndarray  # (n, 4) unit quaternions; (0, 4) of spheres
    margin: np.ndarray  # (n,) how far a particle may go before the list no longer holds [m]
    drift: np.ndarray  # (4,) mean velocity then [m/s]; of walls: where they were [m]


class Kept(NamedTuple):
    """Histories of pairs in contact, while the inner list is made again."""

    number: np.ndarray  # (1,) how many
    key: np.ndarray  # (capacity,) see neighbours.keep_histories; ascending
    history: np.ndarray  # (capacity, N_HISTORY)
    rolling: Any  # (capacity, N_ROLLING) or None


class Walls(NamedTuple):
    """Flat walls, and then curved ones."""

    planes: np.ndarray  # (n_planes, 4) inward normal, offset [m]: inside n.x > offset
    surface: Any  # numbers of the curved walls, of a type that engine.enclosures knows
    drive: Any  # walls.Drive of walls each of which moves by itself; None: all move as one
    curved: bool  # whether the curvature of walls enters the Hertz law
    first: np.ndarray  # (n_walls + 1,) where the contacts of each wall begin
    force: np.ndarray  # (n_walls, 3) by the particles, summed over the steps since asked [N]
    # (n_walls, m, N_HISTORY), up to date while there is no wall list; of triangles (PLACES, ...)
    history: np.ndarray
    rolling: Any  # (n_walls m, N_ROLLING) likewise, or None


class Block(NamedTuple):
    """Arrays that passes over a block of contacts hand on; vectors (3 BLOCK,), numbers (BLOCK,).

    The second row of a vector begins at BLOCK; see damper3d.engine.geometry.entry.
    """

    constants: np.ndarray  # (N_CONSTANTS BLOCK,)
    history: np.ndarray  # (N_HISTORY BLOCK,), after the last step
    next_history: np.ndarray  # (N_HISTORY BLOCK,), after this one
    separation: np.ndarray  # x_j - x_i [m]
    relative_velocity: np.ndarray  # u_j - u_i [m/s]
    rim_velocity: np.ndarray  # R_i w_i + R_j w_j [m/s]
    angular_velocity: np.ndarray  # w_i + w_j [rad/s]
    normal: np.ndarray  # from i to j
    velocity: np.ndarray  # of j relative to i at the contact [m/s]
    push: np.ndarray  # force on j [N]
    couple: np.ndarray  # normal x push [N]
    clearance: np.ndarray  # negative where they may touch
    overlap: np.ndarray  # [m], 0 where they do not touch
    arm_i: np.ndarray  # from the centre of i to the contact [m]
    arm_j: np.ndarray  # from the contact to the centre of j [m]
    normal_power: np.ndarray  # dissipated by the normal dashpot [W]
    tangential_power: np.ndarray  # dissipated by the tangential dashpot [W]
    friction_work: np.ndarray  # dissipated by friction in this step [J]
    stiffness_work: np.ndarray  # work of the changing stiffness of the tangential spring [J]
    slip_power: np.ndarray  # friction force times the whole sliding velocity [W]
    lost: np.ndarray  # half of what is dissipated in this step [J]
    impact_speed: np.ndarray  # speed of an impact that begins in this step [m/s], else 0
    totals: np.ndarray  # (N_MECHANISMS,) sums of powers and works over blocks, see laws.balance
    own_totals: np.ndarray  # (N_MECHANISMS,) what laws add to them: rolling, necks that tear


class Cells(NamedTuple):
    """Cubic cells over the enclosure, for the search of pairs of particles."""

    start: np.ndarray  # (n_cells + 2,) where the particles of a cell begin is entry cell + 1
    members: np.ndarray  # (n,) numbers of particles, cell by cell
    place: np.ndarray  # (n, 4) and their positions and bounding radii, in that order [m]
    home: np.ndarray  # (n,) cell of each particle
    size: float  # [m]
    shape: tuple[int, int, int]
    origin: tuple[float, float, float]  # in the enclosure's frame [m]
    largest: float  # radius of a sphere [m]


class World(NamedTuple):
    """Everything that the step loop works on."""

    shape: Any  # spheres.particles.OneSphere or multisphere.particles.ManySpheres
    particles: Any  # spheres.particles.SphereMotion or multisphere.particles.RigidMotion
    spheres: Spheres
    cells: Cells
    outer: OuterList
    inner: Contacts
    inner_seen: Seen
    wall: Contacts
    wall_seen: Seen
    kept: Kept
    block: Block
    counts: np.ndarray  # (N_COUNTS,) int64
    parts: np.ndarray  # (n_parts + 1,) where the particles of each part begin
    first_pair: np.ndarray  # (n_parts + 1,) where its pairs begin in the inner list
    packed: np.ndarray  # (n_parts,) whether most of these touched when last looked at
    balance: np.ndarray  # (N_BALANCE,) [J]
    impacts: np.ndarray  # (2, 4) of each class, see FASTEST
    lengths: np.ndarray  # (N_LENGTHS,) [m]
    pair_law: Any  # HertzLaw
    direction: np.ndarray  # (4,) unit vector of the enclosure's motion
    gravity: np.ndarray  # (4,) [m/s2]
    time_step: float  # [s]
    walls: Walls  # none where particles are looked at among themselves, see motions.turning
    wall_law: Any  # as pair_law
    shaker: Any  # numbers of the motion, of a type that engine.motions knows
    results: Any = None  # shared.results.Results where several threads share a step
