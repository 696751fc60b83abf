"""Objects on strings that collide, integrated: the truth behind made tracks and rendered films.

    theta'' = -(g/L) sin theta - 2 beta theta',   tau'' = -(g/L) tau - 2 beta tau'

theta is the angle in the plane of the swing, tau a small one out of it. Contacts take no time, and
act in the plane. Picture coordinates: x to the right, y down.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_G = 9.80665  # m/s2

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Strings:
    """One ball against a wall, or two blocks, on strings; the first is let go.

    length       of a string, to the object's centre [m]
    angle        of the first when it is let go [deg], to the left
    restitution  of all contacts
    mass_ratio   second block's mass over the first's; None for a ball against a wall
    offset       of the wall's contact from the lowest point, to the right [m]
    beta         damping by air [1/s]
    release      when it is let go [s]
    aside        largest angle out of the plane [deg]
    contacts     that are computed
    """

    length: float = 0.5
    angle: float = 25.0
    restitution: float = 0.7
    mass_ratio: float | None = None
    offset: float = 0.0
    beta: float = 0.0
    release: float = 0.21
    aside: float = 0.0
    contacts: int = 8

    @property
    def objects(self) -> int:
        """One or two."""
        return 1 if self.mass_ratio is None else 2


@dataclass(frozen=True)
class Swinging:
    """The motion of Strings.

    contacts   (n,) times [s]
    pieces     angles and their rates at times, from the release and from each contact on
    """

    strings: Strings
    contacts: Array
    pieces: tuple[Callable[[Array], Array], ...]

    def angles(self, time: Array) -> Array:
        """(b, n) in the plane, rad, to the right, at (n,) times [s]."""
        one = self.strings
        found = np.empty((one.objects, len(time)))
        ends = [one.release, *self.contacts, np.inf]
        held = time < one.release
        found[:, held] = _at_rest(one)[: one.objects, None]
        for k, piece in enumerate(self.pieces):
            inside = (time >= ends[k]) & (time < ends[k + 1])
            if inside.any():
                found[:, inside] = piece(time[inside])[: one.objects]
        return found

    def out_of_plane(self, time: Array) -> Array:
        """(n,) angle out of the plane [rad], from the release on."""
        one, omega = self.strings, np.sqrt(_G / self.strings.length)
        s = np.maximum(time - one.release, 0.0)
        return np.asarray(np.radians(one.aside) * np.exp(-one.beta * s) * np.sin(omega * s))


def swing(strings: Strings) -> Swinging:
    """Integrate until one contact more than requested."""
    from scipy.integrate import solve_ivp

    start, b = strings.release, strings.objects
    state = np.concatenate([_at_rest(strings)[:b], np.zeros(b)])
    pieces, times = [], []
    longest = 3 * np.pi * np.sqrt(strings.length / _G)  # one and a half periods

    def gap(time: float, y: Array) -> float:
        return float(_gap(strings, y))

    gap.terminal, gap.direction = True, -1.0  # type: ignore[attr-defined]
    for _ in range(strings.contacts + 1):
        found = solve_ivp(
            lambda _, y: _rates(strings, y), (start, start + longest), state, events=gap,
            rtol=1e-10, atol=1e-12, dense_output=True, max_step=longest / 60,
        )  # fmt: skip
        pieces.append(found.sol)
        if not len(found.t_events[0]):
            break
        start, state = float(found.t[-1]), _after(strings, found.y[:, -1])
        times.append(start)
    return Swinging(strings, np.array(times[: strings.contacts]), tuple(pieces))


def _at_rest(strings: Strings) -> Array:
    """Angles before the release: the first is held, the second hangs."""
    return np.array([-np.radians(strings.angle), 0.0])


def _rates(strings: Strings, y: Array) -> Array:
    b = len(y) // 2
    pull = -_G / strings.length * np.sin(y[:b])
    return np.concatenate([y[b:], pull - 2 * strings.beta * y[b:]])


def _gap(strings: Strings, y: Array) -> float:
    """Positive before a contact, in angle; strings hang as far apart as the objects are wide."""
    if len(y) == 2:
        return float(np.arcsin(strings.offset / strings.length) - y[0])
    return float(y[1] - y[0])


def _after(strings: Strings, y: Array) -> Array:
    """Newton's restitution (eq. 3.4), and momentum."""
    y, e = y.copy(), strings.restitution
    if len(y) == 2:
        y[1] *= -e
        return y
    assert strings.mass_ratio is not None
    first = 1 / (1 + strings.mass_ratio)  # share of the mass
    common = first * y[2] + (1 - first) * y[3]
    closing = y[2] - y[3]
    y[2] = common - (1 - first) * e * closing
    y[3] = common + first * e * closing
    return y
