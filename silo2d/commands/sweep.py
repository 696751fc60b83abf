"""The command that computes a study of many runs: sweep."""

from typing import Any

import click

from granulab.campaign.cli.commandline import study_options, sweep_study


@click.command()
@study_options
def sweep(study: str, dry_run: bool, quiet: bool, **options: Any) -> None:
    """Run a study: cases over lists, ranges and distributions, times seeds.

    `silo2d init --study my_study.toml` writes a study file with a comment on every key. Runs that
    are finished are not done again: the same command goes on after whatever stopped it.
    """
    from silo2d.run.sweep import SILO, load_study

    sweep_study(SILO, load_study(study), dry_run=dry_run, quiet=quiet, **options)
