"""The commands on runs that are there: render, observe, compare, export."""

import json
from pathlib import Path
from typing import Any

import click

from damper3d.commands.options import cycles_in_film
from granulab.campaign.cli.commandline import json_option
from granulab.campaign.cli.observe import observe_command


@click.command()
@click.argument("folder", metavar="RUN")
@click.option("--no-film", is_flag=True, help="Make the pictures only.")
@click.option(
    "--by",
    default="velocity",
    metavar="velocity|dissipation|kind",
    help="Quantity shown by the colours.",
)
@click.option(
    "--engine",
    default="matplotlib",
    metavar="matplotlib|pyvista",
    help="Drawing of the particles: a cut, or all of them in space (extra pyvista).",
)
@cycles_in_film
def render(folder: str, no_film: bool, by: str, engine: str, cycles_in_film: int | None) -> None:
    """Make the pictures and the film of a run again from its folder."""
    from damper3d.view.picture import make_figures

    paths = make_figures(
        folder, film=not no_film, by=by, engine=engine, cycles_in_film=cycles_in_film
    )
    for path in paths:
        click.echo(path)


def player() -> Any:
    """Return what makes the page of a run."""
    from damper3d.view.player.page import player_page

    return player_page


def _measures() -> Any:
    from damper3d.measures import MEASURES

    return MEASURES


def _run_folder(path: str) -> Path:
    from damper3d.run.folders import shaken

    return shaken(path).path


observe = observe_command(_measures, _run_folder, "damper3d")


@click.command()
@click.argument("first", metavar="RUN")
@click.argument("second", metavar="RUN")
@click.option("--no-figures", is_flag=True, help="Make no picture.")
@json_option
def compare(first: str, second: str, no_figures: bool, as_json: bool) -> None:
    """Set two runs side by side: efficiency, shares of the mechanisms, histories, cost."""
    from damper3d.view import compare as comparison
    from damper3d.view.scene import NothingKept
    from granulab.campaign.output.figure import write_figure

    found = comparison.compare(first, second)
    click.echo(json.dumps(found, indent=2) if as_json else comparison.table(found))
    if no_figures:
        return
    path = Path(first) / "figures" / f"beside-{Path(second).resolve().name}.png"
    try:
        click.echo(write_figure(path, lambda: comparison.draw(found)), err=True)
    except NothingKept as error:  # its numbers are there all the same
        click.echo(f"no picture: {error}", err=True)


@click.command()
@click.argument("folder", metavar="RUN")
@click.option("--to", required=True, metavar="vtkhdf|csv|shaker", help="The format.")
@click.option(
    "-o", "--output", metavar="PATH", help="File (vtkhdf, shaker) or folder for tables (csv)."
)
@click.option(
    "--enclosure-mass", metavar='"200 g"',
    help="Of a shaker's record, without particles [default: 200 g].",
)  # fmt: skip
def export(folder: str, to: str, output: str | None, enclosure_mass: str | None) -> None:
    """Write a run for other programs: ParaView (vtkhdf), tables (csv), or as a shaker's record.

    The record (shaker) is what a force transducer and an accelerometer would have measured, with
    particles and, next to it, without: `calibrate shaker` reads both.
    """
    from damper3d.view.export import export as write
    from granulab.contact.files.units import to_si

    mass = None if enclosure_mass is None else to_si(enclosure_mass, "kg", "--enclosure-mass")
    for path in write(folder, to, output, mass):
        click.echo(path)
