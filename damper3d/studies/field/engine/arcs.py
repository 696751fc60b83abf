"""Smooth parts of a solution curve, and the solutions at wanted levels on them."""

from typing import NamedTuple

import numpy as np

from damper3d.studies.field.engine.equations import (
    along,
    dot,
    length_of,
    linearise,
    newton,
    solve,
    tangent,
)
from granulab.contact.jit import inner

# How the way along a curve goes: on; ends where a damper leaves its field, where it began, where
# Newton's method fails, or where there is no room for more solutions.
GOES_ON, LEFT, CLOSED, LOST, FULL = -1, 0, 1, 2, 3
_SAME = 1e-7  # largest distance of two solutions that are one
_MET = 1e-15  # of a level, that it is met to
_HALVES = 100  # most of a search, which ends at the last digit sooner


class Found(NamedTuple):
    """Solutions at one frequency, at most s."""

    number: np.ndarray  # (1,)
    level: np.ndarray  # (s,) which of the wanted levels
    z: np.ndarray  # (s, 2 r + 1) unknowns
    stable: np.ndarray  # (s,)


class Arc(NamedTuple):
    """A smooth part of the curve: its ends, the tangents there, pieces, and weights of lengths."""

    z0: np.ndarray  # (2 r + 1,)
    t0: np.ndarray
    z1: np.ndarray
    t1: np.ndarray
    piece: np.ndarray  # (d,)
    weight: np.ndarray  # (d,)
    side: np.ndarray  # (2,) of the curve at both ends, see equations.tangent


class Branches(NamedTuple):
    """Points where another curve crosses one, at most b; number -1: the way ends at the first."""

    number: np.ndarray  # (1,)
    z: np.ndarray  # (b, 2 r + 1)


class Work(NamedTuple):
    """Room to calculate in."""

    m: np.ndarray  # (2 r + 1, 2 r + 2)
    z: np.ndarray  # (2 r + 1,) as all others but the last two
    t: np.ndarray
    row: np.ndarray
    chord: np.ndarray
    plane: np.ndarray
    old: np.ndarray
    new: np.ndarray  # (d,)
    ways: np.ndarray  # (d,)


@inner
def on_arc(balance, arc, part, work):
    """Write point and tangent at a part of an arc's chord, 0 to 1, into work; True if they are."""
    z, chord, row = work.z, work.chord, work.row
    for k in range(len(z)):
        chord[k] = arc.z1[k] - arc.z0[k]
    length = length_of(balance, arc.weight, chord)
    along(balance, arc.weight, chord, row)
    a, b = part * part * (3.0 - 2.0 * part), part * (1.0 - part) * length
    for k in range(len(z)):  # the cubic through both ends
        z[k] = arc.z0[k] + a * chord[k] + b * ((1.0 - part) * arc.t0[k] - part * arc.t1[k])
    wanted = dot(row, arc.z0) + part * length**2
    if not newton(balance, arc.piece, arc.weight, z, row, wanted, -1, False, work.m):
        return False
    side = tangent(balance, arc.piece, arc.weight, z, row, 1.0, work.t, work.m)
    return side == arc.side[0] or side == arc.side[1]


@inner
def _meet(balance, arc, of_tangent, wanted, a, b, at_a, at_b, work):
    """Part of an arc's chord between a and b where the level is as wanted; -1 where Newton fails.

    of_tangent: its derivative instead. at_a, at_b: their values at a and b, on both sides of the
    wanted one. The secant's rule with halves (Illinois). Point and tangent are in work.
    """
    fa, fb, part = at_a - wanted, at_b - wanted, b
    for _ in range(_HALVES):
        if fb != fa:
            part = b - fb * (b - a) / (fb - fa)
        if not on_arc(balance, arc, part, work):
            return -1.0
        f = (work.t[-1] if of_tangent else work.z[-1]) - wanted
        if abs(f) <= _MET * abs(wanted) or abs(b - a) < _MET:
            break
        if f * fb < 0.0:
            a, fa = b, fb
        else:
            fa *= 0.5
        b, fb = part, f
    return part


@inner
def add(balance, piece, weight, z, k, found, work):
    """Add a solution at level k, unless it is there; its number, or -1 where there is no room.

    Stable: the determinant of the derivatives by the modes is positive, as at zero, where it is the
    square of a complex one. By Cramer's rule its sign is that of the level's derivative along the
    curve times its side.
    """
    n, m, row = len(z) - 1, work.m, work.row
    sign = 1.0 if z[n] >= 0.0 else -1.0  # -z solves it for -L
    for i in range(found.number[0]):
        if found.level[i] == k:
            for j in range(n + 1):
                row[j] = found.z[i, j] - sign * z[j]
            if length_of(balance, weight, row) <= _SAME:
                return i
    i = found.number[0]
    if i == len(found.level):
        return -1
    linearise(balance, piece, z, m)
    for j in range(n + 1):
        found.z[i, j] = sign * z[j]
        m[n, j] = 0.0
    m[n, n] = 1.0
    found.stable[i] = solve(m) > 0.0
    found.level[i] = k
    found.number[0] = i + 1
    return i


@inner
def collect(balance, arc, levels, found, start, work):
    """Add the solutions at the wanted levels on an arc; GOES_ON, LOST, FULL, CLOSED at start.

    start: number of a solution, see add. Between the ends and a turning point each level is met
    once.
    """
    n, status = len(arc.z0) - 1, GOES_ON
    middle, turning = 1.0, arc.z1[n]
    if arc.t0[n] * arc.t1[n] < 0.0:
        middle = _meet(balance, arc, True, 0.0, 0.0, 1.0, arc.t0[n], arc.t1[n], work)
        turning = work.z[n]
        if middle < 0.0:
            return LOST
    for half in range(2):
        low, a = (0.0, arc.z0[n]) if half == 0 else (middle, turning)
        high, b = (middle, turning) if half == 0 else (1.0, arc.z1[n])
        for k in range(len(levels)):
            for sign in (1.0, -1.0):
                wanted = sign * levels[k]
                if (a < wanted) == (b < wanted):
                    continue
                if _meet(balance, arc, False, wanted, low, high, a, b, work) < 0.0:
                    return LOST
                number = add(balance, arc.piece, arc.weight, work.z, k, found, work)
                if number < 0:
                    return FULL
                if number == start:
                    status = CLOSED
    return status
