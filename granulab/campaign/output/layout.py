"""Columns of text, and how numbers and runs that failed are written in them."""

from collections.abc import Sequence
from typing import Any

from granulab.campaign.output.statistics import Sample, noise_of_difference, wilson

Row = dict[str, Any]


def columns(header: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """A table of text, each column as wide as its longest entry."""
    table = [list(header), *map(list, lines)]
    widths = [max(len(line[k]) for line in table) for k in range(len(header))]
    rows = (
        "  ".join(f"{cell:{w}}" for cell, w in zip(line, widths, strict=True)) for line in table
    )
    return "\n".join(row.rstrip() for row in rows)


def paragraphs(*parts: str) -> str:
    """The parts that say something, with an empty line between."""
    return "\n\n".join(filter(None, parts))


def with_sd(sample: Sample, digits: int = 3) -> str:
    """ "1.234 +- 0.012 (3)": mean, standard deviation, number."""
    if sample.mean is None:
        return "-"
    spread = "" if sample.sd is None else f" +- {sample.sd:.{digits}f}"
    return f"{sample.mean:.{digits}f}{spread} ({sample.n})"


def percent(part: float) -> str:
    """A part, to a digit where it is small."""
    return f"{100 * part:.1f} %" if abs(part) < 0.0995 else f"{100 * part:.0f} %"


def signed(change: float) -> str:
    """A change with its sign."""
    return f"{'+' if change >= 0 else ''}{percent(change)}"


def verdict(ours: Sample, theirs: Sample) -> str:
    """Return whether two means agree within noise, else by how much ours is high or low."""
    if ours.mean is None or theirs.mean is None:
        return "-"
    off = ours.mean / theirs.mean - 1
    noise = noise_of_difference(ours, theirs)
    if noise is None:
        return f"{signed(off)}, too few to judge"
    allowed = f"(+- {percent(noise / theirs.mean)})"
    if abs(ours.mean - theirs.mean) <= noise:
        return f"agrees {signed(off)} {allowed}"
    return f"{'high' if off > 0 else 'low'} by {percent(abs(off))} {allowed}"


def done(rows: Sequence[Row]) -> list[Row]:
    """The rows of runs that came to an end; only they enter a statistic."""
    return [row for row in rows if row["state"] == "done"]


def not_done(rows: Sequence[Row], labels: Sequence[str]) -> list[str]:
    """A line for each run that failed or was cut off, with its reason."""
    return [
        f"{row['state']}: {', '.join(f'{k} {row[k]}' for k in labels)}: {row['reason']}"
        for row in rows
        if row["state"] != "done"
    ]


def share(k: int, n: int) -> str:
    """ "1 of 5 [0.04, 0.62]", with Wilson's interval."""
    low, high = wilson(k, n)
    return f"{k} of {n} [{low:.2f}, {high:.2f}]" if n else "-"
