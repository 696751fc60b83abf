"""Words on a comparison: the ranking as a table for the terminal, numbers with their intervals."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from granulab.campaign.output.layout import (
    fitted,
    paragraphs,
    share_within,
    with_half_width,
    wrapped,
)
from granulab.campaign.sweeps.report.comparison import Combination, Comparison, Ranked
from granulab.campaign.sweeps.report.quantities import (
    Ending,
    Estimate,
    Number,
    Quantities,
    heading,
    name_of,
)

MOST_ROWS = 12  # of a ranking on the terminal
NO_INTERVAL = "no interval, as of no combination two runs have a value"
_PARTS = ("mean", "sd", "n", "low", "high")  # of an estimate
_LETTERS = 26  # of a word that was varied


def spelled(found: Estimate) -> str:
    """ "0.341 ± 0.012 (3)": mean, half width of the interval, runs; "(3 of 5)" where some lack."""
    if found.mean is None:
        return "-"
    runs = f"{found.n}" if found.n == found.of else f"{found.n} of {found.of}"
    return f"{with_half_width(found.mean, found.half_width)} ({runs})"


def in_words(what: Number | Ending, found: Estimate) -> str:
    """An estimate as a cell of a table."""
    if isinstance(what, Ending):
        return share_within(found.n, found.of, found.low, found.high)
    return spelled(found)


def order_in_words(quantities: Quantities) -> str:
    """The order of a ranking: "share clogged (less), mass flow [kg/s] (more)"."""
    parts = []
    for name in quantities.order:
        what = quantities.named[name]
        better = what.better if isinstance(what, Number) else "less"
        parts.append(f"{_plainly(what)} ({'most' if better == 'more' else 'least'} first)")
    return ", then ".join(parts)


def ranking_as_text(comparison: Comparison) -> str:
    """The best combinations, a line each, no wider than the terminal."""
    ranking = comparison.ranking
    if not ranking or not comparison.quantities.order:
        return ""
    shown = ranking[:MOST_ROWS]
    columns, measured = comparison.columns, comparison.shown
    header = [
        "rank",
        *(one.heading for one in columns),
        *(_head(what) for what in measured),
        "CPU [s]",
        "remarks",
    ]
    cells = [
        [
            rank_in_words(one),
            *(short(column.shown(one.combination.labels[column.column])) for column in columns),
            *(in_words(what, one.combination.estimates[name_of(what)]) for what in measured),
            "-" if one.combination.cpu_s is None else f"{one.combination.cpu_s:.3g}",
            _remarks(comparison, one),
        ]
        for one in shown
    ]
    kept = [k for k in range(len(header)) if header[k] != "remarks" or any(c[k] for c in cells)]
    table = fitted([header[k] for k in kept], [[line[k] for k in kept] for line in cells], 1)
    return paragraphs(
        wrapped(f"{comparison.name}: ranked by {order_in_words(comparison.quantities)}", 2),
        table,
        "\n".join(wrapped(line, 3) for line in [*_more(ranking), *notes_on(comparison)]),
    )


def _more(ranking: Sequence[Ranked]) -> list[str]:
    left = len(ranking) - MOST_ROWS
    return [f"... and {left} more, in the table and the page"] if left > 0 else []


def _head(what: Number | Ending) -> str:
    return what.label if isinstance(what, Ending) else _plainly(what)


def _plainly(what: Number | Ending) -> str:
    return heading(what).removesuffix(" [-]")


def short(text: str) -> str:
    """A text cut to the room of a column."""
    return text if len(text) <= _LETTERS else f"{text[: _LETTERS - 1]}…"


def rank_in_words(one: Ranked) -> str:
    """Rank of a combination; with ~ where it cannot be told from the best."""
    return "-" if one.rank is None else f"{one.rank}{'~' if one.as_good and one.rank > 1 else ''}"


def lacking(one: Ranked) -> str:
    """Runs of a combination that are not done: "1 failed"."""
    states = Counter(row["state"] for row in one.combination.rows if row["state"] != "done")
    return ", ".join(f"{n} {state}" for state, n in states.items())


def _remarks(comparison: Comparison, one: Ranked) -> str:
    """Endings that have no column on the terminal, and runs that are not done."""
    others = [what for what in comparison.quantities.endings if what not in comparison.shown]
    found = ((one.combination.estimates[what.name].n, what.label) for what in others)
    return ", ".join([*(f"{n} {label}" for n, label in found if n), *filter(None, [lacking(one)])])


def notes_on(comparison: Comparison) -> list[str]:
    """Lines that say how a ranking is read."""
    notes = []
    if any(one.as_good and one.rank != 1 for one in comparison.ranking):
        notes.append("~  not to be told from the best (95 %)")
    if not comparison.quantities.numbers:
        return notes
    if not has_intervals(comparison):
        notes.append(NO_INTERVAL)
    elif comparison.seeds == "1":
        notes.append("±  95 % interval over the cycles of one run; (runs)")
    else:
        shares = any(isinstance(what, Ending) for what in comparison.shown)
        notes.append(
            "±  half of Student's 95 % interval of the mean, (runs with a value)"
            + ("; of shares Wilson's 95 % interval" if shares else "")
        )
    return notes


def has_intervals(comparison: Comparison) -> bool:
    """True where any mean of a number has an interval."""
    return any(
        one.estimates[number.column].half_width is not None
        for one in comparison.combinations
        for number in comparison.quantities.numbers
    )


def ranking_rows(comparison: Comparison) -> list[dict[str, Any]]:
    """The ranking for --json: rank, labels in SI, estimates, CPU time [s] of a run."""
    return [
        {"rank": one.rank, "as_good_as_best": one.as_good, **row_of(comparison, one.combination)}
        for one in comparison.ranking
    ]


def row_of(comparison: Comparison, one: Combination) -> dict[str, Any]:
    """A combination as a row of numbers: labels in SI, counts, estimates with their intervals."""
    lost = len(one.rows) - one.done
    table: dict[str, Any] = dict(one.labels) | {"runs": one.done, "not_done": lost}
    for ending in comparison.offered.endings:
        found, name = one.estimates[ending.name], ending.name
        table |= {name: found.n, f"{name}.low": found.low, f"{name}.high": found.high}
    for number in comparison.offered.numbers:
        found, name = one.estimates[number.column], number.column
        table |= {f"{name}.{part}": getattr(found, part) for part in _PARTS}
    return table | {"cpu_s": one.cpu_s}
