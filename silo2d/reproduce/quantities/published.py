"""Published tables that ours are compared with, errata taken in, and how the runs of a silo ended.

Source: Alonso-Marroquin et al., Granular Matter 15 (2013) 811, doi 10.1007/s10035-013-0443-7.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from granulab.campaign.output.layout import Row, done
from granulab.campaign.output.statistics import CONFIDENCE, Counts, Sample, chance_of_shares
from granulab.contact.files.datafile import shipped_rows
from silo2d.run.numbers import published_times

ROUNDING = 0.01  # [s] of all printed times


@dataclass(frozen=True)
class Trials:
    """Published numbers of a silo: the experiment's trials, and SPOLY's one run."""

    time: Sample  # of the trials that did not clog [s]
    n: int  # trials, 0 where the silo is not the paper's
    clogged: int
    spoly_s: float | None  # None where it clogged, or where no time was printed
    spoly_clogged: bool | None  # None where nothing was printed


@dataclass(frozen=True)
class Point:
    """A line of Tables 7 to 11: A4's discharge time at one value of one parameter."""

    parameter: str  # kn, kt, mu, gamma_n or gamma_t
    value: float
    unit: str
    restitution: float | None  # as printed; holds for a reduced mass of 92 g only
    time_s: float


def trials(silo: str) -> Trials:
    """The experiment (Table 5; A3's trial 5 is 2.07 s) and SPOLY (Table 6, Fig. 13) of a silo."""
    known = published_times(silo)
    n, clogged = int(known["experiment_n"] or 0), int(known["experiment_clogged"] or 0)
    time = Sample(n - clogged, known["experiment_mean_s"], known["experiment_sd_s"])
    spoly = known["simulation_clogged"]
    return Trials(time, n, clogged, known["simulation_s"], None if spoly is None else bool(spoly))


def sensitivity() -> list[Point]:
    """Tables 7 to 11, the first kn being 6.25e2 N/mm."""
    return [
        Point(
            row["parameter"],
            float(row["value"]),
            row["unit"],
            float(row["restitution"]) if row["restitution"] else None,
            float(row["time_s"]),
        )
        for row in shipped_rows("published", "silo_sensitivity")
    ]


def outcomes(rows: Sequence[Row]) -> tuple[int, int, int]:
    """Numbers of runs that clogged, did so at the opening, and flowed to an end or clogged.

    A run that the time limit cut off is in neither number.
    """
    ended = [row["outcome"] for row in done(rows) if row["outcome"] != "time_limit"]
    at_opening = ended.count("clogged_at_opening")
    return ended.count("clogged") + at_opening, at_opening, len(ended)


def by_silo(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """The rows of each silo, in their order."""
    silos = dict.fromkeys(row["silo"] for row in rows)
    return {silo: [row for row in rows if row["silo"] == silo] for silo in silos}


def unfinished(rows: Sequence[Row], n: int) -> str:
    """Return what else there is than n runs that flowed to an end or clogged."""
    counts = {"at the time limit": len(done(rows)) - n}
    for state in ("failed", "interrupted"):
        counts[state] = sum(row["state"] == state for row in rows)
    return "".join(f", {count} {what}" for what, count in counts.items() if count)


def outcome_word(known: Trials, k: int, n: int) -> str:
    """Return whether k of n clogged runs agree with the experiment, by Fisher's exact test."""
    if not known.n or not n:
        return "-"
    if chance_of_shares([Counts(k, n, known.clogged, known.n)]) >= 1 - CONFIDENCE:
        return "agrees"
    return f"clogs {'more' if k / n > known.clogged / known.n else 'less'} often"
