"""From a table's cases to rows: what they will cost, and the sweep."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import click

from granulab.campaign.sweeps.overview import cost
from granulab.campaign.sweeps.sweep import Labelled, lacking
from silo2d.run import sweep

Row = dict[str, Any]


def run_all(
    cases: Sequence[Labelled], *, out: Path, workers: int | None, quiet: bool, **engine: Any
) -> list[Row]:
    """The rows of the cases, in their order; see silo2d.run.sweep.run_cases."""
    if not quiet:
        click.echo(cost(sweep.SILO, lacking(cases, engine.get("known", ()))), err=True)
    return sweep.run_cases(cases, out=out, workers=workers, quiet=quiet, **engine)


def run_of_cases(cases: Callable[[Sequence[int]], Iterable[Labelled]]) -> Callable[..., list[Row]]:
    """The `run` of a table (granulab.campaign.cli.reproduce) with these cases of its seeds."""

    def run(*, seeds: Sequence[int], **options: Any) -> list[Row]:
        return run_all(list(cases(seeds)), **options)

    return run
