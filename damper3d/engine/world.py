"""Builds the arrays of a world from spheres, an enclosure, laws and motion; makes lists longer."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from damper3d.engine import state
from damper3d.engine.enclosures import Enclosure
from damper3d.engine.state import Block, Bodies, Cells, Contacts, Near, Spheres, Walls, World
from granulab.contact.hertz import HertzLaw

_FIRST_SKIN = 0.01  # close skin over the largest radius, before it follows the speed
_LINE = 8  # numbers in a line of the cache
_WIDEST_NEAR_SKIN = 0.3  # of the near skin over the largest radius, for which the cells are made


def build_world(
    positions: np.ndarray,
    radii: np.ndarray,
    *,
    density: float,
    enclosure: Enclosure,
    pair_law: HertzLaw,
    wall_law: HertzLaw,
    shaker: Any,
    direction: np.ndarray,
    gravity: np.ndarray,
    time_step: float,
    curved_wall: bool = False,
) -> World:
    """A world of n solid spheres at rest in an enclosure that is about to move.

    positions (n, 3) in the enclosure's frame [m]; radii (n,) [m]; density [kg/m3]; shaker: the
    numbers of a registered motion, along the unit vector direction (3,); gravity (3,) [m/s2];
    time_step [s].
    """
    n, largest = len(positions), float(radii.max())
    mass = density * 4.0 / 3.0 * math.pi * radii**3
    spheres = spheres_of(radii, mass)
    spheres.position[:n, :3] = positions
    return World(
        bodies=_bodies(radii, mass),
        spheres=spheres,
        cells=cells_over(enclosure, n, largest),
        near=_near(n, 16 * n + 64),
        close=contacts_with_room(n, 8 * n + 64),
        wall=contacts_with_room(n, 8 * (n // 2) + 64),
        walls=walls_of(enclosure, n, curved_wall),
        block=block(),
        counts=first_counts(),
        books=np.zeros(state.N_BOOKS),
        fastest=np.zeros(2),
        lengths=first_skins(largest),
        pair_law=pair_law,
        wall_law=wall_law,
        shaker=shaker,
        direction=padded(direction),
        gravity=padded(gravity),
        time_step=time_step,
    )


def spheres_of(radii: np.ndarray, mass: np.ndarray) -> Spheres:
    """Spheres at the origin and at rest; mass (n,) is that of the body of each [kg]."""
    n = len(radii)
    rows = ("position", "velocity", "spin", "force", "torque")
    spheres = Spheres(**{name: zeros(n + 1, 4) for name in rows}, inverse_mass=1.0 / mass)
    spheres.position[:n, 3] = radii
    return spheres


def _bodies(radii: np.ndarray, mass: np.ndarray) -> Bodies:
    n = len(radii)
    return Bodies(
        velocity=zeros(n, 4),
        spin=zeros(n, 4),
        inverse_mass=1.0 / mass,
        inverse_inertia=1.0 / (0.4 * mass * radii**2),
        heat=np.zeros(n + 1),
    )


def walls_of(enclosure: Enclosure, n: int, curved: bool) -> Walls:
    """The walls of an enclosure that n spheres may touch and none does yet."""
    n_walls = len(enclosure.wall_names)
    return Walls(
        planes=enclosure.planes,
        surface=enclosure.surface,
        drive=None,
        curved=curved,
        first=np.zeros(n_walls + 1, np.int64),
        force=np.zeros((n_walls, 3)),
        history=no_history(n_walls, n),
    )


def first_counts() -> np.ndarray:
    """The counts of a world whose lists are still to be made."""
    counts = np.zeros(state.N_COUNTS, np.int64)
    counts[[state.STALE_CLOSE, state.STALE_WALL]] = 1
    return counts


def first_skins(largest: float) -> np.ndarray:
    """The lengths of such a world, from the radius of its largest sphere [m]."""
    skins = np.zeros(state.N_LENGTHS)
    skins[[state.CLOSE_SKIN, state.WALL_SKIN]] = _FIRST_SKIN * largest
    skins[state.NEAR_SKIN] = -1.0  # no list yet: its reach is used up
    return skins


def padded(vector: np.ndarray) -> np.ndarray:
    """A vector (3,) as the kernels load it, (4,)."""
    return np.append(np.asarray(vector, float), 0.0)


def zeros(*shape: int) -> np.ndarray:
    """Zeros that begin at a cache line: what lies across two of them costs double to load."""
    size = math.prod(shape)
    room = np.zeros(size + _LINE)
    begin = (-room.ctypes.data // room.itemsize) % _LINE
    return room[begin : begin + size].reshape(shape)


def no_history(*shape: int) -> np.ndarray:
    """Histories of contacts that there are not."""
    history = zeros(*shape, state.N_HISTORY)
    history[..., state.DAMPING] = state.NO_CONTACT
    return history


def cells_over(enclosure: Enclosure, n: int, largest: float) -> Cells:
    """Cells over the enclosure that are wide enough for the widest near skin."""
    size = (2.0 + _WIDEST_NEAR_SKIN) * largest
    inside = (enclosure.width, enclosure.depth, enclosure.height)
    a, b, c = (max(math.ceil(length / size), 1) for length in inside)
    return Cells(
        start=np.zeros(a * b * c + 2, np.int64),
        spheres=np.zeros(n, np.int64),
        of_sphere=np.zeros(n, np.int64),
        size=size,
        shape=(a, b, c),
        origin=(-0.5 * enclosure.width, -0.5 * enclosure.depth, 0.0),
        largest=largest,
    )


def _near(n: int, capacity: int) -> Near:
    return Near(
        i=np.zeros(capacity, np.uint32),
        j=np.zeros(capacity, np.uint32),
        reach=zeros(capacity),
        hertz=zeros(capacity),
        mass=zeros(capacity),
        gap=zeros(capacity),
        history=no_history(capacity),
        first=np.zeros(n + 1, np.int64),
        old_j=np.zeros(capacity, np.uint32),
        old_history=no_history(capacity),
        old_first=np.zeros(n + 1, np.int64),
        place=zeros(n, 4),
    )


def block() -> Block:
    """Room for the passes over a block of contacts."""
    vectors = ("separation", "passing", "turning", "spin", "normal", "velocity", "push", "couple")
    rows = dict.fromkeys(vectors, 3) | dict.fromkeys(("history", "later"), state.N_HISTORY)
    rows["constants"] = state.N_CONSTANTS
    return Block(**{name: zeros(rows.get(name, 1) * state.BLOCK) for name in Block._fields})


def contacts_with_room(n: int, capacity: int) -> Contacts:
    """An empty list of contacts of n spheres."""
    return Contacts(
        i=np.zeros(capacity, np.uint32),
        j=np.zeros(capacity, np.uint32),
        near=np.zeros(capacity, np.uint32),
        reach=zeros(capacity),
        constants=zeros(capacity, state.N_CONSTANTS),
        history=no_history(capacity),
        touching=np.zeros(capacity, np.uint32),
        place=zeros(n, 4),
        drift=np.zeros(4),
    )


def roomier(world: World, lists: str) -> World:
    """The world with a list, "near", "close" or "wall", of twice the capacity."""
    old = getattr(world, lists)
    capacity = 2 * len(old.i)
    make: Callable[[int, int], Any] = _near if lists == "near" else contacts_with_room
    return world._replace(**{lists: refilled(make(len(world.near.place), capacity), old)})


def refilled(new: Any, old: Any) -> Any:
    """Arrays that are longer, with what the old ones hold."""
    for longer, array in zip(new, old, strict=True):
        longer[tuple(slice(0, size) for size in array.shape)] = array
    return new
