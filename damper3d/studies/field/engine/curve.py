"""The way along a solution curve: pseudo-arclength continuation through the pieces of the fields.

A step goes along the tangent, then onto the curve by Newton's method in the plane across it (Keller
1977; Allgower and Georg, Introduction to Numerical Continuation Methods, SIAM 2003). Where a damper
reaches a knot of its field the step ends there, and the next one follows the tangent in the piece
beyond, with the amplitude of that damper going on as it did.
"""

from damper3d.studies.field.engine.arcs import CLOSED, GOES_ON, LEFT, LOST, collect
from damper3d.studies.field.engine.equations import (
    along,
    displacement,
    dot,
    growth,
    length_of,
    newton,
    tangent,
    weigh,
)
from granulab.contact.jit import inner

_STRAIGHT, _STRAIGHTER = 0.95, 0.975  # cosines between the tangents at both ends of a step: the
# least one, and the least after which steps are doubled
_FIRST, _LONGEST, _SHORTEST = 0.05, 0.3, 1e-12  # steps
_MOST_STEPS = 100_000
_ON = 1e-9  # of an amplitude, that a damper at a knot may be off it
_AT_ONCE = 1e-3  # of a step, before which it should meet no knot
# Steps below which the curve may change its side, as where it crosses another one, and the level
# its sign. Longer ones that do would be jumps to another part of it: two that are near run in
# opposite directions; and where the level is nearly zero the phase of all turns by 180 degrees.
_NOTHING = 1e-6
_LOOKS = 16  # along a step for amplitudes that leave their piece and come back


@inner
def _leaves(balance, piece, z, z0):
    """The first damper that left its piece from z0 to z, the knot, 1 or -1, the part of the way.

    The damper is -1 where none did.
    """
    which, edge, way, first = -1, 0.0, 0, 2.0
    for d in range(len(piece)):
        low, high = balance.knots[d, piece[d]], balance.knots[d, piece[d] + 1]
        now = abs(displacement(balance, z, d))
        above, below = now > high * (1.0 + _ON), piece[d] > 0 and now < low * (1.0 - _ON)
        if above or below:
            before, met = abs(displacement(balance, z0, d)), high if above else low
            part = (met - before) / (now - before)
            if part < first:
                which, edge, way, first = d, met, 1 if above else -1, part
    return which, edge, way, first


@inner
def _grazes(balance, arc, length, row):
    """True where a damper leaves its piece and comes back in a step, by the cubic through it."""
    for d in range(len(arc.piece)):
        low, high = balance.knots[d, arc.piece[d]], balance.knots[d, arc.piece[d] + 1]
        a0, a1 = abs(displacement(balance, arc.z0, d)), abs(displacement(balance, arc.z1, d))
        if min(a0, a1) == 0.0:
            continue
        growth(balance, arc.z0, d, row)
        rate0 = dot(row, arc.t0) * length
        growth(balance, arc.z1, d, row)
        rate1 = dot(row, arc.t1) * length
        if rate0 * rate1 >= 0.0:
            continue
        for i in range(1, _LOOKS):
            s = i / _LOOKS
            ends = (1.0 - s) ** 2 * (1.0 + 2.0 * s) * a0 + s * s * (3.0 - 2.0 * s) * a1
            a = ends + s * (1.0 - s) * ((1.0 - s) * rate0 - s * rate1)
            if a > high * (1.0 + _ON) or (arc.piece[d] > 0 and a < low * (1.0 - _ON)):
                return True
    return False


@inner
def _outward(balance, piece, z, t, d, row):
    """1 or -1 where a damper at a knot of its piece is about to leave it, else 0."""
    low, high = balance.knots[d, piece[d]], balance.knots[d, piece[d] + 1]
    size = abs(displacement(balance, z, d))
    if size == 0.0:
        return 0
    growth(balance, z, d, row)
    rate = dot(row, t)
    if abs(size - high) <= 2.0 * _ON * high and rate > 0.0:
        return 1
    return -1 if piece[d] > 0 and abs(size - low) <= 2.0 * _ON * low and rate < 0.0 else 0


@inner
def cross(balance, arc, d, way, work):
    """Let damper d go on beyond the knot at the end of an arc; GOES_ON, LEFT or LOST.

    Changes the pieces, and tangent and side there. With d go all dampers that are at one and about
    to leave, as like dampers do, or else it alone.
    """
    piece, z, t = arc.piece, arc.z1, arc.t1
    for k in range(len(t)):
        work.old[k] = t[k]
    for alone in (False, True):
        for e in range(len(piece)):
            work.ways[e] = 0 if alone else _outward(balance, piece, z, work.old, e, work.row)
        work.ways[d] = way
        for e in range(len(piece)):
            work.new[e] = piece[e] + work.ways[e]
            if work.new[e] >= balance.pieces[e]:
                return LEFT
        growth(balance, z, d, work.row)
        side = tangent(balance, work.new, arc.weight, z, work.row, float(way), t, work.m)
        goes = side != 0.0
        for e in range(len(piece)):
            goes = goes and _outward(balance, work.new, z, t, e, work.row) == 0
        if goes:
            for e in range(len(piece)):
                piece[e] = work.new[e]
            arc.side[1] = side
            return GOES_ON
    return LOST


@inner
def _step(balance, arc, length, work):
    """Try a step from the beginning of an arc, of which it writes the end.

    Returns whether it went well, and the damper that is at a knot then (-1: none), on its way up or
    down.
    """
    piece, weight, z, z1, plane = arc.piece, arc.weight, arc.z0, arc.z1, work.plane
    along(balance, weight, arc.t0, plane)
    for k in range(len(z)):
        z1[k] = z[k] + length * arc.t0[k]
    wanted = dot(plane, z) + length
    if not newton(balance, piece, weight, z1, plane, wanted, -1, False, work.m):
        return False, -1, 0
    d, edge, way, part = _leaves(balance, piece, z1, z)
    if d >= 0:
        if not part > _AT_ONCE:
            return False, -1, 0
        for k in range(len(z)):
            z1[k] = z[k] + part * (z1[k] - z[k])
        if not newton(balance, piece, weight, z1, work.row, edge, d, False, work.m):
            return False, -1, 0
        forward = dot(plane, z1) - dot(plane, z)
        if not 0.0 < forward <= length or _leaves(balance, piece, z1, z)[0] >= 0:
            return False, -1, 0
        length = forward
    arc.side[1] = tangent(balance, piece, weight, z1, plane, 1.0, arc.t1, work.m)
    for e in range(len(piece)):  # that the step ends at of itself
        if d < 0:
            way = _outward(balance, piece, z1, arc.t1, e, work.row)
            d = e if way else -1
    crossed = arc.side[0] != arc.side[1] or z[-1] * z1[-1] < 0.0
    if (crossed and length > _NOTHING) or arc.side[1] == 0.0 or dot(plane, arc.t1) < _STRAIGHT:
        return False, -1, 0
    return not _grazes(balance, arc, length, work.row), d, way


@inner
def _note_crossing(arc, branches):
    """Keep where another curve crosses this one; CLOSED where the way ends there, else GOES_ON.

    At a level of zero it is the circle of all phases, which is no other curve.
    """
    if arc.z0[-1] * arc.z1[-1] <= 0.0:
        return GOES_ON
    if branches.number[0] < 0:
        return CLOSED
    if branches.number[0] < len(branches.z):
        for k in range(len(arc.z1)):
            branches.z[branches.number[0], k] = arc.z1[k]
        branches.number[0] += 1
    return GOES_ON


@inner
def follow(balance, arc, levels, found, start, branches, work):
    """Follow the curve from the beginning of an arc and add solutions; how the way ends.

    start: number of the solution that it began at, -1: none.
    """
    length, first = _FIRST, True
    for _ in range(_MOST_STEPS):
        weigh(balance, arc.z0, arc.weight)
        own = length_of(balance, arc.weight, arc.t0)
        for k in range(len(arc.t0)):
            arc.t0[k] /= own
        length = min(length, _LONGEST)
        went, d, way = _step(balance, arc, length, work)
        status = collect(balance, arc, levels, found, start, work) if went else LOST
        if status == LOST:
            length *= 0.5
            if length < _SHORTEST:
                return LOST
            continue
        if status == CLOSED and first:
            status = GOES_ON
        first = False
        along(balance, arc.weight, arc.t0, work.row)
        if d < 0 and dot(work.row, arc.t1) > _STRAIGHTER:
            length *= 2.0
        if status == GOES_ON and d >= 0:
            status = cross(balance, arc, d, way, work)
        if status == GOES_ON and arc.side[0] != arc.side[1]:
            status = _note_crossing(arc, branches)
        arc.side[0] = arc.side[1]
        for k in range(len(arc.z0)):
            arc.z0[k], arc.t0[k] = arc.z1[k], arc.t1[k]
        if status != GOES_ON:
            return status
    return LOST
