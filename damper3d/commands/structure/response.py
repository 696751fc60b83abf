"""The command that finds a structure's response with a bed, by harmonic balance or simulation."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from granulab.campaign.cli.commandline import engine_options, json_option, out_option, quiet_option
from granulab.campaign.cli.many import numbers, stop_unless_whole

if TYPE_CHECKING:
    from damper3d.studies.field.balance import Responses
    from damper3d.studies.field.structure import Structure


@click.command()
@click.argument("host")
@click.option("--field", "table", metavar="TABLE", help="field.csv of a bed: harmonic balance.")
@click.option("--levels", metavar="0.1,1,10", help="Factors of the excitation [default: 1].")
@click.option("--between", metavar="30,60", help="Frequencies in Hz [default: the field's].")
@click.option("--simulate", is_flag=True, help="Simulate host and bed at --frequencies.")
@click.option("--frequencies", metavar="38,40,42", help="In Hz, of --simulate.")
@engine_options
@out_option
@click.option("--no-figures", is_flag=True, help="Make no picture.")
@quiet_option
@json_option
def response(
    host: str, table: str | None, levels: str | None, between: str | None, simulate: bool,
    frequencies: str | None, workers: int | None, engine: str, scheduler: str | None, out: str,
    no_figures: bool, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Find the response of a structure with a bed, from the bed's field or by simulations.

    HOST is a case with a table [host]: mass, frequency and damping_ratio, or modes; and force,
    base_displacement or base_acceleration. With --field all solutions of the harmonic balance are
    found, with their stability and the jumps of a swept sine, for one damper on one mode or many.
    With --simulate host and the case's own bed are simulated together, a steady run a level and
    frequency; finished runs are not done again. With both they stand in one picture.
    For example: damper3d response host.toml --field runs/fields/.../field.csv --levels 0.3,1,3
    """
    from damper3d.case.case import DamperCase
    from damper3d.studies.field.chart import draw_responses
    from damper3d.studies.field.structure import structure_of
    from damper3d.studies.map.grid import rising
    from granulab.campaign.output.figure import write_figure
    from granulab.campaign.output.files import refuse_unless_writable, writing

    _refuse_unless_asked(table, between, simulate, frequencies)
    structure = structure_of(DamperCase.load(host))
    wanted = rising("levels", numbers("--levels", levels, (1.0,)))
    refuse_unless_writable(Path(out), "--out")
    with writing(Path(out)):
        Path(out).mkdir(parents=True, exist_ok=True)
    path = Path(out) / f"response-{Path(host).stem}.csv"
    results: dict[str, Any] = {"host": host}
    words: list[str] = []
    found: list[dict[str, Any]] = []
    rows, responses = found, None
    if table is not None:
        responses, balanced, said = _balanced(structure, table, between, wanted, path)
        results |= balanced
        words.append(said)
    if simulate:
        at = rising("--frequencies", numbers("--frequencies", frequencies, ()))
        engines = {"engine": engine, "workers": workers, "scheduler": scheduler, "quiet": quiet}
        rows, found, said = _simulated(structure, host, wanted, at, path, engines)
        results |= {"simulated": found, "simulated_table": str(_beside(path))}
        words.append(said)
    click.echo(json.dumps(results, indent=2) if as_json else "\n".join(words))
    if not no_figures and (responses or any(one["amplitude_m"] for one in found)):
        picture, name = path.with_suffix(".png"), path.stem.removeprefix("response-")

        def drawn() -> Any:
            return draw_responses(responses, name, found, structure)

        click.echo(write_figure(picture, drawn), err=True)
    stop_unless_whole(rows)


def _refuse_unless_asked(
    table: str | None, between: str | None, simulate: bool, frequencies: str | None
) -> None:
    """InputError, a line, where the options do not say which response is wanted."""
    from granulab.errors import InputError

    if frequencies is not None and not simulate:
        raise InputError("--frequencies: those of --simulate; give both, or --between 38,42 for "
                         "the harmonic balance")  # fmt: skip
    if table is None and not simulate:
        raise InputError("no response is asked for; give --field TABLE for the harmonic balance, "
                         "or --simulate --frequencies 38,40,42, or both")  # fmt: skip
    if simulate and frequencies is None:
        raise InputError("--simulate: the frequencies are missing; give --frequencies 38,40,42")
    if between is not None and table is None:
        raise InputError("--between: the frequencies of a field; give --field TABLE too")


def _beside(path: Path) -> Path:
    """The table of simulated points beside that of the harmonic balance."""
    return path.with_name(f"{path.stem}-simulated.csv")


def _balanced(
    structure: "Structure", table: str, between: str | None, levels: tuple[float, ...], path: Path
) -> tuple["Responses", dict[str, Any], str]:
    """Responses from a field, with their table written; results for --json, report in words."""
    from damper3d.studies.field.balance import respond, spaced
    from damper3d.studies.field.report import in_words, of_response, write_responses
    from damper3d.studies.field.table import read_field
    from damper3d.studies.map.grid import rising
    from granulab.errors import InputError

    field = read_field(table)
    known = field.frequencies
    ends = rising("--between", numbers("--between", between, (known[0], known[-1])))
    if between is None and len(known) < 2:
        raise InputError(f"{table}: a field of one frequency has no response over frequency; "
                         "compute it at two or more (damper3d field --frequencies)")  # fmt: skip
    if len(ends) != 2:
        raise InputError(f"--between {between!r}: give two frequencies, such as 30,60")
    responses = respond(structure, field, spaced(structure, *ends), levels)
    write_responses(path, responses)
    found = of_response(structure, field, responses)
    results = {
        "field": table,
        "frequencies_hz": list(ends),
        "rides_at_least_gamma": field.rides_at_least,
        "levels": found,
        "table": str(path),
    }
    name = path.stem.removeprefix("response-")
    words = f"{name} with the bed of {table}\n{in_words(found)}"
    if not field.rides_at_least:
        words += (
            "\nbelow       the bed does not ride along at the field's least Gamma, and below it "
            "the field holds what it has there"
        )
    return responses, results, f"{words}\ntable       {path}"


def _simulated(
    structure: "Structure", host: str, levels: tuple[float, ...], frequencies: tuple[float, ...],
    path: Path, engines: dict[str, Any],
) -> tuple[list[dict[str, Any]], list[dict[str, Any]], str]:  # fmt: skip
    """Rows of the runs, and their points, with the table written; report in words."""
    from damper3d.run.sweep import run_cases
    from damper3d.studies.field.simulated import in_words, points, response_cases
    from granulab.campaign.output.files import write_atomic
    from granulab.campaign.output.table import as_csv

    rows = run_cases(response_cases(host, levels, frequencies), out=path.parent, **engines)
    found = points(structure, rows)
    write_atomic(_beside(path), as_csv(found))
    there = sum(bool(one["reused"]) for one in found)
    return rows, found, (
        f"host and bed simulated, {len(rows)} runs ({there} were there)\n{in_words(found)}\n"
        f"table       {_beside(path)}"
    )  # fmt: skip
