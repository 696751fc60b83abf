"""The command that finds a structure's response with a bed by harmonic balance: response."""

import json
from pathlib import Path

import click

from granulab.campaign.cli.commandline import json_option, out_option
from granulab.campaign.cli.many import numbers


@click.command()
@click.argument("host")
@click.option("--field", "table", required=True, metavar="TABLE", help="field.csv of a bed.")
@click.option("--levels", metavar="0.1,1,10", help="Factors of the excitation [default: 1].")
@click.option("--between", metavar="30,60", help="Frequencies in Hz [default: the field's].")
@out_option
@click.option("--no-figures", is_flag=True, help="Make no picture.")
@json_option
def response(
    host: str, table: str, levels: str | None, between: str | None, out: str, no_figures: bool,
    as_json: bool,
) -> None:  # fmt: skip
    """Find the response of a structure with a bed, from the bed's field, without a simulation.

    HOST is a case with a table [host]: mass, frequency and damping_ratio, or modes; and force,
    base_displacement or base_acceleration. All solutions of the harmonic balance are found, with
    their stability and the jumps of a swept sine, for one damper on one mode or many.
    For example: damper3d response host.toml --field runs/fields/.../field.csv --levels 0.3,1,3
    """
    from damper3d.case.case import DamperCase
    from damper3d.studies.field.balance import respond, spaced
    from damper3d.studies.field.chart import draw_responses
    from damper3d.studies.field.report import in_words, of_response, write_responses
    from damper3d.studies.field.structure import structure_of
    from damper3d.studies.field.table import read_field
    from damper3d.studies.map.grid import rising
    from granulab.campaign.output.figure import write_figure
    from granulab.campaign.output.files import refuse_unless_writable, writing
    from granulab.errors import InputError

    structure, field = structure_of(DamperCase.load(host)), read_field(table)
    wanted = rising("levels", numbers("--levels", levels, (1.0,)))
    known = field.frequencies
    ends = rising("--between", numbers("--between", between, (known[0], known[-1])))
    if between is None and len(known) < 2:
        raise InputError(f"{table}: a field of one frequency has no response over frequency; "
                         "compute it at two or more (damper3d field --frequencies)")  # fmt: skip
    if len(ends) != 2:
        raise InputError(f"--between {between!r}: give two frequencies, such as 30,60")
    refuse_unless_writable(Path(out), "--out")
    responses = respond(structure, field, spaced(structure, *ends), wanted)
    name = Path(host).stem
    path = Path(out) / f"response-{name}.csv"
    with writing(Path(out)):
        Path(out).mkdir(parents=True, exist_ok=True)
    write_responses(path, responses)
    found = of_response(structure, field, responses)
    results = {
        "host": host,
        "field": table,
        "frequencies_hz": list(ends),
        "rides_at_least_gamma": field.rides_at_least,
        "levels": found,
        "table": str(path),
    }
    words = f"{name} with the bed of {table}\n{in_words(found)}"
    if not field.rides_at_least:
        words += (
            "\nbelow       the bed does not ride along at the field's least Gamma, and below it "
            "the field holds what it has there"
        )
    click.echo(json.dumps(results, indent=2) if as_json else f"{words}\ntable       {path}")
    if not no_figures:
        picture = path.with_suffix(".png")
        click.echo(write_figure(picture, lambda: draw_responses(responses, name)), err=True)
