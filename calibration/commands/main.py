"""The command calibrate: its subcommands, and what it says when something goes wrong."""

import importlib

import click

from granulab.campaign.cli.commandline import run_app

# name: module of calibration.commands, imported when it is called or asked for help
_COMMANDS: dict[str, str] = {
    "drop": "drop",
    "pendulum": "pendulum",
    "impacts": "impacts",
    "shaker": "shaker",
    "piv": "piv",
    "incline": "incline",
    "slide": "slide",
    "compression": "compression",
    "interface": "interface",
    "roughness": "roughness",
    "density": "density",
    "published": "published",
    "damping": "damping",
    "flow": "flow",
    "compare": "compare",
    "inverse": "inverse",
    "stiffness-fe": "stiffness_fe",
    "report": "report",
}


class Lazy(click.Group):
    """Commands whose modules are imported when they are needed, so that --help is quick."""

    def list_commands(self, context: click.Context) -> list[str]:
        """All names, in the order in which they are shown."""
        return list(_COMMANDS)

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        """The command `NAME` of the module that has it; an attribute called `command`."""
        if name not in _COMMANDS:
            return None
        return importlib.import_module(f"calibration.commands.{_COMMANDS[name]}").command


@click.group(
    cls=Lazy,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="granulab")
@click.pass_context
def app(context: click.Context) -> None:
    """Calibration: contact parameters from videos, tables and signals, with their uncertainty."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def main() -> None:
    """Run the command; one line on stderr and an exit code for whatever goes wrong."""
    from granulab.errors import InputError

    run_app(app, "calibrate", InputError)
