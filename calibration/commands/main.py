"""The command calibrate: its subcommands, and the one line that ends it where it fails."""

import importlib
import traceback
from typing import Any

import click

from granulab.campaign.cli.commandline import command_group, run_app
from granulab.errors import InputError

# name: module of calibration.commands, imported when it or its help is called
_COMMANDS: dict[str, str] = {
    "drop": "films.drop",
    "pendulum": "films.pendulum",
    "rebound": "films.rebound",
    "triaxial": "films.triaxial",
    "impacts": "impacts",
    "shaker": "shaker",
    "piv": "films.piv",
    "heights": "bench",
    "incline": "bench",
    "slide": "bench",
    "compression": "bench",
    "interface": "bench",
    "roughness": "bench",
    "density": "bench",
    "published": "bench",
    "damping": "bench",
    "flow": "films.flow",
    "packing": "films.packing",
    "compare": "films.flow",
    "inverse": "inverse",
    "stiffness-fe": "stiffness_fe",
    "report": "report",
}


# whose exceptions say nothing to a user
_LIBRARIES = ("numpy", "scipy", "cv2", "pandas", "sklearn", "matplotlib", "PIL")


class Lazy(click.Group):
    """Commands whose modules are imported when they are needed, so that --help is quick."""

    def list_commands(self, context: click.Context) -> list[str]:
        """All names, in the order in which they are shown."""
        return list(_COMMANDS)

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        """The command of the module that has it: its `command`, or one of its `commands`."""
        if name not in _COMMANDS:
            return None
        module = importlib.import_module(f"calibration.commands.{_COMMANDS[name]}")
        command: click.Command = (
            module.commands[name] if hasattr(module, "commands") else module.command
        )
        return command

    def parse_args(self, context: click.Context, args: list[str]) -> list[str]:
        """Keep the command and its files, for what is said where it cannot be carried out."""
        context.meta[__name__] = [word for word in args if not word.startswith("-")][:2]
        return super().parse_args(context, args)

    def invoke(self, context: click.Context) -> Any:
        """Carry the command out; InputError, one line, where numbers defeat a numerical library."""
        try:
            return super().invoke(context)
        except Exception as error:
            if not _is_numerical(error):
                raise
            first = str(error).strip().partition("\n")[0]
            raise InputError(
                f"{' '.join(context.meta[__name__])}: its numbers cannot be evaluated "
                f"({type(error).__name__}: {first}); look for values that are missing, repeated or "
                "constant, or measure another part of it"
            ) from error


def _is_numerical(error: Exception) -> bool:
    """True for an exception of arithmetic, of a numerical library, or raised within one."""
    if isinstance(error, ImportError):
        return False
    if isinstance(error, ArithmeticError) or _is_of_library(type(error).__module__):
        return True
    *_, (frame, _) = traceback.walk_tb(error.__traceback__)
    return _is_of_library(str(frame.f_globals.get("__name__")))


def _is_of_library(module: str) -> bool:
    return module.partition(".")[0] in _LIBRARIES


app = command_group(
    [],
    "Calibration: contact parameters from videos, tables and signals, with their uncertainty.",
    Lazy,
)


def main() -> None:
    """Run the command; one line on stderr and an exit code for whatever goes wrong."""
    run_app(app, "calibrate")
