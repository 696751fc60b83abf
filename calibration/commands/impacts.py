"""The command that finds impacts in a signal and takes the restitution from their times."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from calibration.commands.options import Into, into_options, sheets_option
from granulab.campaign.cli.commandline import json_option, quiet_option
from granulab.contact.files.units import to_si
from granulab.errors import InputError

if TYPE_CHECKING:
    from calibration.impacts.measure import Impacts
    from calibration.statistics.uncertainty import Estimate


@click.command(short_help="Restitution from sound, force or acceleration")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--rate", type=float, metavar="200000", help="Samples/s of a table without times.")
@click.option("--column", metavar="NAME", help="The only column wanted of a table.")
@click.option(
    "--window", metavar='"2 ms"',
    help="Longer than a contact, shorter than a flight [default: 2 ms].",
)  # fmt: skip
@click.option("--drop-height", metavar='"1.5 m"', help="Of the first fall: a check.")
@sheets_option("Folder for the sheet (PNG).")
@into_options("restitution")
@quiet_option
@json_option
def command(
    file: Path, rate: float | None, column: str | None, window: str | None,
    drop_height: str | None, out: Path | None, into: Into | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Restitution from the times between impacts: force, acceleration or sound (WAV, CSV).

    For example: calibrate impacts drop.wav --out sheets
    """
    from calibration.impacts.measure import measure_impacts
    from calibration.impacts.search import WINDOW

    found = measure_impacts(
        file,
        rate=rate,
        column=column,
        window=WINDOW if window is None else to_si(window, "s", "--window"),
        drop_height=None if drop_height is None else to_si(drop_height, "m", "--drop-height"),
    )
    if into is not None:
        into.put("restitution", _estimate(found), method="impact times", files=[file])
    sheet = None if out is None else _sheet(found, file, out)
    if as_json:
        click.echo(json.dumps(found.as_json() | {"sheet": sheet and str(sheet)}, indent=2))
        return
    click.echo(_report(found))
    if sheet is not None and not quiet:
        click.echo(f"sheet: {sheet}", err=True)


def _estimate(found: "Impacts") -> "Estimate":
    """The pooled restitution; InputError where the signal gives none."""
    from calibration.statistics.uncertainty import Estimate

    one = found.restitution
    if one.value is None:
        raise InputError(f"{found.signal.path}: no restitution to write: {found.warnings[0]}")
    return Estimate(one.value, one.sigma, max(1, len(one.per_pair)))


def _sheet(found: "Impacts", file: Path, out: Path) -> Path:
    from calibration.impacts.sheet import draw_sheet
    from granulab.campaign.output.figure import write_figure

    return write_figure(out / f"{file.stem}-impacts.png", lambda: draw_sheet(found))


def _report(found: "Impacts") -> str:
    """Impacts, pairs and what is made of them, as text."""
    from calibration.statistics.quantity import plus_minus

    lines = [f"impact  {'time [s]':28}flight [s]"]
    for k, (time, sigma) in enumerate(zip(found.times_s, found.sigmas_s, strict=True)):
        flight = f"{found.times_s[k + 1] - time:.6f}" if k + 1 < len(found.times_s) else "-"
        lines.append(f"{k + 1:6d}  {plus_minus(time, sigma):28}{flight}")
    one = found.restitution
    for k, (value, sigma, speed) in enumerate(
        zip(one.per_pair, one.per_pair_sigma, one.impact_speeds_m_s, strict=True), start=2
    ):
        lines.append(f"impact {k}: e = {plus_minus(value, sigma)} at {speed:.2f} m/s")
    if one.value is not None and one.sigma is not None:
        told = "" if one.p is None else f" (p = {one.p:.2g} that one number describes the pairs)"
        lines.append(f"restitution {plus_minus(one.value, one.sigma)}{told}")
    if found.first_restitution is not None:
        lines.append(f"drop height and first flight: {found.first_restitution:.4f}")
    return "\n".join([*lines, *(f"warning: {words}" for words in found.warnings)])
