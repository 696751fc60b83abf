"""Position of a ridge of the efficiency along Gamma, its scatter over packings, and quantities."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product

from damper3d.reproduce.panels import Row, prediction_of
from damper3d.studies.map.grid import MapResult
from damper3d.studies.map.peaks import Peak
from damper3d.studies.map.ridges import ridges
from damper3d.studies.predict.prediction import Prediction
from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.statistics import Sample, mean_sd, pooled_sd, quantile

Line = tuple[int, float, str]  # height [mm], frequency [Hz], orientation
OPTIMA = Quantities()


@dataclass(frozen=True)
class Optimum:
    """A peak of eta on a ridge at one frequency.

    mean        of the efficiency averaged over the packings
    top         Gamma of the largest of that average
    alone       ln Gamma of the peak of each packing by itself, of those that have one
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
        """Return the scatter in ln Gamma of one more optimum: t s sqrt(1 + 1/n), resolution."""
        n = max(self.logarithms.n, 1)
        scatter = quantile(pooled[1]) * pooled[0] * math.sqrt(1 + 1 / n) if pooled else 0.0
        return math.hypot(scatter, self.resolution)


def optimum(rows: Sequence[Row], frequency: float, ridge: str) -> Optimum | None:
    """The optimum of a panel's rows on a ridge (map.ridges); None where none stands out."""
    prediction = prediction_of(rows)
    if prediction is None:
        return None

    def on_ridge(result: MapResult) -> Peak | None:
        items = ridges(result, prediction)
        return next((item.peak for item in items if item.ridge == ridge), None)

    here = [row for row in rows if row["frequency_hz"] == frequency]
    return located(here, frequency, on_ridge, prediction)


def located(
    rows: Sequence[Row], frequency: float, peak_of: Callable[[MapResult], Peak | None],
    prediction: Prediction,
) -> Optimum | None:  # fmt: skip
    """The peak of the mean curve of rows, and those of each packing; None where none stands out."""
    averaged = MapResult.of(rows)
    mean = peak_of(averaged)
    if mean is None:
        return None
    peaks = [
        peak_of(MapResult.of(row for row in rows if row["seed"] == seed))
        for seed in sorted({row["seed"] for row in rows})
    ]
    alone = tuple(math.log(peak.gamma) for peak in peaks if peak)
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


@dataclass(frozen=True)
class Table63:
    """The optima of a table of dampers that have one, and the scatter that they share."""

    optima: Mapping[Line, Optimum]
    pooled: tuple[float, int] | None

    @classmethod
    def of(cls, found: Mapping[Line, Optimum | None]) -> "Table63":
        """Of the lines of the table that have a peak."""
        known = {line: one for line, one in found.items() if one is not None}
        return cls(known, pooled_scatter(list(known.values())))


def _labels(line: Line) -> Row:
    return dict(zip(("height_mm", "frequency_hz", "orientation"), line, strict=True))


@OPTIMA.quantity
def optimum_gamma(table: Table63) -> list[Row]:
    """Gamma of each damper's optimum."""
    return [_labels(line) | {"value": one.gamma} for line, one in table.optima.items()]


@OPTIMA.quantity
def exponent_of_frequency(table: Table63) -> list[Row]:
    """Exponent of f of the optimum from one frequency to the next (low, high), with its error.

    together: the mean in words of each damper's over all its frequencies, as two from one to the
    next share an optimum, and how far it is from 2 by their scatter.
    """
    found: list[Row] = []
    whole = []
    known = table.optima
    for height, orientation in dict.fromkeys((h, o) for h, _, o in known):
        frequencies = sorted(f for h, f, o in known if (h, o) == (height, orientation))
        ends = [known[height, f, orientation].gamma for f in (frequencies[0], frequencies[-1])]
        if len(frequencies) > 1:
            octaves = math.log(frequencies[-1] / frequencies[0])
            whole.append(math.log(ends[1] / ends[0]) / octaves)
        for low, high in pairwise(frequencies):
            first, second = known[height, low, orientation], known[height, high, orientation]
            octave = math.log(high / low)
            found.append({
                "height_mm": height, "orientation": orientation, "low": low, "high": high,
                "value": math.log(second.gamma / first.gamma) / octave,
                "noise": math.hypot(first.error(table.pooled), second.error(table.pooled)) / octave,
            })  # fmt: skip
    together = _against_two(whole)
    return [one | {"together": together} for one in found]


def _against_two(exponents: Sequence[float]) -> str:
    """Student's test of the mean of exponents against 2, in words; "" of fewer than three."""
    from scipy.stats import ttest_1samp

    sample = mean_sd(exponents)
    if sample.n < 3 or not sample.sd:
        return ""
    test = ttest_1samp(exponents, 2)
    return (
        f"; mean {sample.mean:.2f}, away from 2 by t = {test.statistic:.1f} of the lines' scatter "
        f"(p = {test.pvalue:.1g})"
    )


@OPTIMA.quantity
def change_with_orientation(table: Table63) -> list[Row]:
    """ln of the horizontal optimum over the vertical one.

    noise (and less, its negative) is what 5 mm of height do, by eq. 6.11 for the close packing.
    """
    found, known = [], table.optima
    for height, frequency in dict.fromkeys((h, f) for h, f, _ in known):
        vertical, horizontal = (
            known.get((height, frequency, o)) for o in ("vertical", "horizontal")
        )
        if vertical is None or horizontal is None:
            continue
        clearance = next(c.length for c in vertical.prediction.clearances if c.name == "close")
        if clearance:
            change = horizontal.gamma / vertical.gamma
            step = math.log(1 + 5e-3 / clearance)  # the clearance grows by the height
            found.append({"height_mm": height, "frequency_hz": frequency, "change": change - 1,
                          "value": math.log(change), "noise": step, "less": -step})  # fmt: skip
    return found


@OPTIMA.quantity
def distance_from_prediction(table: Table63) -> list[Row]:
    """|ln(ours/eq. 6.11)| of each damper for the loose and the close packing, where both are."""
    found = []
    for (line, one), name in product(table.optima.items(), ("loose", "close")):
        if one.predicted("loose") and (gamma := one.predicted(name)) and one.predicted("close"):
            found.append(
                _labels(line) | {"packing": name, "value": abs(math.log(one.gamma / gamma))}
            )
    return found
