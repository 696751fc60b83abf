"""Counts of the efficiency in a table of maps: dissipated, work of the walls, of a steady bed.

The thesis counts what five cycles dissipate, with what the bed itself loses as it packs down. The
walls' work is the shaker's share of it. Beside them stand, in columns called steady.*, the numbers
of the same bed shaken until its cycles are alike (run.steady). Alike they may be while it still
creeps down, so that its count is the walls' work too: what a bed that is at its end dissipates.
"""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import click

from damper3d.measures.efficiency import settling
from damper3d.reproduce.panels import (
    Panel,
    Row,
    completeness,
    first_packings,
    run_all,
    run_panels,
)
from damper3d.reproduce.quantities.maps import MAPS, Maps, Ridges, ridges_by_panel
from damper3d.studies.map.grid import STEEP, MapResult, counted
from granulab.campaign.claims.claim import Claim
from granulab.campaign.claims.judge import report_each
from granulab.campaign.output.layout import done, paragraphs, stopped

WALL_WORK = "efficiency_wall_work"
STEADY = "steady."
STEADY_ETA = f"{STEADY}{WALL_WORK}"
PACKINGS = 3  # of a point where the map is steep
_KEPT = ("efficiency", "efficiency_interval", WALL_WORK, "steady", "cycles", "state", "reason")
# Where much of what is dissipated may be the bed's own: a fifth and more at 80 Hz and above. All
# Gammas would cost four times as much.
_LEAST_HZ, _MOST_GAMMA = 80.0, 6.0


@dataclass(frozen=True)
class Count:
    """A count of the efficiency.

    column      of the rows, that has it
    at          column that a point must have, to be looked at
    everywhere  it is no count of a table where a run lacks it
    """

    column: str
    at: str
    everywhere: bool = True

    def of(self, rows: Sequence[Row]) -> list[Row]:
        """The rows with this count as their efficiency; none where it is not known."""
        known = [row for row in done(rows) if row.get(self.at) is not None]
        if self.everywhere and len(known) < len(done(rows)):
            return []
        return counted(known, self.column)


# Beside the steady bed its points as the thesis counts them: what differs is then the count alone.
COUNTS = {
    "dissipated": Count("efficiency", "efficiency"),
    "walls": Count(WALL_WORK, WALL_WORK),
    "dissipated there": Count("efficiency", STEADY_ETA, everywhere=False),
    "steady": Count(STEADY_ETA, STEADY_ETA, everywhere=False),
}

# Counts that pictures of whole maps show, in words.
DRAWN = {"dissipated": "dissipated", "walls": "work of the walls"}


def run_of_maps(panels: Callable[[], Sequence[Panel]]) -> Callable[..., list[Row]]:
    """The `run` of a table of maps: more packings where they are steep, steady beds if wanted."""

    def run(
        *, seeds: Sequence[int], grid: Sequence[Panel] | None = None, steady: bool = False,
        **options: Any,
    ) -> list[Row]:  # fmt: skip
        chosen = panels() if grid is None else grid
        rows = run_panels(chosen, seeds, steep=PACKINGS, **options)
        more = steady and not stopped(rows)
        return _with_steady(chosen, rows, **options) if more else rows

    return run


def by_count(rows: Sequence[Row]) -> dict[str, Maps]:
    """The maps of each count that the rows have; all of one diameter."""
    found = {name: count.of(rows) for name, count in COUNTS.items()}
    return {name: ridges_by_panel(own) for name, own in found.items() if own}


def judged_by_count(claims: Sequence[Claim], maps: Mapping[str, Maps]) -> str:
    """Return how many claims hold by each count, and those that turn; "" for a single count."""
    return report_each(MAPS.judge_each(claims, maps)) if len(maps) > 1 else ""


def standing(rows: Sequence[Row], points: Sequence[Row], seeds: int) -> str:
    """Return how much of a table there is, its packings, and its steady beds; see completeness."""
    labels = list(points[0])
    return paragraphs(
        completeness(first_packings(rows, labels), points, seeds),
        packings_words(rows, labels),
        steady_words(rows),
    )


def packings_words(rows: Sequence[Row], labels: Sequence[str]) -> str:
    """Return how many packings are behind a verdict, where maps are steep and elsewhere.

    labels    of a point, the last two its frequency and Gamma
    """
    maps: dict[tuple[Any, ...], list[Row]] = {}
    for row in first_packings(rows, labels):
        maps.setdefault(tuple(row[name] for name in labels[:-2]), []).append(row)
    steep = {(*key, *point) for key, own in maps.items() for point in MapResult.of(own).steep()}
    counts = Counter(tuple(row[name] for name in labels) for row in done(rows))
    more = sum(counts[point] >= PACKINGS for point in steep)
    each = min(counts.values(), default=0)
    words = f"packings behind a verdict: {each} a point"
    if each < PACKINGS:
        words += (
            f", {PACKINGS} at {more} of the {len(steep)} points where eta changes by more than "
            f"{STEEP:g} to the next Gamma"
        )
    return words


def there(one: Ridges, column: str, point: int) -> str:
    """The mean of a column at a point; "-" where it is not known."""
    value = one.result.mean(column)[point] if column in one.result.columns else math.nan
    return "-" if math.isnan(value) else f"{value:.3f}"


def steady_words(rows: Sequence[Row]) -> str:
    """Return how many beds were shaken on, what became of them, how many creep; "" without any."""
    tried = [row for row in rows if row.get(f"{STEADY}state") is not None]
    if not tried:
        return ""
    known = [row for row in done(tried) if row.get(STEADY_ETA) is not None]
    alike = sum(row.get(f"{STEADY}steady") is True for row in known)
    creep = sum(settling(row[f"{STEADY}efficiency"], row[STEADY_ETA]) is not None for row in known)
    longest = max((row[f"{STEADY}cycles"] for row in known), default=0)
    lines = [
        f"steady: {len(tried)} points shaken on until their cycles are alike, from {_LEAST_HZ:g} "
        f"Hz and up to Gamma {_MOST_GAMMA:g}: {alike} became so within {longest} cycles; in "
        f"{creep} the bed still gives more than a tenth of what is dissipated"
    ]
    failed = [row for row in tried if row[f"{STEADY}state"] == "failed"]
    if failed:
        lines.append(f"  {len(failed)} failed: {failed[0][f'{STEADY}reason']}")
    return "\n".join(lines)


def _with_steady(
    panels: Sequence[Panel], rows: list[Row], *, quiet: bool, known: Sequence[Row] = (),
    refine: int = 0, **options: Any,
) -> list[Row]:  # fmt: skip
    """The rows, those of gentle points with what a steady bed has."""
    first = min(row["seed"] for row in rows)
    gentle = [
        row
        for row in done(rows)
        if row["frequency_hz"] >= _LEAST_HZ and row["gamma"] <= _MOST_GAMMA and row["seed"] == first
    ]
    if not gentle:
        return rows
    steady = [replace(one, changes=one.changes | {"run.steady": True}) for one in panels]
    cases = [
        case
        for one in steady
        for row in one.of(gentle)
        for case in one.cases([row["seed"]], [(row["frequency_hz"], row["gamma"])])
    ]
    if not quiet:
        click.echo("the same until they are steady:", err=True)
    there = [_bare(row) for row in known if row.get(f"{STEADY}state") == "done"]
    found = run_all(cases, quiet=quiet, known=there, **options)
    labels = [labels for labels, _ in cases]
    return [_beside(row, labels, found) for row in rows]


def _bare(row: Row) -> Row:
    """A row of a steady bed, as run_all gives it, from the row that it stands in."""
    own = {name.removeprefix(STEADY): v for name, v in row.items() if name.startswith(STEADY)}
    return {name: v for name, v in row.items() if not name.startswith(STEADY)} | own


def _beside(row: Row, labels: Sequence[Mapping[str, Any]], found: Sequence[Row]) -> Row:
    """The row with its steady bed's numbers; interrupted where that is."""
    for of, steady in zip(labels, found, strict=True):
        if of.items() <= row.items():
            own = {f"{STEADY}{name}": steady.get(name) for name in _KEPT}
            cut_off = steady["state"] == "interrupted"
            ended = {"state": "interrupted", "reason": steady["reason"]} if cut_off else {}
            return row | own | ended
    return row
