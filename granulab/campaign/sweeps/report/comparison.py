"""Combinations of a study compared: their estimates, and the order from the best to the worst."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import (
    Sample,
    difference_of_shares,
    noise_of_difference,
)
from granulab.campaign.sweeps.report.axes import Axis, Varied, axes_of, key_of
from granulab.campaign.sweeps.report.quantities import (
    Ending,
    Estimate,
    Number,
    Quantities,
    Rows,
    estimate,
    name_of,
)


@dataclass(frozen=True)
class Combination:
    """Runs that differ in their seeds alone."""

    labels: Mapping[str, Any]
    rows: Rows
    estimates: Mapping[str, Estimate]  # by name of the quantity

    @property
    def done(self) -> int:
        """Number of runs that came to an end."""
        return len(done(self.rows))

    @property
    def cpu_s(self) -> float | None:
        """Mean CPU time [s] of the runs that are done; None where none says."""
        known = [row["cpu_s"] for row in done(self.rows) if row.get("cpu_s") is not None]
        return math.fsum(known) / len(known) if known else None


@dataclass(frozen=True)
class Ranked:
    """A combination with its rank.

    rank        1 for the best; the same for those that are alike, None where it has no value
    as_good     whether its difference from the best is within 95 % of noise; None: not known, as
                one of the two is a single run
    """

    rank: int | None
    combination: Combination
    as_good: bool | None


@dataclass(frozen=True)
class Comparison:
    """A study's runs by what was varied.

    offered     quantities of the simulator; quantities: those that any run has
    """

    name: str
    varied: tuple[Varied, ...]
    offered: Quantities
    quantities: Quantities
    combinations: tuple[Combination, ...]

    @classmethod
    def of(
        cls, name: str, varied: Sequence[Varied], quantities: Quantities, rows: Rows
    ) -> "Comparison":
        """From rows as run_labelled gives them; the order is that of the rows."""
        groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
        for row in rows:
            groups.setdefault(tuple(key_of(row[one.column]) for one in varied), []).append(row)
        combinations = [
            Combination(
                {one.column: group[0][one.column] for one in varied},
                group,
                {key: estimate(what, group) for key, what in quantities.named.items()},
            )
            for group in groups.values()
        ]
        return cls(name, tuple(varied), quantities, quantities.of(rows), tuple(combinations))

    @cached_property
    def axes(self) -> list[Axis]:
        """Varied keys, those that went together as one."""
        return axes_of(self.varied, [one.labels for one in self.combinations])

    @property
    def rows(self) -> Rows:
        """All runs."""
        return [row for one in self.combinations for row in one.rows]

    @property
    def shown(self) -> list[Number | Ending]:
        """Quantities of pictures and of the terminal, those of the order first.

        Other endings than the named ones are marked in pictures, and remarked on in the table.
        """
        named = self.quantities.named
        first = [named[name] for name in self.quantities.order]
        rest = (
            one
            for one in named.values()
            if (one.named if isinstance(one, Ending) else one.charted) and one not in first
        )
        return [*first, *rest]

    @property
    def columns(self) -> list[Varied]:
        """Columns by which combinations differ, those left out that repeat another's values."""
        kept: dict[tuple[Any, ...], Varied] = {}
        for one in self.varied:
            values = tuple(key_of(each.labels[one.column]) for each in self.combinations)
            if len(set(values)) > 1:
                kept.setdefault(values, one)
        return list(kept.values())

    @property
    def endings(self) -> dict[str, int]:
        """Number of runs by how they ended, those of which nothing is said left out."""
        words = (self.quantities.ended(row) for row in self.rows)
        return dict(Counter(word for word in words if word))

    @property
    def seeds(self) -> str:
        """Number of runs of a combination in words: "5", or "3 to 5"."""
        counts = [len(one.rows) for one in self.combinations] or [0]
        least, most = min(counts), max(counts)
        return f"{most}" if least == most else f"{least} to {most}"

    @cached_property
    def ranking(self) -> list[Ranked]:
        """Combinations from the best to the worst, then those without a value.

        See Quantities.order. A combination is ranked by its runs that are done.
        """
        order = [self.quantities.named[name] for name in self.quantities.order]

        def key(one: Combination) -> tuple[tuple[bool, float], ...]:
            return tuple(_goodness(what, one.estimates[name_of(what)]) for what in order)

        def has_none(one: Combination) -> bool:
            return not order or one.estimates[name_of(order[0])].mean is None

        found = sorted((one for one in self.combinations if not has_none(one)), key=key)
        first = {key(one): k for k, one in reversed(list(enumerate(found, start=1)))}
        return [
            *(Ranked(first[key(one)], one, _as_good(order, found[0], one)) for one in found),
            *(Ranked(None, one, None) for one in self.combinations if has_none(one)),
        ]


def _goodness(what: Number | Ending, found: Estimate) -> tuple[bool, float]:
    """Key that sorts the better one in front, those without a value last."""
    if found.mean is None:
        return True, 0.0
    more = isinstance(what, Number) and what.better == "more"
    return False, -found.mean if more else found.mean


def _as_good(order: Sequence[Number | Ending], best: Combination, one: Combination) -> bool | None:
    """True where no quantity of the order tells a combination from the best; see Ranked."""
    if one is best:
        return True
    judged = [
        _alike(what, best.estimates[name_of(what)], one.estimates[name_of(what)]) for what in order
    ]
    return False if False in judged else None if None in judged else True


def _alike(what: Number | Ending, first: Estimate, second: Estimate) -> bool | None:
    """True where two estimates differ by no more than noise; None where that is not known."""
    if first.mean is None or second.mean is None:
        return True if first.mean is second.mean else None
    if isinstance(what, Ending):
        low, high = difference_of_shares(first.n, first.of, second.n, second.of)
        return low <= 0.0 <= high
    noise = noise_of_difference(
        Sample(first.n, first.mean, first.sd), Sample(second.n, second.mean, second.sd)
    )
    if noise is None:  # of single runs, from what their cycles scatter
        halves = first.half_width, second.half_width
        if None in halves:
            return None
        noise = math.hypot(*(half for half in halves if half is not None))
    return abs(first.mean - second.mean) <= noise
