"""Options that the measuring commands share: on films, --out, --into, --pair and --material."""

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from calibration.result import PAIR_KEYS, TABLE, Into
from granulab.campaign.cli.commandline import json_option
from granulab.errors import InputError


def figures_option(words: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """-o, --out: a folder for what the command draws; refused before the work if not writable."""

    def checked(_context: click.Context, _option: click.Parameter, out: Path | None) -> Path | None:
        from granulab.campaign.output.files import refuse_unless_writable

        if out is not None:
            refuse_unless_writable(out, "--out")
        return out

    kind = click.Path(path_type=Path)
    return click.option("-o", "--out", type=kind, metavar="DIR", callback=checked, help=words)


def into_options(*keys: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """--into FILE with --pair or --material, as properties `keys` need; checked before the work.

    The command gets `into`, an Into, or None where nothing is to be written. One that has several
    keys, of a pair and of a material, writes those that `into` takes.
    """
    of_pair = [key for key in keys if key in PAIR_KEYS]
    named = ", ".join(keys)

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(command)
        def with_into(*args: Any, into: str | None, **given: Any) -> Any:
            pair, material = given.pop("pair", None), given.pop("material", None)
            return command(*args, into=_checked(into, pair, material, keys), **given)

        options = [
            click.option(
                "--into", metavar="FILE.toml", help=f"Write {named} into this parameter file."
            )
        ]
        if of_pair:
            options.append(click.option("--pair", metavar="wood-steel", help="Of which pair."))
        if len(of_pair) < len(keys):
            options.append(click.option("--material", metavar="wood", help="Of which material."))
        for option in reversed(options):
            with_into = option(with_into)
        return with_into

    return decorate


def _checked(
    into: str | None, pair: str | None, material: str | None, keys: tuple[str, ...]
) -> Into | None:
    from granulab.errors import InputError

    if into is None:
        if name := pair or material:
            raise InputError(f"{name}: names what is written; give the file, too: --into wood.toml")
        return None
    wanted = Into(Path(into), pair, material, tuple(keys))
    wanted.check()
    return wanted


def answers_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """--json, and --table FILE: how else the answers are written; see calibration.result.finish."""

    def checked(context: click.Context, _option: click.Parameter, table: Path | None) -> None:
        from calibration.files.answers import check_table
        from granulab.campaign.output.files import refuse_unless_writable

        if table is not None:
            context.meta[TABLE] = check_table(table)
            refuse_unless_writable(table.parent, "--table")

    option = click.option(
        "--table", type=click.Path(path_type=Path), metavar="FILE.xlsx", callback=checked,
        expose_value=False, help="Write all answers as tables, too: FILE.xlsx or FILE.csv.",
    )  # fmt: skip
    return option(json_option(command))


def unit_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """--unit NAME=UNIT of columns of a table, as {"time": "ms"}; the command gets `units`."""

    def parsed(
        _context: click.Context, _option: click.Parameter, words: tuple[str, ...]
    ) -> dict[str, str]:
        from granulab.contact.files.units import is_unit

        found = {}
        for word in words:
            name, _, unit = (part.strip() for part in word.partition("="))
            if not name or not is_unit(unit):
                raise InputError(f"--unit = {word!r}: column and unit, such as time=ms or x=mm")
            found[name.lower()] = unit
        return found

    return click.option(
        "--unit", "units", multiple=True, metavar="time=ms", callback=parsed,
        help="Unit of a column of a table whose head has none; once for each.",
    )(command)  # fmt: skip


Box = tuple[int, int, int, int]  # x, y, width, height [px]


def fps_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """--fps, a number or in Hz; checked by who uses it (calibration.tracking.film.reader)."""

    def parsed(_context: click.Context, _option: click.Parameter, text: str | None) -> float | None:
        from granulab.contact.files.units import to_si

        if text is None:
            return None
        try:
            return float(text)
        except ValueError:
            return to_si(text, "Hz", "--fps")

    words = "Frames per second of the camera."
    return click.option("--fps", metavar="240", callback=parsed, help=words)(command)


def roi_option(words: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """--roi "x,y,w,h" as four whole numbers of pixels; the film checks whether they lie in it."""

    def parsed(
        _context: click.Context, _option: click.Parameter, text: str | None
    ) -> tuple[int, ...] | None:
        found = _numbers("--roi", text, "x,y,width,height", "0,100,640,380")
        return None if found is None else tuple(round(value) for value in found)

    return click.option("--roi", metavar="x,y,w,h", callback=parsed, help=words)


def position(text: str | None) -> tuple[float, float, float] | None:
    """--at "frame,x,y" as numbers."""
    found = _numbers("--at", text, "frame,x,y", "52,430,118")
    return None if found is None else (found[0], found[1], found[2])


def _numbers(option: str, text: str | None, names: str, example: str) -> list[float] | None:
    if text is None:
        return None
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        found = []
    if len(found) != names.count(",") + 1 or not all(abs(value) < 1e9 for value in found):
        raise InputError(f"{option} = {text!r}: {names} in pixels, such as {example}")
    return found
