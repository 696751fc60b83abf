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
    from calibration.files.page import page
    from calibration.files.provenance import report
    from granulab.campaign.output.files import refuse_unless_writable, write_atomic

    if target is not None:
        refuse_unless_writable(target.parent, "--page")
    found = report(file)
    if target is not None:
        write_atomic(target, page(found.path, found.values, found.records))
        click.echo(f"page: {target}", err=True)
    click.echo(json.dumps(found.to_dict(), indent=2) if as_json else found.text())
