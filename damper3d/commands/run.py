"""The command that computes one damper: run."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from damper3d.commands.options import case_options, changes_of, say_if_compiling
from granulab.campaign.cli.commandline import json_option, out_option, quiet_option

if TYPE_CHECKING:
    from damper3d.case.case import DamperCase
    from damper3d.run.result import Result


@click.command()
@click.argument("case", required=False)
@case_options
@out_option
@click.option("--resume", metavar="DIR", help="Go on with the run in this folder.")
@click.option("--again", is_flag=True, help="Compute it anew beside a run that is there.")
@click.option("--dry-run", is_flag=True, help="Say what would be run, and end.")
@click.option("--no-figures", is_flag=True, help="Make no pictures.")
@quiet_option
@json_option
def run(
    case: str | None, seed: str | None, material: str | None, out: str, resume: str | None,
    again: bool, dry_run: bool, no_figures: bool, quiet: bool, as_json: bool,
    **options: str | bool | None,
) -> None:  # fmt: skip
    """Shake a granular damper and measure the energy that it dissipates.

    CASE is a preset or a TOML file; left out, it is the thesis's damper. For example:
    damper3d run --frequency 40 --gamma 20 --orientation horizontal
    """
    changes = changes_of(seed, material, options)
    if resume and (case is not None or changes or again):
        raise click.UsageError("--resume goes on with a case as it is; leave other options out")
    from damper3d.case.case import DamperCase
    from damper3d.case.plan import plan
    from damper3d.run.folders import shaken
    from damper3d.view.report import echo, report

    usual = "thesis" if case is None else case
    loaded = DamperCase.load(shaken(resume).path / "case.toml" if resume else usual, changes)
    if dry_run:
        click.echo(json.dumps(plan(loaded), indent=2) if as_json else echo(loaded, dry_run=True))
        return
    if not quiet:
        click.echo(echo(loaded, dry_run=False), err=True)
    result = _computed(loaded, out, resume, again, quiet)
    if not no_figures and loaded.settings.output.keep == "all":
        _draw(result, quiet)
    click.echo(_as_json(result) if as_json else report(result))


def _computed(
    case: "DamperCase", out: str, resume: str | None, again: bool, quiet: bool
) -> "Result":
    """The result of a case, with a bar on stderr; Ctrl-C stops at the next sample."""
    from damper3d.run import protocol
    from granulab.campaign.cli.terminal import Progress, StopRequest

    say_if_compiling(quiet)
    with StopRequest() as stop, Progress(case.name, quiet=quiet) as bar:
        if resume:
            return protocol.resume(resume, progress=bar.update, stop=lambda: stop.requested)
        return protocol.run(
            case, out=out, again=again, progress=bar.update, stop=lambda: stop.requested
        )


def _draw(result: "Result", quiet: bool) -> None:
    """The figures of a run, made where they are missing."""
    from damper3d.view.picture import make_figures

    if result.reused and any((Path(result.run_folder) / "figures").glob("*.png")):
        return
    if not quiet:
        click.echo(f"drawing {result.run_folder}/figures ...", err=True)
    make_figures(result.run_folder)


def _as_json(result: "Result") -> str:
    import dataclasses

    return json.dumps(dataclasses.asdict(result), indent=2)
