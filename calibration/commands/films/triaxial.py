"""The command that reads stiffness off two loaded blocks with markers: triaxial."""

from pathlib import Path

import click

from calibration.commands.options import (
    answers_options,
    figures_option,
    fps_option,
    into_options,
)
from calibration.result import Into, finish
from granulab.campaign.cli.commandline import quiet_option
from granulab.errors import InputError


@click.command(short_help="Stiffness of an inclined contact, from markers and a load record")
@click.argument("film")
@click.option("--load", required=True, metavar="RECORD.csv", help="Load against time or frame.")
@click.option(
    "--contact", required=True, metavar="x1,y1,x2,y2", help="Ends of the contact, first frame [px]."
)
@click.option(
    "--scale", required=True, metavar='"0.05 mm/px"',
    help="Length of a pixel, with +- where it is known: '0.05 mm/px +- 0.5 %'.",
)  # fmt: skip
@click.option(
    "--inclination", metavar='"15 deg +- 0.3 deg"',
    help="Of the contact to the horizontal [default: as --contact].",
)  # fmt: skip
@click.option("--load-line", type=float, metavar="x", help="Where the load acts [px]: its moment.")
@click.option("--offset", metavar='"0.2 s"', help="Time of the film when the record starts.")
@click.option(
    "--range", "shares", default="0.9,0.1", metavar="0.9,0.1",
    help="Shares of an unloading's fall to fit [default: 0.9,0.1].",
)  # fmt: skip
@click.option(
    "--least-cycle", type=float, default=0.3, metavar="0.3",
    help="Share of the load's range that an unloading falls by [default: 0.3].",
)  # fmt: skip
@fps_option
@figures_option("Put the diagnostic figure there.")
@into_options("kn", "kt")
@quiet_option
@answers_options
def command(
    film: str, load: str, contact: str, scale: str, inclination: str | None,
    load_line: float | None, offset: str | None, shares: str, least_cycle: float,
    fps: float | None, out: Path | None, into: Into | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Normal and tangential stiffness of two blocks with an inclined contact (sec. 3.2).

    FILM shows both blocks, with at least two dark dots on each, while a press loads and unloads
    them. The dots give approach, slip and rotation at the contact, the record the load.

    For example: calibrate triaxial blocks.mp4 --load load.csv --contact 34,97,206,143 --scale
    "0.08 mm/px" --load-line 126 --out figures
    """
    from calibration.bench.compression import Branch
    from calibration.statistics.quantity import measured_quantity
    from calibration.triaxial.measure import measure_triaxial
    from granulab.campaign.output.terminal import Progress
    from granulab.contact.files.units import to_si

    upper, lower = _numbers("--range", shares, 2)
    branch = Branch(upper, lower, least_cycle)
    angle = None if inclination is None else measured_quantity(inclination, "rad", "--inclination")
    length = measured_quantity(scale.replace("/px", ""), "m", "--scale")
    if "/px" not in scale or length.value <= 0:
        raise InputError(f"--scale = {scale!r}: a length per pixel, such as '0.05 mm/px'")
    late = 0.0 if offset is None else to_si(offset, "s", "--offset")
    with Progress(Path(film).name, quiet) as progress:
        found = measure_triaxial(
            film, load, contact=_numbers("--contact", contact, 4), scale=length, inclination=angle,
            load_line=load_line, fps=fps, offset=late, branch=branch,
            progress=progress.update,
        )  # fmt: skip
    finish(
        found, as_json=as_json, quiet=quiet, out=out, name=f"triaxial-{found.path.stem}",
        into=into, measured=[film, load],
    )  # fmt: skip


def _numbers(option: str, text: str, count: int) -> list[float]:
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        found = []
    if len(found) != count:
        raise InputError(f"{option} = {text!r}: {count} numbers with commas between them")
    return found
