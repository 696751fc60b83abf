"""Times against one parameter from one baseline: a series of runs, and its trend in words."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from granulab.campaign.output.layout import Row, done, percent, signed
from granulab.campaign.output.statistics import Sample, Slope, mean_sd, slope, welch_half_width

LOGARITHMIC = "kn", "kt", "gamma_n"  # parameters tabled in steps of a factor


@dataclass(frozen=True)
class Trend:
    """A slope over the range of its points, as a part of their mean time."""

    slope: Slope
    span: float  # of the abscissa
    mean: float  # [s]

    @classmethod
    def of(
        cls, parameter: str, values: Sequence[float], times: Sequence[float], rounding: float
    ) -> "Trend | None":
        """The trend of times [s]; None for too few points."""
        x = [math.log(v) if parameter in LOGARITHMIC else v for v in values]
        found = slope(x, times, rounding)
        if found is None:
            return None
        return cls(found, max(x) - min(x), math.fsum(times) / len(times))

    def words(self) -> str:
        """ "rises by 5 % (+- 2 %)" """
        change = self.slope.value * self.span / self.mean
        noise = self.slope.half_width * self.span / self.mean
        if abs(change) <= noise:
            return f"flat within noise, {signed(change)} (+- {percent(noise)})"
        return (
            f"{'rises' if change > 0 else 'falls'} by {percent(abs(change))} (+- {percent(noise)})"
        )

    def compared_with(self, published: "Trend") -> str:
        """Return how this one compares with the published one."""
        mine, theirs = self.slope, published.slope
        allowed = welch_half_width([mine.error**2, theirs.error**2], [mine.freedom, theirs.freedom])
        if abs(mine.value - theirs.value) <= allowed:
            return "agrees"
        if mine.value * theirs.value < 0:
            return "opposite"
        return "steeper" if abs(mine.value) > abs(theirs.value) else "weaker"


@dataclass(frozen=True)
class Series:
    """The runs of one parameter from one baseline."""

    parameter: str
    pairs: str
    baseline: str
    rows: list[Row]

    @cached_property
    def values(self) -> list[float]:
        """Of the parameter, as they come."""
        return list(dict.fromkeys(row["value"] for row in self.rows))

    def at(self, value: float) -> list[Row]:
        """The runs at one value."""
        return [row for row in self.rows if row["value"] == value]

    def time(self, value: float, key: str = "discharge_time_s") -> Sample:
        """Of the runs at one value that emptied [s]."""
        return mean_sd([time for _, time in _points(self.at(value), key)])

    def trend(self, key: str = "discharge_time_s") -> Trend | None:
        """Of all runs that emptied."""
        points = _points(self.rows, key)
        return Trend.of(self.parameter, [v for v, _ in points], [t for _, t in points], 0.0)


def series_of(rows: list[Row]) -> dict[tuple[str, str], dict[str, Series]]:
    """The series there are, by parameter and pairs, then by baseline."""
    found: dict[tuple[str, str], dict[str, list[Row]]] = {}
    for row in rows:
        one = found.setdefault((row["parameter"], row["pairs"]), {})
        one.setdefault(row["baseline"], []).append(row)
    return {
        key: {name: Series(*key, name, own) for name, own in one.items()}
        for key, one in found.items()
    }


def _points(rows: list[Row], key: str) -> list[tuple[float, float]]:
    return [(row["value"], row[key]) for row in done(rows) if row[key] is not None]
