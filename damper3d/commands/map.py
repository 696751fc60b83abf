"""The command that maps the efficiency over frequency and Gamma: map."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from damper3d.commands.options import case_command, changes_of, material_option
from granulab.campaign.cli.commandline import (
    device_options,
    dry_run_option,
    json_option,
    no_figures_option,
    out_option,
    quiet_option,
)
from granulab.campaign.cli.many import numbers, rank_by_option, sketched, stop_unless_whole

if TYPE_CHECKING:
    from damper3d.studies.map.grid import Grid
    from damper3d.studies.predict.prediction import Prediction
    from granulab.campaign.sweeps.report.quantities import Quantities

_WITHOUT = {
    "motion.frequency": "give --frequencies, a list such as 20,40,80",
    "motion.gamma": "give --gammas, a list such as 1,3,10",
}


@case_command("map", without=_WITHOUT)
@click.argument("case", required=False)
@material_option
@click.option("--frequencies", metavar="20,40", help="In Hz [default: the thesis's nine].")
@click.option("--gammas", metavar="1,3,10", help="In g [default: the thesis's nineteen].")
@click.option("--packings", type=int, default=1, metavar="N", help="Of each point [default: 1].")
@click.option("--refine", type=int, default=0, metavar="N", help="Halve N times about each peak.")
@device_options
@out_option
@rank_by_option
@dry_run_option
@no_figures_option
@quiet_option
@json_option
def map_(
    case: str | None, material: str | None, frequencies: str | None,
    gammas: str | None, packings: int, refine: int, workers: int | None, engine: str,
    scheduler: str | None, out: str, rank_by: str | None, dry_run: bool, no_figures: bool,
    quiet: bool, as_json: bool, **options: Any,
) -> None:  # fmt: skip
    """Map the efficiency over frequency and Gamma: ridges, table, picture.

    Runs that are finished are not done again: the same command goes on after whatever stopped it,
    and --refine or --packings take the runs of a smaller map, into a map of their own.
    For example: damper3d map --frequencies 20,40 --packings 3 --refine 3
    """
    from damper3d.case.case import DamperCase
    from damper3d.run.sweep import DAMPER
    from damper3d.studies.map.grid import FREQUENCIES, GAMMAS, Grid
    from damper3d.studies.predict.prediction import predict
    from damper3d.view.sketch import sketch
    from granulab.campaign.sweeps.report.summary import ranked_by

    name, changes = case or "thesis", changes_of(material, options)
    loaded = DamperCase.load(name, changes)
    prediction = predict(loaded, needed=False)  # onsets are drawn where they are known
    quantities = ranked_by(DAMPER.quantities, rank_by)
    grid = Grid(
        numbers("--frequencies", frequencies, FREQUENCIES), numbers("--gammas", gammas, GAMMAS),
        packings, refine, loaded.settings.run.seed,
    )  # fmt: skip
    if dry_run:
        planned = _plan(name, changes, grid, Path(out))
        if not no_figures:
            title = f"{planned['case']}: map of {planned['runs']} runs"
            planned |= sketched(DAMPER, [loaded], sketch, Path(planned["folder"]), title)
        click.echo(json.dumps(planned, indent=2) if as_json else _in_words(planned))
        return
    engines = {"engine": engine, "workers": workers, "scheduler": scheduler, "quiet": quiet}
    _map(prediction, (name, changes, grid), quantities, Path(out), no_figures, as_json, engines)


def _map(
    prediction: "Prediction", of: tuple[str, dict[str, Any], "Grid"], quantities: "Quantities",
    out: Path, no_figures: bool, as_json: bool, engines: dict[str, Any],
) -> None:  # fmt: skip
    """Run a map, write and print its results."""
    from damper3d.run.sweep import DAMPER
    from damper3d.studies.map.chart import draw_map
    from damper3d.studies.map.grid import map_so_far
    from damper3d.studies.map.report import as_text, compared, map_folder, summary, write_map
    from damper3d.studies.map.ridges import ridges
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.layout import on_screen, paragraphs, stopped
    from granulab.campaign.sweeps.report.summary import write_pictures, write_ranking
    from granulab.campaign.sweeps.report.words import ranking_as_text

    refuse_unless_writable(out, "--out")
    folder, grid = map_folder(*of, out), of[2]
    result = map_so_far(*of, out=out, **engines)
    on_ridges = ridges(result, prediction)
    comparison = compared(prediction.name, result, quantities)
    results = summary(grid, result, prediction, on_ridges, folder.path, comparison)
    write_map(folder, result, results)
    whole = not stopped(result.rows)
    if whole:
        write_ranking(folder.path, comparison, results)
    text = paragraphs(on_screen(as_text(results)), ranking_as_text(comparison))
    click.echo(json.dumps(results, indent=2) if as_json else text)
    if not no_figures and results["done"] and whole:
        written = write_pictures(
            folder.path, comparison, DAMPER.means, "map.png",
            lambda _: draw_map(result, prediction, on_ridges),
        )  # fmt: skip
        for path in written.values():
            click.echo(path, err=True)
    stop_unless_whole(result.rows)


def _plan(name: str, changes: dict[str, Any], grid: "Grid", out: Path) -> dict[str, Any]:
    """The runs of a map and their cost, but for its refinement, which follows from results."""
    from damper3d.studies.map.grid import map_cases
    from damper3d.studies.map.report import map_folder, planned

    cases = [case for _, case in map_cases(name, changes, grid)]
    folder = map_folder(name, changes, grid, out)
    return planned(cases, grid, folder, out) | {"refine": grid.refine}


def _in_words(planned: dict[str, Any]) -> str:
    from granulab.campaign.output import room
    from granulab.campaign.sweeps.overview import picture_line

    def listed(values: list[float]) -> str:
        return " ".join(f"{value:g}" for value in values)

    refined = f", then {planned['refine']} refinements" if planned["refine"] else ""
    return "\n".join(
        [
            f"{planned['case']}: {planned['runs']} runs, {planned['finished']} of them finished; "
            f"{planned['packings_to_fill']} packings to fill{refined}",
            f"frequencies {listed(planned['frequencies_hz'])} Hz",
            f"Gamma       {listed(planned['gammas'])}",
            f"expected    about {planned['expected_cpu_min']:.1f} min of CPU",
            room.line(planned),
            f"table       {planned['folder']}/table.csv",
            *picture_line(planned),
        ]
    )
