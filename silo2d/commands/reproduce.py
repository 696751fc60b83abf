"""The command that computes a published table: reproduce."""

import inspect
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from silo2d.commands.options import Ended, json_option, out_option, quiet_option

if TYPE_CHECKING:
    from silo2d.reproduce import PublishedTable, Row


@click.command()
@click.argument("table", required=False)
@click.option("--seeds", type=int, metavar="N", help="Seeds 1 to N [default: the table's own].")
@out_option
@click.option("--write", metavar="DIR", help="Where csv, txt and png go [default: that of --out].")
@click.option("--workers", type=int, metavar="N", help="Runs at a time [default: all cores].")
@click.option("--engine", type=click.Choice(["processes", "dask"]), help="What runs them.")
@click.option("--scheduler", metavar="tcp://HOST:PORT", help="Of a Dask cluster.")
@quiet_option
@json_option
def reproduce(
    table: str | None, seeds: int | None, out: str, write: str | None, workers: int | None,
    engine: str | None, scheduler: str | None, as_json: bool, quiet: bool,
) -> None:  # fmt: skip
    """Compute one of the paper's tables and print it beside the published numbers.

    Without TABLE it says what there is. Runs that are there already are not done again.
    """
    from silo2d.reproduce import TABLES, find
    from silo2d.reproduce.results import origin, write_results

    if table is None:
        click.echo("\n".join(f"{name:12} {text}" for name, (_, text) in TABLES.items()))
        return
    found = find(table)
    numbers = _numbers(seeds, workers, found)
    rows = found.run(
        out=Path(out), seeds=numbers, workers=workers, quiet=quiet,
        **_engine(table, found, engine, scheduler),
    )  # fmt: skip
    text = found.report(rows)
    click.echo(json.dumps({"table": table, "rows": rows}, indent=2) if as_json else text)
    _stop_unless_whole(rows)
    lines = origin(f"silo2d reproduce {table} --seeds {len(numbers)}")
    files = write_results(
        Path(write or out), f"reproduce-{table}", rows, lines, text, lambda: found.draw(rows)
    )
    if not quiet:
        click.echo("\n".join(map(str, files)), err=True)
    failed = sum(row["state"] == "failed" for row in rows)
    if failed:
        line = f"{failed} of {len(rows)} rows are failed runs; their reasons stand in {files[0]}"
        raise Ended(line, 3)


def _numbers(seeds: int | None, workers: int | None, found: "PublishedTable") -> Sequence[int]:
    for name, number in (("--seeds", seeds), ("--workers", workers)):
        if number is not None and number < 1:
            raise click.UsageError(f"{name} = {number}: must be at least 1")
    return range(1, (seeds or found.SEEDS) + 1)


def _stop_unless_whole(rows: "list[Row]") -> None:
    """Where Ctrl-C or a lost scheduler cut the runs off: write nothing over earlier results."""
    missing = [row["reason"] for row in rows if row["state"] == "interrupted"]
    if missing:
        from silo2d.discharge import Stopped

        lost = next((f" ({reason})" for reason in missing if reason.endswith("went away")), "")
        line = f"runs that are missing: {len(missing)}{lost}; the same command goes on"
        raise Stopped(line)


def _engine(
    table: str, found: "PublishedTable", engine: str | None, scheduler: str | None
) -> dict[str, Any]:
    """The engine as the table's `run` takes it; nothing where the usual one is meant."""
    if scheduler is not None and engine != "dask":
        raise click.UsageError("--scheduler goes with --engine dask")
    asked: dict[str, Any] = {"engine": engine, "scheduler": scheduler}
    asked = {key: value for key, value in asked.items() if value is not None}
    takes = inspect.signature(found.run).parameters.values()
    if asked and not any(p.kind is p.VAR_KEYWORD or p.name == "engine" for p in takes):
        raise click.UsageError(f"--engine: {table} is computed on this machine only; leave it out")
    return asked
