"""The command `run` of any simulator: the case echoed, computed or gone on with, drawn, printed."""

import dataclasses
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from granulab.campaign.cli.commandline import dry_run_option, json_option, out_option, quiet_option
from granulab.campaign.output.layout import wrapped
from granulab.campaign.output.terminal import say

_DRAWING = 8.0  # [s] that the figures and the film of a run take, about

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
    sketch: Callable[[Any], Sequence[Any]]  # the panels of a case that is drawn before it is run
    # The figures of a run folder; reports the pictures done and left. None where none are wanted.
    draw: Callable[..., Any] | None
    player: Callable[..., Any] | None  # the page of a run folder; None where nothing is kept for it


def run_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options of `run` that do not change the case; see run_case."""
    for option in (
        json_option,
        quiet_option,
        click.option("--page", is_flag=True, help="Write a page that plays the run in a browser."),
        click.option("--no-figures", is_flag=True, help="Make no pictures and no film."),
        click.option(
            "--threads",
            type=click.IntRange(min=1),
            metavar="N",
            help="Threads that share each step; the results are the same to the last bit. Left "
            "out: one, and all cores for large beds.",
        ),
        dry_run_option,
        click.option("--again", is_flag=True, help="Compute it again, in a folder of its own."),
        click.option("--resume", metavar="DIR", help="Go on with the run in this folder."),
        out_option,
    ):
        command = option(command)
    return command


def run_case(
    runnable: Runnable, *, out: str, resume: str | None, again: bool, dry_run: bool,
    no_figures: bool, page: bool, quiet: bool, as_json: bool, threads: int | None,
) -> None:  # fmt: skip
    """Compute a case, draw it and print its result; or say what would be run.

    threads: that share each step; None: as many as pay.

    Raises FolderError before anything is echoed or computed where the run cannot be kept, and
    InputError in place of a result that cannot be.
    """
    from granulab.campaign.output.ranges import judged
    from granulab.campaign.runs.sharing import wanted
    from granulab.contact.files.units import located
    from granulab.errors import InputError

    if page and runnable.player is None:
        raise InputError(
            '--page: nothing is kept to play (output.keep = "summary", or output.frames = 0); keep '
            "all, with frames"
        )
    with wanted(threads):
        if dry_run:
            _say_plan(runnable, Path(out), no_figures, as_json)
            return
        drawn = page or not no_figures
        _refuse_unless_writable(runnable.simulator, runnable.case, Path(out), resume, again, drawn)
        if not quiet:
            say(_in_words(runnable, Path(out), dry_run=False))
        draw = None if no_figures else runnable.draw
        result, paths = _computed(runnable, draw, out, resume, again, quiet)
    _say_what_plays(paths, quiet)
    table = dataclasses.asdict(result)
    with located(f"{result.run_folder}:"):
        warnings = judged(runnable.simulator.name, table)
    said = _page(runnable, Path(result.run_folder)) if page else []
    if as_json:
        click.echo(json.dumps(table | {"warnings": warnings}, indent=2))
        click.echo("".join(said), err=True, nl=bool(said))
        return
    lines = [runnable.report(result), *(f"  warning: {line}" for line in warnings), *said]
    click.echo(wrapped("\n".join(lines), 4))


def _in_words(runnable: Runnable, out: Path, *, dry_run: bool, more: str = "") -> str:
    """The case in words, and what its disk lacks."""
    from granulab.campaign.output import room

    short = room.shortage(runnable.simulator.disk_of([runnable.case]), out)
    warning = f"\n  warning     {short}" if short else ""
    return wrapped(runnable.echo(runnable.case, dry_run=dry_run) + more + warning, 14)


def _say_plan(runnable: Runnable, out: Path, no_figures: bool, as_json: bool) -> None:
    """Print what would be run, and draw it."""
    from granulab.campaign.output import room

    picture = None if no_figures else _sketched(runnable, out)
    free = {"disk_free_bytes": room.free(out), "picture": picture}
    drawn = f"\n  picture     {picture}" if picture else ""
    text = _in_words(runnable, out, dry_run=True, more=drawn)
    click.echo(json.dumps(runnable.plan(runnable.case) | free, indent=2) if as_json else text)


def _sketched(runnable: Runnable, out: Path) -> str | None:
    """Draw a case before it is run, beside the folder that its run would have; the path."""
    from granulab.campaign.sweeps.sketch import write_sketch

    folder = runnable.simulator.run_folder(runnable.case, out).path
    path = folder.with_name(f"{folder.name}.png")
    return write_sketch(path, runnable.case.name, runnable.sketch(runnable.case))


def _page(runnable: Runnable, run: Path) -> list[str]:
    """Line on the page that plays the run, which is written."""
    from granulab.campaign.cli.view import MOST_MB, written

    assert runnable.player is not None
    path, _ = written(runnable.player, run, MOST_MB)
    return [f"  page             {path}: open it in a browser"]


def _say_what_plays(paths: Any, quiet: bool) -> None:
    """Say what plays the film among some pictures, where not everything does."""
    from granulab.campaign.output.film import played_by

    for path in paths:
        words = played_by(path) if path.suffix in (".mp4", ".gif") else ""
        if words and not quiet:
            click.echo(f"{path}: {words}", err=True)


def _refuse_unless_writable(
    simulator: "Simulator", case: Any, out: Path, resume: str | None, again: bool, drawn: bool
) -> None:
    """Raise FolderError where the folder that a run will have cannot be written, and must be."""
    from granulab.campaign.output.files import refuse_unless_writable

    if resume or again:
        refuse_unless_writable(Path(resume) if resume else out, "--out")
        return
    folder = simulator.run_folder(case, out)
    if drawn or folder.state != "finished":
        refuse_unless_writable(folder.path, "--out")


def _computed(
    runnable: Runnable,
    draw: Callable[..., Any] | None,
    out: str,
    resume: str | None,
    again: bool,
    quiet: bool,
) -> tuple[Any, list[Path]]:
    """The result of a case and its figures, a bar on stderr; Ctrl-C stops at the next look."""
    from granulab.campaign.output.terminal import Progress, StopRequest
    from granulab.campaign.runs.stages import Stages

    with Progress(runnable.case.name, quiet=quiet, estimates=False) as bar:
        stages = Stages(bar.update)
        if draw is not None:
            stages.expect(drawing=_DRAWING)
        with StopRequest() as stop:
            common = {"progress": stages, "stop": lambda: stop.requested}
            if resume:
                result = runnable.protocol.resume(resume, **common)
            else:
                result = runnable.protocol.run(runnable.case, out=out, again=again, **common)
        figures = Path(result.run_folder) / "figures"
        if draw is not None and not (result.reused and (figures / "energy.png").exists()):
            stages.report("drawing", 0.0, 1.0, str(figures))  # of which energy.png is always one

            def drawn(done: int, left: int) -> None:
                stages.report("drawing", done, left, f"{done / (done + left):.0%} of the pictures")

            return result, draw(result.run_folder, report=drawn)
    return result, []
