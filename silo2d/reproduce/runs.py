"""From a table's cases to rows: what they will cost, and the sweep."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from granulab.campaign.sweeps.overview import cost
from granulab.campaign.sweeps.sweep import Labelled
from silo2d.run import sweep


def run_all(
    cases: Sequence[Labelled], *, out: Path, workers: int | None, quiet: bool, **engine: Any
) -> list[dict[str, Any]]:
    """The rows of the cases, in their order; see silo2d.run.sweep.run_cases."""
    if not quiet:
        click.echo(cost(sweep.SILO, cases), err=True)
    return sweep.run_cases(cases, out=out, workers=workers, quiet=quiet, **engine)
