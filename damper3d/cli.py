"""The command damper3d: its subcommands, and what it says when something goes wrong."""

import sys

import click

from damper3d.commands import files, run
from damper3d.commands.options import Ended


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


for command in (run.run, files.init, files.list_, files.show):
    app.add_command(command)


def main() -> None:
    """Run the command; one line on stderr and an exit code for whatever goes wrong."""
    from campaign.folder import FolderError
    from campaign.study import StudyError
    from campaign.task import EngineError
    from contact.quantity import InputError

    try:
        app(standalone_mode=False, prog_name="damper3d")
    except click.ClickException as error:
        _fail(error.format_message().replace("\n", " "), 2)
    except (InputError, FolderError, EngineError, StudyError) as error:
        _fail(str(error), 2)
    except Ended as error:
        _fail(str(error), error.code)
    except (KeyboardInterrupt, click.Abort):
        _fail("interrupted; the same command goes on from the last checkpoint", 130)
    except BrokenPipeError:
        sys.stderr.close()  # the reader of a pipe (head) has gone: nothing to say, nobody to tell
        sys.exit(0)
    except Exception as error:
        # The two that carry a run's fate live in modules that load numba: looked up by name here.
        if type(error).__name__ == "SimulationError":
            _fail(str(error), 3)
        if type(error).__name__ == "Stopped":
            _fail(f"stopped; {error}", 130)
        raise


def _fail(line: str, code: int) -> None:
    click.echo(f"damper3d: {line}", err=True)
    sys.exit(code)
