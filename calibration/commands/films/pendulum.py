"""The command that reads restitution off objects that swing on strings and collide: pendulum."""

from pathlib import Path

import click

from calibration.commands.options import (
    Box,
    answers_options,
    figures_option,
    fps_option,
    into_options,
    roi_option,
    unit_option,
)
from calibration.result import Into, finish
from granulab.campaign.cli.commandline import quiet_option
from granulab.contact.files.units import to_si
from granulab.errors import InputError


@click.command(short_help="Restitution of two blocks on strings, or a ball and a wall")
@click.argument("file")
@fps_option
@unit_option
@roi_option("Part of the picture to look at, in pixels.")
@click.option("--track", multiple=True, metavar="NAME", help="Which object; twice for two blocks.")
@click.option("--masses", metavar='"10 g,12 g"', help="Of the left and the right block: a check.")
@figures_option("Draw the diagnostic figure there.")
@into_options("restitution")
@quiet_option
@answers_options
def command(
    file: str, fps: float | None, units: dict[str, str], roi: Box | None, track: tuple[str, ...],
    masses: str | None, out: Path | None, into: Into | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Restitution of two blocks on strings (eq. 3.6), or of a ball on a string against a wall.

    FILE is a film, or a table of frame or time, x, y of one ball or two blocks. The first block, or
    the ball, is held to one side and let go.

    For example: calibrate pendulum blocks.mp4 --out figures
    """
    from calibration.pendulum.measure import measure_pendulum
    from granulab.campaign.output.terminal import Progress

    with Progress(Path(file).name, quiet) as progress:
        found = measure_pendulum(
            file, fps=fps, tracks=track, roi=roi, masses=_masses(masses),
            progress=progress.update, units=units,
        )  # fmt: skip
    finish(
        found, as_json=as_json, quiet=quiet, out=out, name=f"pendulum-{found.objects.name}",
        into=into, measured=[file],
    )  # fmt: skip


def _masses(text: str | None) -> tuple[float, float] | None:
    """Two masses [kg] of "10 g,12 g"."""
    if text is None:
        return None
    words = text.split(",")
    if len(words) != 2:
        raise InputError(f"--masses = {text!r}: two masses, such as '10 g,12 g'")
    first, second = (to_si(word.strip(), "kg", "--masses") for word in words)
    if not (first > 0 and second > 0):
        raise InputError(f"--masses = {text!r}: must be positive, such as '10 g,12 g'")
    return first, second
