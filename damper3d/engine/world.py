"""Builds the arrays of a world from particles, an enclosure, laws and motion; lengthens lists."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from damper3d.engine import state
from damper3d.engine.enclosures import Enclosure
from damper3d.engine.enclosures.cavity import PLACES, Triangles
from damper3d.engine.laws.table import LawTable, rolls
from damper3d.engine.multisphere import particles as many_spheres
from damper3d.engine.multisphere.form import Particles, first_spheres, form_of, rows_of_spheres
from damper3d.engine.multisphere.particles import ManySpheres, most_spheres, of_each
from damper3d.engine.spheres import particles as one_sphere
from damper3d.engine.state import (
    Block,
    Cells,
    Contacts,
    Kept,
    OuterList,
    Seen,
    Spheres,
    Walls,
    World,
    no_history,
    zeros,
)
from granulab.contact.compiled import parts
from granulab.contact.hertz import HertzLaw

_FIRST_SKIN = 0.01  # inner skin over the largest radius, before it follows the speed
# Particles of a part at least, twice as many at most; of spheres, and of such with many. A bed of
# fewer than _WHOLE spheres is one part: its sums stay as they were before there were parts.
_PART_OF_SPHERES, _PART_OF_MANY, _WHOLE = 64, 8, 512
_WIDEST_OUTER_SKIN = 0.3  # of the outer skin over the bounding radius, for which cells are made
_CELLS, _FEW_CELLS = 4, 1000  # at most so many a particle, and these: as in a bed that fills 0.1
_WIDER = 1.25  # how much wider cells are made at a time where there would be more

# Shape, particles, spheres; the largest radius of a sphere round a particle; capacities of lists.
_Made = tuple[Any, Any, Spheres, float, dict[str, int]]


def build_world(
    positions: np.ndarray,
    particle: np.ndarray | Particles,
    orientations: np.ndarray | None = None,
    *,
    density: float | np.ndarray,
    enclosure: Enclosure,
    pair_law: HertzLaw | LawTable,
    wall_law: HertzLaw | LawTable,
    shaker: Any,
    direction: np.ndarray,
    gravity: np.ndarray,
    time_step: float,
    curved_wall: bool = False,
    treatment: str = "sum",
    yields: Sequence[float] = (math.nan, math.nan),
) -> World:
    """A world of n particles at rest in an enclosure that is about to move.

    positions (n, 3) in the enclosure's frame [m]; particle: radii (n,) of solid spheres [m], or a
    multi-sphere particle, as which all are, or each of them, in a list; orientations (n, 4) of
    such, unit quaternions (w, x, y, z), of no rotation if left out; density [kg/m3], of unlike
    particles also (n,); laws: a HertzLaw each, or the same LawTable twice, by the kind of each
    sphere; shaker: the numbers of a registered motion, along the unit vector direction (3,);
    gravity (3,) [m/s2]; time_step [s]; treatment of several contacts of two particles: one of
    multisphere.particles.TREATMENTS; yields: velocity beyond which impacts of particles, and at
    walls, are counted [m/s].
    """
    n = len(positions)
    if isinstance(particle, np.ndarray):
        made = _one_sphere_each(positions, particle, density, getattr(pair_law, "halo", 0.0))
    else:
        made = _many_spheres_each(positions, orientations, particle, density, treatment)
    shape, particles, spheres, bounding, room = made
    largest, m = float(spheres.position[:, 3].max()), len(spheres.inverse_mass)
    built = World(
        shape=shape,
        particles=particles,
        spheres=spheres,
        cells=_cells_over(enclosure, n, bounding, largest),
        **_empty_lists(n, shape, rolls(pair_law)),
        walls=walls_of(enclosure, m, curved_wall, bounding, rolls(wall_law)),
        block=block(),
        counts=_first_counts(),
        **in_parts(parts_of(n, many=not isinstance(particle, np.ndarray))),
        balance=np.zeros(state.N_BALANCE),
        impacts=np.column_stack([np.zeros((2, state.YIELD)), yields]),
        lengths=_first_skins(largest),
        pair_law=pair_law,
        wall_law=wall_law,
        shaker=shaker,
        direction=_padded(direction),
        gravity=_padded(gravity),
        time_step=time_step,
    )
    built = with_capacities(built, outer=16 * n + 64, **room)
    kind_of(built).settle(built)
    return built


def _one_sphere_each(
    positions: np.ndarray, radii: np.ndarray, density: float | np.ndarray, halo: float
) -> _Made:
    n, particles = len(radii), one_sphere.at_rest(radii, density)
    spheres = _spheres(radii + halo, particles.inverse_mass)
    spheres.position[:n, :3] = positions
    room = {"inner": 8 * n + 64, "wall": 8 * (n // 2) + 64}
    bounding = float(spheres.position[:, 3].max())
    return one_sphere.known_pairs(0), particles, spheres, bounding, room


def _many_spheres_each(
    positions: np.ndarray, orientations: np.ndarray | None, particles: Particles,
    density: float | np.ndarray, treatment: str,
) -> _Made:  # fmt: skip
    n, form = len(positions), form_of(particles, density)
    mass = density * of_each(particles, n, lambda one: one.volume)
    first, radii = first_spheres(form, n), form.offset[rows_of_spheres(form, n), 3]
    made = many_spheres.at_rest(positions, orientations, particles, mass, int(first[-1]))
    spheres = _spheres(radii, np.repeat(made.inverse_mass, np.diff(first)))
    room = dict.fromkeys(("inner", "wall"), 16 * n + 16 * most_spheres(form) + 64)
    bounding = float(made.position[:, 3].max())
    return many_spheres.shape_of(form, n, treatment), made, spheres, bounding, room


def _empty_lists(n: int, shape: Any, rolling: bool) -> dict[str, Any]:
    """The fields of a world that are lists of n particles, and what goes with them."""
    return {
        "outer": _outer(n, 0),
        "inner": empty_contacts(0, rolling),
        "inner_seen": _seen(n, shape),
        "wall": empty_contacts(0, rolling),
        "wall_seen": _seen(n, shape),
        "kept": _kept(0, rolling),
    }


def kind_of(world: World) -> Any:
    """Return the module of the particles of a world: spheres.particles, multisphere.particles."""
    return many_spheres if isinstance(world.shape, ManySpheres) else one_sphere


def with_capacities(world: World, **capacities: int) -> World:
    """The world whose lists "outer", "inner" and "wall" have such capacities, where they are named.

    What they hold is kept.
    """
    n = len(world.outer.made_at)
    shape, made, rolling = world.shape, {}, world.kept.rolling is not None
    for lists, capacity in capacities.items():
        if lists == "outer":
            made[lists] = _refilled(_outer(n, capacity), world.outer)
            known = kind_of(world).known_pairs(capacity)
            if isinstance(shape, ManySpheres):
                shape = shape._replace(pairs=_refilled(known, shape.pairs))
            else:
                shape = _refilled(known, shape)
        else:
            made[lists] = _refilled(empty_contacts(capacity, rolling), getattr(world, lists))
    world = world._replace(**made)
    room = len(world.inner.i)
    if isinstance(shape, ManySpheres):
        depth = np.zeros(max(room, len(world.wall.i)))
        shape = shape._replace(scratch=shape.scratch._replace(depth=depth))
    return world._replace(shape=shape, kept=_refilled(_kept(room, rolling), world.kept))


def lengthened(world: World, lists: str) -> World:
    """The world with a list, "outer", "inner" or "wall", of twice the capacity."""
    return with_capacities(world, **{lists: 2 * len(getattr(world, lists).i)})


def _refilled(new: Any, old: Any) -> Any:
    """Arrays with what old ones hold, of another length, as far as there is room for it."""
    for other, array in zip(new, old, strict=True):
        if other is None:
            continue
        common = tuple(slice(0, min(a, b)) for a, b in zip(other.shape, array.shape, strict=True))
        other[common] = array[common]
    return new


def _spheres(radii: np.ndarray, inverse_mass: np.ndarray) -> Spheres:
    """Spheres at the origin and at rest; inverse_mass (m,) is that of the particle of each."""
    m = len(radii)
    spheres = Spheres(
        *(zeros(m + 1, 4) for _ in range(3)),
        *(zeros(m + 1 + state.UNREAD, 4) for _ in range(2)),
        inverse_mass=inverse_mass,
    )
    spheres.position[:m, 3] = radii
    return spheres


def walls_of(enclosure: Enclosure, m: int, curved: bool, bounding: float, rolling: bool) -> Walls:
    """The walls of an enclosure that m spheres may touch and none does yet.

    bounding: radius of the largest particle [m].
    """
    n_walls, surface = len(enclosure.wall_names), enclosure.surface_for(bounding)
    if isinstance(surface, Triangles):  # worlds share the cells, and nothing that is written to
        surface = surface._replace(
            held=np.full((m, PLACES), -1, np.int32), number=surface.number.copy(),
            distance=surface.distance.copy(), normal=surface.normal.copy(),
        )  # fmt: skip
    return Walls(
        planes=enclosure.planes,
        surface=surface,
        drive=None,
        curved=curved,
        first=np.zeros(n_walls + 1, np.int64),
        force=np.zeros((n_walls, 3)),
        history=no_history(PLACES if isinstance(surface, Triangles) else n_walls, m),
        rolling=zeros(n_walls * m, state.N_ROLLING) if rolling else None,
    )


def parts_of(n: int, many: bool) -> np.ndarray:
    """Bounds of the parts of n particles (n_parts + 1,); many: each has many spheres."""
    most = n // _PART_OF_MANY if many else n // _PART_OF_SPHERES * (n >= _WHOLE)
    return parts.parts_of(n, most)


def in_parts(bounds: np.ndarray) -> dict[str, np.ndarray]:
    """Fields of a world whose particles are in parts with these bounds (n_parts + 1,)."""
    return {
        "parts": bounds,
        "first_pair": np.zeros(len(bounds), np.int64),
        "packed": np.zeros(len(bounds) - 1, np.bool_),
    }


def _first_counts() -> np.ndarray:
    """The counts of a world whose lists are still to be made."""
    counts = np.zeros(state.N_COUNTS, np.int64)
    counts[[state.STALE_INNER, state.STALE_WALL]] = 1
    return counts


def _first_skins(largest: float) -> np.ndarray:
    """The lengths of such a world, from the radius of its largest sphere [m]."""
    skins = np.zeros(state.N_LENGTHS)
    skins[[state.INNER_SKIN, state.WALL_SKIN]] = _FIRST_SKIN * largest
    skins[state.OUTER_SKIN] = -1.0  # no list yet: its cutoff is used up
    return skins


def _padded(vector: np.ndarray) -> np.ndarray:
    """A vector (3,) as the kernels load it, (4,)."""
    return np.append(np.asarray(vector, float), 0.0)


def _cells_over(enclosure: Enclosure, n: int, bounding: float, largest: float) -> Cells:
    """Cells over the enclosure that are wide enough for the widest outer skin.

    Wider where few particles have much room: a few cells a particle, not the volume over its own.
    """
    size = (2.0 + _WIDEST_OUTER_SKIN) * bounding
    inside = (enclosure.width, enclosure.depth, enclosure.height)
    while True:
        a, b, c = (max(math.ceil(length / size), 1) for length in inside)
        if a * b * c <= _CELLS * n + _FEW_CELLS:
            break
        size *= _WIDER
    return Cells(
        start=np.zeros(a * b * c + 2, np.int64),
        members=np.zeros(n, np.int64),
        place=zeros(n, 4),
        home=np.zeros(n, np.int64),
        size=size,
        shape=(a, b, c),
        origin=(-0.5 * enclosure.width, -0.5 * enclosure.depth, 0.0),
        largest=largest,
    )


def _outer(n: int, capacity: int) -> OuterList:
    i, j = np.zeros(capacity, np.uint32), np.zeros(capacity, np.uint32)
    return OuterList(i, j, now=zeros(n, 4), made_at=zeros(n, 4))


def _seen(n: int, shape: Any) -> Seen:
    turns = n if isinstance(shape, ManySpheres) else 0
    return Seen(
        position=zeros(n, 4), orientation=zeros(turns, 4), margin=np.zeros(n), drift=np.zeros(4)
    )


def _kept(capacity: int, rolling: bool) -> Kept:
    return Kept(
        number=np.zeros(1, np.int64),
        key=np.zeros(capacity, np.int64),
        history=zeros(capacity, state.N_HISTORY),
        rolling=zeros(capacity, state.N_ROLLING) if rolling else None,
    )


def block() -> Block:
    """Room for the passes over a block of contacts."""
    vectors = (
        "separation",
        "relative_velocity",
        "rim_velocity",
        "angular_velocity",
        "normal",
        "velocity",
        "push",
        "couple",
    )
    rows = dict.fromkeys(vectors, 3) | dict.fromkeys(("history", "next_history"), state.N_HISTORY)
    rows["constants"] = state.N_CONSTANTS
    made = {name: zeros(rows.get(name, 1) * state.BLOCK) for name in Block._fields}
    sums = {name: zeros(state.N_MECHANISMS) for name in ("totals", "own_totals")}
    return Block(**made | sums)


def empty_contacts(capacity: int, rolling: bool = False) -> Contacts:
    """An empty list of contacts; rolling: which resist it."""
    return Contacts(
        i=np.zeros(capacity, np.uint32),
        j=np.zeros(capacity, np.uint32),
        group=np.zeros(capacity, np.uint32),
        cutoff=zeros(capacity),
        constants=zeros(capacity, state.N_CONSTANTS),
        whole=zeros(capacity, 2),
        history=no_history(capacity),
        rolling=zeros(capacity, state.N_ROLLING) if rolling else None,
        touching=np.zeros(capacity, np.uint32),
        feature=np.zeros(capacity, np.uint32),
    )
