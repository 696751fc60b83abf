"""The command that finds impacts in a signal and takes the restitution from their times."""

from pathlib import Path

import click

from calibration.commands.options import answers_options, figures_option, into_options, unit_option
from calibration.result import Into, finish
from granulab.campaign.cli.commandline import quiet_option
from granulab.contact.files.units import to_si
from granulab.errors import InputError


@click.command(short_help="Restitution from sound, force or acceleration")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--rate", type=float, metavar="200000", help="Samples/s of a table without times.")
@unit_option
@click.option("--column", metavar="NAME", help="The only column wanted of a table.")
@click.option(
    "--window", metavar='"2 ms"',
    help="Longer than a contact, shorter than a flight [default: 2 ms].",
)  # fmt: skip
@click.option("--drop-height", metavar='"1.5 m +- 5 mm"', help="Of the first fall: a check.")
@figures_option("Folder for the diagnostic figure (PNG).")
@into_options("restitution")
@quiet_option
@answers_options
def command(
    file: Path, rate: float | None, units: dict[str, str], column: str | None, window: str | None,
    drop_height: str | None, out: Path | None, into: Into | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Restitution from the times between impacts: force, acceleration or sound (WAV, CSV).

    Also from what an acoustic stopwatch exports (xls, xlsx, csv): times of one or more throws.

    For example: calibrate impacts drop.wav --out figures
    """
    from calibration.impacts.measure import measure_impacts
    from calibration.impacts.search import WINDOW
    from calibration.impacts.stopwatch import measure_stopwatch
    from calibration.statistics.quantity import measured_quantity

    given = {"--rate": rate, "--column": column, "--window": window, "--drop-height": drop_height,
             "--unit": units or None}  # fmt: skip
    spare = [name for name, value in given.items() if value is not None]
    timed = measure_stopwatch(file)
    if timed is not None and spare:
        raise InputError(
            f"{file}: holds times of events, which {' and '.join(spare)} do not go with; leave out"
        )
    found = timed or measure_impacts(
        file,
        rate=rate,
        column=column,
        units=units,
        window=WINDOW if window is None else to_si(window, "s", "--window"),
        drop_height=None
        if drop_height is None
        else measured_quantity(drop_height, "m", "--drop-height"),
    )
    finish(
        found, as_json=as_json, quiet=quiet, out=out, name=f"{file.stem}-impacts", into=into,
        measured=[file],
    )  # fmt: skip
