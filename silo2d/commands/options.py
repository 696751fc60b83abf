"""Options that change keys of a silo's case."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from granulab.campaign.cli.caseoptions import CaseCommand, case_changes

if TYPE_CHECKING:
    from silo2d.case.settings import Settings


def _schema() -> "type[Settings]":
    from silo2d.case.settings import Settings

    return Settings


case_command = partial(click.command, cls=CaseCommand, schema=_schema)


def mu_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """--mu, which changes two keys."""
    return click.option("--mu", metavar="0.4", help="Friction of all contacts.")(command)


UNIT = click.option("--unit", metavar="mm", help="Unit of a drawing [default: as the file says].")
LAYER = click.option("--layer", metavar="NAME", help="Layer or group of a drawing to read alone.")
OUTLINE = click.option(
    "--outline", metavar="FILE", help="Silo of a drawing (SVG or DXF), in place of the case's."
)


def outline_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """--outline FILE with --unit and --layer: the silo of a drawing."""
    return OUTLINE(UNIT(LAYER(command)))


def changes_of(mu: str | None, options: dict[str, Any]) -> dict[str, Any]:
    """The keys of the case that the options change, as they would stand in a file."""
    both = {} if mu is None else {"law.mu_particle": mu, "law.mu_wall": mu}
    outline, unit, layer = (options.pop(name, None) for name in ("outline", "unit", "layer"))
    if outline is None:
        if unit or layer:
            raise click.UsageError("--unit and --layer go with a drawing; give --outline FILE")
        return both | case_changes(options)
    from silo2d.drawings.outline import outline_changes

    return both | outline_changes(outline, unit, layer) | case_changes(options)
