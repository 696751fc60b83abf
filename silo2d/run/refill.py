"""Refilling: particles are put at the lowest places of a bed's surface, and move as it does."""

import math

import numpy as np

from silo2d.case.case import GRAVITY
from silo2d.case.outline import Outline
from silo2d.engine import state
from silo2d.engine.simulation import Simulation

_COLUMNS = 4  # that are looked at, a radius of the largest particle
_NOTHING = 1e-12  # [m/s]
_CLEAR = 1.01  # distance of bounding circles, over the sum of their radii


class Surface:
    """The surface of a bed, and where on it a particle is put without touching anything.

    outline   of the silo, high enough for what is put on
    radius    largest bounding radius of the particles [m]
    drop      height [m] above the lowest place that is free at which a particle is put
    shaken    how far [m] the walls come from where they are drawn

    A particle is taken for its bounding circle. It comes to the lowest position that it could be
    let down to from the open top, so that the surface stays level and it falls next to nothing.
    """

    def __init__(
        self, outline: Outline, radius: float, drop: float = 0.0, shaken: float = 0.0
    ) -> None:
        from shapely import LineString

        self._radius, self._drop, self._top = radius, drop, outline.height - radius
        free = outline.inside.buffer(-_CLEAR * radius - shaken)
        left, bottom, right, top = free.bounds if not free.is_empty else (0.0,) * 4
        n = max(math.ceil(_COLUMNS * (right - left) / radius), 1) + 1
        self._x, floor = np.linspace(left, right, n), []
        for x in self._x:
            column = free.intersection(LineString([(x, bottom), (x, top)]))
            pieces = [piece.bounds for piece in getattr(column, "geoms", [column])]
            # A column counts where a particle could be let down in it from the top.
            open_above = [piece[1] for piece in pieces if piece and piece[3] >= top - 1e-9]
            floor.append(min(open_above, default=math.inf))
        self._floor = np.array(floor)

    def places(self, centres: np.ndarray, radii: np.ndarray, added: np.ndarray) -> np.ndarray:
        """Positions (m, 2) [m] for particles of bounding radii `added` (k,), m of them at most.

        centres (n, 2), radii (n,): bounding circles of those that are there [m]. As many of the
        first as there is room for below the open top.
        """
        largest = self._radius
        low = self._floor.copy()  # the lowest centre of a largest particle in each column
        for k in np.argsort(-centres[:, 1], kind="stable"):
            (x, y), far = centres[k], _CLEAR * (radii[k] + largest)
            if y + 2 * _CLEAR * largest < low.min():
                break  # it lies below the surface, as all that follow
            _raise(low, self._x, x, y, far)
        found = []
        for radius in added:
            k = int(low.argmin())
            y = low[k] + self._drop
            if not y < self._top:
                break
            found.append((self._x[k], y))
            _raise(low, self._x, self._x[k], y, _CLEAR * (radius + largest))
        return np.array(found).reshape(-1, 2)


def put_on(
    surface: Surface, sim: Simulation, which: np.ndarray, radii: np.ndarray, angles: np.ndarray
) -> int:
    """Put particles (k,), inside or gone, on the surface of the others; how many found room.

    radii: bounding ones of all particles (n,) [m]; angles: of those to be put (k,) [rad]. Each
    moves as the particle nearest to it does, at most as fast as one is that fell from there to the
    outlet. Particles that were put at rest stayed behind a sinking surface, and those put next
    behind them: above a wide outlet only a column of falling particles was left.
    """
    others = np.setdiff1d(sim.live, which)
    centres = sim.rows[others][:, [state.X, state.Y]]
    places = surface.places(centres, radii[others], radii[which])
    put = which[: len(places)]
    if not len(put):
        return 0
    velocity = np.zeros((len(put), 2))
    if len(others):
        apart = ((places[:, None] - centres) ** 2).sum(axis=2)
        velocity = sim.rows[others[apart.argmin(axis=1)]][:, [state.UX, state.UY]]
        fastest = np.sqrt(2 * GRAVITY * np.maximum(places[:, 1], 0.0))
        speed = np.maximum(np.hypot(*velocity.T), _NOTHING)
        velocity *= np.minimum(1.0, fastest / speed)[:, None]
    sim.put(put, np.column_stack([places, angles[: len(put)]]))
    sim.push(put, velocity)
    return len(put)


def _raise(low: np.ndarray, columns: np.ndarray, x: float, y: float, far: float) -> None:
    """Raise the lowest centres in columns over a circle that keeps others `far` away [m]."""
    first, last = np.searchsorted(columns, [x - far, x + far])
    rise = far**2 - (columns[first:last] - x) ** 2
    low[first:last] = np.maximum(low[first:last], y + np.sqrt(np.maximum(rise, 0.0)))
