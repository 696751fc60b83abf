"""The command that gives the loads on a silo: loads."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from granulab.campaign.cli.caseoptions import case_changes
from granulab.campaign.cli.commandline import json_option, out_option, quiet_option
from granulab.campaign.cli.observe import between_option, window_of
from silo2d.commands.options import case_command, changes_of, mu_option

if TYPE_CHECKING:
    from granulab.contact.files.casefile import Section

# Keys of a case that runs for loads have, where it does not say otherwise.
_SAMPLED = {"output.wall_interval": "1 ms", "output.contact_interval": "10 ms"}


def _beside() -> "type[Section]":
    from silo2d.loads.spec import Beside

    return Beside


@case_command(also=_beside, without={"run.engine": "loads need the contacts of dem"})
@click.argument("cases_or_runs", metavar="CASE | RUN...", nargs=-1)
@click.option("--silo", metavar="FILE", help="A full-size silo in closed form, without a CASE; or "
              "solid and rules for one.")  # fmt: skip
@click.option("--seeds", type=click.IntRange(1), metavar="3", help="With CASE: seeds 1 to N.")
@click.option(
    "--rough-plates", is_flag=True, help="Closed forms with plates that rub as the walls."
)
@between_option
@mu_option
@out_option
@click.option("--no-figures", is_flag=True, help="Make no picture and no sheet.")
@quiet_option
@json_option
def loads(
    cases_or_runs: tuple[str, ...], silo: str | None, seeds: int | None, rough_plates: bool,
    between: str | None, mu: str | None, out: str, no_figures: bool, quiet: bool, as_json: bool,
    **options: Any,
) -> None:  # fmt: skip
    """Loads on a silo: wall pressures and base by runs, Janssen, EN 1991-4, Jenike.

    A CASE is run (or taken from where it was); RUN... are run folders that differ in their seed, or
    the folder of a sweep. Without any, --silo FILE is assessed in closed form: silo2d init FILE
    --loads writes one.
    For example: silo2d loads A4 --seeds 3; silo2d loads --silo my_silo.toml --solid wheat
    """
    from granulab.campaign.output.files import refuse_unless_writable

    beside = case_changes({k: v for k, v in options.items() if _of_beside(k)})
    changes = changes_of(mu, {k: v for k, v in options.items() if not _of_beside(k)})
    if not cases_or_runs:
        if silo is None:
            raise click.UsageError("give a CASE (A4, or a TOML file), run folders, or --silo FILE")
        if changes or seeds or between or rough_plates:
            raise click.UsageError("--silo without a CASE is closed form; leave its options out")
        found, place = _closed(silo, beside), Path(out) / "loads" / Path(silo).stem
    else:
        window = window_of(between)
        refuse_unless_writable(Path(out), "--out")
        found = _of_runs(cases_or_runs, silo, seeds, changes, beside, window, rough_plates,
                         Path(out), quiet)  # fmt: skip
        place = Path(found["runs"][0]) / "figures"
    _show(found, place, no_figures, as_json)


def _of_beside(option: str) -> bool:
    return option.partition("__")[0] in ("solid", "rules")


def _closed(silo: str, beside: dict[str, Any]) -> dict[str, Any]:
    from silo2d.loads.assess import closed_forms
    from silo2d.loads.design import load_design

    return {"closed_forms": closed_forms(load_design(silo, beside))}


def _of_runs(
    given: tuple[str, ...], silo: str | None, seeds: int | None, changes: dict[str, Any],
    beside: dict[str, Any], window: tuple[float, float] | None, rough_plates: bool, out: Path,
    quiet: bool,
) -> dict[str, Any]:  # fmt: skip
    from granulab.campaign.runs.folder import resume_run
    from silo2d.loads.design import load_beside
    from silo2d.view.loads.study import runs_of, study

    load_beside(silo, beside, {})  # refused before anything is computed
    if all(Path(one).is_dir() for one in given):
        if changes or seeds:
            raise click.UsageError("run folders are as they are; leave options of a case out")
        found = [resume_run(path).path for one in given for path in runs_of(Path(one))]
        folders = list({path.resolve(): path for path in found}.values())
    elif len(given) == 1:
        folders = _computed(given[0], seeds, changes, window, out, quiet)
    else:
        raise click.UsageError("give one CASE, or run folders that are there")
    return study(folders, silo, beside, window, rough_plates)


def _computed(
    case: str, seeds: int | None, changes: dict[str, Any], window: tuple[float, float] | None,
    out: Path, quiet: bool,
) -> list[Path]:  # fmt: skip
    """Run folders of a case, computed now or before."""
    from granulab.campaign.output.terminal import Progress, StopRequest
    from granulab.contact.files.datafile import data_file, is_file
    from silo2d.case.case import SiloCase
    from silo2d.case.settings import read_settings
    from silo2d.run import protocol
    from silo2d.view.loads.study import refuse_case

    if seeds and "run.seed" in changes:
        raise click.UsageError("--seeds says this; leave --seed out")
    SiloCase.load(case, changes)  # refused with its own words
    file = Path(case) if is_file(Path(case)) else data_file("cases", case)
    given = {} if file is None else read_settings(file).get("output", {})
    usual = {key: value for key, value in _SAMPLED.items() if key.split(".")[1] not in given}
    chosen = [{"run.seed": seed} for seed in range(1, (seeds or 0) + 1)] or [{}]
    cases = [SiloCase.load(case, {**usual, **changes, **one}) for one in chosen]
    refuse_case(cases[0], window)
    with StopRequest() as stop, Progress(cases[0].name, quiet=quiet, estimates=False) as bar:
        return [
            Path(protocol.run(one, out=out, progress=bar.update, stop=lambda: stop.requested)
                 .run_folder)
            for one in cases
        ]  # fmt: skip


def _show(found: dict[str, Any], place: Path, no_figures: bool, as_json: bool) -> None:
    from granulab.campaign.output.figure import as_png
    from granulab.campaign.output.files import write_atomic, writing
    from silo2d.view.loads.figure import draw
    from silo2d.view.loads.sheet import as_page, in_words

    if as_json:
        click.echo(json.dumps(found, indent=2))
    else:
        click.echo(in_words(found))
    if no_figures:
        return
    picture, on_page = as_png(lambda: draw(found)), as_png(lambda: draw(found, head=False))
    assert picture is not None
    assert on_page is not None
    with writing(place):
        place.mkdir(parents=True, exist_ok=True)
    made_by = " ".join(["silo2d", *sys.argv[1:]])
    for name, content in (("loads.png", picture), ("loads.html", as_page(found, on_page, made_by))):
        write_atomic(place / name, content)
        click.echo(place / name, err=True)
