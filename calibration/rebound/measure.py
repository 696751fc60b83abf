"""measure_rebound: the film of a particle that rebounds, to restitution at the point of contact."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from calibration.drop.bounce import STANDARD_GRAVITY
from calibration.drop.choice import is_shadow
from calibration.drop.timebase import TimeBase, check
from calibration.rebound.contact import Contact, Known, of_contacts
from calibration.rebound.motion import Fitted, fit
from calibration.rebound.result import Rebound
from calibration.rebound.shape import gyration, outline
from calibration.result import checked
from calibration.statistics.correlated import pool
from calibration.statistics.uncertainty import Estimate, through
from calibration.tracking.film.reader import Progress, is_film, open_film, said_rate
from calibration.tracking.follow import follow
from calibration.tracking.orientation import Orientation, orientation
from calibration.tracking.segments import flights
from calibration.tracking.track import Track
from granulab.contact.material import Measured
from granulab.errors import InputError

_FEWEST = 8  # positions: four before a contact and four after
_OTHER_SIDES = 2.0  # scatter of silhouettes in that from frame to frame: not one shape
LEVEL = Measured(0.0, float(np.radians(0.5)))  # a plate and a camera set with a spirit level


def measure_rebound(
    film: str | Path,
    *,
    fps: float | None = None,
    scale: float | None = None,
    plane: Measured = LEVEL,
    gyration_radius: Measured | None = None,
    track: str | None = None,
    roi: tuple[int, int, int, int] | None = None,
    hint: tuple[float, float, float] | None = None,
    progress: Progress | None = None,
) -> Rebound:
    """Restitution, friction and energies of a particle that falls on a plate and rebounds.

    film      a film of the particle from the side, along the axis about which it rotates
    fps       frames per second of the camera; overrides what time stamps say
    scale     metres per pixel; else free fall gives it
    plane     angle of the plate to the picture's horizontal, counter-clockwise [rad]
    gyration_radius   about the axis of rotation [m]; else that of a prism with this silhouette
    track     name of the track, where several objects rebound
    roi       x, y, width, height of the part of the film to look at [px]
    hint      frame, x, y [px] of the particle

    Raises InputError, one line, for what cannot be measured.
    """
    fps = said_rate(fps)
    if not is_film(film):
        raise InputError(f"{film}: a rotation is seen in a film; see calibrate drop for tables")
    opened = open_film(film)
    tracks = follow(opened, roi=roi, hint=hint, progress=progress)
    chosen, base, ranges = _the_one(tracks, track, str(film))
    try:
        found = _measured(chosen, base, ranges, fps, scale, plane, gyration_radius)
    except InputError as error:
        raise InputError(f"{film}: {error}") from error
    found = replace(found, path=Path(film))
    checked(found.to_dict(), [film])
    return found


def _the_one(
    tracks: list[Track], name: str | None, where: str
) -> tuple[Track, TimeBase, list[tuple[int, int]]]:
    """The track that falls and rebounds, the clock that free fall shows, and its flights."""
    known = [one.name for one in tracks]
    if name is not None and name not in known:
        raise InputError(f"{where}: no track {name!r}; there are {', '.join(map(repr, known))}")
    found = []
    for one in tracks:
        if len(one.frame) < _FEWEST or name not in (None, one.name):
            continue
        base = check(one.seen(), one.seen().clock)
        kept = one.seen().chosen(base.rows)
        ranges, acceleration = flights(base.clock, kept.y)
        if len(ranges) > 1 and acceleration is not None and acceleration > 0:
            found.append((kept, base, ranges))
    if not found:
        raise InputError(
            f"{where}: no contact is seen: nothing falls and goes up again from a plate below it"
        )
    lit = [one for one in found if one[0].look is None or not is_shadow(one[0].look)] or found
    if len(lit) > 1:
        names = ", ".join(f"{one.name!r} from {one.x[0]:.0f},{one.y[0]:.0f} px" for one, *_ in lit)
        raise InputError(
            f"{where}: {len(lit)} objects rebound: choose one with --track, --at or --roi ({names})"
        )
    return lit[0]


def _measured(
    track: Track, base: TimeBase, ranges: list[tuple[int, int]], fps: float | None,
    scale: float | None, plane: Measured, gyration_radius: Measured | None,
) -> Rebound:  # fmt: skip
    seen = orientation(track)
    positions = np.stack([track.x, -track.y, -seen.angle])
    radius = float(np.sqrt(np.mean(seen.outline**2)))
    fitted = fit(base.clock, positions, ranges, plane.sigma or 0.0, radius)
    rate = fps or (track.rate and track.rate * base.share)
    length = _length(fitted, rate, scale)
    k = _gyration(seen, gyration_radius, length)
    known = Known(fitted, outline(seen.outline), k, plane)
    contacts, e, covariance = of_contacts(known)
    good = [k for k, one in enumerate(contacts) if not one.doubt]
    if not good:
        one = contacts[0]
        raise InputError(f"contact at frame {one.frame:.1f}: {one.doubt}; drop it again")
    pooled, p = pool(e[good], covariance[np.ix_(good, good)])
    _refuse_unknown(pooled)
    warnings = [
        *track.remarks,
        *base.remarks,
        *seen.remarks(track.frame),
        *_warnings(contacts, seen),
    ]
    return Rebound(
        track, base.clock, seen, known, contacts, pooled, p, rate, length,
        tuple(dict.fromkeys(warnings)),
    )  # fmt: skip


def _length(fitted: Fitted, rate: float | None, scale: float | None) -> Estimate | None:
    """Metres per pixel: as given, or from free fall where the rate is known."""
    if scale is not None:
        return Estimate(scale, 0.0, 1)
    if rate is None:
        return None
    place = fitted.layout.m - 1 + fitted.layout.m + 2 + 1
    fall = -float(fitted.parameters[place]), float(np.sqrt(fitted.covariance[place, place]))
    return through(lambda g, a: g / (a * rate**2), STANDARD_GRAVITY, Estimate(fall[0], fall[1], 1))


def _gyration(
    seen: Orientation, given: Measured | None, length: Estimate | None
) -> tuple[float, float]:
    """Radius of gyration and sigma [px]."""
    if given is None:
        return gyration(seen.outline)
    if length is None:
        raise InputError(
            "--gyration: a length needs --fps or --scale to be compared with a picture"
        )
    k = through(lambda a, s: a / s, Estimate(given.value, given.sigma or 0.0, 1), length)
    return k.value, k.sigma or 0.0


def _refuse_unknown(pooled: Estimate) -> None:
    """InputError for what says nothing of a number between 0 and 1 (sigma of a rectangle)."""
    if (pooled.sigma or 0.0) > 12**-0.5:
        raise InputError(
            f"the restitution at the point of contact is {pooled.value:.2f} +- {pooled.sigma:.2g}, "
            "which says nothing: too few frames, or the point hardly moves towards the plate"
        )


def _warnings(contacts: list[Contact], seen: Orientation) -> list[str]:
    said = []
    if seen.changes > _OTHER_SIDES:
        said.append(
            f"its silhouettes differ {seen.changes:.1f} times as much as from frame to frame: it "
            "shows other sides, and rotates about an axis that is not the camera's"
        )
    said.extend(
        f"contact at frame {one.frame:.1f}: {one.doubt}: left out" for one in contacts if one.doubt
    )
    return said
