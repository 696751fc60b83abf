"""The commands that compute one silo: run, packing."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from granulab.campaign.cli.commandline import json_option, out_option, quiet_option
from silo2d.commands.options import case_options, changes_of, say_if_compiling

if TYPE_CHECKING:
    from silo2d.case.case import SiloCase
    from silo2d.run.result import Result


@click.command()
@click.argument("case", required=False)
@case_options
@out_option
@click.option("--resume", metavar="DIR", help="Go on with the run in this folder.")
@click.option("--again", is_flag=True, help="Compute it anew beside a run that is there.")
@click.option("--dry-run", is_flag=True, help="Say what would be run, and end.")
@click.option("--no-figures", is_flag=True, help="Make no pictures and no film.")
@quiet_option
@json_option
def run(
    case: str | None, seed: str | None, mu: str | None, keep_ratios: bool, out: str,
    resume: str | None, again: bool, dry_run: bool, no_figures: bool, quiet: bool, as_json: bool,
    **options: str | None,
) -> None:  # fmt: skip
    """Fill a silo, open it, and measure how it empties.

    For example: silo2d run A4 --outlet "120 mm" --mu 0.3
    """
    changes = changes_of(seed, mu, keep_ratios, options)
    if (case is None) == (resume is None):
        raise click.UsageError("give a case (A4, or a TOML file), or --resume DIR, one of them")
    if resume and (changes or again):
        raise click.UsageError("--resume goes on with a case as it is; leave other options out")
    from granulab.campaign.runs.folder import resume_run
    from silo2d.case.case import SiloCase
    from silo2d.case.plan import plan
    from silo2d.view.report import echo, report

    loaded = SiloCase.load(resume_run(resume).path / "case.toml" if resume else str(case), changes)
    if dry_run:
        click.echo(json.dumps(plan(loaded), indent=2) if as_json else echo(loaded, dry_run=True))
        return
    if not quiet:
        click.echo(echo(loaded, dry_run=False), err=True)
    result = _computed(loaded, out, resume, again, quiet)
    if not no_figures:
        _draw(result.run_folder, quiet, anew=not result.reused)
    click.echo(_as_json(result) if as_json else report(result))


def _computed(case: "SiloCase", out: str, resume: str | None, again: bool, quiet: bool) -> "Result":
    """The result of a case, with a bar on stderr; Ctrl-C stops at the next frame."""
    from granulab.campaign.cli.terminal import Progress, StopRequest
    from silo2d.run import protocol

    say_if_compiling(quiet)
    with StopRequest() as stop, Progress(case.name, quiet=quiet) as bar:
        if resume:
            return protocol.resume(resume, progress=bar.update, stop=lambda: stop.requested)
        return protocol.run(
            case, out=out, again=again, progress=bar.update, stop=lambda: stop.requested
        )


def _draw(folder: str, quiet: bool, anew: bool) -> None:
    """The figures of a run, made where they are missing."""
    from silo2d.view.picture import make_figures

    if not anew and (Path(folder) / "figures" / "silo.png").exists():
        return
    if not quiet:
        click.echo(f"drawing {folder}/figures ...", err=True)
    make_figures(folder)


def _as_json(result: "Result") -> str:
    import dataclasses

    return json.dumps(dataclasses.asdict(result), indent=2)


@click.command()
@click.argument("case")
@case_options
@out_option
@quiet_option
@json_option
def packing(
    case: str, seed: str | None, mu: str | None, keep_ratios: bool, out: str, quiet: bool,
    as_json: bool, **options: str | None,
) -> None:  # fmt: skip
    """Fill a silo and keep the packing; runs of the same case take it from there."""
    from granulab.campaign.cli.terminal import Progress, StopRequest
    from silo2d.case.case import SiloCase
    from silo2d.run.packing import packing_folder
    from silo2d.run.protocol import get_packing

    loaded = SiloCase.load(case, changes_of(seed, mu, keep_ratios, options))
    say_if_compiling(quiet)
    with StopRequest() as stop, Progress(loaded.name, quiet=quiet) as bar:
        found = get_packing(loaded, Path(out), bar.update, lambda: stop.requested)
    folder = packing_folder(loaded, Path(out))
    table = {
        "n_particles": len(found.kinds),
        "packing_fraction": found.fraction,
        "coordination": found.coordination,
        "poured_with": found.poured_with,
        "cpu_s": found.cpu_s,
        "folder": str(folder),
    }
    lines = (f"{name:17} {value}" for name, value in table.items())
    click.echo(json.dumps(table, indent=2) if as_json else "\n".join(lines))
