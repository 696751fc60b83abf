"""How a time changes over a table's range of a parameter, in numbers and in words."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from granulab.campaign.output.layout import percent, signed
from granulab.campaign.output.statistics import Slope, slope, welch_half_width

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

    def beside(self, published: "Trend") -> str:
        """How this one compares with the published one."""
        mine, theirs = self.slope, published.slope
        allowed = welch_half_width([mine.error**2, theirs.error**2], [mine.freedom, theirs.freedom])
        if abs(mine.value - theirs.value) <= allowed:
            return "agrees"
        if mine.value * theirs.value < 0:
            return "opposite"
        return "steeper" if abs(mine.value) > abs(theirs.value) else "weaker"
