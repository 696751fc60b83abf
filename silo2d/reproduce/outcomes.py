"""How the runs of a silo ended, in numbers and beside what was published."""

from collections.abc import Sequence

from granulab.campaign.output.layout import Row, done
from granulab.campaign.output.statistics import overlap, wilson
from silo2d.reproduce.published import Trials


def outcomes(rows: Sequence[Row]) -> tuple[int, int, int]:
    """How many runs clogged, of these at the opening, of how many that flowed to an end or clogged.

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
    """What else there is than n runs that flowed to an end or clogged."""
    counts = {"at the time limit": len(done(rows)) - n}
    for state in ("failed", "interrupted"):
        counts[state] = sum(row["state"] == state for row in rows)
    return "".join(f", {count} {what}" for what, count in counts.items() if count)


def outcome_word(known: Trials, k: int, n: int) -> str:
    """Whether k of n clogged runs are compatible with the experiment: their intervals overlap."""
    if not known.n or not n:
        return "-"
    if overlap(wilson(known.clogged, known.n), wilson(k, n)):
        return "agrees"
    return f"clogs {'more' if k / n > known.clogged / known.n else 'less'} often"
