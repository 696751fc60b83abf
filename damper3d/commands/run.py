"""The command that computes one damper: run."""

from functools import partial
from typing import Any

import click

from damper3d.commands.options import case_command, changes_of, cycles_in_film, material_option
from granulab.campaign.cli.run import Runnable, run_case, run_options


@case_command()
@click.argument("case", required=False)
@material_option
@cycles_in_film
@run_options
def run(
    case: str | None, material: str | None, cycles_in_film: int | None, out: str,
    resume: str | None, again: bool, dry_run: bool, no_figures: bool, page: bool, quiet: bool,
    as_json: bool, threads: int | None,
    **options: Any,
) -> None:  # fmt: skip
    """Shake a granular damper and measure the energy that it dissipates.

    CASE is a preset or a TOML file; left out, it is the thesis's damper. For example:
    damper3d run --frequency 40 --gamma 20 --orientation horizontal
    """
    changes = changes_of(material, options)
    if resume and (case is not None or changes or again):
        raise click.UsageError("--resume goes on with a case as it is; leave other options out")
    from damper3d.case.case import DamperCase
    from damper3d.case.plan import plan
    from damper3d.run import protocol
    from damper3d.run.folders import shaken
    from damper3d.run.sweep import DAMPER
    from damper3d.view.picture import make_figures
    from damper3d.view.player.page import player_page
    from damper3d.view.report import echo, report
    from damper3d.view.sketch import sketch

    usual = "thesis" if case is None else case
    loaded = DamperCase.load(shaken(resume).case_file if resume else usual, changes)
    drawn = partial(make_figures, cycles_in_film=cycles_in_film)
    output = loaded.settings.output
    draw = drawn if output.keep == "all" else None
    player = player_page if draw and output.frames else None
    runnable = Runnable(loaded, DAMPER, protocol, plan, echo, report, sketch, draw, player)
    run_case(
        runnable, out=out, resume=resume, again=again, dry_run=dry_run, no_figures=no_figures,
        page=page, quiet=quiet, as_json=as_json, threads=threads,
    )  # fmt: skip
