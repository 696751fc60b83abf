"""The table of scenes: as text and Markdown, and compared with the one that is kept."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from benchmarks.speed.timing import BOUND

ALLOWED = 1.1  # times the ratio that is kept, beyond which a scene has become slower
COLUMNS = ("scene", "here", "compared with", "its cost", "ratio", "quartiles")
WIDTHS = (43, 29, 13, 13, 6, 0)


def cells(row: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """Lines of a scene: one for each engine, for those that are missing, and for the bound."""
    against = row["against"]
    names = [*(name for name in against if name != BOUND), *row["missing"]]
    names += [BOUND] if BOUND in against else []
    first = (row["scene"], f"{number(row['here'])} {row['unit']}")
    for name in names or [""]:
        if name in against:
            one = against[name]
            spread = f"{number(one['low'])} to {number(one['high'])}"
            yield (*first, name, number(one["cost"]), number(one["ratio"]), spread)
        else:
            yield (*first, name, "not installed" if name else "", "", "")
        first = ("", "")


def number(value: float) -> str:
    """A number with three digits, without an exponent."""
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def text(row: Mapping[str, Any]) -> str:
    """Lines of a scene for a terminal."""
    return "\n".join(line(one) for one in cells(row))


def line(one: Sequence[str]) -> str:
    """Cells side by side."""
    return " ".join(f"{cell:{width}}" for cell, width in zip(one, WIDTHS, strict=True)).rstrip()


def markdown(record: Mapping[str, Any]) -> str:
    """The record as it stands in docs/runs/speed.md."""
    parts = [about(record), table(COLUMNS, [one for row in record["scenes"] for one in cells(row)])]
    for package, scenes in record["stages"].items():
        stages = dict.fromkeys(stage for shares in scenes.values() for stage in shares)
        rows = [(name, *(f"{shares.get(stage, 0):.0%}" for stage in stages))
                for name, shares in scenes.items()]  # fmt: skip
        parts.append(f"A step of `{package}`, shares of its time:\n")
        parts.append(table(("scene", *stages), rows))
    return "\n".join(parts)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def about(record: Mapping[str, Any]) -> str:
    """Machine, versions, date, command, and the reference kernel, in a paragraph."""
    versions = ", ".join(f"{name} {version}" for name, version in record["versions"].items())
    words = (
        f"`{record['command']}`, {record['date']}, {record['machine']}; {versions}. Reference "
        f"kernel: {number(record['pair_ns'])} ns a pair, {number(record['row_ns'])} ns a row."
    )
    return textwrap.fill(words, 118, break_long_words=False, break_on_hyphens=False) + "\n"


def slower(record: Mapping[str, Any], kept: Mapping[str, Any]) -> list[str]:
    """A line for each ratio that is more than 10 % above the one that is kept.

    Ratios to the bound are compared on the same processor only. Raises ValueError where nothing can
    be compared.
    """
    known = {row["scene"]: row["against"] for row in kept["scenes"]}
    found, compared = [], 0
    for row in record["scenes"]:
        for name, one in row["against"].items():
            before = known.get(row["scene"], {}).get(name)
            if before is None or (name == BOUND and record["machine"] != kept["machine"]):
                continue
            compared += 1
            if one["ratio"] > ALLOWED * before["ratio"]:
                found.append(
                    f"{row['scene']}: {number(one['ratio'])} of {name}, more than "
                    f"{ALLOWED - 1:.0%} above the {number(before['ratio'])} that is kept"
                )
    if not compared:
        raise ValueError("no scene has a ratio that is kept: nothing was compared")
    return found
