"""What the command lines of all simulators share: options, studies, and how a command ends."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from granulab.campaign.sweeps.cases import LabelledStudy
    from granulab.campaign.sweeps.sweep import Simulator

out_option = click.option(
    "-o", "--out", default="runs", metavar="DIR", help="Holds runs and packings [default: runs]."
)
quiet_option = click.option("--quiet", is_flag=True, help="Print nothing but the answer.")
json_option = click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")


class Ended(Exception):
    """A command did its work and says, by a line and an exit code, what is missing."""

    def __init__(self, line: str, code: int) -> None:
        super().__init__(line)
        self.code = code


def engine_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Where many runs go: --workers, --engine, --scheduler."""
    for option in (
        click.option("--scheduler", metavar="ADDRESS", help="A Dask cluster: tcp://127.0.0.1:8786"),
        click.option(
            "--engine",
            type=click.Choice(["processes", "dask"]),
            default="processes",
            help="Where the runs go [default: processes of this machine].",
        ),
        click.option("--workers", type=int, metavar="N", help="Processes [default: one per core]."),
    ):
        command = option(command)
    return command


def study_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The argument and the options of a command that runs a study; see sweep_study."""
    for option in (
        json_option,
        quiet_option,
        click.option("--dry-run", is_flag=True, help="Say what would be run, and end."),
        engine_options,
        out_option,
        click.argument("study"),
    ):
        command = option(command)
    return command


def sweep_study(
    simulator: "Simulator",
    loaded: "LabelledStudy",
    *,
    out: str,
    dry_run: bool,
    as_json: bool,
    quiet: bool,
    **engine: Any,
) -> None:
    """Run a study, or say what would be run; print what came of it, and raise Ended for gaps."""
    from granulab.campaign.sweeps.cases import run_study
    from granulab.campaign.sweeps.overview import as_text, plan, plan_as_text, summary

    if dry_run:
        planned = plan(simulator, loaded, Path(out))
        click.echo(json.dumps(planned, indent=2) if as_json else plan_as_text(loaded, planned))
        return
    folder, rows = run_study(simulator, loaded, out=Path(out), quiet=quiet, **engine)
    table = summary(simulator, loaded, folder, rows)
    click.echo(json.dumps(table, indent=2) if as_json else as_text(table))
    if table["interrupted"]:
        raise Ended(f"{table['why_interrupted']}; the same command goes on from there", 130)
    if table["failed"]:
        raise Ended(f"{table['failed']} of {table['runs']} runs failed; see {table['table']}", 3)


def run_app(app: click.Group, name: str, bad_input: type[Exception]) -> None:
    """Run a command; one line on stderr and an exit code for whatever goes wrong.

    `bad_input` is what the simulator raises where it is given something that it cannot use.
    """
    from granulab.campaign.runs.folder import FolderError
    from granulab.campaign.sweeps.study import StudyError
    from granulab.campaign.sweeps.task import EngineError
    from granulab.errors import SimulationError, Stopped

    def fail(line: str, code: int) -> None:
        click.echo(f"{name}: {line}", err=True)
        sys.exit(code)

    try:
        app(standalone_mode=False, prog_name=name)
    except click.ClickException as error:
        fail(error.format_message().replace("\n", " "), 2)
    except (bad_input, FolderError, EngineError, StudyError) as error:
        fail(str(error), 2)
    except Ended as error:
        fail(str(error), error.code)
    except SimulationError as error:
        fail(str(error), 3)
    except Stopped as error:
        fail(f"stopped; {error}", 130)
    except (KeyboardInterrupt, click.Abort):
        fail("interrupted; the same command goes on from the last checkpoint", 130)
    except BrokenPipeError:
        sys.stderr.close()  # the reader of a pipe (head) has gone: nothing to say, nobody to tell
        sys.exit(0)
