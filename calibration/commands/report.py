"""The command that says where each number of a parameter file came from: report."""

import json

import click

from granulab.campaign.cli.commandline import json_option


@click.command(short_help="Where each number of a parameter file came from")
@click.argument("file")
@json_option
def command(file: str, as_json: bool) -> None:
    """Show where each number of a parameter file came from, and what it replaced.

    FILE is a .toml file or a shipped table, such as wood. For example: calibrate report wood.toml
    """
    from calibration.files import provenance

    read = provenance.read_values(file)
    if as_json:
        click.echo(json.dumps(provenance.as_json(*read), indent=2))
    else:
        click.echo(provenance.as_text(*read))
