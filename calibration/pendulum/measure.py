"""measure_pendulum: a ball on a string before a wall, or two blocks on strings, to restitution."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calibration.correlated import CHANCE, pool
from calibration.pendulum.arc import Arc, arc_through
from calibration.pendulum.collisions import Collisions, collide
from calibration.pendulum.contacts import Swings, found_swings
from calibration.pendulum.doubts import doubts
from calibration.pendulum.fit import Fit, Seen, fit, rests, starts
from calibration.pendulum.motion import across, amplitude, root_of_height
from calibration.pendulum.things import Things, things_in
from calibration.segments import noise
from calibration.track import Array, Track
from calibration.uncertainty import Estimate
from contact.quantity import InputError

_GRAVITY = 9.80665  # m/s2


@dataclass(frozen=True)
class Pendulum:
    """What a clip says of b things on strings and n contacts.

    things       their tracks, from left to right
    arcs         the circle of each
    rough        the swings, and the contacts where parabolas had them [frames]
    fitted       all swings; without damping where that cannot be told from leaving the plane
    damped       the same with the damping free, which is what the contacts' times come from
    collisions   by `fitted`
    times        (n, 2) contacts, where the swings of `damped` meet; sigma [frames]
    untold       what the damping of `damped` would add to the restitution, where it is left in
    pooled       one restitution, and p of the test that it describes the clip
    masses       of the two blocks, where they were given
    """

    things: Things
    arcs: tuple[Arc, ...]
    swings: Swings
    fitted: Fit
    damped: Fit
    collisions: Collisions
    times: Array
    untold: float
    pooled: Estimate
    p: float | None
    masses: tuple[float, float] | None
    warnings: tuple[str, ...] = ()
    sheet: Path | None = None

    @property
    def restitution(self) -> Estimate:
        """The pooled value."""
        return self.pooled

    @property
    def planar(self) -> bool | None:
        """Whether the path is an arc that heights can be read off; None where it looks straight."""
        return planar(self.arcs)

    @property
    def constant_within_noise(self) -> bool | None:
        """Whether one number describes the clip (p at least 0.05); None for one contact."""
        return None if self.p is None else self.p >= CHANCE

    def frame(self, clock: float) -> float:
        """The frame number of the file at a time of the clock."""
        return float(np.interp(clock, self.things.t, self.things.frame))

    def amplitudes(self) -> tuple[Array, Array]:
        """(b, n) before and after each contact [px]: how far a swing turns from where it hangs.

        Of a ball, from where it meets the wall, along x or the arc: what is seen in the picture.
        """
        found, b = self.fitted, len(self.arcs)
        start = starts(found.parameters, b)
        arc = amplitude(found.law, start[..., 0], start[..., 1])
        if not found.seen.angles:
            arc = across(found.law, arc)
        if b == 1:
            wall = float(np.median(self.collisions.gaps[:, 0])) - rests(found.parameters, 1)[0]
            side = np.sign(self.collisions.before[0, 0])
            arc = arc + side * wall
        return arc[:, self.swings.before], arc[:, self.swings.after]

    def from_amplitudes(self) -> Array | None:
        """(n,) amplitude after over before, as seen from the wall; None for two blocks."""
        before, after = self.amplitudes()
        return after[0] / before[0] if len(before) == 1 else None

    def heights(self) -> tuple[Array, Array] | None:
        """(b, n) H = L (1 - cos theta) before and after contacts [px]; None without a length."""
        found = self.fitted
        if found.law.kappa == 0:
            return None
        start = starts(found.parameters, len(self.arcs))
        root = root_of_height(found.law, amplitude(found.law, start[..., 0], start[..., 1]))
        height = found.law.kappa * root**2 / 2
        return height[:, self.swings.before], height[:, self.swings.after]

    def length_m(self) -> Estimate | None:
        """Of the string, from the period: g/omega^2; None without a rate."""
        if self.things.rate is None:
            return None
        omega, sigma = self.fitted.law.omega, float(np.sqrt(self.fitted.covariance[0, 0]))
        length = _GRAVITY / (omega * self.things.rate) ** 2
        return Estimate(length, 2 * length * sigma / omega, 1)


def measure_pendulum(
    source: str | Path | Track | Sequence[Track],
    *,
    fps: float | None = None,
    tracks: Sequence[str] = (),
    roi: tuple[int, int, int, int] | None = None,
    masses: tuple[float, float] | None = None,
    out: str | Path | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Pendulum:
    """Restitution of two things on strings (eq. 3.6), or of one against a wall.

    source    a film, a track table, or tracks
    fps       frames per second of the camera; overrides what time stamps say
    tracks    names of the one or two tracks wanted, where more things move
    roi       x, y, width, height of the part of a film to look at [px]
    masses    of the left and the right thing [kg]; their ratio is checked by momentum
    out       folder for the sheet

    Raises InputError, one line, for what cannot be measured.
    """
    things = things_in(source, fps=fps, names=tracks, roi=roi, progress=progress)
    if masses is not None and len(things.x) == 1:
        raise InputError("--masses: of two blocks; this is one thing against a wall")
    rough, found = found_swings(things.t, things.gap)
    arcs = tuple(
        arc_through(x, y, found.rows, noise(things.t, y))
        for x, y in zip(things.x, things.y, strict=True)
    )
    pendulum = _measured(things, arcs, found, rough, masses)
    pendulum = replace(pendulum, warnings=tuple(doubts(pendulum)))
    if out is None:
        return pendulum
    from calibration.pendulum.sheet import draw_sheet

    return replace(pendulum, sheet=draw_sheet(pendulum, Path(out), things.name))


def planar(arcs: tuple[Arc, ...]) -> bool | None:
    """Of all things: False where one is not, None where nothing is seen of it."""
    seen = [arc.planar for arc in arcs if arc.planar is not None]
    return all(seen) if seen else None


def _measured(
    things: Things,
    arcs: tuple[Arc, ...],
    found: Swings,
    rough: Array,
    masses: tuple[float, float] | None,
) -> Pendulum:
    damped = fit(_seen(things, arcs, found))
    free = collide(damped, found, rough)
    fitted, collisions = damped, free
    if planar(arcs) is False:
        # A swing that does not go back on its own path loses speed along x without any air.
        fitted = fit(damped.seen, damped=False)
        collisions = collide(fitted, found, rough)
    (pooled, p), with_air = (pool(one.restitution, one.covariance) for one in (collisions, free))
    untold = with_air[0].value - pooled.value
    assert pooled.sigma is not None
    # Any share of it may be air: a rectangular distribution (GUM 4.3.7) about the end that is used.
    pooled = replace(pooled, sigma=float(np.hypot(pooled.sigma, untold / np.sqrt(3))))
    return Pendulum(
        things, arcs, found, fitted, damped, collisions, free.times, untold, pooled, p, masses
    )


def _seen(things: Things, arcs: tuple[Arc, ...], found: Swings) -> Seen:
    """Arc lengths where the path is an arc, else x; with the length of the best arc, if any."""
    angles = all(arc.known for arc in arcs) and bool(planar(arcs))
    lengths = [arc.curvature for arc in arcs if arc.known]
    best = min(lengths, key=lambda one: one.sigma or np.inf) if lengths else None
    z = things.x
    if angles:
        each = zip(arcs, things.x, things.y, strict=True)
        z = np.array([arc.along(x, y) for arc, x, y in each])
    return Seen(things.t, z, found.rows, angles, best)
