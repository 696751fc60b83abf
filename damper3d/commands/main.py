"""The command damper3d: its subcommands, and what it says when something goes wrong."""

import click

from damper3d.commands import (
    contact,
    files,
    impact,
    map,
    pack,
    predict,
    reproduce,
    results,
    run,
    shape,
    slow,
    sweep,
)  # fmt: skip
from granulab.campaign.cli.commandline import run_app


@click.group(
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="granulab")
@click.pass_context
def app(context: click.Context) -> None:
    """Granular dampers: the energy that shaken particles dissipate.

    A case is a preset ("thesis") or a TOML file; `damper3d init my_damper.toml` writes one with a
    comment on every key.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


for command in (
    run.run, sweep.sweep, map.map_, reproduce.reproduce, predict.predict, pack.pack, impact.impact,
    contact.contact, shape.shape, slow.shear, slow.compress, results.render, results.compare,
    results.export, files.init, files.list_, files.show,
):  # fmt: skip
    app.add_command(command)


def main() -> None:
    """Run the command; one line on stderr and an exit code for whatever goes wrong."""
    from granulab.errors import InputError

    run_app(app, "damper3d", InputError)
