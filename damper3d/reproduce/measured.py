"""Beds that others measured: lift-off, flight, apparent mass, rise, collect and collide, drops.

The beds are this project's, of acrylic, in the regime that the source states; where a source gives
a formula, that is compared. data/published/shaken_beds.csv has their numbers and where they are
from.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damper3d.case.case import DamperCase
from damper3d.reproduce.panels import completeness, run_all
from damper3d.reproduce.quantities.measured import BEDS, DROP, MEASURED, found_in, of_beds, points
from damper3d.studies.dropped import rebound
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.layout import columns, paragraphs
from granulab.campaign.output.terminal import Progress
from granulab.campaign.runs.protocol import Stop
from granulab.campaign.sweeps.engine import run_tasks
from granulab.campaign.sweeps.sweep import as_outcome, over_seeds
from granulab.errors import InputError, SimulationError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Labelled

Row = dict[str, Any]

SEEDS = 3
COLUMNS = (
    "bed", "count", "at", "frequency_hz", "gamma", "discarded", "efficiency",
    "efficiency_interval", "efficiency_wall_work", "efficiency_per_cycle", "effective_mass.",
    "mass_kg", "bed_height_m", "rebound", "phase", "energy_closure",
)  # fmt: skip
_READING = """\
theirs: an interval, or the number of a formula; ours: value and interval. lift_off, sliding: from
  the last Gamma at which the shaker's work is at most 1 % of 4 M V^2 to the next, over all
  packings; doubling: likewise where what successive cycles dissipate differs by 10 % of their
  sum; rebound: likewise below 2 % of the drop. transition, optimum: amplitude over clearance/pi,
  from the close packing's clearance to the loose one's; the optimum in the bracket of its peak.
  Powers: least squares with 95 % of their scatter."""


def cases(seeds: Sequence[int], changes: Row | None = None) -> "list[Labelled]":
    """Each shaken point once for each seed; `changes` go over what the table sets."""
    return [
        labelled
        for point in points()
        if BEDS[point["bed"]].dropped is None
        for labelled in over_seeds(point, _case(point, changes), seeds)
    ]


def _case(point: Row, changes: Row | None = None) -> DamperCase:
    own: Row = {"particles.count": point["count"], "output.keep": "summary"}
    if BEDS[point["bed"]].dropped is None:
        own["motion.gamma"] = point["at"]
    return DamperCase.load("thesis", BEDS[point["bed"]].changes | own | (changes or {}))


@dataclass(frozen=True)
class Drop:
    """One dropped enclosure."""

    point: tuple[tuple[str, Any], ...]
    seed: int


def run(*, out: Path, seeds: Sequence[int], workers: int | None, quiet: bool) -> list[Row]:
    """Every shaken point and every drop for each seed."""
    rows = run_all(cases(seeds), out=out, workers=workers, quiet=quiet)
    drops = [
        Drop(tuple(point.items()), seed)
        for point in points()
        if BEDS[point["bed"]].dropped is not None
        for seed in seeds
    ]
    with Progress(f"{len(drops)} drops", quiet=quiet) as bar:
        outcomes = run_tasks(
            drop, drops, workers=workers,
            report=lambda tally: bar.update(tally.done / tally.total, f"{tally.done} done"),
        )  # fmt: skip
    return rows + [
        {**dict(one.point), "seed": one.seed, "rebound": outcome.value, "state": outcome.state,
         "reason": outcome.reason}
        for one, outcome in zip(drops, outcomes, strict=True)
    ]  # fmt: skip


def drop(one: Drop, stop: Stop) -> float:
    """Height of a rebound over the drop; in a worker."""
    point = dict(one.point)
    e0 = BEDS[point["bed"]].dropped
    assert e0 is not None
    with as_outcome(InputError, SimulationError):
        case = _case(point, {"run.seed": one.seed})
        return rebound(case, point["at"] * e0, e0, DROP, stop)


def report(rows: list[Row]) -> str:
    """Return what is there, theirs and ours side by side, the claims, and the beds as run."""
    found = found_in(rows)
    return paragraphs(
        completeness(rows, points(), SEEDS),
        _table(of_beds(found)),
        report_claims(MEASURED.judge(claims_of("damper_measured"), found)),
        columns(["  bed", "as run"], [[f"  {name}", bed.words] for name, bed in BEDS.items()]),
        _READING,
    )


def _table(items: list[Row]) -> str:
    lines = [
        [f"  {one['name']}", one["bed"], _interval(one["their_low"], one["their_high"]),
         f"{one['value']:.3g}", f"{one['low']:.3g} to {one['high']:.3g}",
         "in common" if one["low"] <= one["their_high"] and one["their_low"] <= one["high"]
         else "apart"]
        for one in items
    ]  # fmt: skip
    header = ["  quantity", "bed", "theirs", "ours", "interval", "intervals"]
    return columns(header, lines) if lines else ""


def _interval(low: float, high: float) -> str:
    return f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"


def draw(rows: list[Row]) -> "Figure":
    """Six panels: each measurement, with theirs as a band or a line."""
    from damper3d.reproduce.figures.measured import measured_panels

    return measured_panels(rows)
