"""What the film of a silo that empties told: times, curve, profiles, velocities."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from calibration.flow.layers import Band, Profile
from calibration.flow.silo import Silo
from calibration.flow.survey import Survey
from calibration.flow.velocity import VelocityField
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.film.reader import Film

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """Frame by frame: time since the opening [s], and what remains, as a share.

    area       of the material that is seen in the silo; NaN where the backing is not known
    tracers    of the points that are followed
    surface    mean height of the free surface, in the silo's unit; NaN likewise
    """

    time: Floats
    area: Floats
    tracers: Floats
    surface: Floats

    @property
    def remaining(self) -> Floats:
        """By area, or by tracers where that is not known."""
        return self.area if np.isfinite(self.area).all() else self.tracers

    @property
    def sigma(self) -> float | None:
        """Of the share that remains: how far its two measures differ, root mean square."""
        if not np.isfinite(self.area).all():
            return None
        return float(np.sqrt(np.mean(np.square(self.area - self.tracers))))


@dataclass(frozen=True)
class Flow:
    """What a film of a discharge gives. Lengths in silo.unit, times in s from the opening.

    opening      frame of the film, with a part of one
    outcome      empty, dead_zones, clogged, unfinished or nothing_flows
    discharge    from the opening to the last grain [s]; None if clogged or unfinished
    """

    film: Film
    rate: float
    silo: Silo
    outlet: tuple[float, float]
    opening: Estimate
    outcome: str
    discharge: Estimate | None
    curve: Curve
    bands: list[Band]
    edges: Floats
    interval: float
    profiles: list[Profile]
    velocities: list[VelocityField]
    seen: Survey
    warnings: list[str] = field(default_factory=list)

    def depths(self) -> tuple[Floats, Floats]:
        """Depth of each layer's V, and its sigma, (times, layers); NaN for none.

        The mean of the line's outermost columns less the column at the outlet, as silo2d has it.
        """
        middle = int(np.digitize(sum(self.outlet) / 2, self.edges[1:-1]))
        out = np.full((2, len(self.profiles), len(self.bands)), np.nan)
        for t, layer in np.ndindex(out.shape[1:]):
            line, sigma = self.profiles[t].lines[layer], self.profiles[t].sigma[layer]
            filled = np.flatnonzero(np.isfinite(line))
            if len(filled) and filled[0] < middle < filled[-1] and np.isfinite(line[middle]):
                ends = filled[[0, -1]]
                out[0, t, layer] = line[ends].mean() - line[middle]
                out[1, t, layer] = np.sqrt(np.sum(sigma[ends] ** 2) / 4 + sigma[middle] ** 2)
        return out[0], out[1]
