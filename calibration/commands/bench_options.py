"""What the commands of the bench share: files, options for their inputs, and how results go out."""

import inspect
import json
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from calibration.commands.options import into_options
from calibration.result import Into
from granulab.campaign.cli.commandline import json_option, quiet_option

if TYPE_CHECKING:
    from calibration.bench.measure import Result
    from calibration.bench.sections import Input

_OPTIONS = (
    click.option(
        "--column", "columns", multiple=True, metavar="NAME=HEAD",
        help='A column that is called otherwise, with its unit if it lacks one: "load=Force [kN]".',
    ),
    click.option(
        "--constant", "constants", multiple=True, metavar="NAME=VALUE",
        help='What is the same in all trials, in place of a column: "length=300 mm +- 1 mm".',
    ),
    click.option(
        "--instrument", "instruments", multiple=True, metavar="NAME=SIGMA",
        help='Uncertainty of an input that all trials share, such as a zero: "angle=0.2 deg".',
    ),
    click.option(
        "--reading", "readings", multiple=True, metavar="NAME=SIGMA",
        help="Uncertainty of an input that differs from trial to trial.",
    ),
    click.option(
        "--group", metavar="HEAD",
        help='Column that tells pairings apart [default: "group" or "pairing", if there is one].',
    ),
    click.option("--only", metavar="GROUP", help="Evaluate this group and no other."),
    quiet_option,
    json_option,
)  # fmt: skip

trial_option = click.option(
    "--trial", metavar="HEAD",
    help='Column that tells curves in one file apart [default: "trial", if there is one].',
)  # fmt: skip


def bench_command(
    inputs: "Sequence[Input]", writes: Mapping[str, str], *, files: bool = True
) -> Callable[..., Any]:
    """Make a function (files, asked, **its own options) -> results a command that shows them.

    `writes` has the JSON key of the result that --into writes for each property of the parameter
    file; `files` whether at least one is needed.
    """

    def decorate(function: Callable[..., "list[Result]"]) -> click.Command:
        def run(
            files: tuple[str, ...], columns: tuple[str, ...], constants: tuple[str, ...],
            instruments: tuple[str, ...], readings: tuple[str, ...], group: str | None,
            only: str | None, quiet: bool, as_json: bool, into: "Into | None" = None, **own: Any,
        ) -> None:  # fmt: skip
            from calibration.bench.sections import asked

            what = asked(inputs, columns, constants, instruments, readings, group, only)
            results = function(files, what, **own)
            if into is not None:
                _write(results, into, writes, name, files)
            _show(results, as_json, quiet)

        name = function.__module__.rpartition(".")[2]
        # click collects the options that a function's own decorators made in this attribute
        run.__click_params__ = getattr(function, "__click_params__", [])  # type: ignore[attr-defined]
        run.__doc__ = f"{inspect.getdoc(function)}\n\n{_inputs(inputs)}"
        command: Callable[..., Any] = into_options(*writes)(run) if writes else run
        for option in reversed(_OPTIONS):
            command = option(command)
        argument = click.argument("files", nargs=-1, required=files, metavar="FILE...")
        return click.command(name)(argument(command))

    return decorate


def _write(
    results: "Sequence[Result]", into: Into, writes: Mapping[str, str], method: str,
    files: Sequence[str],
) -> None:  # fmt: skip
    """Put what --pair or --material takes into the parameter file."""
    from granulab.errors import InputError

    for key, wanted in writes.items():
        if not into.takes(key):
            continue
        result = next((one for one in results if one.key == wanted), None)
        if result is None:
            raise InputError(f"--into {into.path}: no {key}: its columns or constants are missing")
        source = None if files else "constants on the command line"
        into.put(key, result.pooled.all, method=method, files=files, source=source)


def _inputs(inputs: "Sequence[Input]") -> str:
    """The columns for --help, as they stand: click keeps a block that begins with \\b."""
    width = max(len(one.name) for one in inputs)
    lines = [f"  {one.name:{width}}  [{one.unit:4}]  {one.meaning}" for one in inputs]
    return "\b\nColumns (any unit of the kind; written in the head or as load_N):\n" + "\n".join(
        lines
    )


def _show(results: "list[Result]", as_json: bool, quiet: bool) -> None:
    from calibration.bench.measure import as_text, values

    if as_json:
        click.echo(json.dumps({k: v for r in results for k, v in r.as_json().items()}, indent=2))
    else:
        click.echo(values(results) if quiet else as_text(results))
