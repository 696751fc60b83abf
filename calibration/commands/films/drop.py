"""The command that reads restitution off an object that falls and bounces: drop."""

from pathlib import Path

import click

from calibration.commands.options import (
    Box,
    answers_options,
    figures_option,
    fps_option,
    into_options,
    position,
    roi_option,
    unit_option,
)
from calibration.result import Into, finish
from granulab.campaign.cli.commandline import quiet_option


@click.command(short_help="Restitution of an object that falls and bounces")
@click.argument("file")
@fps_option
@unit_option
@click.option("--scale", metavar='"0.81 mm/px"', help="Length per unit of x and y.")
@click.option("--track", metavar="NAME", help="Which of several objects that bounce.")
@click.option("--one-bounce", is_flag=True, help="Take a single bounce, unchecked by another.")
@roi_option("Part of the picture to look at, in pixels.")
@click.option("--at", metavar="frame,x,y", help="Where the object is in some frame of a film.")
@figures_option("Put diagnostic figure and annotated film there.")
@into_options("restitution")
@quiet_option
@answers_options
def command(
    file: str, fps: float | None, units: dict[str, str], scale: str | None, track: str | None,
    one_bounce: bool, roi: Box | None, at: str | None, out: Path | None, into: Into | None,
    quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Restitution of an object that falls on a plate and bounces (eq. 3.5).

    FILE is a film (mp4, avi, mov, ..., a folder of pictures, 'im*.png'), in which the object is
    found by itself, or a table of frame or time, x, y, as trackers write it. Free fall gives the
    scale where the rate is known, and the rate where the scale is; with both, g is a check.

    For example: calibrate drop marble.mp4 --fps 240 --out figures
    """
    from calibration.drop.measure import measure_drop
    from granulab.campaign.output.terminal import Progress

    with Progress(Path(file).name, quiet) as progress:
        drop = measure_drop(
            file, fps=fps, scale=scale, track=track, one_bounce=one_bounce, roi=roi,
            hint=position(at), progress=progress.update, units=units, out=out,
        )  # fmt: skip
    finish(
        drop, as_json=as_json, quiet=quiet, into=into, measured=[file],
        files={"sheet": drop.sheet, "annotated_film": drop.film},
    )  # fmt: skip
