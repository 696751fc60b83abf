"""The command that says where each number of a parameter file came from: report."""

import json
from pathlib import Path

import click

from granulab.campaign.cli.commandline import json_option


@click.command(short_help="Where each number of a parameter file came from")
@click.argument("file")
@click.option(
    "--page",
    "target",
    type=click.Path(path_type=Path),
    metavar="FILE.html",
    help="Write all of it as a page to print: figures, raw data, what a reviewer would ask.",
)
@json_option  # fmt: skip
def command(file: str, target: Path | None, as_json: bool) -> None:
    """Show where each number of a parameter file came from, and what it replaced.

    FILE is a .toml file or a shipped table, such as wood. For example: calibrate report wood.toml
    --page wood.html
    """
    from calibration.files import provenance
    from calibration.files.page import page
    from calibration.files.record import records_of
    from granulab.campaign.output.files import refuse_unless_writable, write_atomic

    if target is not None:
        refuse_unless_writable(target.parent, "--page")
    read = provenance.read_values(file)
    path, values, _ = read
    records = records_of(path, values)
    if target is not None:
        write_atomic(target, page(path, values, records))
        click.echo(f"page: {target}", err=True)
    if as_json:
        click.echo(json.dumps(provenance.as_json(*read, records), indent=2))
    else:
        click.echo(provenance.as_text(*read, records))
