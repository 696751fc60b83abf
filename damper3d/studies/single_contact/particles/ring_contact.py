"""Contact of an axisymmetric body with a flat wall: pressed, and then shifted against friction.

Signorini's law across, Coulomb's along the wall, |t| <= mu p in every direction at every point. As
for Mindlin's contacts the pressure of the normal load stays while the body is shifted (Goodman's
assumption; Johnson 1985, sec. 7.4): p is the same all round the ring, and the tangential tractions

    t_r = sum of t_rm cos(m t),   t_t = sum of t_tm sin(m t),   m = 1, 3, 5, ...

are known in a quarter of it. `tilt` says what the assumption leaves out.
"""

import math
from typing import NamedTuple

import numpy as np

from damper3d.studies.single_contact.particles.axisymmetric_fe import Body, yielding

_ROUNDS = 20_000  # of the iteration for one step of friction
_SETTLED = 1e-9  # largest change of a force in a round over the mean limit of friction


class Contact(NamedTuple):
    """A body that is pressed on a wall by an overlap; n points touch."""

    touching: np.ndarray  # (n,) which of the surfaces' points
    pressure: np.ndarray  # (n,) normal force of each [N/rad]
    width: float  # of the ring that touches, or radius of the circle [m]

    @property
    def force(self) -> float:
        """Normal force of the whole contact [N]."""
        return float(2.0 * math.pi * self.pressure.sum())


def press(bodies: tuple[Body, ...], overlap: float) -> Contact:
    """Press a body on a wall, or (body,) on a rigid one, by an overlap [m].

    Points of the surfaces face each other. The points that touch are found by an active set.
    """
    soft = _together(bodies, 0)[2][:, 2]
    r, z = bodies[0].places
    needed = overlap - (z - z.min())  # how far the surfaces must yield where they touch
    touching = needed > 0.0
    while True:
        forces = np.zeros(len(r))
        forces[touching] = np.linalg.solve(soft[np.ix_(touching, touching)], needed[touching])
        now = (forces > 0.0) | (~touching & (needed - soft @ forces > 1e-9 * overlap))
        if np.array_equal(now, touching):
            points = np.flatnonzero(touching)
            return Contact(points, forces[points], float(np.ptp(r[points])))
        touching = now


def _together(bodies: tuple[Body, ...], harmonic: int) -> np.ndarray:
    """Yielding of all bodies, (3, n, 3, n) [m rad/N]: that of one towards the other."""
    return np.sum([yielding(body, harmonic) for body in bodies], axis=0)


class Quarter(NamedTuple):
    """A quarter of the ring in k directions, and how it yields; n points across touch."""

    angles: np.ndarray  # (k,) of the directions from x [rad]
    soft: np.ndarray  # displacements by forces, each (r or t, point, direction), (2nk, 2nk)
    shift: np.ndarray  # displacements of a shift of 1 along x, (2, n, k) [-]
    limit: np.ndarray  # mu p [N/rad], (n, k)

    def force(self, forces: np.ndarray) -> float:
        """Tangential force along x [N] of forces (2, n, k) [N/rad] on all four quarters."""
        return float(2.0 * math.pi / len(self.angles) * (self.shift * forces).sum())


def yields(bodies: tuple[Body, ...], contact: Contact, count: int) -> list[np.ndarray]:
    """Yielding of what touches in the wall's plane by the odd harmonics 1 ... 2 count - 1.

    Each (2, n, 2, n) [m rad/N]: displacement (u or v) of a point by force (r or t) on a point.
    """
    points = contact.touching
    whole = (_together(bodies, m) for m in range(1, 2 * count, 2))
    return [own[:2][:, points][:, :, :2][..., points] for own in whole]


def quarter(contact: Contact, friction: float, own: list[np.ndarray]) -> Quarter:
    """The contact in as many directions as harmonics, whose yielding is given (`yields`).

    With angles (k + 1/2) pi/(2 K) the odd harmonics up to 2 K - 1 are orthogonal (DCT and DST IV).
    """
    n, count = len(contact.touching), len(own)
    angles = (np.arange(count) + 0.5) * math.pi / (2 * count)
    soft = np.zeros((2, n, count, 2, n, count))
    for k, one in enumerate(own):
        waves = np.array([np.cos((2 * k + 1) * angles), np.sin((2 * k + 1) * angles)])
        soft += 2.0 / count * np.einsum("aibj,ak,bl->aikbjl", one, waves, waves)
    shift = np.stack([np.cos(angles), -np.sin(angles)])
    size = 2 * n * count
    return Quarter(
        angles, soft.reshape(size, size), np.repeat(shift[:, None], n, axis=1),
        friction * np.repeat(contact.pressure[:, None], count, axis=1),
    )  # fmt: skip


def stick_stiffness(here: Quarter) -> float:
    """Tangential stiffness before any of it slides [N/m]."""
    forces = np.linalg.solve(here.soft, here.shift.ravel())
    return here.force(forces.reshape(here.shift.shape))


def shear(here: Quarter, shifts: np.ndarray) -> np.ndarray:
    """Tangential forces (k,) [N] at shifts (k,) [m] that rise from 0.

    In each step friction dissipates most: the forces t minimise t.W t/2 - t.(s - d) in the discs
    |t| <= mu p, with the yielding W, the shift s and the slip d of the step before. Solved by
    accelerated projected gradients (Beck and Teboulle 2009, SIAM J. Imaging Sci. 2, 183).
    Raises ArithmeticError where that does not settle.
    """
    forces, slip = np.zeros_like(here.shift), np.zeros_like(here.shift)
    step = 1.0 / np.linalg.eigvalsh(here.soft)[-1]
    found = []
    for shift in shifts:
        wanted = shift * here.shift - slip
        forces = _settled(here, wanted, forces, step)
        slip += wanted - (here.soft @ forces.ravel()).reshape(forces.shape)
        found.append(here.force(forces))
    return np.array(found)


def _settled(here: Quarter, wanted: np.ndarray, forces: np.ndarray, step: float) -> np.ndarray:
    """Forces (2, n, k) of one step, from those of the step before."""
    ahead, momentum, small = forces, 1.0, _SETTLED * here.limit.mean()
    for _ in range(_ROUNDS):
        lacking = wanted - (here.soft @ ahead.ravel()).reshape(ahead.shape)
        trial = ahead + step * lacking
        size = np.hypot(*trial)
        new = trial * (here.limit / np.maximum(size, here.limit))
        change = new - forces
        if np.abs(change).max() < small:
            return new
        if (change * (ahead - new)).sum() > 0.0:  # overshot: begin anew (O'Donoghue, Candes 2015)
            momentum = 1.0
        grown = 0.5 * (1.0 + math.sqrt(1.0 + 4.0 * momentum**2))
        ahead, forces = new + (momentum - 1.0) / grown * change, new
        momentum = grown
    raise ArithmeticError(f"friction did not settle in {_ROUNDS} rounds")


def tilt(bodies: tuple[Body, ...], contact: Contact, friction: float) -> float:
    """Normal displacement by the tractions mu p of gross sliding over that by the pressure [-].

    The largest of the ring, where it is sheared across: what Goodman's assumption leaves out.
    """
    points = contact.touching
    pushed = np.array([1.0, -1.0])[:, None] * friction * contact.pressure
    first = _together(bodies, 1)[2][points][:, :2][..., points]
    pressed = _together(bodies, 0)[2][points][:, 2][..., points] @ contact.pressure
    return float(np.abs(np.einsum("iaj,aj->i", first, pushed)).max() / pressed.max())
