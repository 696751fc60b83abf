"""Beds that others measured: lift-off, flight, apparent mass, rise, collect and collide, drops.

The beds are this project's, of acrylic, in the regime that the source states; where a source gives
a formula, that is compared. data/published/shaken_beds.csv has their numbers and where they are
from.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damper3d.case.case import DamperCase
from damper3d.reproduce.measured.beds import BEDS, DROP, points
from damper3d.reproduce.measured.quantities import MEASURED, found_in, sought
from damper3d.reproduce.panels import completeness, run_all
from damper3d.studies.dropped import rebound
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.layout import columns, paragraphs
from granulab.campaign.output.terminal import Progress
from granulab.campaign.runs.protocol import Stop
from granulab.campaign.sweeps.engine import run_tasks
from granulab.campaign.sweeps.sweep import as_outcome, beside_known, over_seeds
from granulab.errors import InputError, SimulationError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Labelled

Row = dict[str, Any]

SEEDS = 3
COLUMNS = (
    "bed", "count", "at", "frequency_hz", "gamma", "discarded", "efficiency",
    "efficiency_interval", "efficiency_wall_work", "efficiency_per_cycle", "effective_mass.",
    "mass_kg", "bed_height_m", "rebound", "phase",
    "phase_measures.circulation", "energy_closure",
)  # fmt: skip
_READING = """\
theirs: an interval, or the number of a formula; ours: value and interval, or not found where the
  first or the last point leaves it open. lift_off, sliding: from the last Gamma at which the
  shaker's work is at most 1 % of 4 M V^2 to the next, over all packings; doubling: likewise where
  what successive cycles dissipate differs by 10 % of their sum; convection: likewise where a roll
  holds a tenth of the displacements; leidenfrost: likewise where the phase is one of convection
  (sec. 6.4.3.3); rebound: likewise below 2 % of the drop. transition, optimum: amplitude over
  clearance/pi, from the close packing's clearance to the loose one's; the optimum in the bracket
  of its peak. Powers: least squares with 95 % of their scatter."""


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


def run(
    *, out: Path, seeds: Sequence[int], workers: int | None, quiet: bool,
    known: Sequence[Row] = (), **engine: Any,
) -> list[Row]:  # fmt: skip
    """Every shaken point and every drop for each seed."""
    rows = run_all(cases(seeds), out=out, workers=workers, quiet=quiet, known=known, **engine)
    drops = [
        point | {"seed": seed}
        for point in points()
        if BEDS[point["bed"]].dropped is not None
        for seed in seeds
    ]

    def made(lacks: list[int]) -> list[Row]:
        tasks = [drops[k] for k in lacks]
        with Progress(f"{len(tasks)} drops", quiet=quiet) as bar:
            outcomes = run_tasks(
                drop, tasks, workers=workers, **engine,
                report=lambda tally: bar.update(tally.done / tally.total, f"{tally.done} done"),
            )  # fmt: skip
        return [
            labels | {"rebound": outcome.value, "state": outcome.state, "reason": outcome.reason}
            for labels, outcome in zip(tasks, outcomes, strict=True)
        ]

    return rows + beside_known(drops, known, made)


def drop(labels: Row, stop: Stop) -> float:
    """Height of a rebound over the drop, of one dropped enclosure; in a worker."""
    e0 = BEDS[labels["bed"]].dropped
    assert e0 is not None
    with as_outcome(InputError, SimulationError):
        case = _case(labels, {"run.seed": labels["seed"]})
        return rebound(case, labels["at"] * e0, e0, DROP, stop)


def report(rows: list[Row]) -> str:
    """Return what is there, theirs and ours side by side, the claims, and the beds as run."""
    found = found_in(rows)
    return paragraphs(
        completeness(rows, points(), SEEDS),
        _table(sought(found)),
        report_claims(MEASURED.judge(claims_of("damper_measured"), found)),
        columns(["  bed", "as run"], [[f"  {name}", bed.words] for name, bed in BEDS.items()]),
        _READING,
    )


def _table(items: list[Row]) -> str:
    lines = [
        [f"  {one['name']}", one["bed"], _interval(one["their_low"], one["their_high"]), *_own(one)]
        for one in items
    ]
    header = ["  quantity", "bed", "theirs", "ours", "interval", "intervals"]
    return columns(header, lines) if lines else ""


def _own(one: Row) -> list[str]:
    if "value" not in one:
        return ["not found", "", ""]
    common = one["low"] <= one["their_high"] and one["their_low"] <= one["high"]
    return [
        f"{one['value']:.3g}", f"{one['low']:.3g} to {one['high']:.3g}",
        "in common" if common else "apart",
    ]  # fmt: skip


def _interval(low: float, high: float) -> str:
    return f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"


def draw(rows: list[Row]) -> "Figure":
    """Nine panels: each measurement, with theirs as a band or a line."""
    from damper3d.reproduce.measured.panels import measured_panels

    return measured_panels(rows)
