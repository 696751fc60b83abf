"""Shapes of particles of many spheres: one of all, or those of particles that are not alike.

The type says which, and the kernels are compiled for it: what is alike in all particles is no
array. Each name of the second part stands for the code that goes with the type.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from damper3d.engine.state import LANES, zeros
from granulab.contact.jit import inner, specialised

_ROUNDING = 1e-9  # by which moments may differ that are meant to be equal


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


Particles = Particle | Sequence[Particle]  # one, as which all are, or each of them


class Alike(NamedTuple):
    """The shape of all particles, in principal axes about the centroid."""

    offset: np.ndarray  # (k, 4) centre of each sphere, its radius [m]
    columns: np.ndarray  # (4, K) transposed; with as many that extend nowhere as fill vectors
    arm: float  # distance of the farthest centre from the centroid [m]
    inverse_inertia: np.ndarray  # (3,) of the principal moments [1/(kg m2)]
    odd: int  # the axis about which it is, or may be, as round as about no other


class Unlike(NamedTuple):
    """The shapes of particles that are not alike; those of one shape and size share its rows."""

    offset: np.ndarray  # as those of Alike, shape by shape
    columns: np.ndarray  # likewise
    arm: np.ndarray  # (n,)
    inverse_inertia: np.ndarray  # (n, 3)
    odd: np.ndarray  # (n,)
    row: np.ndarray  # (n,) of offset, where the spheres of a particle begin
    column: np.ndarray  # (n,) uint64, of columns, likewise
    n_columns: np.ndarray  # (n,) how many they are
    first: np.ndarray  # (n + 1,) number of the first sphere of a particle
    whose: np.ndarray  # (m,) uint32, particle of each sphere
    most: int  # largest number of spheres of a particle


def form_of(particles: Particles, density: float | np.ndarray) -> Alike | Unlike:
    """Shapes of particles; density [kg/m3] of all, or of each (n,)."""
    if isinstance(particles, Sequence):
        return _unlike(particles, np.broadcast_to(density, len(particles)))
    offset = _offset(particles)
    inverse_inertia, odd = _rotation(particles, float(density))
    return Alike(offset, _columns(offset), _arm(particles), inverse_inertia, odd)


def _unlike(particles: Sequence[Particle], density: np.ndarray) -> Unlike:
    shapes = list({id(one): one for one in particles}.values())
    number = {id(one): k for k, one in enumerate(shapes)}
    which = np.array([number[id(one)] for one in particles])
    tables = [_offset(one) for one in shapes]
    columns = [_columns(table) for table in tables]
    sizes = np.array([len(table) for table in tables])
    wide = np.array([table.shape[1] for table in columns])
    rotations = [_rotation(one, rho) for one, rho in zip(particles, density.tolist(), strict=True)]
    return Unlike(
        offset=_aligned(np.concatenate(tables)),
        columns=_aligned(np.concatenate(columns, axis=1)),
        arm=np.array([_arm(one) for one in shapes])[which],
        inverse_inertia=np.array([moments for moments, _ in rotations]),
        odd=np.array([odd for _, odd in rotations]),
        row=_begins(sizes)[which],
        column=_begins(wide)[which].astype(np.uint64),
        n_columns=wide[which],
        first=np.append(_begins(sizes[which]), sizes[which].sum()),
        whose=np.repeat(np.arange(len(particles)), sizes[which]).astype(np.uint32),
        most=int(sizes.max()),
    )


def _begins(sizes: np.ndarray) -> np.ndarray:
    return np.cumsum(sizes) - sizes


def _aligned(rows: np.ndarray) -> np.ndarray:
    """The same array, at the beginning of a cache line."""
    copy = zeros(*rows.shape)
    copy[:] = rows
    return copy


def _offset(particle: Particle) -> np.ndarray:
    offset = zeros(len(particle.radii), 4)
    offset[:, :3], offset[:, 3] = particle.offsets, particle.radii
    return offset


def _columns(offset: np.ndarray) -> np.ndarray:
    """Rows of spheres as columns, and more of them, which extend nowhere, to a whole of LANES."""
    columns = zeros(4, whole(len(offset)))
    columns[3] = -np.inf
    columns[:, : len(offset)] = offset.T
    return columns


def whole(k: int) -> int:
    """The next multiple of LANES."""
    return -(-k // LANES) * LANES


def _arm(particle: Particle) -> float:
    return float(np.linalg.norm(particle.offsets, axis=1).max())


def _rotation(particle: Particle, density: float) -> tuple[np.ndarray, int]:
    """Inverse principal moments (3,) [1/(kg m2)], and the odd axis."""
    inertia = density * np.asarray(particle.inertia, float)
    # The axis whose two others have the most equal moments.
    spread = [abs(inertia[(k + 1) % 3] - inertia[(k + 2) % 3]) for k in range(3)]
    odd = int(np.argmin(spread))
    others = [(odd + 1) % 3, (odd + 2) % 3]
    if abs(inertia[others[0]] - inertia[others[1]]) <= _ROUNDING * inertia.max():
        inertia[others] = inertia[others].mean()  # then its free rotation is exact
    return 1.0 / inertia, odd


def first_spheres(form: Alike | Unlike, n: int) -> np.ndarray:
    """Number of the first sphere of each of n particles, and of all spheres (n + 1,)."""
    return form.first if isinstance(form, Unlike) else len(form.offset) * np.arange(n + 1)


def rows_of_spheres(form: Alike | Unlike, n: int) -> np.ndarray:
    """Row of `offset` of each sphere of n particles (m,)."""
    if isinstance(form, Alike):
        return np.tile(np.arange(len(form.offset)), n)
    return np.arange(len(form.whose)) + (form.row - form.first[:-1])[form.whose]


# By the type of the form.


def first_sphere(form, b):
    """Return the number of the first sphere of particle b; of one after the last, of all."""


def first_row(form, b):
    """Return the row of `offset` where the spheres of particle b begin."""


def columns_of(form, b):
    """Return the column where those of particle b begin, and how many they are."""


def farthest_centre(form, b):
    """Distance of the farthest centre of particle b from its centroid [m]."""


def rotation_of(form, b):
    """Inverse principal moments (3,) of particle b [1/(kg m2)], and its odd axis."""


def key_of(form, n, i, j):
    """Return a number by which pairs of spheres of n particles ascend: by particles, by sphere."""


def pair_mass(form, spheres, i, j):
    """Reduced mass of the particles of two spheres [kg]."""


def _are_alike(form: Any) -> bool:
    return form.instance_class is Alike


@specialised(first_sphere)
def _first_sphere(form, b):
    if _are_alike(form):
        return lambda form, b: b * len(form.offset)
    return lambda form, b: form.first[b]


@specialised(first_row)
def _first_row(form, b):
    if _are_alike(form):
        return lambda form, b: np.int64(0)
    return lambda form, b: form.row[b]


@specialised(columns_of)
def _columns_of(form, b):
    if _are_alike(form):
        return lambda form, b: (np.uintp(0), np.int64(form.columns.shape[1]))
    return lambda form, b: (form.column[b], form.n_columns[b])


@specialised(farthest_centre)
def _farthest_centre(form, b):
    if _are_alike(form):
        return lambda form, b: form.arm
    return lambda form, b: form.arm[b]


@specialised(rotation_of)
def _rotation_of(form, b):
    if _are_alike(form):
        return lambda form, b: (form.inverse_inertia, form.odd)
    return lambda form, b: (form.inverse_inertia[b], form.odd[b])


@specialised(key_of)
def _key_of(form, n, i, j):
    if _are_alike(form):
        return lambda form, n, i, j: _key_of_alike(len(form.offset), n, i, j)
    return lambda form, n, i, j: key_of_pair(
        form.most, n, np.int64(form.whose[i]), i - form.first[form.whose[i]],
        np.int64(form.whose[j]), j - form.first[form.whose[j]],
    )  # fmt: skip


@inner
def _key_of_alike(k, n, i, j):
    a, b = np.int64(i) // k, np.int64(j) // k
    return key_of_pair(k, n, a, i - a * k, b, j - b * k)


@inner
def key_of_pair(most, n, a, p, b, q):
    """Key of sphere p of particle a and q of b, which have at most so many; n particles."""
    return ((a * n + b) * most + p) * most + q


@specialised(pair_mass)
def _pair_mass(form, spheres, i, j):
    if _are_alike(form):
        return lambda form, spheres, i, j: 0.5 / spheres.inverse_mass[0]
    return lambda form, spheres, i, j: 1.0 / (spheres.inverse_mass[i] + spheres.inverse_mass[j])
