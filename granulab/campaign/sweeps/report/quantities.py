"""Quantities that the runs of a simulator are compared by, and their means over seeds.

All intervals are of 95 %: Student's of a mean, Wilson's of a share. A run that failed or was
interrupted enters none of them; one that is done and has no value of a number (a discharge time of
a silo that clogged) lacks in the number's mean and counts in the shares.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import (
    Sample,
    half_width_of_mean,
    mean_sd,
    pooled_sd,
    quantile,
    wilson,
)

Row = dict[str, Any]
Rows = Sequence[Row]


class Number(NamedTuple):
    """A number that each run has, or lacks.

    better      whether more of it is better, or less; "": neither
    interval    column with its interval over the cycles of one run, for a mean of one run
    charted     whether pictures show it; tables always do
    counts      runs whose value counts; None: all
    """

    column: str
    label: str
    unit: str = ""
    better: Literal["more", "less", ""] = ""
    interval: str = ""
    charted: bool = True
    counts: Callable[[Row], bool] | None = None

    def of(self, row: Row) -> Any:
        """Value of a run that is done, None where it has none or does not count."""
        return row.get(self.column) if self.counts is None or self.counts(row) else None


class Ending(NamedTuple):
    """A way that runs end, of whose share less is better.

    named       whether the share is also given where no run ended so
    """

    name: str
    label: str
    is_one: Callable[[Row], bool]
    named: bool = False


@dataclass(frozen=True)
class Quantities:
    """Quantities of a simulator's runs.

    order       names by which combinations are ranked: a later one among those that are alike in
                the earlier ones
    """

    numbers: tuple[Number, ...] = ()
    endings: tuple[Ending, ...] = ()
    order: tuple[str, ...] = ()

    def of(self, rows: Rows) -> "Quantities":
        """Those that any of the rows has."""
        rows = done(rows)
        numbers = [n for n in self.numbers if any(n.of(row) is not None for row in rows)]
        endings = [e for e in self.endings if e.named or any(map(e.is_one, rows))]
        names = {n.column for n in numbers} | {e.name for e in endings}
        order = tuple(name for name in self.order if name in names)
        return Quantities(tuple(numbers), tuple(endings), order)

    @property
    def named(self) -> Mapping[str, Number | Ending]:
        """All of them by name."""
        return {n.column: n for n in self.numbers} | {e.name: e for e in self.endings}

    def ended(self, row: Row) -> str:
        """The way that a run ended in a word; "" where nothing is said of it."""
        if row["state"] != "done":
            return str(row["state"])
        return next((ending.label for ending in self.endings if ending.is_one(row)), "")


def name_of(quantity: Number | Ending) -> str:
    """Its name in tables."""
    return quantity.column if isinstance(quantity, Number) else quantity.name


def heading(quantity: Number | Ending) -> str:
    """Label with unit."""
    if isinstance(quantity, Ending):
        return f"share {quantity.label}"
    return f"{quantity.label} [{quantity.unit or '-'}]"


class Estimate(NamedTuple):
    """A mean or share with its 95 % interval; None where there is none.

    n, of       runs with a value, or that ended so, of so many that are done
    sd          standard deviation over the runs, of a number
    """

    mean: float | None
    low: float | None
    high: float | None
    n: int
    of: int
    sd: float | None = None

    @property
    def half_width(self) -> float | None:
        """Half the width of the interval."""
        return None if self.low is None or self.high is None else (self.high - self.low) / 2


def estimate(quantity: Number | Ending, rows: Rows) -> Estimate:
    """Mean or share of some runs.

    Of one run with an interval over its own cycles, the interval is that.
    """
    rows = done(rows)
    if isinstance(quantity, Ending):
        k, n = sum(map(quantity.is_one, rows)), len(rows)
        return Estimate(k / n, *wilson(k, n), k, n) if n else Estimate(None, None, None, 0, 0)
    known = [row for row in rows if quantity.of(row) is not None]
    sample = mean_sd([quantity.of(row) for row in known])
    half = half_width_of_mean(sample)
    if half is None or sample.mean is None:
        low, high = (known[0].get(quantity.interval) if known else None) or (None, None)
        return Estimate(sample.mean, low, high, sample.n, len(rows))
    return Estimate(
        sample.mean, sample.mean - half, sample.mean + half, sample.n, len(rows), sample.sd
    )


def pooled(quantity: Number | Ending, groups: Sequence[Rows]) -> Estimate:
    """Mean over groups of runs, all of the same weight, or share of all their runs.

    The groups are taken to scatter alike, s by all of them with f degrees of freedom; the spread
    between them does not enter: t(f) s sqrt(sum 1/n)/C for C groups of n runs, as in an analysis of
    variance. There is no interval where no group has two values; a group without any is left out.
    """
    if len(groups) == 1 or isinstance(quantity, Ending):
        return estimate(quantity, [row for rows in groups for row in rows])
    found = [estimate(quantity, rows) for rows in groups]
    known = [Sample(one.n, one.mean, one.sd) for one in found if one.mean is not None]
    n, of = sum(one.n for one in found), sum(one.of for one in found)
    if not known:
        return Estimate(None, None, None, 0, of)
    mean = math.fsum(one.mean for one in known if one.mean is not None) / len(known)
    scatter = pooled_sd(known)
    if scatter is None:
        return Estimate(mean, None, None, n, of)
    sd, freedom = scatter
    half = quantile(freedom) * sd * math.sqrt(sum(1 / one.n for one in known)) / len(known)
    return Estimate(mean, mean - half, mean + half, n, of)
