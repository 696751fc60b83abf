"""Run plans of the tables: dampers of Table 6.1 as panels, cases to rows, and what rows lack."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import click

from damper3d.case.case import DamperCase
from damper3d.case.closed_forms import PACKINGS, bouncing_bed_onset, fluidisation_threshold
from damper3d.run import sweep
from damper3d.studies.map.grid import GAMMAS, MapResult
from damper3d.studies.predict.prediction import Clearance, Prediction
from granulab.campaign.cli import reproduce
from granulab.campaign.output.layout import done, not_done, stopped
from granulab.campaign.sweeps.sweep import Labelled, is_elsewhere, over_seeds
from granulab.errors import FolderError

Row = dict[str, Any]
Point = tuple[float, float]  # frequency [Hz] and Gamma
Run = Callable[..., list[Row]]

ORIENTATIONS = "vertical", "horizontal"
HEIGHTS = 40, 45, 50, 55  # mm
SPHERES = {3: 1659, 4: 700, 5: 358, 6: 207}  # how many of a diameter [mm]: the same volume
# What labels, report and figure of a table of panels read of a row.
PANEL_COLUMNS = (
    "orientation", "height_mm", "diameter_mm", "frequency_hz", "gamma", "fill_ratio", "efficiency",
    "efficiency_interval",
)  # fmt: skip
_FRICTION = 0.52  # of acrylic on acrylic (Table 6.2)
_MOST = 12  # lines of points that lack, and of runs that failed or were cut off


@dataclass(frozen=True)
class Panel:
    """One damper of a table, and the points at which it is run.

    labels    that its rows have and those of other panels have not
    changes   of the thesis's case, as DamperCase.load takes them
    points    (frequency [Hz], Gamma), before they are refined
    """

    labels: Row
    changes: dict[str, Any]
    points: tuple[Point, ...] = field(default=())

    def of(self, rows: Sequence[Row]) -> list[Row]:
        """Its rows among those of a table."""
        return [row for row in rows if all(row[key] == v for key, v in self.labels.items())]

    def cases(self, seeds: Sequence[int], points: Sequence[Point] | None = None) -> list[Labelled]:
        """A case at each of its points, or at others, once for each packing."""
        cases: list[Labelled] = []
        for frequency, gamma in self.points if points is None else points:
            here = {"motion.frequency": frequency, "motion.gamma": gamma, "output.keep": "summary"}
            case = DamperCase.load("thesis", self.changes | here)
            cases += over_seeds(self._labels(frequency, gamma), case, seeds)
        return cases

    def labelled(self) -> list[Row]:
        """The labels of each of its points, without the seed."""
        return [self._labels(*point) for point in self.points]

    def _labels(self, frequency: float, gamma: float) -> Row:
        return {**self.labels, "frequency_hz": frequency, "gamma": gamma}


def labels_of(panels: Sequence[Panel]) -> list[Row]:
    """The labels of each point of a table of panels, before it is refined."""
    return [labels for panel in panels for labels in panel.labelled()]


def run_all(cases: Sequence[Labelled], **options: Any) -> list[Row]:
    """The rows of the cases, in their order; see granulab.campaign.cli.reproduce.run_all.

    The thesis leaves three cycles out and counts what the next ones lose, settling and all: so
    does the column efficiency here.
    """
    rows = reproduce.run_all(sweep, sweep.DAMPER, cases, **options)
    whole = "efficiency_with_settling"
    return [row if row.get(whole) is None else row | {"efficiency": row[whole]} for row in rows]


run_of_cases = partial(reproduce.run_of_cases, run_all)


def run_panels(
    panels: Sequence[Panel], seeds: Sequence[int], *, refine: int = 0, steep: int = 1, quiet: bool,
    **options: Any,
) -> list[Row]:  # fmt: skip
    """All points of all panels; then, `refine` times, the middles next to each peak along Gamma.

    steep    packings of the points at which a panel is steep (MapResult.steep), the last round

    A round begins when the one before is whole, so that whatever was interrupted comes to the same
    points; see damper3d.studies.map.grid. `options` are those of run_all.
    """
    rows = run_all([c for p in panels for c in p.cases(seeds)], quiet=quiet, **options)
    for number in range(1, refine + 1):
        if stopped(rows):
            break
        added = [
            case
            for panel in panels
            for case in panel.cases(seeds, MapResult.of(panel.of(rows)).to_add())
        ]
        if not added:
            break
        if not quiet:
            click.echo(f"refinement {number} of {refine} about the peaks:", err=True)
        rows += run_all(added, quiet=quiet, **options)
    more = range(max(seeds) + 1, steep + 1)
    if more and not stopped(rows):
        points = [(panel, MapResult.of(panel.of(rows)).steep()) for panel in panels]
        cases = [case for panel, own in points for case in panel.cases(more, own)]
        if cases and not quiet:
            click.echo(f"{steep} packings where the map is steep:", err=True)
        rows += run_all(cases, quiet=quiet, **options) if cases else []
    return rows


def first_packings(rows: Sequence[Row], labels: Sequence[str]) -> list[Row]:
    """The rows of the seeds that every point of a table has; steep ones may have more."""
    counts = Counter(tuple(row[name] for name in labels) for row in rows)
    seeds = sorted({row["seed"] for row in rows})[: min(counts.values(), default=0)]
    return [row for row in rows if row["seed"] in seeds]


def panel(
    orientation: str, height: int, diameter: int, points: Iterable[Point], **changes: object
) -> Panel:
    """A damper of Table 6.1 by its height and the spheres' diameter [mm]; with changes, another.

    The names of changes are keys with "__" for the point, such as particles__count.
    """
    labels: Row = {"orientation": orientation, "height_mm": height, "diameter_mm": diameter}
    case: Row = {
        "motion.orientation": orientation,
        "enclosure.height": f"{height} mm",
        "particles.shape": f"sphere:{diameter}mm",
        "particles.count": SPHERES.get(diameter),
    }
    case |= {key.replace("__", "."): value for key, value in changes.items()}
    return Panel(labels, case, tuple(points))


def about(onset: float, factor: float, beyond: tuple[float, ...] = ()) -> list[float]:
    """The thesis's Gammas, and those `beyond`, within a factor of an onset."""
    return [gamma for gamma in GAMMAS + beyond if onset / factor <= gamma <= onset * factor]


def close_onset(height: int, frequency: float) -> float:
    """Gamma of eq. 6.11 for the close packing in the thesis's cylinder of a height [mm]."""
    fill = SPHERES[5] * (5 / 40) ** 2 * 5 / height * 2 / 3  # spheres of 5 mm in 40 mm, eq. 6.1
    clearance = (1 - fill / PACKINGS["close"]) * height / 1e3
    return float(bouncing_bed_onset(frequency, clearance))


def prediction_of(rows: Sequence[Row]) -> Prediction | None:
    """Return the prediction for the damper that rows were computed with; None without a run."""
    row = next((row for row in rows if row["state"] == "done"), None)
    if row is None:
        return None
    fill, length = row["fill_ratio"], row["height_mm"] / 1e3
    clearances = tuple(
        Clearance(name, most, (1 - fill / most) * length if fill < most else None)
        for name, most in PACKINGS.items()
    )
    threshold = fluidisation_threshold(row["orientation"], _FRICTION)
    name = f"{row['height_mm']} mm, spheres of {row['diameter_mm']} mm"
    return Prediction(name, fill, length, row["orientation"], clearances, threshold)


def point_cases(
    points: Callable[[], Sequence[Row]], settings: Callable[[Row], Row], seeds: Sequence[int],
    changes: Row | None = None,
) -> list[Labelled]:  # fmt: skip
    """The thesis's case with the settings of each point, once for each seed.

    `changes` go over what the table sets.
    """
    return [
        labelled
        for point in points()
        for labelled in over_seeds(
            point, DamperCase.load("thesis", settings(point) | (changes or {})), seeds
        )
    ]


def with_read(row: Row, read: Callable[[str], Row]) -> Row:
    """A row that is done, with what is read from its run folder.

    A run whose samples are not there any more becomes a failed one.
    """
    if row["state"] != "done" or is_elsewhere(row):
        return row
    try:
        return row | read(row["run_folder"])
    except FolderError as error:
        return row | {"state": "failed", "reason": str(error)}


def run_of_panels(panels: Callable[[], Sequence[Panel]], refine: int = 0) -> Run:
    """The `run` of a table of panels; also of another `grid` of them, or refined otherwise."""

    def run(
        *, seeds: Sequence[int], grid: Sequence[Panel] | None = None, refine: int = refine,
        **options: Any,
    ) -> list[Row]:  # fmt: skip
        return run_panels(panels() if grid is None else grid, seeds, refine=refine, **options)

    return run


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
