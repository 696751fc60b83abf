"""Whether one of two things that bounce at the same frames only shows the other once more.

A reflection in the plate goes up where its thing comes down. A part of a thing stays within its
outline. A shadow darkens what is behind it in all colours alike (Horprasert et al. 1999), and has
not the thing's own colour.
"""

import numpy as np

from calibration.drop.bounce import Bounces
from calibration.tracking.track import Look

_WITHIN = 1.2  # sums of the radii, within which the middles of a thing's parts stay
_SAME = 0.5  # of the contrast, by which colours of one thing differ
_OFF = 0.2  # of the contrast, by which a shadow's colour may miss that of the wall made darker


def is_shown_twice(one: Bounces, other: Bounces) -> bool:
    """Whether `one`, seen in fewer places, is a reflection, a part or a shadow of `other`.

    Where only places are known, nothing tells two things from one.
    """
    if one.track.look is None or other.track.look is None:
        return one.track.radius is not None
    return (
        one.flights.acceleration[0] * other.flights.acceleration[0] < 0
        or _part(one, other)
        or (is_shadow(one.track.look) and not _alike(one.track.look, other.track.look))
    )


def _part(one: Bounces, other: Bounces) -> bool:
    """Whether the two are never farther apart than parts of one thing are."""
    _, here, there = np.intersect1d(one.track.frame, other.track.frame, return_indices=True)
    a, b = one.track, other.track
    if not len(here) or a.radius is None or b.radius is None:
        return False
    apart = np.hypot(a.x[here] - b.x[there], a.y[here] - b.y[there])
    return bool(np.all(apart < _WITHIN * (a.radius[here] + b.radius[there])))


def is_shadow(look: Look) -> bool:
    """Whether a thing's colour is that behind it, darker."""
    share = float(look.colour @ look.behind / (look.behind @ look.behind))
    miss = float(np.linalg.norm(look.colour - share * look.behind))
    return share < 1 and miss < _OFF * float(np.linalg.norm(look.colour - look.behind))


def _alike(one: Look, other: Look) -> bool:
    contrasts = [float(np.linalg.norm(look.colour - look.behind)) for look in (one, other)]
    return float(np.linalg.norm(one.colour - other.colour)) < _SAME * float(
        np.sqrt(np.prod(contrasts))
    )
