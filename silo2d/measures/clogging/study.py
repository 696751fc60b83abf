"""Clogging of a silo by outlet, from the rows of its runs of avalanches."""

import dataclasses
import itertools
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import wilson
from silo2d.measures.clogging.laws import Estimate, Law, Outlets, exponential, outlet_of, power
from silo2d.measures.clogging.sizes import (
    Mean,
    Run,
    empties,
    form,
    independence,
    joined,
    mean_avalanche,
    mode,
    scatter,
)
from silo2d.measures.clogging.waits import tail

Row = dict[str, Any]

PROBABILITIES = 0.5, 0.05, 0.01  # of clogging, whose outlets are given


@dataclass(frozen=True)
class AtOutlet:
    """Runs of a silo at one outlet; runs: the avalanches of each, whose pieces are joined."""

    outlet: float  # [m]
    across: float  # over the particles' diameter
    rows: list[Row]
    runs: list[Run]

    def all_of(self, key: str) -> list[Any]:
        """A list of the rows, one after the other."""
        return [value for row in self.rows for value in row[key]]

    @property
    def sizes(self) -> list[int]:
        """Sizes of all avalanches that count, one run after the other."""
        return [size for run in self.runs for size in run.sizes]

    @property
    def cut(self) -> list[int]:
        """Marks of those that no clog ended: 1, else 0."""
        return [cut for run in self.runs for cut in run.cut]

    @property
    def unclogged(self) -> int:
        """Particles that left after the first cut, where nothing clogged at all; else 0.

        The flow from the opening is no avalanche, but once it was cut off it has forgotten that.
        """
        clogged = self.sizes or any(run.first_clogged for run in self.runs)
        return 0 if clogged else sum(self.all_of("sizes"))

    @property
    def mean(self) -> Mean:
        """Mean avalanche; of an outlet at which nothing clogged a lower bound."""
        cut = self.cut
        if unclogged := self.unclogged:
            return mean_avalanche(unclogged, 0)
        return mean_avalanche(sum(self.sizes), len(cut) - sum(cut), scatter(self.runs)[0])


def by_outlet(rows: Sequence[Row]) -> list[AtOutlet]:
    """The runs that are done, by outlet from the smallest on."""
    found: dict[float, list[Row]] = {}
    for row in done(rows):
        found.setdefault(row["outlet_m"], []).append(row)
    return [
        AtOutlet(outlet, outlet / own[0]["diameter_m"], own, [_run(row) for row in own])
        for outlet, own in sorted(found.items())
    ]


def _run(row: Row) -> Run:
    return joined(row["first_size"], row["first_clogged"], row["sizes"], row["cut"])


def seen_at(outlets: Sequence[AtOutlet]) -> Outlets:
    """Outlets as laws are fitted to them."""
    means = [one.mean for one in outlets]
    return Outlets(
        np.array([one.across for one in outlets]),
        np.array([mean.exposure for mean in means], float),
        np.array([mean.clogs for mean in means], float),
    )


def study(rows: Sequence[Row], rest_time: float) -> dict[str, Any]:
    """Statistics of the runs of one silo with one kind of particles; SI.

    rest_time: of the case [s], above which a pause counts as a clog.
    """
    outlets = by_outlet(rows)
    seen, n = seen_at(outlets), _particles(outlets)
    laws = {law.name: law for fit in (exponential, power) if (law := fit(seen)) is not None}
    diameter = outlets[0].rows[0]["diameter_m"] if outlets else None
    # One start for all, since exponents of other parts of a curved tail are not to be compared.
    tails = [tail(_waits(one), rest_time) for one in outlets]
    start = max((one.start for one in tails if one is not None), default=0.0)
    return {
        "outlets": [_at(one, n, rest_time, start) for one in outlets],
        "diameter_m": diameter,
        "n_particles": n,
        "independence": _independence(outlets),
        "laws": {name: dataclasses.asdict(law) for name, law in laws.items()},
        "outlets_by_probability": _by_probability(seen, n, diameter, laws.values()),
    }


def laws_of(found: Mapping[str, Any]) -> list[Law]:
    """The laws of a study, as they were fitted."""
    return [
        Law(**{**law, "parameters": {k: Estimate(**v) for k, v in law["parameters"].items()}})
        for law in found["laws"].values()
    ]


def _particles(outlets: Sequence[AtOutlet]) -> int | None:
    """Particles of the filled silo, the mean of all runs."""
    numbers = [row["n_particles"] for one in outlets for row in one.rows]
    return round(sum(numbers) / len(numbers)) if numbers else None


def _waits(one: AtOutlet) -> list[int]:
    """Numbers of waiting times, by bins."""
    return [int(n) for n in np.sum([row["waits"] for row in one.rows], axis=0)]


def _first_flow(one: AtOutlet) -> tuple[int, int]:
    """Runs that clogged from the opening before as many particles left as the silo holds, of how
    many: none, where a flow ended before without a clog, as what it would have done is not known.
    """
    both = [(run, row["n_particles"]) for run, row in zip(one.runs, one.rows, strict=True)]
    if not all(run.first_clogged or run.first >= n for run, n in both):
        return 0, 0
    return sum(run.first_clogged and run.first < n for run, n in both), len(both)


def _at(one: AtOutlet, n: int | None, rest_time: float, start: float) -> dict[str, Any]:
    """Statistics of one outlet; start: of the waits' tails [s]."""
    sizes, cut, mean = one.sizes, one.cut, one.mean
    clogged, known = _first_flow(one)
    arches, waits = one.all_of("arch_particles"), _waits(one)
    beyond = mode(sizes, cut)
    value, low, high = empties(mean, n or 0)
    return {
        "outlet_m": one.outlet,
        "outlet_over_diameter": one.across,
        "runs": known,
        "clogged": clogged,
        "share": clogged / known if known else None,
        "interval": list(wilson(clogged, known)),
        "avalanches": len(sizes),
        "cut": sum(cut),
        "unclogged": one.unclogged,
        "mean_avalanche": mean.value,
        "mean_avalanche_interval": [mean.low, mean.high],
        "runs_alike": scatter(one.runs)[1],
        "ended_early": dict(
            Counter(row["outcome"] for row in one.rows if row["outcome"] != "whole")
        ),
        "clogs_before_empty": 1 - value,
        "clogs_before_empty_interval": [1 - high, 1 - low],
        "form": _dict(form(sizes, cut)),
        "form_beyond_mode": _dict(form(sizes, cut, beyond)),
        "independence": _dict(independence([(run.sizes, run.cut) for run in one.runs])),
        "arch_particles": np.bincount(arches).tolist() if arches else [],
        "arch_particles_mean": float(np.mean(arches)) if arches else None,
        "arch_span_m": _median(one.all_of("arch_span_m")),
        "arch_aspect": _median(one.all_of("arch_aspect")),
        "arches_not_found": sum(row["arches_not_found"] for row in one.rows),
        "breaks": sum(row["breaks"] for row in one.rows),
        "waits": waits,
        "waits_tail": _dict(tail(waits, rest_time, start)),
        "cpu_s": math.fsum(row["cpu_s"] for row in one.rows),
    }


def _independence(outlets: Sequence[AtOutlet]) -> dict[str, Any] | None:
    """Rank correlation of successive sizes, all outlets together, by the rank at their own outlet:
    sizes over the mean would link those of outlets whose sizes have unlike forms.
    """
    from scipy.stats import rankdata

    runs: list[tuple[Sequence[float], Sequence[int]]] = []
    for one in outlets:
        of_all = iter(rankdata(one.sizes) / max(len(one.sizes), 1))
        runs += [([float(next(of_all)) for _ in run.sizes], run.cut) for run in one.runs]
    return _dict(independence(runs))


def _by_probability(
    seen: Outlets, n: int | None, diameter: float | None, laws: Iterable[Law]
) -> list[dict[str, Any]]:
    """Outlets at which silos clog with some probabilities P before they are empty, by each law.

    (1 - 1/<s>)^n = 1 - P; larger ones than were seen are extrapolated, but not by a law that those
    refute (p below 0.05).
    """
    if not n or diameter is None:
        return []
    lines: list[dict[str, Any]] = []
    for probability, law in itertools.product(PROBABILITIES, laws):
        found = outlet_of(1 / -math.expm1(math.log1p(-probability) / n), law, seen)
        if found is None or ((beyond := bool(found.value > seen.across.max())) and law.refuted):
            continue
        ends = [None if end is None else end * diameter for end in (found.low, found.high)]
        lines.append({
            "probability": probability, "law": law.name, "outlet_m": found.value * diameter,
            "interval_m": ends, "outlet_over_diameter": found.value, "extrapolated": beyond,
        })  # fmt: skip
    return lines


def _dict(found: Any) -> dict[str, Any] | None:
    return None if found is None else dataclasses.asdict(found)


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None
