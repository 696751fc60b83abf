"""From a table's cases to rows: what they will cost, the runs, the refinement about the peaks."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click

from damper3d.case.case import DamperCase
from damper3d.run import sweep
from damper3d.studies.map.grid import MapResult
from granulab.campaign.sweeps.overview import cost
from granulab.campaign.sweeps.sweep import Labelled, over_seeds

Row = dict[str, Any]
Point = tuple[float, float]  # frequency [Hz] and Gamma


@dataclass(frozen=True)
class Panel:
    """One damper of a table, and the points at which it is run.

    labels    what tells its rows from those of the other panels
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


def run_all(
    cases: Sequence[Labelled], *, out: Path, workers: int | None, quiet: bool, **engine: Any
) -> list[Row]:
    """The rows of the cases, in their order; see damper3d.run.sweep.run_cases."""
    if not quiet:
        click.echo(cost(sweep.DAMPER, cases), err=True)
    return sweep.run_cases(cases, out=out, workers=workers, quiet=quiet, **engine)


def run_panels(
    panels: Sequence[Panel], seeds: Sequence[int], *, refine: int = 0, quiet: bool, **options: Any
) -> list[Row]:
    """All points of all panels; then, `refine` times, the middles beside each peak along Gamma.

    A round begins when the one before is whole, so that whatever was interrupted comes to the same
    points; see damper3d.studies.map.grid. `options` are those of run_all.
    """
    rows = run_all([c for p in panels for c in p.cases(seeds)], quiet=quiet, **options)
    for number in range(1, refine + 1):
        if any(row["state"] == "interrupted" for row in rows):
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
    return rows
