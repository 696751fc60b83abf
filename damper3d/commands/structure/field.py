"""The command that computes a bed's effective mass over frequency and amplitude: field."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from damper3d.commands.options import case_command, changes_of, material_option
from granulab.campaign.cli.commandline import device_options, json_option, out_option, quiet_option
from granulab.campaign.cli.many import numbers, stop_unless_whole
from granulab.campaign.output.layout import stopped

if TYPE_CHECKING:
    from damper3d.case.case import DamperCase
    from damper3d.studies.field.runs import Refinement
    from damper3d.studies.map.grid import Grid, MapResult

_WITHOUT = {
    "motion.frequency": "give --frequencies, a list such as 20,40,80",
    "motion.gamma": "give --gammas, a list such as 0.5,1,2,5,10",
    "run.steady": "the runs of a field are always steady ones",
}


@case_command("field", without=_WITHOUT)
@click.argument("case", required=False)
@material_option
@click.option("--frequencies", metavar="20,40", help="In Hz [default: 20,40,80].")
@click.option("--gammas", metavar="0.5,1,3", help="In g [default: ten from 0.5 to 30].")
@click.option("--packings", type=int, default=3, metavar="N", help="Of each point [default: 3].")
@click.option(
    "--more-runs", type=int, default=0, metavar="N",
    help="Runs that may be added where the curves bend [default: 0].",
)  # fmt: skip
@click.option(
    "--within", type=float, default=0.05, metavar="0.05",
    help="Of the bed's mass, by which a straight line may miss a point [default: 0.05].",
)  # fmt: skip
@click.option(
    "--damper", metavar="tip|2", help="Of a case with several dampers: name or number of one."
)
@click.option("--fit", metavar="2,10", help="Gammas of the fitted powers [default: found].")
@device_options
@out_option
@click.option("--dry-run", is_flag=True, help="Say what would be run, and end.")
@click.option("--no-figures", is_flag=True, help="Make no picture.")
@quiet_option
@json_option
def field(
    case: str | None, material: str | None, frequencies: str | None, gammas: str | None,
    packings: int, more_runs: int, within: float, damper: str | None, fit: str | None,
    workers: int | None, engine: str, scheduler: str | None, out: str, dry_run: bool,
    no_figures: bool, quiet: bool, as_json: bool, **options: Any,
) -> None:  # fmt: skip
    """Compute the bed's effective mass over frequency and amplitude: table, picture.

    Steady runs at prescribed motion, as of a map; finished ones are not done again. `damper3d
    response` takes the table. A [host] in the case, and what moves it, are left out: the bed alone
    is shaken; of several dampers that of --damper.
    For example: damper3d field --frequencies 20,40 --more-runs 60
    """
    from damper3d.case.case import DamperCase
    from damper3d.studies.field.report import as_text, field_folder
    from damper3d.studies.field.runs import FREQUENCIES, GAMMAS, Refinement, field_of_runs
    from damper3d.studies.map.grid import Grid
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.layout import on_screen

    name = case or "thesis"
    changes = _bed_alone(name, damper) | changes_of(material, options)
    loaded = DamperCase.load(name, changes)
    refine, fitted = Refinement(more_runs, within), _range(fit)
    grid = Grid(
        numbers("--frequencies", frequencies, FREQUENCIES), numbers("--gammas", gammas, GAMMAS),
        packings, 0, loaded.settings.run.seed,
    )  # fmt: skip
    if dry_run:
        planned = _plan(name, changes, grid, refine, Path(out))
        click.echo(json.dumps(planned, indent=2) if as_json else _in_words(planned))
        return
    refuse_unless_writable(Path(out), "--out")
    engines = {"engine": engine, "workers": workers, "scheduler": scheduler, "quiet": quiet}
    folder = field_folder(name, changes, grid, refine, Path(out))
    result = field_of_runs(name, changes, grid, refine, out=Path(out), **engines)
    results = _write(loaded, result, folder, fitted, no_figures or stopped(result.rows))
    click.echo(json.dumps(results, indent=2) if as_json else on_screen(as_text(results)))
    stop_unless_whole(result.rows)


def _bed_alone(name: str, damper: str | None) -> dict[str, Any]:
    """Changes that leave the bed of a case, of several dampers that of the one that is named.

    Raises InputError where it is not said which.
    """
    from damper3d.case.case import DamperCase
    from granulab.errors import InputError

    case = DamperCase.load(name)
    given = case.together.damper or [] if case.together is not None else []
    if damper is not None:
        return {"damper": damper}
    if given:
        names = [one.at or str(k) for k, one in enumerate(given, 1)]
        raise InputError(
            f"{name}: [[damper]] has {len(given)} beds, each with a field of its own; give "
            f"--damper {names[0]} (they are {', '.join(names)}). Like beds have one field"
        )
    return {} if case.modes is None and case.excitation is None else {
        "host": None, "excitation": None,
    }  # fmt: skip


def _range(fit: str | None) -> tuple[float, float] | None:
    from granulab.errors import InputError

    if fit is None:
        return None
    found = numbers("--fit", fit, ())
    if len(found) != 2 or not 0 < found[0] < found[1]:
        raise InputError(f"--fit {fit!r}: give two rising Gammas, such as 2,10")
    return found[0], found[1]


def _write(
    case: "DamperCase", result: "MapResult", folder: Any, fitted: tuple[float, float] | None,
    no_figures: bool,
) -> dict[str, Any]:  # fmt: skip
    """Write the tables and the picture of a field; its results."""
    from damper3d.studies.field.chart import draw_field
    from damper3d.studies.field.origin import head
    from damper3d.studies.field.report import summary
    from damper3d.studies.field.runs import field_of
    from damper3d.studies.map.report import write_map
    from granulab.campaign.output.figure import write_figure

    found = field_of(result, head(case))
    results = summary(case, found, result, folder.path, fitted)
    write_map(folder, result, results)
    if len(found.gamma):
        found.write(folder.path / "field.csv")
        if not no_figures:
            picture = folder.path / "field.png"
            click.echo(write_figure(picture, lambda: draw_field(found, case.name)), err=True)
    return results


def _plan(
    name: str, changes: dict[str, Any], grid: "Grid", refine: "Refinement", out: Path
) -> dict[str, Any]:
    """The runs of a field and their cost at most; those that are added cost about as much each."""
    from damper3d.run.sweep import DAMPER
    from damper3d.studies.field.report import field_folder
    from damper3d.studies.field.runs import check_length, steady_changes
    from damper3d.studies.map.grid import map_cases
    from damper3d.studies.map.report import planned

    cases = [case for _, case in map_cases(name, steady_changes(changes), grid)]
    check_length(cases[0].name, cases[0].settings.run.max_cycles, cases[0].settings.run.discard)
    seconds = sum(DAMPER.expected_cpu_s(case)[1] for case in cases) / len(cases)
    found = planned(cases, grid, field_folder(name, changes, grid, refine, out), out)
    own = found.pop("expected_cpu_min")
    return found | {
        "more_runs_at_most": refine.most_runs // grid.packings * grid.packings,
        "expected_cpu_min_at_most": own + refine.most_runs * seconds / 60,
    }


def _in_words(planned: dict[str, Any]) -> str:
    return (
        f"{planned['case']}: {planned['runs']} runs, {planned['finished']} of them finished, then "
        f"at most {planned['more_runs_at_most']} where the curves bend\n"
        f"expected    at most {planned['expected_cpu_min_at_most']:.1f} min of CPU\n"
        f"table       {planned['folder']}/field.csv"
    )
