"""The command that gives the loads on a silo: loads."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from granulab.campaign.cli.caseoptions import case_changes
from granulab.campaign.cli.commandline import (
    dry_run_option,
    json_option,
    out_option,
    quiet_option,
)
from granulab.campaign.cli.observe import between_option, window_of
from silo2d.commands.options import case_command, changes_of, mu_option

if TYPE_CHECKING:
    from granulab.contact.files.casefile import Section
    from silo2d.case.case import SiloCase

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
@dry_run_option
@click.option("--no-figures", is_flag=True, help="Make no picture and no sheet.")
@quiet_option
@json_option
def loads(
    cases_or_runs: tuple[str, ...], silo: str | None, seeds: int | None, rough_plates: bool,
    between: str | None, mu: str | None, out: str, dry_run: bool, no_figures: bool, quiet: bool,
    as_json: bool, **options: Any,
) -> None:  # fmt: skip
    """Loads on a silo: wall pressures and base by runs, Janssen, EN 1991-4, Jenike.

    A CASE is run (or taken from where it was); RUN... are run folders that differ in their seed, or
    the folder of a sweep. Without any, --silo FILE is assessed in closed form: silo2d init FILE
    --loads writes one.
    For example: silo2d loads A4 --seeds 3; silo2d loads --silo my_silo.toml --solid wheat
    """
    from granulab.campaign.output.files import refuse_unless_writable
    from silo2d.view.loads.study import study

    beside = case_changes({k: v for k, v in options.items() if _of_beside(k)})
    changes = changes_of(mu, {k: v for k, v in options.items() if not _of_beside(k)})
    if not cases_or_runs:
        if silo is None:
            raise click.UsageError("give a CASE (A4, or a TOML file), run folders, or --silo FILE")
        if changes or seeds or between or rough_plates or dry_run:
            raise click.UsageError("--silo without a CASE is closed form; leave its options out")
        found, place = _closed(silo, beside), Path(out) / "loads" / Path(silo).stem
    else:
        window = window_of(between)
        cases = _cases(cases_or_runs, silo, seeds, changes, beside, window, dry_run)
        if dry_run:
            _say_cost(cases, as_json)
            return
        refuse_unless_writable(Path(out), "--out")
        folders = _computed(cases, Path(out), quiet) if cases else _there(cases_or_runs)
        found = study(folders, silo, beside, window, rough_plates)
        place = Path(found["runs"][0]) / "figures"
    _show(found, place, no_figures, as_json)


def _of_beside(option: str) -> bool:
    return option.partition("__")[0] in ("solid", "rules")


def _closed(silo: str, beside: dict[str, Any]) -> dict[str, Any]:
    from silo2d.loads.assess import closed_forms
    from silo2d.loads.design import load_design

    return {"closed_forms": closed_forms(load_design(silo, beside))}


def _cases(
    given: tuple[str, ...], silo: str | None, seeds: int | None, changes: dict[str, Any],
    beside: dict[str, Any], window: tuple[float, float] | None, dry_run: bool,
) -> "list[SiloCase]":  # fmt: skip
    """The cases to be run, one for each seed; none where run folders are given."""
    from granulab.contact.files.datafile import data_file, is_file
    from silo2d.case.case import SiloCase
    from silo2d.case.settings import read_settings
    from silo2d.loads.design import load_beside
    from silo2d.view.loads.study import refuse_case

    load_beside(silo, beside, {})  # refused before anything is computed
    if all(Path(one).is_dir() for one in given):
        if changes or seeds or dry_run:
            raise click.UsageError("run folders are as they are; leave options of a case out")
        return []
    if len(given) > 1:
        raise click.UsageError("give one CASE, or run folders that are there")
    if seeds and "run.seed" in changes:
        raise click.UsageError("--seeds says this; leave --seed out")
    (case,) = given
    SiloCase.load(case, changes)  # refused with its own words
    file = Path(case) if is_file(Path(case)) else data_file("cases", case)
    own = {} if file is None else read_settings(file).get("output", {})
    usual = {key: value for key, value in _SAMPLED.items() if key.split(".")[1] not in own}
    chosen = [{"run.seed": seed} for seed in range(1, (seeds or 0) + 1)] or [{}]
    cases = [SiloCase.load(case, {**usual, **changes, **one}) for one in chosen]
    refuse_case(cases[0], window)
    return cases


def _say_cost(cases: "list[SiloCase]", as_json: bool) -> None:
    """Print what cases will take."""
    from granulab.campaign.sweeps.overview import cost, expected_cpu_s
    from silo2d.run.sweep import SILO

    if not as_json:
        click.echo(cost(SILO, [({}, case) for case in cases]))
        return
    packings, runs = expected_cpu_s(SILO, cases, Path())
    planned = {"runs": len(cases), "packings": len(packings)}
    click.echo(json.dumps({**planned, "expected_min": (sum(packings.values()) + runs) / 60}))


def _computed(cases: "list[SiloCase]", out: Path, quiet: bool) -> list[Path]:
    """Run folders of cases, computed now or before."""
    from granulab.campaign.output.terminal import Progress, StopRequest
    from silo2d.run import protocol

    with StopRequest() as stop, Progress(cases[0].name, quiet=quiet, estimates=False) as bar:
        return [
            Path(protocol.run(one, out=out, progress=bar.update, stop=lambda: stop.requested)
                 .run_folder)
            for one in cases
        ]  # fmt: skip


def _there(given: tuple[str, ...]) -> list[Path]:
    """Run folders that are there, gone on with where they were stopped, each once."""
    from granulab.campaign.runs.folder import resume_run
    from silo2d.view.loads.study import runs_of

    found = [resume_run(path).path for one in given for path in runs_of(Path(one))]
    return list({path.resolve(): path for path in found}.values())


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
