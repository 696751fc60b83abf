"""Collisions from the swings before and after: when, where, and the restitution.

The gap is the second object's position less the first's, or one object's position before a wall.
Contact is where the gaps of both swings meet; restitution is -(gap' after)/(gap' before), Newton's,
which is eq. 3.6 where the second object hangs at rest and the contact is at the lowest point: there
speed = omega sqrt(2 H/kappa), H = (1 - cos theta)/kappa the height of the swing. Speeds are those
at the contact, so that neither the air between contacts nor a contact off the lowest point is in
them; eq. 3.6 itself, with the heights of whole swings, is given for comparison.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from calibration.pendulum.contacts import Swings
from calibration.pendulum.fit import Fit, law_of, rests, starts, states
from calibration.pendulum.motion import amplitude, root_of_height
from calibration.statistics.correlated import propagated, with_sigma
from calibration.tracking.track import Array

_NEWTON = 20  # steps: a contact moves by less than a frame from where the parabolas had it


class _Meeting(NamedTuple):
    """At each of n contacts: time, gap, its speed before and after; speeds of objects (b, n)."""

    time: Array
    gap: Array
    before: Array
    after: Array
    speeds_before: Array
    speeds_after: Array


@dataclass(frozen=True)
class Collisions:
    """Of n contacts of b objects; pairs are value and sigma.

    times         (n, 2) [frames]
    gaps          (n, 2) position of the wall, or distance of the objects in contact [px]
    speeds        (n, 2) of approach [px/frame]
    restitution   (n,) with its covariance, which has what the contacts share
    from_heights  (n, 2) eq. 3.6 with the heights of the whole swings; the air is in it
    before, after  (b, n) speed of each object about the contact [px/frame]
    mass_ratio    (2,) second object's over the first's, from the momentum; None for a wall
    """

    times: Array
    gaps: Array
    speeds: Array
    restitution: Array
    covariance: Array
    from_heights: Array
    before: Array
    after: Array
    mass_ratio: Array | None


def collide(fitted: Fit, swings: Swings, rough: Array) -> Collisions:
    """All collisions, from the rough times of the contacts."""
    p, n = fitted.parameters, len(rough)
    time = _meet(p, fitted, swings, rough, _NEWTON).time

    def everything(vector: Array) -> Array:
        at = _meet(vector, fitted, swings, time, 1)
        whole = _from_heights(vector, fitted, swings, at)
        ratio = _mass_ratio(at) if len(at.speeds_before) == 2 else 1.0
        return np.concatenate(
            [-at.after / at.before, at.time, at.gap, np.abs(at.before), whole, [ratio]]
        )

    value, covariance = propagated(p, fitted.covariance, everything)
    known = with_sigma(value, covariance)
    at = _meet(p, fitted, swings, time, 1)
    return Collisions(
        known[n : 2 * n],
        known[2 * n : 3 * n],
        known[3 * n : 4 * n],
        value[:n],
        covariance[:n, :n],
        known[4 * n : 5 * n],
        at.speeds_before,
        at.speeds_after,
        known[-1] if len(at.speeds_before) == 2 else None,
    )


def _meet(p: Array, fitted: Fit, swings: Swings, time: Array, steps: int) -> _Meeting:
    """Return where the gaps of the swings before and after each contact meet, from `time` on."""
    for _ in range(steps):
        q, v = states(p, fitted.seen, swings.before, time)
        r, w = states(p, fitted.seen, swings.after, time)
        apart, jump = _gap(r - q), _gap(w - v)
        time = time - apart / jump
    return _Meeting(time, _gap(q) + _gap(rests(p, len(q))[:, None]), _gap(v), _gap(w), v, w)


def _gap(positions: Array) -> Array:
    """Of the second object from the first; of one object its position."""
    return np.asarray(positions[-1] - positions[0] if len(positions) == 2 else positions[0])


def _mass_ratio(at: _Meeting) -> float:
    """m2/m1 = -(v1' - v1)/(v2' - v2), all contacts weighted by what they change."""
    first, second = at.speeds_after - at.speeds_before
    return float(-(first @ second) / (second @ second))


def _from_heights(p: Array, fitted: Fit, swings: Swings, at: _Meeting) -> Array:
    """Eq. 3.6, each root of a height with the sign of the speed: what the heights alone say."""
    law, start = law_of(p), starts(p, len(fitted.seen.z))
    arc = amplitude(law, start[..., 0], start[..., 1])
    root = root_of_height(law, arc)
    before = _gap(np.sign(at.speeds_before) * root[:, swings.before])
    after = _gap(np.sign(at.speeds_after) * root[:, swings.after])
    return np.asarray(-after / before)
