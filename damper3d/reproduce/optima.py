"""Where a ridge of the efficiency lies along Gamma, and how its place scatters over packings."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from damper3d.reproduce.dampers import prediction_of
from damper3d.reproduce.runs import Row
from damper3d.studies.map.grid import MapResult
from damper3d.studies.map.peaks import Peak
from damper3d.studies.map.ridges import ridges
from damper3d.studies.predict.prediction import Prediction
from granulab.campaign.output.statistics import Sample, mean_sd, pooled_sd, quantile


@dataclass(frozen=True)
class Optimum:
    """A peak of eta on a ridge at one frequency.

    mean        of the efficiency averaged over the packings
    top         Gamma of the largest of that average
    alone       ln Gamma of the peak of each packing alone, of those that have one
    prediction  of the damper
    frequency   [Hz]
    """

    mean: Peak
    top: float
    alone: tuple[float, ...]
    prediction: Prediction
    frequency: float

    @cached_property
    def logarithms(self) -> Sample:
        """Mean and standard deviation of ln Gamma over the packings."""
        return mean_sd(self.alone)

    @property
    def gamma(self) -> float:
        """The geometric mean over the packings; of none that has a peak, that of the mean curve."""
        known = self.logarithms.mean
        return self.mean.gamma if known is None else math.exp(known)

    @property
    def resolution(self) -> float:
        """Half the bracket of the mean curve's peak, in ln Gamma: what the grid leaves open."""
        low, high = self.mean.bracket
        return math.log(high / low) / 2

    def predicted(self, packing: str) -> float | None:
        """Gamma of eq. 6.11 for a packing of the prediction, such as "close"; None: none."""
        found = next((c for c in self.prediction.clearances if c.name == packing), None)
        return found.onset(self.frequency) if found else None

    def error(self, pooled: tuple[float, int] | None) -> float:
        """Half width of the interval of ln Gamma: scatter of the mean and resolution together.

        `pooled` is the standard deviation that all optima of a table share, with its degrees of
        freedom (pooled_scatter); without, the resolution alone.
        """
        n = max(self.logarithms.n, 1)
        scatter = quantile(pooled[1]) * pooled[0] / math.sqrt(n) if pooled else 0.0
        return math.hypot(scatter, self.resolution)

    def allowance(self, pooled: tuple[float, int] | None) -> float:
        """How far in ln Gamma one more packing's optimum may lie: t s sqrt(1 + 1/n), resolution."""
        n = max(self.logarithms.n, 1)
        scatter = quantile(pooled[1]) * pooled[0] * math.sqrt(1 + 1 / n) if pooled else 0.0
        return math.hypot(scatter, self.resolution)


def optimum(rows: Sequence[Row], frequency: float, ridge: str) -> Optimum | None:
    """The optimum of a panel's rows on a ridge (map.ridges); None where none stands out."""
    prediction = prediction_of(rows)
    if prediction is None:
        return None
    here = [row for row in rows if row["frequency_hz"] == frequency]
    mean = _on_ridge(here, prediction, ridge)
    if mean is None:
        return None
    peaks = [
        _on_ridge([row for row in here if row["seed"] == seed], prediction, ridge)
        for seed in sorted({row["seed"] for row in here})
    ]
    alone = tuple(math.log(peak.gamma) for peak in peaks if peak)
    averaged = MapResult.of(here)
    top = float(averaged.gamma[averaged.at(frequency)][mean.index])
    return Optimum(mean, top, alone, prediction, frequency)


def pooled_scatter(optima: Sequence[Optimum | None]) -> tuple[float, int] | None:
    """The standard deviation of ln Gamma over packings that optima share; None for single ones."""
    return pooled_sd([found.logarithms for found in optima if found])


def with_scatter(found: Optimum) -> str:
    """ "19.8 +- 0.4 (3)": geometric mean, standard deviation over the packings, their number."""
    sample = found.logarithms
    spread = "" if sample.sd is None else f" +- {found.gamma * sample.sd:.2g}"
    return f"{found.gamma:.3g}{spread} ({sample.n})"


def _on_ridge(rows: Sequence[Row], prediction: Prediction, ridge: str) -> Peak | None:
    items = ridges(MapResult.of(rows), prediction)
    return next((item.peak for item in items if item.ridge == ridge), None)
