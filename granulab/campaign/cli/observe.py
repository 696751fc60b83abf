"""The command that measures a finished run: observe."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from granulab.campaign.cli.commandline import json_option
from granulab.campaign.output.layout import wrapped

if TYPE_CHECKING:
    from granulab.campaign.output.measures import Measures


def window_of(text: str | None) -> tuple[float, float] | None:
    """From and until [s] of a text such as "0.2 s,0.6 s"; None of none."""
    from granulab.contact.files.units import to_si
    from granulab.errors import InputError

    if text is None:
        return None
    first, comma, last = text.partition(",")
    window = to_si(first, "s", "--between"), to_si(last, "s", "--between") if comma else 0.0
    if not comma or not 0 <= window[0] < window[1]:
        raise InputError(f"--between {text!r}: write from and until, such as '0.2 s,0.6 s'")
    return window


between_option = click.option(
    "--between", metavar="'0.2 s,0.6 s'", help="Take the mean over this time, for the flow."
)


def observe_command(
    measures: "Callable[[], Measures]", run_folder: Callable[[str], Path], of: str
) -> click.Command:
    """The command `observe RUN WHAT` of a simulator.

    measures: gives its registry; run_folder: the path of a run, FolderError where it is none; of:
    whose ranges its numbers are judged by (granulab/campaign/output/ranges.py).
    """

    @click.command()
    @click.argument("folder", metavar="RUN")
    @click.argument("what", required=False)
    @between_option
    @click.option("--no-figures", is_flag=True, help="Print the numbers only.")
    @json_option
    def observe(
        folder: str, what: str | None, between: str | None, no_figures: bool, as_json: bool
    ) -> None:
        """Measure something of a run: numbers on stdout, a picture in figures/.

        Without WHAT it lists the measures.
        """
        from granulab.campaign.output.figure import write_figure
        from granulab.campaign.output.ranges import judged
        from granulab.contact.files.units import located

        known = measures()
        if what is None:
            click.echo(wrapped(known.listing(), 16))
            return
        found, path = known.find(what), run_folder(folder)
        given = known.options(what, between=window_of(between))
        numbers = found.measure(path, **given)
        with located(f"{path}: {what}:"):
            for line in judged(of, numbers):
                click.echo(f"warning: {line}", err=True)
        if as_json:
            click.echo(json.dumps(numbers, indent=2))
        else:
            shown = {k: v for k, v in numbers.items() if not isinstance(v, (list, dict))}
            wide = max(map(len, shown), default=0)
            lines = (f"{key:{wide}}  {_value(value)}" for key, value in shown.items())
            click.echo(wrapped("\n".join(lines), wide + 2))
        if not no_figures:
            picture = write_figure(
                path / "figures" / f"{what}.png", lambda: found.draw(path, **given)
            )
            click.echo(picture, err=True)

    return observe


def _value(value: Any) -> str:
    if value is None:
        return "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
