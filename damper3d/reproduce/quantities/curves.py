"""A number of some runs against a label: means over the packings, with their spread."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import mean_sd

Row = dict[str, Any]


@dataclass(frozen=True)
class Curve:
    """Means by rising x, and standard deviations over the packings (0 where there is one run)."""

    x: list[float]
    mean: list[float]
    sd: list[float]

    def between(self, low: float, high: float) -> "Curve":
        """The points with low <= x <= high."""
        chosen = [k for k, x in enumerate(self.x) if low <= x <= high]
        return Curve(*([column[k] for k in chosen] for column in (self.x, self.mean, self.sd)))

    @property
    def points(self) -> dict[float, float]:
        """The means by x."""
        return dict(zip(self.x, self.mean, strict=True))


def curve(
    rows: Sequence[Row], value: str | Callable[[Row], float | None], x: str = "gamma"
) -> Curve:
    """Of a column, or of what is reckoned from a row, of the runs that are done and have it."""
    found: dict[float, list[float]] = {}
    for row in done(rows):
        number = row[value] if isinstance(value, str) else value(row)
        if number is not None:
            found.setdefault(float(row[x]), []).append(number)
    points = sorted(found)
    samples = [mean_sd(found[point]) for point in points]
    return Curve(points, [s.mean or 0.0 for s in samples], [s.sd or 0.0 for s in samples])
