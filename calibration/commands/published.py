"""The command that sets printed measurements beside what follows from them: published."""

import json

import click

from granulab.campaign.cli.commandline import json_option


@click.command("published", short_help="The sources' measurements, calculated again")
@click.argument("tables", nargs=-1, metavar="[TABLE]...")
@json_option
def command(tables: tuple[str, ...], as_json: bool) -> None:
    """The sources' bench measurements beside what follows from their own parts.

    Tables: friction, restitution, interface, stiffness, damping, density, roughness; all of them
    where none is named. Only means are printed but for the interface's markers: single trials,
    curves and profiles cannot be evaluated again.
    """
    from calibration.bench.published import as_json as for_json
    from calibration.bench.published import as_text, statements

    found = statements(tables)
    if as_json:
        click.echo(json.dumps(for_json(found), indent=2))
    else:
        click.echo(as_text(found))
