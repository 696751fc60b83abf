"""Options that change keys of a damper's case."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from granulab.campaign.cli.caseoptions import CaseCommand, case_changes

if TYPE_CHECKING:
    from damper3d.case.settings import Settings


def _schema() -> "type[Settings]":
    from damper3d.case.settings import Settings

    return Settings


EXAMPLES_OF_CASES = ("host", "sines", "sweep", "random", "shock")  # case.settings.EXAMPLES

case_command = partial(click.command, cls=CaseCommand, schema=_schema)


def material_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """--material, which changes three keys."""
    text = "Of particles and walls: a shipped table, or a file."
    return click.option("--material", metavar="acrylic|FILE", help=text)(command)


cycles_in_film = click.option(
    "--cycles-in-film", type=click.IntRange(1), metavar="N",
    help="Film of the last N cycles [default: all].",
)  # fmt: skip


def changes_of(material: str | None, options: dict[str, Any]) -> dict[str, Any]:
    """The keys of the case that the options change, as they would stand in a file."""
    changes = case_changes(options)
    if material is not None:
        from damper3d.case.parameters import named_material

        changes |= named_material(material)
    return changes
