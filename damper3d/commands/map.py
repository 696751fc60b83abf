"""The command that maps the efficiency over frequency and Gamma: map."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from damper3d.commands.options import case_command, changes_of, material_option
from granulab.campaign.cli.commandline import engine_options, json_option, out_option, quiet_option
from granulab.campaign.cli.many import numbers, stop_unless_whole

if TYPE_CHECKING:
    from damper3d.studies.map.grid import Grid

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
@engine_options
@out_option
@click.option("--dry-run", is_flag=True, help="Say what would be run, and end.")
@click.option("--no-figures", is_flag=True, help="Make no picture.")
@quiet_option
@json_option
def map_(
    case: str | None, material: str | None, frequencies: str | None,
    gammas: str | None, packings: int, refine: int, workers: int | None, engine: str,
    scheduler: str | None, out: str, dry_run: bool, no_figures: bool, quiet: bool, as_json: bool,
    **options: Any,
) -> None:  # fmt: skip
    """Map the efficiency over frequency and Gamma: ridges, table, picture.

    Runs that are finished are not done again: the same command goes on after whatever stopped it,
    and --refine or --packings take the runs of a smaller map, into a map of their own.
    For example: damper3d map --frequencies 20,40 --packings 3 --refine 3
    """
    from damper3d.case.case import DamperCase
    from damper3d.studies.map.chart import draw_map
    from damper3d.studies.map.grid import FREQUENCIES, GAMMAS, Grid, efficiency_map
    from damper3d.studies.map.report import as_text, map_folder, summary, write_map
    from damper3d.studies.map.ridges import ridges
    from damper3d.studies.predict.prediction import predict
    from granulab.campaign.output.figure import write_figure
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.layout import on_screen

    name, changes = case or "thesis", changes_of(material, options)
    loaded = DamperCase.load(name, changes)
    prediction = predict(loaded)
    grid = Grid(
        numbers("--frequencies", frequencies, FREQUENCIES), numbers("--gammas", gammas, GAMMAS),
        packings, refine, loaded.settings.run.seed,
    )  # fmt: skip
    if dry_run:
        planned = _plan(name, changes, grid, Path(out))
        click.echo(json.dumps(planned, indent=2) if as_json else _in_words(planned))
        return
    refuse_unless_writable(Path(out), "--out")
    engines = {"engine": engine, "workers": workers, "scheduler": scheduler, "quiet": quiet}
    folder = map_folder(name, changes, grid, Path(out))
    result = efficiency_map(name, changes, grid, out=Path(out), **engines)
    on_ridges = ridges(result, prediction)
    results = summary(grid, result, prediction, on_ridges, folder.path)
    write_map(folder, result, results)
    click.echo(json.dumps(results, indent=2) if as_json else on_screen(as_text(results)))
    stopped = any(row["state"] == "interrupted" for row in result.rows)
    if not no_figures and results["done"] and not stopped:
        picture = folder.path / "map.png"
        click.echo(write_figure(picture, lambda: draw_map(result, prediction, on_ridges)), err=True)
    stop_unless_whole(result.rows)


def _plan(name: str, changes: dict[str, Any], grid: "Grid", out: Path) -> dict[str, Any]:
    """The runs of a map and their cost, but for its refinement, which follows from results."""
    from damper3d.run.sweep import DAMPER
    from damper3d.studies.map.grid import map_cases
    from damper3d.studies.map.report import map_folder
    from granulab.campaign.output import room

    cases = [case for _, case in map_cases(name, changes, grid)]
    todo = [case for case in cases if DAMPER.run_folder(case, out).state != "finished"]
    packings = {DAMPER.packing_file(case, out): case for case in todo}
    to_fill = [case for file, case in packings.items() if not file.exists()]
    seconds = sum(DAMPER.expected_cpu_s(case)[1] for case in todo)
    seconds += sum(DAMPER.expected_cpu_s(case)[0] for case in to_fill)
    return {
        "case": cases[0].name,
        "folder": str(map_folder(name, changes, grid, out).path),
        "frequencies_hz": list(grid.frequencies),
        "gammas": list(grid.gammas),
        "packings": grid.packings,
        "refine": grid.refine,
        "runs": len(cases),
        "finished": len(cases) - len(todo),
        "packings_to_fill": len(to_fill),
        "expected_cpu_min": seconds / 60,
        "disk_bytes_at_most": DAMPER.disk_of(todo),
        "disk_free_bytes": room.free(out),
    }


def _in_words(planned: dict[str, Any]) -> str:
    from granulab.campaign.output import room

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
        ]
    )
