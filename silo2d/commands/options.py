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


def changes_of(mu: str | None, options: dict[str, Any]) -> dict[str, Any]:
    """The keys of the case that the options change, as they would stand in a file."""
    both = {} if mu is None else {"law.mu_particle": mu, "law.mu_wall": mu}
    return both | case_changes(options)
