"""measure_pendulum: a ball on a string before a wall, or two blocks on strings, to restitution."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from calibration.pendulum.arc import Arc, arc_through, planar
from calibration.pendulum.chain import refuse_chain
from calibration.pendulum.collisions import collide
from calibration.pendulum.contacts import Swings, found_swings
from calibration.pendulum.fit import Seen, fit
from calibration.pendulum.objects import Objects, objects_in
from calibration.pendulum.result import Pendulum
from calibration.pendulum.warnings import warnings_of
from calibration.result import checked, draw
from calibration.statistics.correlated import pool
from calibration.tracking.film.reader import Film, Progress, is_film, open_film
from calibration.tracking.segments import noise
from calibration.tracking.track import Array, Track
from granulab.errors import InputError


def measure_pendulum(
    source: str | Path | Track | Sequence[Track],
    *,
    fps: float | None = None,
    tracks: Sequence[str] = (),
    roi: tuple[int, int, int, int] | None = None,
    masses: tuple[float, float] | None = None,
    out: str | Path | None = None,
    progress: Progress | None = None,
    units: Mapping[str, str] | None = None,
) -> Pendulum:
    """Restitution of two objects on strings (eq. 3.6), or of one against a wall.

    source    a film, a track table, or tracks
    fps       frames per second of the camera; overrides what time stamps say
    tracks    names of the one or two tracks wanted, where more objects move
    roi       x, y, width, height of the part of a film to look at [px]
    masses    of the left and the right object [kg]; their ratio is checked by momentum
    out       folder for the diagnostic figure
    units     of the columns of a table: {"time": "ms", "x": "mm", "y": "mm"}

    Raises InputError, one line, for what cannot be measured.
    """
    film = open_film(source) if isinstance(source, str | Path) and is_film(source) else None
    try:
        objects = objects_in(source, fps=fps, names=tracks, roi=roi, progress=progress, units=units)
        if film is not None:
            refuse_chain(film, objects.tracks)
        pendulum = _pendulum_of(objects, masses)
    except InputError:
        if film is not None:
            _refuse_chain_of_all(film, roi, progress)
        raise
    if out is None:
        return pendulum
    return replace(pendulum, sheet=draw(pendulum, Path(out) / f"pendulum-{objects.name}.png"))


def _refuse_chain_of_all(
    film: Film, roi: tuple[int, int, int, int] | None, progress: Progress | None
) -> None:
    """InputError where a film that gave no answer shows a chain, by everything that moves in it."""
    from calibration.tracking.follow import follow

    try:
        tracks = follow(film, roi=roi, progress=progress)
    except InputError:  # nothing moves, or the film cannot be read: the caller's error says it
        return
    refuse_chain(film, tracks)


def _pendulum_of(objects: Objects, masses: tuple[float, float] | None) -> Pendulum:
    """The result; InputError where there is none."""
    if masses is not None and len(objects.x) == 1:
        raise InputError("--masses: of two blocks; this is one object against a wall")
    rough, found = found_swings(objects.t, objects.gap)
    arcs = tuple(
        arc_through(x, y, found.rows, noise(objects.t, y))
        for x, y in zip(objects.x, objects.y, strict=True)
    )
    pendulum = _measured(objects, arcs, found, rough, masses)
    checked(pendulum.to_dict(), [objects.name])
    return replace(pendulum, warnings=tuple(warnings_of(pendulum)))


def _measured(
    objects: Objects,
    arcs: tuple[Arc, ...],
    found: Swings,
    rough: Array,
    masses: tuple[float, float] | None,
) -> Pendulum:
    damped = fit(_seen(objects, arcs, found))
    free = collide(damped, found, rough)
    fitted, collisions = damped, free
    if planar(arcs) is False:
        # A swing that does not go back on its own path loses speed along x without any air.
        fitted = fit(damped.seen, damped=False)
        collisions = collide(fitted, found, rough)
    (pooled, p), with_air = (pool(one.restitution, one.covariance) for one in (collisions, free))
    left_in = with_air[0].value - pooled.value
    assert pooled.sigma is not None
    # Any share of it may be air: a rectangular distribution (GUM 4.3.7) about the end that is used.
    pooled = replace(pooled, sigma=float(np.hypot(pooled.sigma, left_in / np.sqrt(3))))
    return Pendulum(
        objects, arcs, found, fitted, damped, collisions, free.times, left_in, pooled, p, masses
    )


def _seen(objects: Objects, arcs: tuple[Arc, ...], found: Swings) -> Seen:
    """Arc lengths where the path is an arc, else x; with the length of the best arc, if any."""
    angles = all(arc.known for arc in arcs) and bool(planar(arcs))
    lengths = [arc.curvature for arc in arcs if arc.known]
    best = min(lengths, key=lambda one: one.sigma or np.inf) if lengths else None
    z = objects.x
    if angles:
        each = zip(arcs, objects.x, objects.y, strict=True)
        z = np.array([arc.along(x, y) for arc, x, y in each])
    return Seen(objects.t, z, found.rows, angles, best)
