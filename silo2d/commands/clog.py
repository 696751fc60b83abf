"""The command on clogging as statistics: clog."""

import dataclasses
import json
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from granulab.campaign.cli.commandline import (
    dry_run_option,
    json_option,
    no_figures_option,
    out_option,
    quiet_option,
    workers_option,
)
from silo2d.commands.options import case_command, changes_of, mu_option

if TYPE_CHECKING:
    from granulab.campaign.sweeps.sweep import Labelled
    from silo2d.avalanches.case import AvalancheCase, Protocol

_SAID = {
    "silo.outlet": "--outlets says this",
    "run.seed": "--seeds says this",
    "run.engine": "avalanches need the contacts of dem",
}
# Options with a value, and those without one, that decide nothing of the results.
_BESIDES = ("-o", "--out", "--write", "--workers")
_FLAGS = ("--quiet", "--json", "--no-figures", "--add", "--dry-run")
_RUNS = ("--outlets", "--seeds")  # options that say which runs, and nothing of each


@case_command(without=_SAID)
@click.argument("case")
@click.option("--outlets", metavar='"45 mm,50 mm"', required=True, help="Widths of the outlet.")
@click.option("--avalanches", type=int, metavar="50", help="Avalanches of a run [default: 50].")
@click.option("--seeds", type=click.IntRange(1), metavar="1", help="Runs at each outlet: seeds 1 "
              "to N [default: 1].")  # fmt: skip
@click.option("--largest", type=int, metavar="2000", help="Particles after which an avalanche is "
              "cut off, and counts as larger than that [default: 2000].")  # fmt: skip
@click.option("--break", "breaking", metavar="remove|shake", help="Breaking of an arch: its "
              "particles are put on the bed, or thrown about [default: remove].")  # fmt: skip
@click.option("--drop", metavar='"0 mm"', help="Height above the lowest free place of the bed's "
              "surface at which particles are put back [default: 0 mm].")  # fmt: skip
@mu_option
@out_option
@click.option(
    "--write", metavar="DIR", help="Where csv, txt and png go [default: DIR/clog of --out]."
)
@click.option("--add", is_flag=True, help="Keep rows that csv has, and run what it lacks.")
@workers_option
@dry_run_option
@no_figures_option
@quiet_option
@json_option
def clog(
    case: str, outlets: str, avalanches: int | None, seeds: int | None, largest: int | None,
    breaking: str | None, drop: str | None, mu: str | None, out: str, write: str | None,
    add: bool, workers: int | None, dry_run: bool, no_figures: bool, quiet: bool, as_json: bool,
    **options: Any,
) -> None:  # fmt: skip
    """Let a silo clog again and again, and give its avalanches as statistics.

    Each run goes on after a clog: the arch is broken, what has left is put back on top, so that the
    level stays. Sizes of avalanches against the outlet, with the laws of the literature; runs that
    are there already are not done again, and unfinished ones go on.
    For example: silo2d clog A3 --outlets "45 mm,50 mm,55 mm,60 mm,70 mm" --seeds 4
    """
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.sweeps.sweep import lacking
    from granulab.contact.files.units import to_si
    from silo2d.avalanches.case import Protocol
    from silo2d.avalanches.sweep import cases_of, run_cases

    if workers is not None and workers < 1:
        raise click.UsageError(f"--workers = {workers}: must be at least 1")
    given = {"avalanches": avalanches, "largest": largest, "breaking": breaking,
             "drop": None if drop is None else to_si(drop, "m", "--drop")}  # fmt: skip
    protocol = Protocol(**{k: v for k, v in given.items() if v is not None})  # type: ignore[arg-type]
    changes = changes_of(mu, options)

    def runs_of(widths: Sequence[float], numbers: Sequence[int]) -> "list[Labelled]":
        return cases_of(case, widths, numbers, protocol, changes)

    cases = runs_of(_lengths(outlets), range(1, (seeds or 1) + 1))
    place = Path(write or Path(out) / "clog")
    known: list[dict[str, Any]] = []
    kept: list[str] = []
    table = place / f"{_name(cases[0][1])}.csv"
    if add:
        known, kept = _known(table, runs_of)
    elif table.exists() and not dry_run:
        _refuse_to_replace(table, runs_of)
    wanted = lacking(cases, known)
    if dry_run:
        click.echo(_planned(wanted, protocol, as_json))
        return
    refuse_unless_writable(Path(out), "--out")
    refuse_unless_writable(place, "--write")
    if not quiet:
        click.echo(_cost(wanted), err=True)
    rows = run_cases(wanted, out=Path(out), workers=workers, quiet=quiet) + known
    rows.sort(key=lambda row: (row["outlet_mm"], row["seed"]))
    kept = [f"case: {_digest(cases[0])}", *kept]
    _show(cases[0][1], rows, place, kept, no_figures, as_json)


def _name(case: "AvalancheCase") -> str:
    """Name of the files of a silo and its particles."""
    return f"clog-{case.silo.name}-{case.silo.shapes.name}"


def _digest(labelled: "Labelled") -> str:
    """Digest of one run of a table: of everything that is common to all of its runs."""
    from silo2d.avalanches.case import run_digest

    labels, case = labelled
    return f"{run_digest(case)} of {labels['outlet_mm']:g} mm, seed {labels['seed']}"


def _known(
    file: Path, runs_of: "Callable[[list[float], list[int]], list[Labelled]]"
) -> tuple[list[dict[str, Any]], list[str]]:
    """Rows of the file that is there, and where they are from.

    runs_of: the runs of outlets [m] and seeds. Raises InputError where the file is of another silo,
    of other particles, parameters or avalanches: by the digest in its head, or in one that has
    none by the words of its command.
    """
    from granulab.campaign.cli.reproduce import rows_there
    from granulab.errors import InputError
    from silo2d.avalanches.sweep import AVALANCHES

    made, rows, kept = rows_there(file, AVALANCHES)
    if rows and not (_same_case(made, runs_of) if "case" in made else _same_command(made)):
        raise InputError(
            f"--add: {file} was made by {made.get('command', '')!r} of another silo, protocol or "
            "file; give the same, or --write"
        )
    return rows, kept


def _refuse_to_replace(
    file: Path, runs_of: "Callable[[list[float], list[int]], list[Labelled]]"
) -> None:
    """InputError where the file of this name is of another command and of another case."""
    from granulab.campaign.output.results import read_results
    from granulab.errors import FolderError, InputError

    try:
        made, rows = read_results(file)
    except FolderError:  # damaged: nothing to lose
        return
    if rows and "case" in made and not (_same_command(made) or _same_case(made, runs_of)):
        raise InputError(
            f"{file}: is of {made.get('command', '')!r}, another silo or protocol, and would be "
            "replaced; give --write with another folder"
        )


def _same_command(made: "Mapping[str, str]") -> bool:
    """True where a file was made by this command but for the runs that it asks for."""
    theirs, ours = (
        _without(shlex.split(text), _RUNS) for text in (made.get("command", ""), _command())
    )
    return theirs == ours


def _same_case(
    made: "Mapping[str, str]", runs_of: "Callable[[list[float], list[int]], list[Labelled]]"
) -> bool:
    """True where the run that a file has the digest of is one of this command's."""
    _, _, outlet, _, _, seed = made["case"].split()
    return made["case"] == _digest(runs_of([1e-3 * float(outlet)], [int(seed)])[0])


def _lengths(text: str) -> list[float]:
    """The widths [m] of a list such as "45 mm,50 mm", ascending."""
    from granulab.contact.files.units import to_si
    from granulab.errors import InputError

    words = [word.strip() for word in text.split(",")]
    found = sorted(to_si(word, "m", "--outlets") for word in words)
    twice = [one for one, other in pairwise(found) if other - one < 1e-9]
    if twice:
        raise InputError(f"--outlets: {1e3 * twice[0]:g} mm stands there twice; give it once")
    return found


def _cost(cases: "Sequence[Labelled]") -> str:
    from granulab.campaign.sweeps.overview import cost
    from silo2d.avalanches.sweep import AVALANCHES

    return cost(AVALANCHES, cases)


def _planned(cases: "Sequence[Labelled]", protocol: "Protocol", as_json: bool) -> str:
    """Table of what would be run, with its expected cost by outlet."""
    from granulab.campaign.output.layout import columns
    from silo2d.avalanches.case import expected_avalanche, expected_cpu_s

    lines: dict[float, dict[str, Any]] = {}
    for labels, case in cases:
        one = lines.setdefault(labels["outlet_mm"], {
            "outlet_m": case.silo.outline.outlet,
            "outlet_over_diameter": case.silo.outline.outlet / case.diameter,
            "runs": 0, "avalanches": 0, "expected_avalanche": expected_avalanche(case),
            "expected_min": 0.0,
        })  # fmt: skip
        one["runs"] += 1
        one["avalanches"] += case.protocol.avalanches
        one["expected_min"] += sum(expected_cpu_s(case)) / 60
    found = list(lines.values())
    minutes = sum(one["expected_min"] for one in found)
    if as_json:
        planned = {"protocol": dataclasses.asdict(protocol), "outlets": found}
        return json.dumps({**planned, "expected_min": minutes}, indent=2)
    table = columns(
        ["outlet", "D/d", "runs", "avalanches", "of about", "CPU time"],
        [
            [f"{1e3 * one['outlet_m']:g} mm", f"{one['outlet_over_diameter']:.2f}",
             str(one["runs"]), str(one["avalanches"]), f"{one['expected_avalanche']:.0f}",
             f"{one['expected_min']:.0f} min"]
            for one in found
        ],
    )  # fmt: skip
    said = (
        "\"of about\": mean size as the wood's particles have it; other particles' may be several "
        "times as large or small, and the time goes with it"
    )
    return f"{table}\n{_cost(cases)}\n{said}"


def _show(
    case: "AvalancheCase", rows: list[dict[str, Any]], place: Path, kept: list[str],
    no_figures: bool, as_json: bool,
) -> None:  # fmt: skip
    """Print and keep the statistics of runs; Ended where some lack."""
    from granulab.campaign.cli.many import stop_unless_whole
    from granulab.campaign.output.layout import not_done, on_screen, stopped
    from granulab.campaign.output.results import origin, write_results
    from silo2d.avalanches.sweep import AVALANCHES
    from silo2d.measures.clogging.study import study
    from silo2d.view.clogging.figure import draw
    from silo2d.view.clogging.words import in_words

    if stopped(rows):
        stop_unless_whole(rows)
    silo = case.silo
    found = {
        "silo": silo.name,
        "shapes": silo.shapes.name,
        "protocol": dataclasses.asdict(case.protocol),
        "rest_time_s": silo.settings.run.rest_time,
        **study(rows, silo.settings.run.rest_time),
        "runs": [row["run_folder"] for row in rows if row.get("run_folder")],
    }
    title = f"Clogging of {found['silo']}, {found['shapes']}"
    text = "\n\n".join(
        filter(None, [in_words(found), "\n".join(not_done(rows, ["outlet_mm", "seed"]))])
    )
    click.echo(json.dumps(found, indent=2) if as_json else on_screen(f"{title}\n\n{text}"))
    files = write_results(
        place, _name(case), rows, origin(_command(), AVALANCHES) + kept, text,
        None if no_figures else lambda: draw(found, rows, title),
    )  # fmt: skip
    click.echo("\n".join(map(str, files)), err=True)
    stop_unless_whole(rows)


def _command() -> str:
    """The command, without what decides nothing of its results."""
    kept = [word for word in _without(sys.argv[1:], _BESIDES) if word not in _FLAGS]
    return shlex.join(["silo2d", *kept])


def _without(words: "Sequence[str]", options: tuple[str, ...]) -> list[str]:
    """Words of a command without some options and their values."""
    rest, kept = iter(words), []
    for word in rest:
        if word in options:
            next(rest, None)
        elif word.partition("=")[0] not in options:
            kept.append(word)
    return kept
