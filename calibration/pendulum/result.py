"""What a clip of things on strings says: swings, collisions, restitution, amplitudes, heights."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calibration.drop.bounce import STANDARD_GRAVITY
from calibration.pendulum.arc import Arc, planar
from calibration.pendulum.collisions import Collisions
from calibration.pendulum.contacts import Swings
from calibration.pendulum.fit import Fit, rests, starts
from calibration.pendulum.motion import across, amplitude, root_of_height
from calibration.pendulum.things import Things
from calibration.statistics.correlated import CHANCE
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.track import Array


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
        length = STANDARD_GRAVITY.value / (omega * self.things.rate) ** 2
        return Estimate(length, 2 * length * sigma / omega, 1)
