"""The command silo2d: its subcommands, and what it says when something goes wrong."""

import click

from granulab.campaign.cli.commandline import run_app
from silo2d.commands import files, reproduce, results, run, sweep


@click.group(
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="granulab")
@click.pass_context
def app(context: click.Context) -> None:
    """Discharge of angular particles from 2D silos.

    A case is a preset (A1 ... D4: hopper of 60, 45, 30, 0 degrees; outlet of 40, 60, 100,
    150 mm) or a TOML file; `silo2d init my_silo.toml` writes one with a comment on every key.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


for command in (
    run.run, run.packing, sweep.sweep, reproduce.reproduce, results.render, results.observe,
    results.compare, results.export, files.init, files.list_, files.show,
):  # fmt: skip
    app.add_command(command)


def main() -> None:
    """Run the command; one line on stderr and an exit code for whatever goes wrong."""
    from granulab.errors import InputError

    run_app(app, "silo2d", InputError)
