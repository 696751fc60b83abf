"""Completeness of a table: the first lines of its report."""

from collections.abc import Mapping, Sequence
from typing import Any

from granulab.campaign.output.layout import done, not_done

Row = Mapping[str, Any]

_MOST = 12  # lines of points that lack, and of runs that failed or were cut off


def completeness(rows: Sequence[dict[str, Any]], points: Sequence[Row], seeds: int) -> str:
    """Return whether a table is whole, which points lack, and which runs failed or were cut off.

    points   the labels of each point, without the seed; the last label is listed
    seeds    the packings of a point by default; with fewer a table is not whole

    A point lacks where it has no run that is done, or fewer packings than another has.
    """
    labels = list(points[0])
    found: dict[tuple[Any, ...], set[int]] = {tuple(point.values()): set() for point in points}
    for row in done(rows):
        key = tuple(row[name] for name in labels)
        if key in found:  # points that a refinement added are in no table
            found[key].add(row["seed"])
    counts = {key: len(own) for key, own in found.items()}
    least, most = min(counts.values()), max(counts.values())
    packings = f"{_packings(most, seeds)} {'each' if least == most else 'at most'}"
    there = sum(count > 0 for count in counts.values())
    if least == most >= seeds:
        head = f"complete: {len(points)} points, {packings}"
    else:
        head = f"INCOMPLETE: {there} of {len(points)} points are there"
        head += f", with {packings}" if there else ""
    lacking = _lacking(labels, counts, most)
    return "\n".join([head, *_first(lacking), *_first(not_done(rows, [*labels, "seed"]))])


def _packings(number: int, seeds: int) -> str:
    """ "1 packing", "3 packings"; "1 of 3 packings" where the table has more by default."""
    if number < seeds:
        return f"{number} of {seeds} packings"
    return f"{number} packing{'' if number == 1 else 's'}"


def _first(lines: list[str]) -> list[str]:
    more = len(lines) - _MOST
    return [*lines[:_MOST], f"  ... and {more} more such lines"] if more > 0 else lines


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
