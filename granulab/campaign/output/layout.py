"""Columns of text, and how numbers and runs that failed are written in them."""

import math
import re
import shutil
import textwrap
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any

from granulab.campaign.output.statistics import Sample, noise_of_difference, wilson

Row = dict[str, Any]

_NAME = re.compile(r"( +\S+( \S+)* {2,}| {8,})(?=\S)")  # of a line, with what is between
_UNIT = re.compile(
    r"(?<=[a-z_=]) (?=[\d.+-]+)|(?<=\d) (?=(?:[kmuMG]?(?:m|s|g|N|J|W|B|Pa|Hz)\b|min\b|1/s|%))"
)
_GAP = re.compile(r"\S {2,}\S")  # between two cells of a table
_VERDICTS = ("PASS", "FAIL", "----")  # that begin the lines of claims, which have no head
_MOST_DIGITS = 7  # behind the point
_TIED = "\0"  # in place of the space between a name, a number and its unit


def columns(header: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """A table of text, each column as wide as its longest entry."""
    table = [list(header), *map(list, lines)]
    widths = [max(len(line[k]) for line in table) for k in range(len(header))]
    rows = (
        "  ".join(f"{cell:{w}}" for cell, w in zip(line, widths, strict=True)) for line in table
    )
    return "\n".join(row.rstrip() for row in rows)


def screen() -> int:
    """Characters in a line of the terminal; 80 where there is none."""
    return max(shutil.get_terminal_size((80, 24)).columns, 40)


def wrapped(text: str, indent: int, width: int | None = None) -> str:
    """The text with long lines broken between words, never in one or before a unit.

    What follows stands below what the line says after its name ("  energy      ..."), else it is
    indented by so many characters.
    """
    width = screen() if width is None else width
    lines = []
    for line in text.split("\n"):
        name = _NAME.match(line)
        lines += textwrap.wrap(
            _UNIT.sub(_TIED, line), width, break_long_words=False, break_on_hyphens=False,
            subsequent_indent=" " * (len(name[0]) if name else indent),
        ) or [""]  # fmt: skip
    return "\n".join(lines).replace(_TIED, " ")


def fitted(
    header: Sequence[str], lines: Sequence[Sequence[str]], labels: int, width: int | None = None
) -> str:
    """A table of text no wider than the terminal: one below the other where it would be.

    labels: the first columns, which say what a line is. Of these, those that are the same in all
    lines are said once, above; the others begin each part.
    """
    width = screen() if width is None else width
    same = [k for k in range(labels) if len(lines) > 1 and len({line[k] for line in lines}) == 1]
    said = f"all with {', '.join(f'{header[k]} {lines[0][k]}' for k in same)}" if same else ""
    table = [[line[k] for k in range(len(line)) if k not in same] for line in [header, *lines]]
    labels -= len(same)
    sizes = [max(map(len, column)) + 2 for column in zip(*table, strict=True)]
    if labels == len(sizes) or 2 * sum(sizes[:labels]) > width:  # lines are known by a number
        table = [[str(k) if k else "no", *line] for k, line in enumerate(table)]
        sizes, labels = [len(str(len(lines))) + 3, *sizes], 1
    parts: list[list[int]] = [[]]
    for k in range(labels, len(sizes)):
        if parts[-1] and sum(sizes[:labels]) + sum(sizes[c] for c in [*parts[-1], k]) - 2 > width:
            parts.append([])
        parts[-1].append(k)
    texts = [
        "\n".join(
            "  ".join(line[k].rjust(sizes[k] - 2) for k in [*range(labels), *part]).rstrip()
            for line in table
        )
        for part in parts
    ]
    return paragraphs(wrapped(said, 2, width), *texts)


def on_screen(text: str, width: int | None = None) -> str:
    """A report with its tables (see columns) and its sentences no wider than the terminal."""
    width = screen() if width is None else width
    blocks: list[str] = []
    for in_table, group in groupby(text.split("\n"), lambda line: bool(_GAP.search(line))):
        lines = list(group)
        if max(map(len, lines)) <= width:
            blocks += lines
        elif in_table and len(lines) > 1:
            starts, (header, *rows) = _cells(lines)
            if len(header) < 3 or header[0] in _VERDICTS:  # words, and what is said of them
                blocks += [wrapped(line, starts[-1], width) for line in lines]
            else:
                blocks.append(_narrow(fitted(header, rows, _labels(rows), width), width))
        else:
            blocks += [wrapped(line, _indented(line) + 2, width) for line in _sentences(lines)]
    return "\n".join(blocks)


def _cells(lines: Sequence[str]) -> tuple[list[int], list[list[str]]]:
    """Starts of the columns of a table, each behind two spaces in all lines, and its cells."""
    longest = max(map(len, lines))
    padded = [line.ljust(longest) for line in lines]
    gap = [all(line[k] == " " for line in padded) for k in range(longest)]
    starts = [k for k in range(longest) if not gap[k] and all(gap[max(k - 2, 0) : k])]
    ends = [*starts[1:], longest]
    cells = [[line[a:b].strip() for a, b in zip(starts, ends, strict=True)] for line in padded]
    return starts, cells


def _sentences(lines: Sequence[str]) -> list[str]:
    """The lines with those joined that go on further to the right than the first one."""
    joined: list[str] = []
    for line in lines:
        if joined and _indented(line) > _indented(joined[-1]) < len(joined[-1]):
            joined[-1] += f" {line.lstrip()}"
        else:
            joined.append(line)
    return joined


def _indented(line: str) -> int:
    return len(line) - len(line.lstrip())


def _labels(rows: Sequence[Sequence[str]]) -> int:
    """Number of the first columns that distinguish the rows; one where none do."""
    numbers = range(1, len(rows[0]) if rows else 1)
    return next((k for k in numbers if len({tuple(row[:k]) for row in rows}) == len(rows)), 1)


def _narrow(table: str, width: int) -> str:
    """A table whose cells are sentences, with these wrapped below the first column."""
    lines = table.split("\n")
    short = (re.sub(" {2,}", "  ", line) if len(line) > width else line for line in lines)
    return "\n".join(wrapped(line, 4, width) for line in short)


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


def stopped(rows: Sequence[Row]) -> bool:
    """True where runs were interrupted: no time for pictures then, and nothing to go on from."""
    return any(row["state"] == "interrupted" for row in rows)


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


def with_half_width(mean: float, half: float | None) -> str:
    """ "0.341 ± 0.012": a number to the second digit of its half width, or to four."""
    if half is None:
        return f"{mean:.4g}"
    digits = max(1 - math.floor(math.log10(half)), 0) if half > 0 else _MOST_DIGITS + 1
    if digits > _MOST_DIGITS or abs(mean) >= 1e6:
        return f"{mean:.4g} ± {half:.2g}"
    return f"{mean:.{digits}f} ± {half:.{digits}f}"


def share_within(k: int, n: int, low: float | None, high: float | None) -> str:
    """ "1 of 5, 4 to 62 %": a share and the interval of what it may be."""
    return (
        "-" if low is None or high is None else f"{k} of {n}, {100 * low:.0f} to {100 * high:.0f} %"
    )


def pulls_in_words(
    found: dict[str, float] | None, share: Callable[[float], str], when: str = ""
) -> list[str]:
    """A line of a report where the law pulled, none elsewhere.

    found: `numbers` of an Attraction; share: spells the share of the contacts; when: they were
    looked at, in words.
    """
    if not found or not found["particle_weights"] > 0.0:
        return []
    return [
        f"  law pulls        {when}in {share(found['share'])} of the contacts, with up to "
        f'{found["particle_weights"]:.3g} particle weights (contact_end = "force": never)'
    ]
