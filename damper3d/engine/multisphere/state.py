"""The arrays of a world whose bodies are rigid clusters of spheres, all alike.

Sphere s of body b has the number b k + s, k spheres a body: rows of `spheres` and the contacts'
lists go by it, so that the passes over contacts are those of balls. Only the spheres that stand in
a list are kept up to date ("active"). Vectors stand in rows of four, as in damper3d.engine.state.
"""

from typing import Any, NamedTuple, Protocol

import numpy as np

from damper3d.engine.state import Block, Cells, Contacts, Spheres, Walls

# What becomes of several contacts of one body with another, or with a wall: World.treatment.
TREATMENTS = ("sum", "deepest", "scaled")
SUM, DEEPEST, SCALED = range(3)


class Particle(Protocol):
    """A multi-sphere particle in its principal axes about its centroid, as the engine needs it."""

    @property
    def offsets(self) -> np.ndarray:
        """Centres of the spheres (k, 3) [m]."""

    @property
    def radii(self) -> np.ndarray:
        """Radii of the spheres (k,) [m]."""

    @property
    def volume(self) -> float:
        """Volume of the smooth shape [m3]."""

    @property
    def inertia(self) -> np.ndarray:
        """Principal moments over the density (3,) [m5]."""

    @property
    def bounding_radius(self) -> float:
        """Radius of the sphere about the centroid that holds the particle [m]."""

    @property
    def smallest_radius(self) -> float:
        """Radius of its smallest sphere [m]."""


class Shape(NamedTuple):
    """The cluster in its principal axes about its centroid."""

    offset: np.ndarray  # (k, 4) centre of each sphere, its radius [m]
    columns: np.ndarray  # (4, K) the same, turned; as many that reach nowhere as fill the vectors
    arm: float  # distance of the farthest centre from the centroid [m]
    inverse_inertia: np.ndarray  # (3,) of the principal moments [1/(kg m2)]
    odd: int  # the axis about which the cluster is, or may be, as round as about no other


class Rigid(NamedTuple):
    """Rigid bodies, (n, 4) or (n,)."""

    position: np.ndarray  # of the centroid [m]; radius of the ball that holds the body [m]
    orientation: (
        np.ndarray
    )  # unit quaternion (w, x, y, z), from the body's axes to the laboratory's
    axes: np.ndarray  # (n, 12) the body's x, y and z in the laboratory, rows of four; from it
    velocity: np.ndarray  # half a step behind [m/s]
    momentum: np.ndarray  # angular, in the laboratory, half a step behind [kg m2/s]
    velocity_now: np.ndarray  # extrapolated to the time of the position [m/s]
    momentum_now: np.ndarray  # likewise [kg m2/s]
    spin_now: np.ndarray  # likewise [rad/s]
    force: np.ndarray  # on the body in this step [N]
    torque: np.ndarray  # about the centroid [N m]
    inverse_mass: np.ndarray  # (n,) [1/kg]
    heat: np.ndarray  # (m + 1,) of each sphere, half of what its contacts dissipated [J]


class BodyPairs(NamedTuple):
    """Pairs of bodies i < j whose balls are near, ascending."""

    i: np.ndarray  # (capacity,) uint32
    j: np.ndarray  # (capacity,) uint32
    direction: np.ndarray  # (capacity, 4) unit vector from i to j across which they were seen last
    free: np.ndarray  # (capacity,) a gap that they have at least [m]
    first: np.ndarray  # (n + 1,) where the pairs of each body i begin
    old_j: np.ndarray  # the previous list, while a new one is made
    old_direction: np.ndarray
    old_free: np.ndarray
    old_first: np.ndarray
    place: np.ndarray  # (n, 4) positions when the list was made [m]


class Kept(NamedTuple):
    """Histories of pairs in contact, while the list of pairs is made anew."""

    number: np.ndarray  # (1,) how many
    key: np.ndarray  # (capacity,) see pairs.key_of; ascending
    history: np.ndarray  # (capacity, N_HISTORY)


class Seen(NamedTuple):
    """Positions of the particles when a list was made."""

    place: np.ndarray  # (n, 4) [m]
    turn: np.ndarray  # (n, 4) orientation
    leeway: np.ndarray  # (n,) how far a body may go before the list no longer holds [m]
    drift: np.ndarray  # (4,) mean velocity then [m/s]; of walls: where they were [m]


class Scratch(NamedTuple):
    """Room for the search within a pair of bodies, and for the treatment of its contacts."""

    way: np.ndarray  # (n,) how far each body has come since the list was made [m]
    height: np.ndarray  # (2, K) how far each sphere of either body reaches along a direction [m]
    sphere: np.ndarray  # (2, k) those that may be near the other body
    centre: np.ndarray  # (2, 4, k) their centres and radii [m], from the first body's centroid
    gap: np.ndarray  # (k,) of one of them to all of the other body [m]
    depth: np.ndarray  # (capacity,) overlap of each contact that touches [m]
    whole: np.ndarray  # (capacity, 2) Hertz constant and mass of each listed pair, before a share
    wall_whole: np.ndarray  # likewise of the contacts with walls
    listed: np.ndarray  # (m,) whether a sphere stands in a list


class ClusterWorld(NamedTuple):
    """Everything that the step loop works on; fields as in damper3d.engine.state.World."""

    shape: Shape
    bodies: Rigid
    spheres: Spheres
    active: np.ndarray  # (m,) uint32 spheres that stand in a list, ascending
    active_first: np.ndarray  # (n + 1,) where those of each body begin
    cells: Cells  # over the bodies; `largest` is the radius of a sphere
    near: BodyPairs
    close: Contacts
    close_seen: Seen
    wall: Contacts
    wall_seen: Seen
    kept: Kept
    scratch: Scratch
    walls: Walls
    block: Block
    counts: np.ndarray
    books: np.ndarray
    fastest: np.ndarray
    lengths: np.ndarray
    pair_law: Any
    wall_law: Any
    shaker: Any
    direction: np.ndarray
    gravity: np.ndarray
    time_step: float
    treatment: int
