"""The commands that compute many runs: `sweep`, and what such commands share."""

import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from granulab.campaign.cli.caseoptions import case_changes
from granulab.campaign.cli.commandline import (
    ENGINES,
    Ended,
    dry_run_option,
    engine_options,
    json_option,
    no_figures_option,
    out_option,
    quiet_option,
)

if TYPE_CHECKING:
    from granulab.campaign.sweeps.cases import LabelledStudy
    from granulab.campaign.sweeps.sketch import Sketch
    from granulab.campaign.sweeps.sweep import Simulator


rank_by_option = click.option(
    "--rank-by", metavar="NAME", help="Quantity that the ranking goes by."
)


def sweep_command(
    name: str,
    simulator: Callable[[], "Simulator"],
    load: Callable[[str, dict[str, Any]], "LabelledStudy"],
    sketch: "Callable[[], Sketch]",
    engines: list[str] = ENGINES,
    command: Callable[..., Any] = click.command,
) -> click.Command:
    """The command `sweep` of a simulator.

    name: of its command line; load: gives the cases of a study file, with changes by key; sketch:
    what draws a case; engines: where its runs may go; command: makes the command, with options that
    change keys of every case (a CaseCommand) where it has some.
    """

    @command(
        help=f"""Run a study: cases over lists, ranges and distributions, times seeds.

        `{name} init --study my_study.toml` writes a study file with a comment on every key. Runs
        that are finished are not done again: the same command goes on after whatever stopped it.
        """
    )
    @click.argument("study")
    @out_option
    @partial(engine_options, engines=engines)
    @rank_by_option
    @dry_run_option
    @no_figures_option
    @quiet_option
    @json_option
    def sweep(study: str, **options: Any) -> None:
        given = {name: options.pop(name) for name in list(options) if "__" in name}
        loaded = load(study, case_changes(given))
        _sweep(simulator(), loaded, sketch, **options)

    return sweep


def _sweep(
    simulator: "Simulator",
    loaded: "LabelledStudy",
    sketch: "Callable[[], Sketch]",
    *,
    out: str,
    rank_by: str | None,
    dry_run: bool,
    no_figures: bool,
    as_json: bool,
    quiet: bool,
    **engine: Any,
) -> None:
    """Run a study, or say what would be run; print its table, and raise Ended for gaps in it."""
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.terminal import say
    from granulab.campaign.sweeps.cases import run_study
    from granulab.campaign.sweeps.overview import cost, plan, plan_as_text
    from granulab.campaign.sweeps.report import summary
    from granulab.campaign.sweeps.report.comparison import Comparison

    quantities = summary.ranked_by(simulator.quantities, rank_by)
    if dry_run:
        planned = plan(simulator, loaded, Path(out))
        if not no_figures:
            cases = [case for _, case in loaded.cases[:: len(loaded.study.seeds)]]
            title = f"{loaded.study.name}: {planned['runs']} runs"
            planned |= sketched(simulator, cases, sketch(), Path(planned["folder"]), title)
        click.echo(json.dumps(planned, indent=2) if as_json else plan_as_text(loaded, planned))
        return
    refuse_unless_writable(Path(out), "--out")
    if not quiet:
        say(cost(simulator, loaded.cases))
    folder, rows = run_study(simulator, loaded, out=Path(out), quiet=quiet, **engine)
    comparison = Comparison.of(loaded.study.name, loaded.varied, quantities, rows)
    table = summary.summary(comparison, folder)
    if not table["interrupted"]:
        summary.write_ranking(folder, comparison, table)
        if not no_figures:
            table |= summary.write_pictures(folder, comparison, simulator.means)
    click.echo(json.dumps(table, indent=2) if as_json else summary.as_text(comparison, table))
    if table["interrupted"]:
        raise Ended(f"{table['why_interrupted']}; the same command goes on from there", 130)
    if table["failed"]:
        raise Ended(f"{table['failed']} of {table['runs']} runs failed; see {table['table']}", 3)


def sketched(
    simulator: "Simulator", cases: Sequence[Any], sketch: "Sketch", folder: Path, title: str
) -> dict[str, str | None]:
    """Draw the cases of a study before they are run, beside its folder; the path as "picture"."""
    from granulab.campaign.sweeps.sketch import panels_of, write_sketch

    panels = panels_of(cases, sketch, lambda case: simulator.packing_folder(case, Path()))
    return {"picture": write_sketch(folder.with_name(f"{folder.name}.png"), title, panels)}


def numbers(option: str, text: str | None, default: Sequence[float]) -> tuple[float, ...]:
    """The numbers of a list such as "20,40,80"; InputError where one is none."""
    if text is None:
        return tuple(default)
    from granulab.errors import InputError

    try:
        return tuple(map(float, text.split(","))) if text.strip() else ()
    except ValueError:
        cure = "write numbers with commas, such as 20,40,80"
        raise InputError(f"{option} {text!r}: {cure}") from None


def stop_unless_whole(rows: Sequence[dict[str, Any]]) -> None:
    """End the command where runs were interrupted (code 130) or failed (3)."""
    lost = [row["reason"] for row in rows if row["state"] == "interrupted"]
    if lost:
        why = next((reason for reason in lost if reason.endswith("went away")), "stopped")
        raise Ended(f"{why}; the same command goes on from there", 130)
    failed = [row["reason"] for row in rows if row["state"] == "failed"]
    if failed:
        raise Ended(f"{len(failed)} of {len(rows)} runs failed, the first: {failed[0]}", 3)
