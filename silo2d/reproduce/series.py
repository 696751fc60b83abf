"""The runs of one parameter from one baseline: times and their trend."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import Sample, mean_sd
from silo2d.reproduce.trend import Trend

if TYPE_CHECKING:
    from silo2d.reproduce import Row


@dataclass(frozen=True)
class Series:
    """The runs of one parameter from one baseline."""

    parameter: str
    pairs: str
    baseline: str
    rows: "list[Row]"

    @cached_property
    def values(self) -> list[float]:
        """Of the parameter, as they come."""
        return list(dict.fromkeys(row["value"] for row in self.rows))

    def at(self, value: float) -> "list[Row]":
        """The runs at one value."""
        return [row for row in self.rows if row["value"] == value]

    def time(self, value: float, key: str = "discharge_time_s") -> Sample:
        """Of the runs at one value that emptied [s]."""
        return mean_sd([time for _, time in _points(self.at(value), key)])

    def trend(self, key: str = "discharge_time_s") -> Trend | None:
        """Of all runs that emptied."""
        points = _points(self.rows, key)
        return Trend.of(self.parameter, [v for v, _ in points], [t for _, t in points], 0.0)


def series_of(rows: "list[Row]") -> dict[tuple[str, str], dict[str, Series]]:
    """The series there are, by parameter and pairs, then by baseline."""
    found: dict[tuple[str, str], dict[str, list[Row]]] = {}
    for row in rows:
        one = found.setdefault((row["parameter"], row["pairs"]), {})
        one.setdefault(row["baseline"], []).append(row)
    return {
        key: {name: Series(*key, name, own) for name, own in one.items()}
        for key, one in found.items()
    }


def _points(rows: "list[Row]", key: str) -> list[tuple[float, float]]:
    return [(row["value"], row[key]) for row in done(rows) if row[key] is not None]
