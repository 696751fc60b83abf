"""The commands on runs that are there: render, observe, compare, export."""

import json
from pathlib import Path
from typing import Any

import click

from granulab.campaign.cli.commandline import json_option, out_option, quiet_option
from granulab.campaign.cli.observe import observe_command
from silo2d.commands.options import case_command, changes_of, mu_option


@click.command()
@click.argument("folder")
@click.option("--no-film", is_flag=True, help="Make the pictures only.")
def render(folder: str, no_film: bool) -> None:
    """Make the pictures and the film of a run again from its folder."""
    from granulab.campaign.runs.folder import resume_run
    from silo2d.view.picture import make_figures

    for path in make_figures(resume_run(folder).path, film=not no_film):
        click.echo(path)


def player() -> Any:
    """Return what makes the page of a run."""
    from silo2d.view.player import player_page

    return player_page


def _measures() -> Any:
    from silo2d.measures import MEASURES

    return MEASURES


def _run_folder(path: str) -> Path:
    from granulab.campaign.runs.folder import resume_run

    return resume_run(path).path


observe = observe_command(_measures, _run_folder, "silo2d")
_WITHOUT = {"run.engine": "give --engines, such as dem,pymunk"}


@case_command(without=_WITHOUT)
@click.argument("runs_or_case", metavar="RUN RUN | CASE", nargs=-1, required=True)
@click.option("--engines", metavar="dem,pymunk", help="Run a case by both, and compare these runs.")
@click.option("--seeds", type=click.IntRange(1), metavar="3", help="With --engines: seeds 1 to N.")
@mu_option
@out_option
@click.option("--no-figures", is_flag=True, help="Make no picture.")
@quiet_option
@json_option
def compare(
    runs_or_case: tuple[str, ...], engines: str | None, seeds: int | None, mu: str | None,
    out: str, no_figures: bool, quiet: bool, as_json: bool,
    **options: Any,
) -> None:  # fmt: skip
    """Set two runs side by side: times, curves, cost.

    For example: silo2d compare --engines dem,pymunk A4
    """
    from granulab.campaign.output.figure import write_figure
    from granulab.campaign.output.layout import on_screen
    from silo2d.view import compare as comparison

    changes = changes_of(mu, options)
    if engines is None and (len(runs_or_case) != 2 or changes or seeds):
        raise click.UsageError("give two run folders; or --engines dem,pymunk, a case and options")
    if engines is not None and len(runs_or_case) != 1:
        raise click.UsageError("--engines compares the runs of one case; give one")
    if engines is None:
        pairs = [comparison.compare(*runs_or_case)]
        second = Path(pairs[0]["runs"][1]["run_folder"]).resolve()
        path = Path(runs_or_case[0]) / "figures" / f"beside-{second.name}.png"
    else:
        folders = _by_engines(runs_or_case[0], engines, seeds, changes, Path(out), quiet)
        pairs = [comparison.compare(*pair) for pair in folders]
        path = Path(folders[0][0]) / "figures" / f"beside-{Path(folders[0][1]).name}.png"
    result = {"pairs": pairs, "mean_curve": comparison.mean_distance(pairs)}
    click.echo(json.dumps(result, indent=2) if as_json else on_screen(comparison.table(pairs)))
    if not no_figures:
        click.echo(write_figure(path, lambda: comparison.draw(pairs)), err=True)


def _by_engines(
    case: str, engines: str, seeds: int | None, changes: dict[str, Any], out: Path, quiet: bool
) -> list[list[str]]:
    """The folders of a case's runs by two engines, a pair a seed."""
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.terminal import Progress, StopRequest
    from silo2d.baseline.comparison import engine_pair, run_engines
    from silo2d.case.case import SiloCase

    if seeds and "run.seed" in changes:
        raise click.UsageError("--seeds says this; leave --seed out")
    own = SiloCase.load(case, changes).settings.run.seed
    chosen = range(1, seeds + 1) if seeds else [own]
    pair = engine_pair(engines)
    refuse_unless_writable(out, "--out")
    with StopRequest() as stop, Progress(case, quiet=quiet, estimates=False) as bar:
        return run_engines(case, changes, pair, chosen, out, bar.update, lambda: stop.requested)


@click.command()
@click.argument("folder")
@click.option("--to", required=True, metavar="vtkhdf|csv", help="The format.")
@click.option("-o", "--output", metavar="PATH", help="File (vtkhdf) or folder for tables (csv).")
def export(folder: str, to: str, output: str | None) -> None:
    """Write a run for other programs: ParaView (vtkhdf) or tables (csv)."""
    from granulab.campaign.runs.folder import resume_run
    from silo2d.view.export import export as write

    for path in write(resume_run(folder).path, to, output):
        click.echo(path)
