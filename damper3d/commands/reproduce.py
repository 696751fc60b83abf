"""The command that computes a published table: reproduce."""

from typing import Any

import click

from granulab.campaign.cli.reproduce import reproduce_options, reproduce_table


@click.command()
@reproduce_options
def reproduce(table: str | None, **options: Any) -> None:
    """Compute one of the thesis's tables and compare it with the published numbers.

    Without TABLE it says what there is. Runs that are there already are not done again: the same
    command goes on after whatever stopped it.
    """
    from damper3d.reproduce import TABLES, find

    if table is None:
        click.echo("\n".join(f"{name:12} {text}" for name, (_, text) in TABLES.items()))
        return
    found = find(table)
    from damper3d.run.sweep import DAMPER

    reproduce_table(DAMPER, table, found, **options)
