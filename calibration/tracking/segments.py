"""Flights found in a track by themselves: the best cut of y(t) into parabolas, then contacts.

Every stretch of the track is a parabola within the noise, or a single position that fits none:
the cut that costs least is found exactly, by dynamic programming (optimal partitioning, Jackson et
al. 2005, doi 10.1109/LSP.2001.838216), whatever is done to the object before it falls. Flights are
the stretches that share the acceleration that draws the largest parabolas; a contact is where the
velocity reverses from along it to against it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.statistics.robust import MEDIAN_TO_SIGMA
from calibration.tracking.track import Array, Rows

_FEWEST = 4  # points of a stretch: one more than a parabola needs
_LONGEST = 600  # points that one stretch may have before stretches are joined again
_STILL = 0.1  # share of its farthest way in as many frames by which an object at rest moves less
_ALIKE = 0.3  # share by which drag and perspective may change the acceleration of one flight
_CURVED = 5  # sigma by which a stretch must be curved to be in flight


@dataclass(frozen=True)
class Stretch:
    """Points i to j (j not in it) and their own parabola: c0 + c1 s + c2 s^2/2, s = t - centre."""

    i: int
    j: int
    start: float
    end: float
    centre: float
    coefficients: Array  # (3,)
    acceleration_sigma: float

    @property
    def duration(self) -> float:
        """From its first to its last point."""
        return self.end - self.start


def noise(t: Array, y: Array) -> float:
    """Standard deviation of y about any smooth path, from third divided differences (robust).

    These vanish for a parabola, so contacts and bad points alone stand out, and the median of the
    absolute values does not see them. An object that lies still is seen with the same error again
    and again: only positions where it moves show the noise. Not below a millionth of the range:
    numbers are rounded.
    """
    floor = 1e-6 * float(np.ptp(y))
    if len(t) < 8:
        return floor
    moves = _moves(np.lib.stride_tricks.sliding_window_view(y, 4))
    return max(floor, MEDIAN_TO_SIGMA * float(np.median(third_differences(t, y)[moves])))


def third_differences(t: Array, y: Array) -> Array:
    """(n - 3,) sizes of the third divided differences, scaled to the noise of one y."""
    window = np.lib.stride_tricks.sliding_window_view(t, 4)
    apart = window[:, :, None] - window[:, None, :] + np.eye(4)
    weights = 1 / np.prod(apart, axis=2)
    # By a power of two first, which rounds nothing: times that nearly coincide have large weights.
    weights = np.ldexp(weights, -np.frexp(weights)[1].max(axis=1, keepdims=True))
    weights /= np.linalg.norm(weights, axis=1)[:, None]
    return np.abs(np.sum(weights * np.lib.stride_tricks.sliding_window_view(y, 4), axis=1))


def _moves(windows: Array) -> NDArray[np.bool_]:
    """(n,) whether it moves within each window by a tenth of the farthest that it does in one."""
    reach = np.ptp(windows, axis=1)
    return np.asarray(reach >= _STILL * reach.max())


def stretches(t: Array, y: Array) -> list[Stretch]:
    """The best cut of a track into parabolas; points that fit none are in none.

    A stretch costs twice what the Bayesian information criterion requires for its three
    coefficients and its end; a point left out costs what a normal deviate exceeds once in n points.
    """
    sigma = noise(t, y)
    _, came_from = _cheapest(t, y, sigma)
    found = []
    j = len(t)
    while j > 0:
        i = came_from[j]
        if i >= 0:
            found.append(_fitted(t, y, i, j, sigma))
            j = i
        else:
            j -= 1
    return found[::-1]


def misfit(t: Array, y: Array, sigma: float) -> float:
    """Cost of the best cut of a track into parabolas, in sigma^2: twice minus its log likelihood.

    Two clocks for the same positions, whose noise is sigma, compare by it.
    """
    return float(_cheapest(t, y, sigma)[0]) / max(sigma**2, float(np.finfo(float).tiny))


def _cheapest(t: Array, y: Array, sigma: float) -> tuple[float, Rows]:
    """Cost of the best cut; (n + 1,) where the stretch that ends there began, -1 for none."""
    n = len(t)
    per_stretch, per_point = 8 * np.log(n) * sigma**2, 2 * np.log(n) * sigma**2
    cost = np.full(n + 1, np.inf)
    came_from = np.zeros(n + 1, dtype=int)
    cost[0] = 0.0
    for i in range(n):
        if cost[i] + per_point < cost[i + 1]:
            cost[i + 1], came_from[i + 1] = cost[i] + per_point, -1
        ends, squares = _squares_from(t, y, i)
        total = cost[i] + per_stretch + squares
        better = total < cost[ends]
        cost[ends[better]], came_from[ends[better]] = total[better], i
    return float(cost[n]), came_from


def _squares_from(t: Array, y: Array, i: int) -> tuple[Rows, Array]:
    """Sums of squares about the parabolas of points i to j, for all j; ends j and sums."""
    s, z = t[i : i + _LONGEST] - t[i], y[i : i + _LONGEST] - y[i]
    ends = np.arange(i + _FEWEST, i + len(s) + 1)
    if not len(ends):
        return ends, np.empty(0)
    size = s[_FEWEST - 1 :]  # scaled by the length of the stretch: well conditioned at any length
    powers = np.cumsum(s[None] ** np.arange(5)[:, None], axis=1)[:, _FEWEST - 1 :]
    powers = powers / size[None] ** np.arange(5)[:, None]
    mixed = np.cumsum(z * s[None] ** np.arange(3)[:, None], axis=1)[:, _FEWEST - 1 :]
    mixed = mixed / size[None] ** np.arange(3)[:, None]
    order = np.arange(3)
    matrix = np.moveaxis(powers[order[:, None] + order[None, :]], 2, 0)
    right = mixed.T[:, :, None]
    explained = np.sum(right * np.linalg.solve(matrix, right), axis=(1, 2))
    return ends, np.maximum(np.cumsum(z**2)[_FEWEST - 1 :] - explained, 0.0)


def _fitted(t: Array, y: Array, i: int, j: int, sigma: float) -> Stretch:
    centre = float(np.mean(t[[i, j - 1]]))
    s = t[i:j] - centre
    design = np.stack([np.ones_like(s), s, s**2 / 2], axis=1)
    coefficients = np.asarray(np.linalg.lstsq(design, y[i:j], rcond=None)[0], dtype=float)
    spread = sigma * float(np.sqrt(np.linalg.pinv(design.T @ design)[2, 2]))
    return Stretch(i, j, float(t[i]), float(t[j - 1]), centre, coefficients, spread)


def shared_acceleration(found: list[Stretch]) -> float | None:
    """The acceleration that draws the largest parabolas; None where nothing is curved.

    The median of the stretches' own, each counting as the height that it draws.
    """
    curved = [one for one in found if abs(one.coefficients[2]) > _CURVED * one.acceleration_sigma]
    if not curved:
        return None
    own = np.array([one.coefficients[2] for one in curved])
    drawn = np.abs(own) * np.array([one.duration for one in curved]) ** 2
    order = np.argsort(own)
    share = np.cumsum(drawn[order]) / drawn.sum()
    return float(own[order][np.searchsorted(share, 0.5)])


def flights(t: Array, y: Array) -> tuple[list[tuple[int, int]], float | None]:
    """Ranges of points of flights that follow one another through contacts; the acceleration.

    The chain with most contacts, of equal ones the one of longest duration.
    """
    found = stretches(t, y)
    acceleration = shared_acceleration(found)
    if acceleration is None:
        return [], None
    sigma, step = noise(t, y), float(np.median(np.diff(t)))
    chains: list[list[Stretch]] = [[]]
    for one in (one for one in found if is_flight(one, acceleration)):
        one = with_acceleration(t, y, one, acceleration)
        last = chains[-1][-1] if chains[-1] else None
        meets = last is not None and _meets(last, one, acceleration, step)
        if last is not None and _continues(last, one, acceleration):
            chains[-1][-1] = with_acceleration(
                t, y, _fitted(t, y, last.i, one.j, sigma), acceleration
            )
        elif last is None or meets:
            chains[-1].append(one)
        else:
            chains.append([one])
    best = max(chains, key=lambda chain: (len(chain), sum(one.duration for one in chain)))
    if len(best) == 2:
        best = best + _short_flight(t, y, best, acceleration, sigma, sure=False)
    elif len(best) == 1:
        behind = _short_flight(t, y, best, acceleration, sigma, sure=True)
        back = _reversed(best, len(t))
        before = _short_flight(-t[::-1], y[::-1], back, acceleration, sigma, sure=True)
        best = [*_reversed(before, len(t)), *best, *behind]
    ranges = [(one.i, one.j) for one in best]
    return _without_doubtful_ends(t, best, ranges, acceleration, sigma), acceleration


def _reversed(chain: list[Stretch], n: int) -> list[Stretch]:
    """Stretches of n points, as they are where time goes backwards."""
    back = np.array([1.0, -1.0, 1.0])
    return [
        Stretch(
            n - one.j, n - one.i, -one.end, -one.start, -one.centre, back * one.coefficients,
            one.acceleration_sigma,
        )
        for one in reversed(chain)
    ]  # fmt: skip


def _short_flight(
    t: Array, y: Array, chain: list[Stretch], acceleration: float, sigma: float, *, sure: bool
) -> list[Stretch]:
    """A further flight that is too short for a parabola of its own; in a list, empty without one.

    Three points or more with the acceleration of the clip, within four of the sigma that the one or
    two flights before show about it, which meet the last in a contact.

    sure    their own acceleration is that of a flight, too: what rests after a fall is none
    """
    last, step = chain[-1], float(np.median(np.diff(t)))
    off = np.concatenate([_off(t, y, one) for one in chain])
    allowed = 4 * max(sigma, float(np.sqrt(np.mean(off**2))))
    for i in range(last.j, min(last.j + 2, len(t))):  # a point may be within the contact
        found = []
        for j in range(i + _FEWEST - 1, len(t) + 1):
            own = _fitted(t, y, i, j, sigma)
            one = with_acceleration(t, y, own, acceleration)
            if np.abs(_off(t, y, one)).max() > allowed:
                break
            known = not sure or is_flight(own, acceleration)
            if known and _meets(last, one, acceleration, step):
                found = [one]
        if found:
            return found
    return []


def _off(t: Array, y: Array, one: Stretch) -> Array:
    """Of the points of a stretch from its parabola."""
    s = t[one.i : one.j] - one.centre
    return np.asarray(y[one.i : one.j] - np.stack([s**0, s, s**2 / 2], axis=1) @ one.coefficients)


def _without_doubtful_ends(
    t: Array, chain: list[Stretch], ranges: list[tuple[int, int]], acceleration: float, sigma: float
) -> list[tuple[int, int]]:
    """The ranges without the points at either end whose position in a flight was chosen by noise.

    After its release an object at rest is within four sigma of where it was held for sqrt(8
    sigma/a). Where the chain ends, the last point may be within a contact that is not resolved.
    """
    if not chain:
        return ranges
    (i, j), blurred = ranges[0], np.sqrt(8 * sigma / abs(acceleration))
    from_rest = abs(speed(chain[0], t[i])) < 2 * abs(acceleration) * blurred
    after = int(np.searchsorted(t, t[i] + blurred))
    if i > 0 and from_rest and j - after >= 2 * _FEWEST:
        ranges[0] = (after, j)
    i, j = ranges[-1]
    if j < len(t) and j - i > _FEWEST:
        ranges[-1] = (i, j - 1)
    return ranges


def is_flight(one: Stretch, acceleration: float) -> bool:
    """True if a stretch has the acceleration of the clip, and is known not to be at rest."""
    own = one.coefficients[2] * np.sign(acceleration)
    off = abs(one.coefficients[2] - acceleration)
    alike = off <= max(_ALIKE * abs(acceleration), 4 * one.acceleration_sigma)
    return bool(alike and own > _CURVED * one.acceleration_sigma)


def with_acceleration(t: Array, y: Array, one: Stretch, acceleration: float) -> Stretch:
    """The stretch's parabola with the shared acceleration: its speeds are better known so."""
    s = t[one.i : one.j] - one.centre
    slope, level = np.polyfit(s, y[one.i : one.j] - acceleration * s**2 / 2, 1)
    coefficients = np.array([level, slope, acceleration])
    return Stretch(
        one.i, one.j, one.start, one.end, one.centre, coefficients, one.acceleration_sigma
    )


def speed(one: Stretch, time: float) -> float:
    """Velocity on the stretch's parabola."""
    return float(one.coefficients[1] + one.coefficients[2] * (time - one.centre))


def position(one: Stretch, time: float) -> float:
    """Position on the stretch's parabola."""
    s = time - one.centre
    return float(one.coefficients @ [1.0, s, s**2 / 2])


def _meets(last: Stretch, one: Stretch, acceleration: float, step: float) -> bool:
    """True if two parabolas meet in a contact between them, where the velocity reverses.

    Where it was seen in more positions between them than in either, it did something else there.
    """
    if one.i - last.j > max(last.j - last.i, one.j - one.i):
        return False
    middle = (last.end + one.start) / 2
    jump = speed(one, middle) - speed(last, middle)
    if jump * acceleration >= 0:
        return False
    contact = middle - (position(one, middle) - position(last, middle)) / jump
    between = last.end - 2 * step <= contact <= one.start + 2 * step
    down, up = np.sign(acceleration) * np.array([speed(last, contact), speed(one, contact)])
    least = abs(acceleration) * step  # what a frame of flight changes: less reverses nothing
    return bool(between and down > least and up < -least)


def _continues(last: Stretch, one: Stretch, acceleration: float) -> bool:
    """True if two stretches are one flight cut in two: by a bad point, a gap, or its length."""
    middle = (last.end + one.start) / 2
    jump = abs(speed(one, middle) - speed(last, middle))
    # A contact reverses the velocity: it changes by at least that which the shorter flight loses to
    # its apex. Less than a quarter of that is no contact.
    return bool(jump < abs(acceleration) * min(last.duration, one.duration) / 4)
