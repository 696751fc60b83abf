"""The track that a drop test is about, among those of all objects that were followed.

An object may be shown once more. Its reflection in the plate goes up where it comes down. A part of
it stays within its outline. Its shadow darkens what is behind it in all colours alike (Horprasert
et al. 1999), and has not the object's own colour.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from calibration.drop.bounce import Bounces, find_bounces
from calibration.drop.first import first_bounce, with_first
from calibration.drop.odd import (
    refuse_what_does_not_fall,
    refuse_what_falls_sideways,
    seen_instead,
)
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.track import Look, Track
from granulab.errors import InputError

_WITHIN = 1.2  # sums of the radii, within which the middles of an object's parts stay
_SAME = 0.5  # of the contrast, by which colours of one object differ
_OFF = 0.2  # of the contrast, by which a shadow's colour may miss that of the wall made darker
_FEWEST = 8  # positions of a drop
_TOGETHER = 1.0  # frames: contacts of an object and of its shadow or reflection


def is_shown_twice(one: Bounces, other: Bounces) -> bool:
    """True if `one`, seen in fewer positions, is a reflection, a part or a shadow of `other`.

    Where only positions are known, nothing separates two objects from one.
    """
    if one.track.look is None or other.track.look is None:
        return one.track.radius is not None
    return (
        one.flights.acceleration[0] * other.flights.acceleration[0] < 0
        or _part(one, other)
        or (is_shadow(one.track.look) and not _alike(one.track.look, other.track.look))
    )


def _part(one: Bounces, other: Bounces) -> bool:
    """True if the two are never farther apart than parts of one object are."""
    _, here, there = np.intersect1d(one.track.frame, other.track.frame, return_indices=True)
    a, b = one.track, other.track
    if not len(here) or a.radius is None or b.radius is None:
        return False
    apart = np.hypot(a.x[here] - b.x[there], a.y[here] - b.y[there])
    return bool(np.all(apart < _WITHIN * (a.radius[here] + b.radius[there])))


def is_shadow(look: Look) -> bool:
    """True if an object's colour is that behind it, darker."""
    share = float(look.colour @ look.behind / (look.behind @ look.behind))
    miss = float(np.linalg.norm(look.colour - share * look.behind))
    return share < 1 and miss < _OFF * float(np.linalg.norm(look.colour - look.behind))


def _alike(one: Look, other: Look) -> bool:
    contrasts = [float(np.linalg.norm(look.colour - look.behind)) for look in (one, other)]
    return float(np.linalg.norm(one.colour - other.colour)) < _SAME * float(
        np.sqrt(np.prod(contrasts))
    )


def the_one_that_bounces(
    tracks: list[Track], name: str | None, one_bounce: bool, where: str
) -> Bounces:
    """The bounces of the track `name`, or of the only one that bounces.

    A shadow or a reflection bounces when its object does: the one with more positions counts.
    Raises InputError where none bounces, or several do.
    """
    if name is not None:
        known = [track.name for track in tracks]
        if name not in known:
            raise InputError(f"{where}no track {name!r}; there are {', '.join(map(repr, known))}")
        tracks = [track for track in tracks if track.name == name]
    found, failures = [], []
    for track in tracks:
        try:
            one = find_bounces(track, one_is_enough=True)
            if len(one.contacts) < 2 and not (one_bounce or first_bounce(one).held):
                find_bounces(track)  # says what one bounce lacks
            found.append(one)
        except InputError as error:
            failures.append((_range(track), error))
    if not found:
        refuse_what_falls_sideways(tracks, where)
        why = str(max(failures, key=lambda failure: failure[0])[1])
        raise InputError(f"{where}{why}{seen_instead(tracks, why)}")
    found = _without_companions(found)
    if len(found) > 1:
        raise InputError(f"{where}{_several(found)}")
    _refuse_what_is_no_restitution(with_first(found[0])[0].pooled, where)
    refuse_what_does_not_fall(found[0], where)
    return replace(found[0], warnings=[*found[0].warnings, *_other_drops(found[0])])


def _other_drops(found: Bounces) -> list[str]:
    """A warning for each drop of the same track before or after the flights that were used.

    It falls farther than the last flight used went up: else it is the end of the same drop.
    """
    used = found.base.rows[np.concatenate(found.flights.rows)]
    last = found.base.rows[found.flights.rows[-1]]
    least = float(np.ptp(found.track.y[last]))
    said = []
    for rows in (np.arange(used.min()), np.arange(used.max() + 1, len(found.track.frame))):
        if len(rows) < _FEWEST or np.ptp(found.track.y[rows]) < least:
            continue
        try:
            other = find_bounces(found.track.chosen(rows))
        except InputError:
            continue
        e, first = other.pooled, _frames(other)[0]
        said.append(
            f"another drop of the same object, from its contact at frame {first:.0f} on, has "
            f"{e.value:.4f} +- {e.sigma or 0.0:.1g}: not used; cut the recording to measure it"
        )
    return said


def _refuse_what_is_no_restitution(pooled: Estimate, where: str) -> None:
    """InputError for what says nothing of a number between 0 and 1, or lies above 1.

    1/sqrt(12) is the standard deviation of what is only known to lie there.
    """
    sigma = pooled.sigma or 0.0
    if sigma > 12**-0.5 or pooled.value - 3 * sigma > 1:
        raise InputError(
            f"{where}what moves has a restitution of {pooled.value:.2f} +- {sigma:.2g}: "
            "no drop test; give the part of the picture with --roi, or see calibrate pendulum"
        )


def _without_companions(found: list[Bounces]) -> list[Bounces]:
    """Those that are no shadow, reflection or part of one that was seen in more positions."""
    in_order = sorted(
        found,
        key=lambda one: (-sum(map(len, one.flights.rows)), _looks_as_a_shadow(one)),
    )
    kept: list[Bounces] = []
    for one in in_order:
        if not any(_together(one, other) and is_shown_twice(one, other) for other in kept):
            kept.append(one)
    return [one for one in found if any(one is other for other in kept)]


def _looks_as_a_shadow(one: Bounces) -> bool:
    return one.track.look is not None and is_shadow(one.track.look)


def _together(one: Bounces, other: Bounces) -> bool:
    """True if each contact of the one that has fewer is one of the other's."""
    few, many = sorted(([_frames(b) for b in (one, other)]), key=len)
    near = np.abs(few[:, None] - many[None, :]).min(axis=1)
    return len(few) > 1 and bool(np.all(near < _TOGETHER))


def _frames(found: Bounces) -> np.ndarray:
    """Frame numbers of the contacts."""
    base = found.base
    return np.interp(found.contacts[:, 0], base.clock, found.track.frame[base.rows])


def _several(found: list[Bounces]) -> str:
    """Refusal of more than one object that bounces, with the value of each."""
    first = [float(one.track.frame[0]) for one in found]
    last = [float(one.track.frame[-1]) for one in found]
    order = np.argsort(first)
    after = all(first[k] > last[j] for j, k in pairwise(order))
    what = "drops follow one another" if after else "objects bounce"
    film = found[0].track.radius is not None
    ways = "--track, --at or --roi" if film else "--track"
    return f"{len(found)} {what}: choose one with {ways} ({', '.join(map(_named, found))})"


def _named(found: Bounces) -> str:
    """The name of a track, where it begins in a film, and its restitution."""
    track, e = found.track, found.pooled
    words = f"{track.name!r}"
    if track.radius is not None:
        words += f" from {track.x[0]:.0f},{track.y[0]:.0f} px in frame {track.frame[0]:g}"
    return f"{words}: {e.value:.3f} +- {e.sigma or 0.0:.1g}"


def _range(track: Track) -> float:
    """Range of a track along y: the one that goes farthest says why nothing was found."""
    seen = track.y[np.isfinite(track.y)]
    return float(np.ptp(seen)) if len(seen) else 0.0
