"""Harmonic balance of a structure with a bed: every amplitude that a field allows.

With the receptance H and the bare response X_b at the damper (structure.py), the bed's force
omega^2 m(omega, A) X and A = |X|:

    |A - H omega^2 m A| = |X_b|,   of one mode |k - w^2 (M + m) + i w c| A = |F0|

A field's force m A is linear between its knots, so the left side is there |p + q A| with complex p
and q: its square is a parabola that opens upwards. Between two knots there is one solution where
the sides change their order, two where the right one is above the parabola's lowest point and
below both its ends, and none else; so none is missed. The left side's value at a knot is one
number for both neighbours.

Where the left side rises with A, more excitation gives more response, and the solution is stable
against slow changes of its amplitude; where it falls it is not, and between them are the turning
points, from which the response jumps. Other losses of stability (of phase, of symmetry, to other
frequencies) are not looked at. One damper on any number of modes; several.py has more of them.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damper3d.case.parts import GRAVITY
from damper3d.studies.field.structure import Structure
from damper3d.studies.field.table import Complexes, Field, Floats

Truths = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Responses:
    """Amplitudes of a structure with a bed, at l levels and f frequencies.

    Of the s solutions at a point the first, third, ... are stable, as the left side of the balance
    begins at zero, unless it is said which are. Those beyond the field's greatest Gamma are not
    known.
    """

    levels: Floats  # (l,) [-]
    frequency: Floats  # (f,) [Hz]
    bare: Floats  # (l, f) without the bed [m]
    # (l, f, s) [m], NaN where there are fewer; rising, of several dampers the first's
    amplitude: Floats
    beyond: Truths  # (l, f) whether a solution lies above the field
    # Of several dampers: whether a solution is stable (l, f, s); the frequencies where some may
    # lack for no known reason (f,).
    said: Truths | None = None
    lost: Truths | None = None
    base: Floats | None = None  # amplitude of a base that moves, at level 1 (f,) [m]

    @cached_property
    def count(self) -> NDArray[np.int64]:
        """Solutions within the field (l, f)."""
        return np.isfinite(self.amplitude).sum(axis=2)

    @property
    def is_stable(self) -> Truths:
        """Solutions that are stable (l, f, s)."""
        if self.said is not None:
            return self.said
        return np.broadcast_to(np.arange(self.amplitude.shape[2]) % 2 == 0, self.amplitude.shape)

    @property
    def stable(self) -> Floats:
        """The stable amplitudes (l, f, s) [m], NaN elsewhere."""
        return np.where(self.is_stable, self.amplitude, math.nan)

    def largest(self, level: int) -> tuple[float, float] | None:
        """Frequency [Hz] and amplitude [m] of the largest stable response; None where unknown.

        On a base that moves, of the largest transmissibility.
        """
        found = self.place(level)
        if found is None:
            return None
        return float(self.frequency[found[0]]), float(self.amplitude[level][found])

    def place(self, level: int) -> tuple[int, int] | None:
        """Numbers of frequency and solution of the largest stable response; None where unknown."""
        if self.beyond[level].any():
            return None
        at = int(np.argmax(self.over_base(self.largest_at_each(level))))
        return at, int(np.argmax(np.nan_to_num(self.stable[level, at])))

    def largest_at_each(self, level: int) -> Floats:
        """Largest stable amplitude at each frequency (f,) [m]; 0 where none is known."""
        return np.asarray(np.nan_to_num(self.stable[level]).max(axis=1, initial=0.0))

    def over_base(self, amplitude: Floats) -> Floats:
        """Amplitudes (f,) [m] over that of a base which moves at level 1 [-]; else themselves."""
        return amplitude if self.base is None else amplitude / self.base

    def is_end(self, frequency: float) -> bool:
        """True for the first and the last frequency, where a largest value is no peak."""
        return frequency in (self.frequency[0], self.frequency[-1])


def respond(
    structure: Structure, field: Field, frequency: ArrayLike, levels: ArrayLike = (1.0,)
) -> Responses:
    """All solutions at frequencies (f,) [Hz]; levels (l,): factors of what moves the structure.

    Raises InputError for a frequency outside the field.
    """
    frequency, levels = np.asarray(frequency, float), np.asarray(levels, float)
    return closed_form(structure, *field.knots(frequency), frequency, levels)


def closed_form(
    structure: Structure, gamma: Floats, force: Complexes, frequency: Floats, levels: Floats
) -> Responses:
    """The same with the knots of the force at each frequency, Gamma and m Gamma (f, k)."""
    product, receptance, moved = structure.products(frequency)
    omega2 = (2.0 * math.pi * frequency[:, None]) ** 2
    length = GRAVITY / omega2  # amplitude of Gamma 1 (f, 1)
    left = length * (product[:, None] * gamma - receptance[:, None] * omega2 * force)
    squares = np.abs(left) ** 2
    right = (levels[:, None] * np.abs(moved)) ** 2  # (l, f)
    found = _roots(gamma * length, left, squares, right)
    with np.errstate(divide="ignore"):
        bare = np.abs(structure.bare(frequency)) * levels[:, None]
    beyond, base = squares[:, -1] < right, structure.base(frequency)
    return Responses(levels, frequency, bare, found, beyond, base=base if base.any() else None)


def _roots(at: Floats, left: Any, squares: Floats, right: Floats) -> Floats:
    """Amplitudes (l, f, s) where the square of the left side is the right one's.

    at (f, k): amplitudes of the knots; left (f, k), squares (f, k): the left side there;
    right (l, f): the square of the right side.
    """
    width = np.diff(at)
    slope = np.diff(left)  # over the part t of an interval, 0 to 1
    a = np.abs(slope) ** 2
    b = (np.conj(left[:, :-1]) * slope).real  # squares = |left|^2 + 2 b t + a t^2
    above = squares[None] >= right[..., None]
    crossed = above[..., 1:] != above[..., :-1]
    dips = (b < 0) & (a + b > 0)  # the lowest point lies between the knots
    lowest = np.where(dips, squares[:, :-1] - b**2 / np.where(a > 0, a, 1.0), np.inf)
    twice = above[..., 1:] & above[..., :-1] & (lowest < right[..., None])
    times = (crossed + 2 * twice).reshape(-1)
    which = np.repeat(np.arange(times.size), times)
    order = np.arange(len(which)) - np.repeat(np.cumsum(times) - times, times)
    level, f, k = np.unravel_index(which, crossed.shape)
    upper = np.where(twice[level, f, k], order == 1, above[level, f, k + 1])
    t = _part(a[f, k], b[f, k], squares[f, k] - right[level, f], upper)
    roots = at[f, k] + width[f, k] * np.clip(t, 0.0, 1.0)
    cell = level * right.shape[1] + f
    each = np.bincount(cell, minlength=right.size)
    place = np.arange(len(cell)) - np.repeat(np.cumsum(each) - each, each)
    found = np.full((right.size, max(int(each.max(initial=0)), 1)), math.nan)
    found[cell, place] = roots
    return found.reshape(*right.shape, -1)


def _part(a: Floats, b: Floats, c: Floats, upper: Truths) -> Floats:
    """Return the upper or lower root of a t^2 + 2 b t + c, a > 0, without loss of digits."""
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    far = -(b + np.where(b >= 0, root, -root))  # of the larger size
    is_far = upper == (b < 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.nan_to_num(np.where(is_far, far / a, c / far))


@dataclass(frozen=True)
class Jump:
    """A turning point that the response meets as the frequency goes up or down."""

    direction: str  # "up" or "down": of the frequency
    frequency: float  # [Hz], of the last point before it
    before: float  # amplitude [m]
    after: float  # [m]


def swept(responses: Responses, level: int, down: bool = False) -> tuple[Floats, list[Jump]]:
    """Stable amplitude (f,) as the frequency goes up, or down, and its jumps; (f,) by rising f.

    From the smallest stable solution at the first frequency. A branch goes on in the stable
    solution that is nearest in ln A, unless another branch is nearer to that one: then it has
    ended, and the response jumps there. NaN where no solution lies within the field.
    """
    followed, jumps = swept_together([responses], level, down)
    return followed[0], jumps[0]


def swept_together(
    dampers: Sequence[Responses], level: int, down: bool = False
) -> tuple[Floats, list[list[Jump]]]:
    """The same of several dampers with the same solutions: amplitudes (d, f), jumps of each.

    Nearest is then what has the least of the largest differences in ln A.
    """
    frequency = dampers[0].frequency
    stable = np.stack([one.stable[level] for one in dampers])  # (d, f, s)
    order = range(len(frequency))[:: -1 if down else 1]
    followed = np.full((len(dampers), len(order)), math.nan)
    jumps: list[list[Jump]] = [[] for _ in dampers]
    before = stable[:, 0, :0]
    for last, k in zip([None, *order], order, strict=False):
        there = stable[:, k, (stable[:, k] > 0).all(axis=0)]
        here = followed[:, last] if last is not None else np.full(len(dampers), math.nan)
        if there.size and np.isnan(here[0]):
            followed[:, k] = there[:, 0]
        elif there.size:
            nearest = there[:, _nearest(there, here)]
            claimed = before[:, _nearest(before, nearest)]
            followed[:, k] = nearest
            if (claimed != here).any():
                at, direction = float(frequency[last]), "down" if down else "up"
                for own, a, b in zip(jumps, here.tolist(), nearest.tolist(), strict=True):
                    own.append(Jump(direction, at, a, b))
        before = there
    return followed, jumps


def _nearest(solutions: Floats, one: Floats) -> int:
    """Number of the solution (d, s) that is nearest to one (d,)."""
    return int(np.argmin(np.abs(np.log(solutions / one[:, None])).max(axis=0)))


def spaced(structure: Structure, low: float, high: float) -> Floats:
    """Frequencies [Hz] from low to high, where a peak is met to 0.2 %, and the modes' own.

    Twenty lie in the half-power bandwidth 2 zeta of the sharpest mode: a peak is at most a fortieth
    of it away, and 1/sqrt(1 + (1/20)^2) of it is met. Below zeta = 0.005 they would be too many,
    and with_peaks adds those that it takes.
    """
    step = np.clip(_OF_RATIO * float(structure.damping_ratio.min()), _FINEST, _COARSEST)
    even = np.geomspace(low, high, max(2, math.ceil(math.log(high / low) / step) + 1))
    own = structure.omega / (2.0 * math.pi)
    return np.union1d(even, own[(low < own) & (own < high)])


_OF_RATIO = 0.1  # of a damping ratio, step of ln f
_FINEST, _COARSEST = 5e-4, 5e-3  # of ln f: at most 2800 in a factor of four, and smooth curves
_WITHIN = 9  # frequencies about a maximum, the next nearer ones
_CLOSEST = 1e-7  # of ln f, where a structure without damping ends it


@dataclass(frozen=True)
class _Maximum:
    """A largest response between two frequencies [Hz], of a damper and a level by their numbers."""

    damper: int
    level: int
    low: float
    high: float

    def among(self, frequency: Floats, together: Sequence[Responses]) -> "_Maximum":
        """The same between the neighbours of the largest at frequencies, which it is within."""
        inside = np.flatnonzero((self.low <= frequency) & (frequency <= self.high))
        own = together[self.damper]
        size = own.over_base(own.largest_at_each(self.level))
        top = int(inside[np.argmax(size[inside])])
        first, last = max(top - 1, inside[0]), min(top + 1, inside[-1])
        return replace(self, low=float(frequency[first]), high=float(frequency[last]))


def with_peaks(
    answer: Callable[[Floats], Sequence[Responses]], frequency: Floats, sharpest: float
) -> list[Responses]:
    """Responses of dampers at frequencies (f,) [Hz], and at more of them about their maxima.

    answer: the responses at some frequencies; sharpest: the least damping ratio. Each maximum is
    closed in on until its neighbours are as near as `spaced` has them where they are not too many.
    """
    together, close = answer(frequency), max(2.0 * _OF_RATIO * sharpest, _CLOSEST)
    maxima, found = _maxima(together), [frequency]
    while maxima := [one for one in maxima if math.log(one.high / one.low) > close * (1 + 1e-9)]:
        each = [np.geomspace(one.low, one.high, _WITHIN) for one in maxima]
        near = np.unique(np.concatenate(each))
        there = answer(near)
        maxima = [one.among(near, there) for one in maxima]
        found.append(near)
    return list(answer(np.unique(np.concatenate(found))) if len(found) > 1 else together)


def _maxima(together: Sequence[Responses]) -> list[_Maximum]:
    """Largest responses between their neighbours, of each damper and level."""
    found = []
    for d, responses in enumerate(together):
        for k in range(len(responses.levels)):
            size, f = responses.over_base(responses.largest_at_each(k)), responses.frequency
            tops = 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:]))
            found += [_Maximum(d, k, float(f[i - 1]), float(f[i + 1])) for i in tops]
    return found
