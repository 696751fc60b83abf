"""Clogging of a silo by outlet, from the rows of its runs of avalanches."""

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import wilson
from silo2d.measures.clogging.laws import Estimate, Law, Outlets, exponential, outlet_of, power
from silo2d.measures.clogging.sizes import Mean, empties, form, independence, mean_avalanche, mode
from silo2d.measures.clogging.waits import tail

Row = dict[str, Any]

PROBABILITIES = 0.5, 0.05, 0.01  # of clogging, whose outlets are given


@dataclass(frozen=True)
class AtOutlet:
    """Runs of a silo at one outlet.

    sizes, cut     of all avalanches that count, one run after the other
    runs           the same run by run
    """

    outlet: float  # [m]
    across: float  # over the particles' diameter
    rows: list[Row]

    @property
    def runs(self) -> list[tuple[list[int], list[int]]]:
        """Sizes and cut of each run."""
        return [(row["sizes"], row["cut"]) for row in self.rows]

    def all_of(self, key: str) -> list[Any]:
        """A list of the rows, one after the other."""
        return [value for row in self.rows for value in row[key]]

    @property
    def mean(self) -> Mean:
        """Mean avalanche."""
        cut = self.all_of("cut")
        return mean_avalanche(sum(self.all_of("sizes")), len(cut) - sum(cut))


def by_outlet(rows: Sequence[Row]) -> list[AtOutlet]:
    """The runs that are done, by outlet from the smallest on."""
    found: dict[float, list[Row]] = {}
    for row in done(rows):
        found.setdefault(row["outlet_m"], []).append(row)
    return [
        AtOutlet(outlet, outlet / own[0]["diameter_m"], own)
        for outlet, own in sorted(found.items())
    ]


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
    return {
        "outlets": [_at(one, n, rest_time) for one in outlets],
        "diameter_m": diameter,
        "n_particles": n,
        "independence": _independence(outlets),
        "laws": {name: dataclasses.asdict(law) for name, law in laws.items()},
        "outlets_by_probability": _by_probability(seen, n, diameter),
    }


def laws_of(found: dict[str, Any]) -> list[Law]:
    """The laws of a study, as they were fitted."""
    return [
        Law(**{**law, "parameters": {k: Estimate(**v) for k, v in law["parameters"].items()}})
        for law in found["laws"].values()
    ]


def _particles(outlets: Sequence[AtOutlet]) -> int | None:
    """Particles of the filled silo, the mean of all runs."""
    numbers = [row["n_particles"] for one in outlets for row in one.rows]
    return round(sum(numbers) / len(numbers)) if numbers else None


def _at(one: AtOutlet, n: int | None, rest_time: float) -> dict[str, Any]:
    sizes, cut, mean = one.all_of("sizes"), one.all_of("cut"), one.mean
    # Of the runs whose first flow came to a clog, or to as many particles as the silo holds.
    known = [r for r in one.rows if r["first_clogged"] or r["first_size"] >= r["n_particles"]]
    clogged = sum(r["first_clogged"] and r["first_size"] < r["n_particles"] for r in known)
    arches = one.all_of("arch_particles")
    waits = np.sum([row["waits"] for row in one.rows], axis=0).tolist()
    correlation, beyond = independence(one.runs), mode(sizes, cut)
    value, low, high = empties(mean, n or 0)
    return {
        "outlet_m": one.outlet,
        "outlet_over_diameter": one.across,
        "runs": len(known),
        "clogged": clogged,
        "share": clogged / len(known) if known else None,
        "interval": list(wilson(clogged, len(known))),
        "avalanches": len(sizes),
        "cut": sum(cut),
        "mean_avalanche": mean.value,
        "mean_avalanche_interval": [mean.low, mean.high],
        "ratholes": sum(row["outcome"] == "rathole" for row in one.rows),
        "clogs_before_empty": 1 - value,
        "clogs_before_empty_interval": [1 - high, 1 - low],
        "form": _dict(form(sizes, cut)),
        "form_beyond_mode": _dict(form(sizes, cut, beyond)),
        "independence": _dict(correlation),
        "arch_particles": np.bincount(arches).tolist() if arches else [],
        "arch_particles_mean": float(np.mean(arches)) if arches else None,
        "arch_span_m": _median(one.all_of("arch_span_m")),
        "arch_aspect": _median(one.all_of("arch_aspect")),
        "arches_not_found": sum(row["arches_not_found"] for row in one.rows),
        "breaks": sum(row["breaks"] for row in one.rows),
        "waits": waits,
        "waits_tail": _dict(tail(waits, rest_time)),
        "cpu_s": math.fsum(row["cpu_s"] for row in one.rows),
    }


def _independence(outlets: Sequence[AtOutlet]) -> dict[str, Any] | None:
    """Rank correlation of successive sizes over their outlets' means, all outlets together."""
    runs = [
        ([size / mean for size in sizes], cut)
        for one in outlets
        if (mean := one.mean.value) is not None
        for sizes, cut in one.runs
    ]
    return _dict(independence(runs))


def _by_probability(seen: Outlets, n: int | None, diameter: float | None) -> list[dict[str, Any]]:
    """Outlets at which silos clog with some probabilities P before they are empty.

    (1 - 1/<s>)^n = 1 - P by the exponential law; larger ones than were seen are extrapolated.
    """
    lines: list[dict[str, Any]] = []
    if not n or diameter is None:
        return lines
    for probability in PROBABILITIES:
        found = outlet_of(1 / -math.expm1(math.log1p(-probability) / n), seen)
        if found is not None:
            ends = [None if end is None else end * diameter for end in (found.low, found.high)]
            lines.append({
                "probability": probability, "outlet_m": found.value * diameter, "interval_m": ends,
                "outlet_over_diameter": found.value,
                "extrapolated": bool(found.value > seen.across.max()),
            })  # fmt: skip
    return lines


def _dict(found: Any) -> dict[str, Any] | None:
    return None if found is None else dataclasses.asdict(found)


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None
