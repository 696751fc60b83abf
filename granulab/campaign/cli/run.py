"""The command `run` of any simulator: the case echoed, computed or gone on with, drawn, printed."""

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from granulab.campaign.cli.commandline import json_option, out_option, quiet_option

if TYPE_CHECKING:
    from granulab.campaign.sweeps.sweep import Simulator


class Runnable(NamedTuple):
    """A case, and what the command takes of its simulator."""

    case: Any
    simulator: "Simulator"
    protocol: Any  # a module: run(case, out, again, progress, stop), resume(path, progress, stop)
    plan: Callable[[Any], dict[str, Any]]  # steps and expected time, of --dry-run --json
    echo: Callable[..., str]  # the case in words
    report: Callable[[Any], str]  # the result in words
    draw: Callable[[str], Any] | None  # the figures of a run folder; None where none are wanted


def run_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options of `run` that do not change the case; see run_case."""
    for option in (
        json_option,
        quiet_option,
        click.option("--no-figures", is_flag=True, help="Make no pictures and no film."),
        click.option("--dry-run", is_flag=True, help="Say what would be run, and end."),
        click.option("--again", is_flag=True, help="Compute it again, in a folder of its own."),
        click.option("--resume", metavar="DIR", help="Go on with the run in this folder."),
        out_option,
    ):
        command = option(command)
    return command


def run_case(
    runnable: Runnable, *, out: str, resume: str | None, again: bool, dry_run: bool,
    no_figures: bool, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Compute a case, draw it and print its result; or say what would be run.

    Raises FolderError before anything is echoed or computed where the run cannot be kept.
    """
    case, echo = runnable.case, runnable.echo
    if dry_run:
        shown = json.dumps(runnable.plan(case), indent=2) if as_json else echo(case, dry_run=True)
        click.echo(shown)
        return
    _refuse_unless_kept(runnable.simulator, case, Path(out), resume, again)
    if not quiet:
        click.echo(echo(case, dry_run=False), err=True)
    result = _computed(runnable, out, resume, again, quiet)
    if not no_figures and runnable.draw is not None:
        figures = Path(result.run_folder) / "figures"
        if not (result.reused and (figures / "energy.png").exists()):  # which every run has
            if not quiet:
                click.echo(f"drawing {figures} ...", err=True)
            runnable.draw(result.run_folder)
    table = dataclasses.asdict(result)
    click.echo(json.dumps(table, indent=2) if as_json else runnable.report(result))


def _refuse_unless_kept(
    simulator: "Simulator", case: Any, out: Path, resume: str | None, again: bool
) -> None:
    """Raise FolderError where the folder that a run will have cannot be written."""
    from granulab.campaign.runs.folder import refuse_unless_writable

    folder = Path(resume) if resume else out if again else simulator.run_folder(case, out).path
    refuse_unless_writable(folder, "--out")


def _computed(runnable: Runnable, out: str, resume: str | None, again: bool, quiet: bool) -> Any:
    """The result of a case, with a bar on stderr; Ctrl-C stops at the next look."""
    from granulab.campaign.output.terminal import Progress, StopRequest, announce_compilation

    announce_compilation(quiet, runnable.simulator.compiled())
    with StopRequest() as stop, Progress(runnable.case.name, quiet=quiet) as bar:
        common = {"progress": bar.update, "stop": lambda: stop.requested}
        if resume:
            return runnable.protocol.resume(resume, **common)
        return runnable.protocol.run(runnable.case, out=out, again=again, **common)
