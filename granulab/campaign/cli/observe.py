"""The command that measures a finished run: observe."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from granulab.campaign.cli.commandline import json_option

if TYPE_CHECKING:
    from granulab.campaign.output.measures import Measures


def observe_command(
    measures: "Callable[[], Measures]", run_folder: Callable[[str], Path]
) -> click.Command:
    """The command `observe RUN WHAT` of a simulator.

    measures: gives its registry; run_folder: the path of a run, FolderError where it is none.
    """

    @click.command()
    @click.argument("folder", metavar="RUN")
    @click.argument("what", required=False)
    @click.option("--no-figures", is_flag=True, help="Print the numbers only.")
    @json_option
    def observe(folder: str, what: str | None, no_figures: bool, as_json: bool) -> None:
        """Measure something of a run: numbers on stdout, a picture in figures/.

        Without WHAT it lists the measures.
        """
        from granulab.campaign.output.figure import write_figure

        known = measures()
        if what is None:
            click.echo(known.listing())
            return
        found, path = known.find(what), run_folder(folder)
        numbers = found.measure(path)
        if as_json:
            click.echo(json.dumps(numbers, indent=2))
        else:
            lines = (
                f"{key:32} {value:.4g}" if isinstance(value, float) else f"{key:32} {value}"
                for key, value in numbers.items()
                if not isinstance(value, (list, dict))
            )
            click.echo("\n".join(lines))
        if not no_figures:
            picture = write_figure(path / "figures" / f"{what}.png", lambda: found.draw(path))
            click.echo(picture, err=True)

    return observe
