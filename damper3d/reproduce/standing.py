"""How much of a table is there: the first lines of its report."""

from collections.abc import Mapping, Sequence
from typing import Any

from campaign.layout import done, not_done

Row = Mapping[str, Any]

_MOST = 12  # lines of runs that lack or failed


def standing(rows: Sequence[dict[str, Any]], points: Sequence[Row]) -> list[str]:
    """Runs that are done of those that the table has, and which lack.

    points: the labels of each point, without the seed; the last label is told as a list. A point
    lacks where it has no run that is done, or fewer than another has.
    """
    labels = list(points[0])
    counts = {tuple(point.values()): 0 for point in points}
    for row in done(rows):
        key = tuple(row[name] for name in labels)
        if key in counts:
            counts[key] += 1
    most = max(counts.values(), default=0)
    there = sum(count > 0 for count in counts.values())
    packings = f"{most} packing{'' if most == 1 else 's'}"
    if most and min(counts.values()) == most:
        return [f"complete: {len(points)} points, {packings} each"]
    head = f"INCOMPLETE: {there} of {len(points)} points are there, with {packings} at most"
    lines = _lacking(labels, counts, most) + not_done(rows, [*labels, "seed"])
    rest = [f"  ... and {len(lines) - _MOST} more such lines"] if len(lines) > _MOST else []
    return [head, *lines[:_MOST], *rest]


def _lacking(labels: Sequence[str], counts: dict[tuple[Any, ...], int], most: int) -> list[str]:
    """A line for each run of points that differ in the last label alone."""
    groups: dict[tuple[Any, ...], list[str]] = {}
    for key, count in counts.items():
        if count < max(most, 1):
            partly = f" ({count} of {most})" if count else ""
            groups.setdefault(key[:-1], []).append(f"{_word(key[-1])}{partly}")
    return [
        f"  lacking: {', '.join(f'{n} {_word(v)}' for n, v in zip(labels, key, strict=False))}"
        f"{': ' if key else ''}{labels[-1]} {', '.join(values)}"
        for key, values in groups.items()
    ]


def _word(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
