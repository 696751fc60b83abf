"""The commands of the effective field: field, and response by harmonic balance."""

import json
from pathlib import Path
from typing import Any

import click

from damper3d.commands.options import case_command, changes_of, material_option
from granulab.campaign.cli.commandline import engine_options, json_option, out_option, quiet_option
from granulab.campaign.cli.many import numbers, stop_unless_whole

_WITHOUT = {
    "motion.frequency": "give --frequencies, a list such as 20,40,80",
    "motion.gamma": "give --gammas, a list such as 1,3,10",
    "run.steady": "the runs of a field are steady",
}


@case_command("field", without=_WITHOUT)
@click.argument("case", required=False)
@material_option
@click.option("--frequencies", metavar="20,40", help="In Hz [default: 20,40,80].")
@click.option("--gammas", metavar="0.5,1,3", help="In g [default: 0.5,1,1.5,2,3,5,8,12,20].")
@click.option("--packings", type=int, default=3, metavar="N", help="Of each point [default: 3].")
@click.option("--refine", type=int, default=0, metavar="N", help="Add points N times at bends.")
@engine_options
@out_option
@click.option("--no-figures", is_flag=True, help="Make no picture.")
@quiet_option
@json_option
def field(
    case: str | None, material: str | None, frequencies: str | None, gammas: str | None,
    packings: int, refine: int, workers: int | None, engine: str, scheduler: str | None, out: str,
    no_figures: bool, quiet: bool, as_json: bool, **options: Any,
) -> None:  # fmt: skip
    """Measure a bed's effective mass over frequency and amplitude: table, picture.

    The table serves `damper3d response`, and other programs. Runs are steady; those that are
    finished are not done again. For example: damper3d field --frequencies 15,20,25 --packings 4
    """
    from damper3d.case.case import DamperCase
    from damper3d.studies.field import runs
    from damper3d.studies.field.chart import draw_field
    from damper3d.studies.field.report import as_text, results_of, write_field
    from damper3d.studies.map.grid import Grid
    from granulab.campaign.output.figure import write_figure
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.layout import on_screen

    name, changes = case or "thesis", changes_of(material, options)
    loaded = DamperCase.load(name, changes)
    grid = Grid(
        numbers("--frequencies", frequencies, (20.0, 40.0, 80.0)),
        numbers("--gammas", gammas, (0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0)),
        packings, refine, loaded.settings.run.seed,
    )  # fmt: skip
    refuse_unless_writable(Path(out), "--out")
    engines = {"engine": engine, "workers": workers, "scheduler": scheduler, "quiet": quiet}
    rows, points = runs.measure(name, changes, grid, loaded.mass, out=Path(out), **engines)
    if len(points.gamma):
        folder = write_field(name, changes, grid, rows, points, Path(out))
        results = results_of(loaded, points, rows, folder.path)
        click.echo(json.dumps(results, indent=2) if as_json else on_screen(as_text(results)))
        if not no_figures:
            drawn = write_figure(
                folder.path / "field.png", lambda: draw_field(points, loaded.name, loaded.mass)
            )
            click.echo(drawn, err=True)
    stop_unless_whole(rows)


@case_command("response")
@click.argument("case")
@material_option
@click.option("--field", "table", required=True, metavar="TABLE", help="Table of a field.")
@click.option("--levels", metavar="0.5,1,2", help="Times the excitation [default: 0.5,1,2].")
@click.option("--span", metavar="0.9,1.1", help="Over the host's frequency [default: 0.85,1.15].")
@click.option("--points", type=click.IntRange(2, 100_000), default=600, metavar="N",
              help="Frequencies [default: 600].")  # fmt: skip
@click.option("-o", "--output", metavar="FOLDER", default=".", help="For response.csv and .png.")
@click.option("--no-figures", is_flag=True, help="Make no picture.")
@json_option
def response(
    case: str, material: str | None, table: str, levels: str | None, span: str | None, points: int,
    output: str, no_figures: bool, as_json: bool, **options: Any,
) -> None:  # fmt: skip
    """Find a structure's response with a damper from its field: all branches, peaks, jumps.

    CASE has a [host]; the table is that of `damper3d field` for the same bed.
    """
    from damper3d.case.case import DamperCase
    from damper3d.studies.field import report
    from damper3d.studies.field.chart import draw_response
    from damper3d.studies.field.table import read_field
    from granulab.campaign.output.figure import write_figure
    from granulab.campaign.output.layout import on_screen

    loaded = DamperCase.load(case, changes_of(material, options))
    asked = report.Asked(
        numbers("--levels", levels, (0.5, 1.0, 2.0)), numbers("--span", span, (0.85, 1.15)), points
    )
    found = report.responses(loaded, read_field(Path(table)), asked)
    report.write_responses(found, Path(output))
    results = report.response_results(loaded, found, Path(output))
    click.echo(json.dumps(results, indent=2) if as_json else on_screen(report.in_words(results)))
    if not no_figures:
        drawn = write_figure(
            Path(output) / "response.png",
            lambda: draw_response(
                found.branch, found.frequency, found.bare, found.names, report.title(loaded)
            ),
        )
        click.echo(drawn, err=True)
