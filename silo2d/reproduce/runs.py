"""From a table's cases to rows: what they will cost, and the sweep."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from campaign.sweep import Labelled
from silo2d import sweep
from silo2d.packing import packing_digest
from silo2d.protocol import run_digest
from silo2d.report import expected_cpu_s


def run_all(
    cases: Sequence[Labelled], *, out: Path, workers: int | None, quiet: bool, **engine: Any
) -> list[dict[str, Any]]:
    """The rows of the cases, in their order; see silo2d.sweep.run_cases."""
    if not quiet:
        click.echo(cost(cases), err=True)
    return sweep.run_cases(cases, out=out, workers=workers, quiet=quiet, **engine)


def cost(cases: Sequence[Labelled]) -> str:
    """What cases will cost if nothing of them is there, in words."""
    distinct = {run_digest(case): case for _, case in cases}
    fillings: dict[str, float] = {}
    discharges = 0.0
    for case in distinct.values():
        filling, discharge = expected_cpu_s(case)
        fillings[packing_digest(case, case.settings.run.seed)] = filling
        discharges += discharge
    minutes = (sum(fillings.values()) + discharges) / 60
    shortest = min(case.time_step for case in distinct.values())
    return (
        f"{len(distinct)} runs of {len(fillings)} packings, about {minutes:.0f} min of CPU time if "
        f"none is there yet; the shortest time step is {shortest * 1e6:.2g} us"
    )
