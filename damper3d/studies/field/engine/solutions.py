"""Solutions of the harmonic balance at many frequencies and levels, on all curves that are met.

The curve through zero at each frequency first. A curve that does not meet it (an isola) is looked
for from the solutions at the neighbouring frequencies, from below and from above: Newton's method
begins at each at the same level. What it finds and was not known lies on another curve, which is
followed in both directions.
"""

import numpy as np

from damper3d.studies.field.engine.arcs import (
    CLOSED,
    FULL,
    GOES_ON,
    LOST,
    Arc,
    Branches,
    Found,
    Work,
    add,
    collect,
)
from damper3d.studies.field.engine.curve import cross, follow
from damper3d.studies.field.engine.equations import (
    Balance,
    along,
    displacement,
    dot,
    length_of,
    linearise,
    newton,
    pieces_at,
    solve,
    tangent,
    weigh,
)
from granulab.contact.jit import inner, njit

_MOST_BRANCHES = 20  # that are followed from the curve through zero
_OFF = 1e-3  # length by which a branch begins beside its curve
_INVERSE = 3  # iterations for its direction


@inner
def _from_zero(balance, arc, levels, found, branches, work):
    """Follow the curve from zero, along which the fields are linear at first; how it ends."""
    n = len(arc.z0) - 1
    for k in range(n + 1):
        arc.z0[k], work.plane[k] = 0.0, 0.0
    for d in range(len(arc.piece)):
        arc.piece[d] = 0
    work.plane[n] = 1.0
    weigh(balance, arc.z0, arc.weight)
    side = tangent(balance, arc.piece, arc.weight, arc.z0, work.plane, 1.0, arc.t0, work.m)
    if side == 0.0:
        return LOST
    arc.side[0] = arc.side[1] = side
    first, which = np.inf, 0
    for d in range(len(arc.piece)):
        size = abs(displacement(balance, arc.t0, d))
        if size > 0.0 and balance.knots[d, 1] / size < first:
            first, which = balance.knots[d, 1] / size, d
    for k in range(n + 1):
        arc.z1[k], arc.t1[k] = first * arc.t0[k], arc.t0[k]
    status = collect(balance, arc, levels, found, -1, work)
    if status == GOES_ON:
        status = cross(balance, arc, which, 1, work)
    for k in range(n + 1):
        arc.z0[k], arc.t0[k] = arc.z1[k], arc.t1[k]
    arc.side[0] = arc.side[1]
    if status == GOES_ON:
        status = follow(balance, arc, levels, found, -1, branches, work)
    return status


@inner
def _branch(balance, arc, z, levels, found, branches, work):
    """Follow the curve that crosses another one at z, in both directions; FULL or GOES_ON.

    Its direction there, across the other tangent, is what the derivatives take to nothing: by
    inverse iteration.
    """
    n = len(z) - 1
    for way in (1.0, -1.0):
        for k in range(n + 1):
            arc.z0[k], arc.t0[k], work.plane[k] = z[k], 0.0, 0.0
        weigh(balance, arc.z0, arc.weight)
        pieces_at(balance, arc.z0, arc.piece)
        work.plane[n] = 1.0
        if tangent(balance, arc.piece, arc.weight, z, work.plane, 1.0, work.old, work.m) == 0.0:
            return GOES_ON
        along(balance, arc.weight, work.old, work.plane)
        for k in range(n):  # of no symmetry that the direction might lack
            arc.t0[k] = work.old[k] if k % 3 else -work.old[k] - 1.0
        for _ in range(_INVERSE):
            linearise(balance, arc.piece, z, work.m)
            for k in range(n + 1):
                work.m[n, k] = work.plane[k]
                work.m[k, n + 1] = arc.t0[k] if k < n else 0.0
            if solve(work.m) == 0.0:
                return GOES_ON
            for k in range(n + 1):
                arc.t0[k] = work.m[k, n + 1]
            length = length_of(balance, arc.weight, arc.t0)
            for k in range(n + 1):
                arc.t0[k] /= length
        for k in range(n + 1):
            arc.z0[k] += way * _OFF * arc.t0[k]
        along(balance, arc.weight, arc.t0, work.plane)
        wanted = dot(work.plane, arc.z0)
        if not newton(balance, arc.piece, arc.weight, arc.z0, work.plane, wanted, -1, True, work.m):
            continue
        for k in range(n + 1):
            work.chord[k] = arc.z0[k] - z[k]
        if not length_of(balance, arc.weight, work.chord) < 2.0 * _OFF:
            continue
        side = tangent(balance, arc.piece, arc.weight, arc.z0, work.plane, way, arc.t0, work.m)
        arc.side[0] = arc.side[1] = side
        if side != 0.0 and follow(balance, arc, levels, found, -1, branches, work) == FULL:
            return FULL
    return GOES_ON


@inner
def _near(balance, arc, scale, k, own, levels, found, branches, work):
    """Look for a solution near one of a neighbouring frequency, and follow its curve if it is new.

    k, own: that one's level and unknowns, whose lengths are to be multiplied by scale. FULL where
    there is no room, else GOES_ON.
    """
    n = len(arc.z0) - 1
    for way in (1.0, -1.0):
        for i in range(n):
            arc.z0[i], work.plane[i] = scale * own[i], 0.0
        arc.z0[n], work.plane[n] = levels[k], 1.0
        weigh(balance, arc.z0, arc.weight)
        if not newton(
            balance, arc.piece, arc.weight, arc.z0, work.plane, levels[k], -1, True, work.m
        ):
            return GOES_ON
        pieces_at(balance, arc.z0, arc.piece)
        for d in range(len(arc.piece)):
            if abs(displacement(balance, arc.z0, d)) > balance.knots[d, balance.pieces[d]]:
                return GOES_ON
        known = found.number[0]
        start = add(balance, arc.piece, arc.weight, arc.z0, k, found, work)
        if start < 0:
            return FULL
        if start < known and way > 0.0:
            return GOES_ON
        side = tangent(balance, arc.piece, arc.weight, arc.z0, work.plane, way, arc.t0, work.m)
        if side == 0.0:
            return GOES_ON
        arc.side[0] = arc.side[1] = side
        status = follow(balance, arc, levels, found, start, branches, work)
        if status in (CLOSED, FULL):
            return FULL if status == FULL else GOES_ON
    return GOES_ON


@inner
def _at(balances, i):
    """The balance at frequency number i of several."""
    return Balance(
        balances.modes[i], balances.shapes, balances.drive[i], balances.base[i], balances.knots[i],
        balances.force[i], balances.pieces[i],
    )  # fmt: skip


@inner
def _of(found, i):
    """The solutions at frequency number i of several."""
    return Found(found.number[i], found.level[i], found.z[i], found.stable[i])


@inner
def _at_all(balances, length, levels, found, ends, arc, branches, work):
    """The work of solutions, where references are not counted, as for views that are handed on."""
    many = len(length)
    for i in range(many):
        branches.number[0] = 0
        status = _from_zero(_at(balances, i), arc, levels, _of(found, i), branches, work)
        ends[i, 0], ends[i, 1] = status, abs(arc.z0[-1])
        crossings, branches.number[0] = branches.number[0], -1
        for b in range(crossings):
            if status != FULL:
                status = _branch(
                    _at(balances, i), arc, branches.z[b], levels, _of(found, i), branches, work
                )
        if status == FULL:
            return False
    branches.number[0] = len(branches.z)
    for up in (True, False):
        for turn in range(1, many):
            i = turn if up else many - 1 - turn
            last = i - 1 if up else i + 1
            scale = length[last] / length[i]
            for s in range(found.number[last, 0]):
                k, z = found.level[last, s], found.z[last, s]
                status = _near(
                    _at(balances, i), arc, scale, k, z, levels, _of(found, i), branches, work
                )
                if status == FULL:
                    return False
    return True


@njit
def solutions(balances, length, levels, found, ends):
    """Find the solutions at f frequencies and l levels; False where there is no room for all.

    balances: with a first axis of frequencies, but for the shapes; length (f,): of Gamma 1; found:
    likewise. Writes into ends (f, 2) how the curve from zero ends, and the level there.
    """
    n, d = 2 * balances.modes.shape[1] + 1, len(balances.shapes)
    work = Work(
        np.zeros((n, n + 1)), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n),
        np.zeros(n), np.zeros(d, np.int64), np.zeros(d, np.int64),
    )  # fmt: skip
    arc = Arc(
        np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(d, np.int64), np.zeros(d),
        np.zeros(2),
    )  # fmt: skip
    branches = Branches(np.zeros(1, np.int64), np.zeros((_MOST_BRANCHES, n)))
    return _at_all(balances, length, levels, found, ends, arc, branches, work)
