"""The commands that compute one silo: run, packing."""

import json
from pathlib import Path
from typing import Any

import click

from granulab.campaign.cli.commandline import json_option, out_option, quiet_option
from granulab.campaign.cli.run import Runnable, run_case, run_options
from silo2d.commands.options import case_command, changes_of, mu_option, outline_options


@case_command()
@click.argument("case", required=False)
@mu_option
@outline_options
@run_options
def run(
    case: str | None, mu: str | None, out: str,
    resume: str | None, again: bool, dry_run: bool, no_figures: bool, page: bool, quiet: bool,
    as_json: bool, threads: int | None,
    **options: Any,
) -> None:  # fmt: skip
    """Fill a silo, open it, and measure how it empties.

    For example: silo2d run A4 --outlet "120 mm" --mu 0.3
    """
    changes = changes_of(mu, options)
    if (case is None) == (resume is None):
        raise click.UsageError("give a case (A4, or a TOML file), or --resume DIR, one of them")
    if resume and (changes or again):
        raise click.UsageError("--resume goes on with a case as it is; leave other options out")
    if resume and (Path(resume) / "avalanches.toml").is_file():
        raise click.UsageError(f"{resume}: avalanches; the same command clog goes on with them")
    from granulab.campaign.runs.folder import resume_run
    from silo2d.case.case import SiloCase
    from silo2d.case.plan import plan
    from silo2d.run import protocol
    from silo2d.run.sweep import SILO
    from silo2d.view.picture import make_figures
    from silo2d.view.player import player_page
    from silo2d.view.report import echo, report
    from silo2d.view.sketch import sketch

    loaded = SiloCase.load(resume_run(resume).case_file if resume else str(case), changes)
    runnable = Runnable(
        loaded, SILO, protocol, plan, echo, report, sketch, make_figures, player_page
    )
    run_case(
        runnable, out=out, resume=resume, again=again, dry_run=dry_run, no_figures=no_figures,
        page=page, quiet=quiet, as_json=as_json, threads=threads,
    )  # fmt: skip


@case_command()
@click.argument("case")
@mu_option
@outline_options
@out_option
@quiet_option
@json_option
def packing(
    case: str, mu: str | None, out: str, quiet: bool,
    as_json: bool, **options: Any,
) -> None:  # fmt: skip
    """Fill a silo and keep the packing; runs of the same case take it from there."""
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.terminal import Progress, StopRequest
    from silo2d.case.case import SiloCase
    from silo2d.run.packing import packing_folder
    from silo2d.run.protocol import get_packing
    from silo2d.run.sweep import SILO

    loaded = SiloCase.load(case, changes_of(mu, options))
    folder = packing_folder(loaded, Path(out))
    if not SILO.packing_file(loaded, Path(out)).exists():
        refuse_unless_writable(folder, "--out")
    with StopRequest() as stop, Progress(loaded.name, quiet=quiet, estimates=False) as bar:
        found = get_packing(loaded, Path(out), bar.update, lambda: stop.requested)
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
