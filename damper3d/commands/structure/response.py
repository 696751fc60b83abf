"""The command that finds a structure's response with a bed, by harmonic balance or simulation."""

import json
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from granulab.campaign.cli.commandline import device_options, json_option, out_option, quiet_option
from granulab.campaign.cli.many import numbers, stop_unless_whole
from granulab.campaign.output.layout import stopped

if TYPE_CHECKING:
    from damper3d.case.case import DamperCase
    from damper3d.studies.field.balance import Responses
    from damper3d.studies.field.structure import Structure
    from damper3d.studies.field.table import Field


@click.command()
@click.argument("host")
@click.option(
    "--field", "tables", multiple=True, metavar="[PLACE=]TABLE",
    help="field.csv of a bed: harmonic balance; of several dampers one for all, or each its own.",
)  # fmt: skip
@click.option("--levels", metavar="0.1,1,10", help="Factors of the excitation [default: 1].")
@click.option("--between", metavar="30,60", help="Frequencies in Hz [default: the field's].")
@click.option("--simulate", is_flag=True, help="Simulate host and bed at --frequencies.")
@click.option("--frequencies", metavar="38,40,42", help="In Hz, of --simulate.")
@device_options
@out_option
@click.option("--dry-run", is_flag=True, help="Say what --simulate would run, and end.")
@click.option("--no-figures", is_flag=True, help="Make no picture.")
@quiet_option
@json_option
def response(
    host: str, tables: tuple[str, ...], levels: str | None, between: str | None, simulate: bool,
    frequencies: str | None, workers: int | None, engine: str, scheduler: str | None, out: str,
    dry_run: bool, no_figures: bool, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Find the response of a structure with a bed, from the bed's field or by simulations.

    HOST is a case with a table [host]: mass, frequency and damping_ratio, or modes; and force,
    base_displacement or base_acceleration. With --field the solutions of the harmonic balance are
    found, with their stability and the jumps of a swept sine, on one mode or many. Several dampers
    ([[damper]] in the case) have one field, or each its own: --field tip=a.csv --field middle=b.csv
    by the names of their places, or their numbers.
    With --simulate host and the case's own beds are simulated together, a steady run a level and
    frequency; finished runs are not done again. With both they stand in one picture.
    For example: damper3d response host.toml --field runs/fields/.../field.csv --levels 0.3,1,3
    """
    from damper3d.case.case import DamperCase
    from damper3d.studies.field.chart import draw_responses
    from damper3d.studies.field.structure import structures_of
    from damper3d.studies.map.grid import rising
    from granulab.campaign.output.figure import write_figure
    from granulab.campaign.output.files import refuse_unless_writable, writing

    _refuse_unless_asked(tables, between, simulate, frequencies)
    case = DamperCase.load(host)
    beds = _Beds(structures_of(case), case.dampers or (case,), case.number, quiet)
    of_each = tables_of(tables, list(beds.structures)) if tables else {}
    wanted = rising("levels", numbers("--levels", levels, (1.0,)))
    at = rising("--frequencies", numbers("--frequencies", frequencies, ())) if simulate else ()
    if dry_run:
        click.echo(_cost(host, wanted, at))
        return
    refuse_unless_writable(Path(out), "--out")
    with writing(Path(out)):
        Path(out).mkdir(parents=True, exist_ok=True)
    path = Path(out) / f"response-{Path(host).stem}.csv"
    results: dict[str, Any] = {"host": host}
    words: list[str] = []
    found: list[dict[str, Any]] = []
    rows: list[dict[str, Any]] = []
    together: list[Responses] = []
    if of_each:
        together, balanced, said = _balanced(beds, of_each, between, wanted, path)
        results |= balanced
        words.append(said)
    if simulate:
        engines = {"engine": engine, "workers": workers, "scheduler": scheduler, "quiet": quiet}
        rows, found, said = _simulated(beds, host, wanted, at, path, engines)
        results |= {"simulated": found, "simulated_table": str(_beside(path))}
        words.append(said)
    click.echo(json.dumps(results, indent=2) if as_json else "\n".join(words))
    known = together or any(one["amplitude_m"] for one in found)
    if known and not (no_figures or stopped(rows)):
        picture, name = path.with_suffix(".png"), path.stem.removeprefix("response-")

        def drawn() -> Any:
            return draw_responses(name, beds.structures, together, found)

        click.echo(write_figure(picture, drawn), err=True)
    stop_unless_whole(rows)


def _cost(host: str, levels: Sequence[float], frequencies: Sequence[float]) -> str:
    """The runs of --simulate and their cost, in words."""
    from damper3d.run.sweep import DAMPER
    from damper3d.studies.field.simulated import response_cases
    from granulab.campaign.sweeps.overview import cost

    if not frequencies:
        return "the harmonic balance runs nothing; some seconds"
    return cost(DAMPER, response_cases(host, levels, frequencies))


class _Beds(NamedTuple):
    """The structure as each damper sees it, by the names of places; the number of the shown one."""

    structures: "dict[str, Structure]"
    cases: "tuple[DamperCase, ...]"  # of each
    shown: int
    quiet: bool

    @property
    def names(self) -> list[str]:
        """Names that columns of tables have: none of a single damper."""
        return list(self.structures) if len(self.structures) > 1 else []


def _refuse_unless_asked(
    tables: tuple[str, ...], between: str | None, simulate: bool, frequencies: str | None
) -> None:
    """InputError, a line, where the options do not say which response is wanted."""
    from granulab.errors import InputError

    if frequencies is not None and not simulate:
        raise InputError("--frequencies: those of --simulate; give both, or --between 38,42 for "
                         "the harmonic balance")  # fmt: skip
    if not tables and not simulate:
        raise InputError("no response is asked for; give --field TABLE for the harmonic balance, "
                         "or --simulate --frequencies 38,40,42, or both")  # fmt: skip
    if simulate and frequencies is None:
        raise InputError("--simulate: the frequencies are missing; give --frequencies 38,40,42")
    if between is not None and not tables:
        raise InputError("--between: the frequencies of a field; give --field TABLE too")


def tables_of(given: Sequence[str], places: Sequence[str]) -> dict[str, str]:
    """The table of each damper from the values of --field: TABLE for all, or PLACE=TABLE.

    A place is a damper's name or number; TABLE is that of those which are not named. Raises
    InputError, a line, where a place is not known, or lacks a table, or has two.
    """
    from granulab.contact.files.datafile import is_file
    from granulab.errors import InputError

    called = {str(k): name for k, name in enumerate(places, 1)} | {name: name for name in places}
    found: dict[str, str] = {}
    others = [text for text in given if "=" not in text or is_file(Path(text))]
    for text in given:
        place, _, table = text.partition("=")
        if text in others:
            continue
        if place not in called:
            raise InputError(f"--field {text}: no damper is called {place!r}; they are "
                             f"{', '.join(places)}, or numbers from 1")  # fmt: skip
        if called[place] in found:
            already = f"{called[place]} has {found[called[place]]} already"
            raise InputError(f"--field {text}: {already}; leave one of them out")
        found[called[place]] = table
    if len(others) > 1:
        which = f"; say whose, --field {places[0]}={others[0]}" if len(places) > 1 else ""
        raise InputError(f"--field {others[0]} and {others[1]}: one table is that of all dampers"
                         f"{which or '; leave one of them out'}")  # fmt: skip
    for name in places:
        if name not in found and not others:
            raise InputError(f"--field: the damper at {name} has no table; add --field "
                             f"{name}=TABLE, or give one --field TABLE for all")  # fmt: skip
    return {name: found[name] if name in found else others[0] for name in places}


def _beside(path: Path) -> Path:
    """The table of simulated points beside that of the harmonic balance."""
    return path.with_name(f"{path.stem}-simulated.csv")


def _ends(
    fields: "Mapping[str, Field]", tables: dict[str, str], between: str | None
) -> tuple[float, float]:
    """Least and greatest frequency [Hz] of the responses: as given, or those of all fields.

    Raises InputError where the fields do not have them.
    """
    from damper3d.studies.map.grid import rising
    from granulab.errors import InputError

    each = {name: (float(f[0]), float(f[-1])) for name, f in
            ((name, field.frequencies) for name, field in fields.items())}  # fmt: skip
    low, high = max(f[0] for f in each.values()), min(f[1] for f in each.values())
    for name, (first, last) in each.items():
        if first == last and between is None:
            raise InputError(
                f"{tables[name]}: a field of one frequency has no response over frequency; compute "
                "it at two or more (damper3d field --frequencies)"
            )
        if between is None and (first, last) != (low, high):
            other = next(one for one, ends in each.items() if ends != (first, last))
            cure = f"give --between {low:g},{high:g}, which all have" if low < high else (
                "compute them at common frequencies (damper3d field --frequencies)"
            )  # fmt: skip
            raise InputError(
                f"{tables[name]}: {first:g} to {last:g} Hz, and {tables[other]}: "
                f"{each[other][0]:g} to {each[other][1]:g} Hz; {cure}"
            )
    ends = rising("--between", numbers("--between", between, (low, high)))
    if len(ends) != 2:
        raise InputError(f"--between {between!r}: give two frequencies, such as 30,60")
    for name, (first, last) in each.items():
        if not first <= ends[0] < ends[1] <= last:
            raise InputError(
                f"--between {between}: {tables[name]} is of {first:g} to {last:g} Hz; choose "
                "within it, or compute the field there (damper3d field --frequencies)"
            )
    return ends[0], ends[1]


def _balanced(
    beds: _Beds, tables: dict[str, str], between: str | None, levels: tuple[float, ...], path: Path
) -> tuple["list[Responses]", dict[str, Any], str]:
    """Responses from fields, with their table written; results for --json, report in words."""
    from damper3d.studies.field.balance import spaced, with_peaks
    from damper3d.studies.field.engine import BALANCE
    from damper3d.studies.field.origin import check_origin
    from damper3d.studies.field.report import (
        in_words,
        of_response,
        of_responses,
        write_responses,
    )
    from damper3d.studies.field.several import act_as_one, respond_together
    from damper3d.studies.field.table import read_field
    from granulab.campaign.output.terminal import announce_compilation
    from granulab.contact.jit import already_compiled

    structures, one = beds.structures, len(set(tables.values())) == 1
    fields = {name: read_field(table) for name, table in tables.items()}
    for case, (name, field) in zip(beds.cases, fields.items(), strict=True):
        check_origin(tables[name], field.head, case)
    ends = _ends(fields, tables, between)
    lead = next(iter(structures.values()))
    own, each = list(structures.values()), list(fields.values())
    announce_compilation(beds.quiet or act_as_one(own), already_compiled(BALANCE))
    together = with_peaks(
        partial(respond_together, own, each, levels=levels), spaced(lead, *ends),
        float(lead.damping_ratio.min()),
    )  # fmt: skip
    if len(structures) == 1:
        found = of_response(lead, each[0], together[0])
    else:
        found = of_responses(structures, each, together, beds.shown)
    write_responses(path, together, beds.names, beds.shown)
    rides = {name: field.rides_at_least for name, field in fields.items()}
    results: dict[str, Any] = {
        "field": next(iter(tables.values())) if one else None,
        "frequencies_hz": list(ends),
        "rides_at_least_gamma": all(rides.values()),
        "levels": found,
        "table": str(path),
    }
    words = ", ".join(f"{table} at {name}" for name, table in tables.items())
    of = next(iter(tables.values())) if one else words
    lines = [f"{path.stem.removeprefix('response-')} with the bed of {of}", in_words(found)]
    if beds.names:
        first = together[0]
        lost = first.frequency[first.lost].tolist() if first.lost is not None else []
        results |= {"fields": tables, "not_followed_hz": lost}
        if lost:
            lines.append(f"not whole   at {len(lost)} frequencies, the first {lost[0]:g} Hz, the "
                         "solutions could not be followed to their end; some may lack")  # fmt: skip
    if not all(rides.values()):
        lines.append(
            "below       the bed does not ride along at the field's least Gamma, and below it the "
            "field holds what it has there"
        )
    return together, results, "\n".join([*lines, f"table       {path}"])


def _simulated(
    beds: _Beds, host: str, levels: tuple[float, ...], frequencies: tuple[float, ...], path: Path,
    engines: dict[str, Any],
) -> tuple[list[dict[str, Any]], list[dict[str, Any]], str]:  # fmt: skip
    """Rows of the runs, and their points, with the table written; report in words."""
    from damper3d.run.sweep import run_cases
    from damper3d.studies.field.simulated import in_columns, in_words, points, response_cases
    from granulab.campaign.output.files import write_atomic
    from granulab.campaign.output.table import as_csv

    rows = run_cases(response_cases(host, levels, frequencies), out=path.parent, **engines)
    found = points(beds.structures, rows, beds.shown)
    write_atomic(_beside(path), as_csv(in_columns(found)))
    there = sum(bool(one["reused"]) for one in found)
    return rows, found, (
        f"host and bed simulated, {len(rows)} runs ({there} were there)\n{in_words(found)}\n"
        f"table       {_beside(path)}"
    )  # fmt: skip
