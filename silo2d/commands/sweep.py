"""The command that computes a study of many runs: sweep."""

import json
from pathlib import Path

import click

from silo2d.commands.options import (
    Ended,
    announce_compilation,
    json_option,
    out_option,
    quiet_option,
)


@click.command()
@click.argument("study")
@out_option
@click.option("--workers", type=int, metavar="N", help="Processes [default: one per core].")
@click.option(
    "--engine",
    type=click.Choice(["processes", "dask"]),
    default="processes",
    help="Where the runs go [default: processes of this machine].",
)
@click.option("--scheduler", metavar="ADDRESS", help="Of a Dask cluster: tcp://127.0.0.1:8786")
@click.option("--dry-run", is_flag=True, help="Say what would be run, and end.")
@quiet_option
@json_option
def sweep(
    study: str, out: str, workers: int | None, engine: str, scheduler: str | None, dry_run: bool,
    quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Run a study: cases over lists, ranges and distributions, times seeds.

    `silo2d init --study my_study.toml` writes a study file with a comment on every key. Runs that
    are finished are not done again: the same command goes on after whatever stopped it.
    """
    from silo2d.overview import as_text, plan, plan_as_text, summary
    from silo2d.study import load_study, run_study

    loaded = load_study(study)
    if dry_run:
        planned = plan(loaded, Path(out))
        click.echo(json.dumps(planned, indent=2) if as_json else plan_as_text(loaded, planned))
        return
    announce_compilation(quiet)
    folder, rows = run_study(
        loaded, out=Path(out), engine=engine, workers=workers, scheduler=scheduler, quiet=quiet
    )
    table = summary(loaded, folder, rows)
    click.echo(json.dumps(table, indent=2) if as_json else as_text(table))
    if table["interrupted"]:
        raise Ended(f"{table['why_interrupted']}; the same command goes on from there", 130)
    if table["failed"]:
        raise Ended(f"{table['failed']} of {table['runs']} runs failed; see {table['table']}", 3)
