"""The command `reproduce` of any simulator: published tables and ours, printed and kept."""

import importlib
import inspect
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

import click

from granulab.campaign.cli.commandline import (
    ENGINES,
    Ended,
    json_option,
    out_option,
    quiet_option,
)
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Labelled, Simulator

Row = dict[str, Any]


class PublishedTable(Protocol):
    """Interface of the module of a table."""

    SEEDS: int  # how many seeds it takes unless another number is given
    # Names of the columns that are labels, or that report and figure read: "shares." for all that
    # begin so. None: all there are.
    COLUMNS: tuple[str, ...] | None

    def run(
        self, *, out: Path, seeds: Sequence[int], workers: int | None, quiet: bool, **engine: Any
    ) -> list[Row]:
        """All runs of the table, a row each; those that are there are not done again.

        Tables of labelled runs take `engine`, `scheduler` and `known`, see run_labelled; some
        take flags of their simulator's command.
        """

    def report(self, rows: list[Row]) -> str:
        """Report for a person: our numbers, the published ones, and a word on each."""

    def draw(self, rows: list[Row]) -> "Figure":
        """The table as a picture."""


def run_all(
    sweep: Any, simulator: "Simulator", cases: "Sequence[Labelled]", *, quiet: bool, **options: Any
) -> list[Row]:
    """The rows of the cases, in their order, once it is said what they will cost.

    sweep: the simulator's module whose `run_cases` takes the options, see run_labelled.
    """
    from granulab.campaign.output.terminal import say
    from granulab.campaign.sweeps.overview import cost
    from granulab.campaign.sweeps.sweep import lacking

    if not quiet:
        say(cost(simulator, lacking(cases, options.get("known", ()))))
    rows: list[Row] = sweep.run_cases(cases, quiet=quiet, **options)
    return rows


def run_of_cases(
    run_all: Callable[..., list[Row]], cases: "Callable[[Sequence[int]], Iterable[Labelled]]"
) -> Callable[..., list[Row]]:
    """The `run` of a table whose cases are all known before, from those of its seeds."""

    def run(*, seeds: Sequence[int], **options: Any) -> list[Row]:
        return run_all(list(cases(seeds)), **options)

    return run


def reproduce_command(
    purpose: str,
    package: str,
    simulator: Callable[[], "Simulator"],
    engines: list[str] = ENGINES,
    flags: Mapping[str, str] | None = None,
) -> click.Command:
    """The command `reproduce` of a simulator.

    purpose: text of its --help; package: of the tables, which has their names and texts (TABLES)
    and a module for each; engines: where its runs may go; flags: names and texts of further ones,
    which only the tables take whose `run` does.
    """

    @click.command(help=purpose)
    @click.argument("table", required=False)
    @click.option("--seeds", type=int, metavar="N", help="Seeds 1 to N [default: the table's own].")
    @out_option
    @click.option(
        "--write", metavar="DIR", help="Where csv, txt and png go [default: that of --out]."
    )
    @click.option("--add", is_flag=True, help="Keep rows that csv has, and run what it lacks.")
    @click.option("--workers", type=int, metavar="N", help="Runs at a time [default: all cores].")
    @click.option("--engine", type=click.Choice(engines), help="What runs them.")
    @click.option("--scheduler", metavar="tcp://HOST:PORT", help="Of a Dask cluster.")
    @quiet_option
    @json_option
    def reproduce(table: str | None, **options: Any) -> None:
        if table is None:
            texts = importlib.import_module(package).TABLES.items()
            click.echo("\n".join(f"{name:12} {text}" for name, text in texts))
            return
        found = find_table(package, table)
        given = [name for name in flags or () if options.pop(name)]
        for name in given:
            _refuse_unless_taken(package, table, name)
        reproduce_table(simulator(), table, found, flags=given, **options)

    for name, text in (flags or {}).items():
        reproduce = click.option(f"--{name}", is_flag=True, help=text)(reproduce)
    return reproduce


def _refuse_unless_taken(package: str, table: str, flag: str) -> None:
    """UsageError where a table does not take a flag, with those that do."""
    names = importlib.import_module(package).TABLES
    takers = [name for name in names if flag in _parameters(find_table(package, name))]
    if table not in takers:
        raise click.UsageError(
            f"--{flag}: {table} does not take it; leave it out, or take {' or '.join(takers)}"
        )


def _parameters(table: PublishedTable) -> Mapping[str, inspect.Parameter]:
    """The parameters of a table's `run`, by name."""
    return inspect.signature(table.run).parameters


def find_table(package: str, name: str) -> PublishedTable:
    """The table of a name; InputError with the names there are."""
    from granulab.contact.files.units import nearest

    known = importlib.import_module(package).TABLES
    if name not in known:
        raise InputError(f"reproduce {name!r}: no such table; {nearest(name, list(known))}")
    return cast(PublishedTable, importlib.import_module(f"{package}.{name.replace('-', '_')}"))


def reproduce_table(
    simulator: "Simulator",
    name: str,
    table: PublishedTable,
    *,
    seeds: int | None,
    out: str,
    write: str | None,
    add: bool,
    workers: int | None,
    engine: str | None,
    scheduler: str | None,
    as_json: bool,
    quiet: bool,
    flags: Sequence[str] = (),
) -> None:
    """Compute a table, print it, and keep it as reproduce-NAME.csv, .parquet, .txt and .png.

    add: rows that are done in the CSV file that is there are kept, and only the others run; they
    are matched by their labels. Where a version of the sources made them that is another one, a
    line says so, and the head of the new files does. flags: those that the table takes and that
    were given.

    Raises Ended where runs lack or failed, click.UsageError for options that do not go with the
    table, and FolderError where a folder cannot be written: before anything is run, or at the end,
    when it is printed.
    """
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.layout import on_screen
    from granulab.campaign.output.results import origin, write_results

    numbers = _numbers(seeds, workers, table)
    where = _of_labelled_runs(name, table, engine=engine, scheduler=scheduler, add=add)
    where |= dict.fromkeys(flags, True)
    refuse_unless_writable(Path(out), "--out")  # before the hours of work, not after them
    refuse_unless_writable(Path(write or out), "--write")
    kept: list[str] = []
    if add:
        file = Path(write or out) / f"reproduce-{name}.csv"
        _, where["known"], kept = rows_there(file, simulator)
    rows = table.run(out=Path(out), seeds=numbers, workers=workers, quiet=quiet, **where)
    text = table.report(rows)
    click.echo(json.dumps({"table": name, "rows": rows}, indent=2) if as_json else on_screen(text))
    _stop_unless_whole(rows)
    command = [simulator.name, "reproduce", name, "--seeds", str(len(numbers))]
    command += [f"--{flag}" for flag in flags]
    lines = origin(" ".join(command), simulator) + kept
    files = write_results(
        Path(write or out), f"reproduce-{name}", rows, lines, text, lambda: table.draw(rows),
        table.COLUMNS,
    )  # fmt: skip
    if not quiet:
        click.echo("\n".join(map(str, files)), err=True)
    failed = sum(row["state"] == "failed" for row in rows)
    if failed:
        line = f"{failed} of {len(rows)} rows are failed runs; their reasons stand in {files[0]}"
        raise Ended(line, 3)


def _numbers(seeds: int | None, workers: int | None, table: PublishedTable) -> Sequence[int]:
    for name, number in (("--seeds", seeds), ("--workers", workers)):
        if number is not None and number < 1:
            raise click.UsageError(f"{name} = {number}: must be at least 1")
    return range(1, (seeds or table.SEEDS) + 1)


def _stop_unless_whole(rows: list[Row]) -> None:
    """Stop where Ctrl-C or a lost scheduler cut the runs off: earlier results stay as they are."""
    missing = [row["reason"] for row in rows if row["state"] == "interrupted"]
    if missing:
        lost = next((f" ({reason})" for reason in missing if reason.endswith("went away")), "")
        line = f"runs that are missing: {len(missing)}{lost}; the same command goes on"
        raise Ended(f"stopped; {line}", 130)


def _of_labelled_runs(
    name: str, table: PublishedTable, *, engine: str | None, scheduler: str | None, add: bool
) -> dict[str, Any]:
    """The engine as the table's `run` takes it; nothing where the usual one is meant."""
    if scheduler is not None and engine != "dask":
        raise click.UsageError("--scheduler goes with --engine dask")
    given: dict[str, Any] = {"engine": engine, "scheduler": scheduler}
    given = {key: value for key, value in given.items() if value is not None}
    takes = _parameters(table).values()
    labelled = any(p.kind is p.VAR_KEYWORD or p.name == "engine" for p in takes)
    if given and not labelled:
        raise click.UsageError(f"--engine: {name} is computed on this machine only; leave it out")
    if add and not labelled:
        raise click.UsageError(f"--add: {name} has no rows that can be kept; leave it out")
    return given


def rows_there(file: Path, simulator: "Simulator") -> tuple[dict[str, str], list[Row], list[str]]:
    """Head and done rows of a CSV file of results, and a line on where they are from.

    Nothing where there is no such file; FolderError where it is damaged.
    """
    from granulab.campaign.output.layout import done
    from granulab.campaign.output.results import read_results
    from granulab.campaign.runs.provenance import arithmetic, in_words, to_stderr

    if not file.exists():
        return {}, [], []
    made, rows = read_results(file)
    rows = done(rows)
    sources = made.get("versions", "").rpartition("sources ")[2] or "unknown sources"
    words = f"{len(rows)} rows of {made.get('date', 'an unknown date')}, sources {sources}"
    if sources != simulator.sources.digest:
        to_stderr(f"{file}: {words}, are kept, which another version of the sources made")
    if made.get("arithmetic", here := in_words(arithmetic())) != here:
        to_stderr(f"{file}: its rows round otherwise ({made['arithmetic']}; here {here})")
    earlier = made.get("kept")
    kept = f"kept: {words}" + (f"; of these {earlier}" if earlier else "")
    return made, rows, [kept]
