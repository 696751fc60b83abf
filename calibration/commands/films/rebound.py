"""The command that reads restitution off a particle that rebounds with rotation: rebound."""

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
)
from calibration.result import Into, finish
from granulab.campaign.cli.commandline import quiet_option
from granulab.errors import InputError


@click.command(short_help="Restitution of an irregular particle, with its rotation")
@click.argument("film")
@fps_option
@click.option("--scale", metavar='"0.81 mm/px"', help="Length of a pixel; else free fall gives it.")
@click.option(
    "--plane", metavar='"0 deg +- 0.5 deg"', default="0 deg +- 0.5 deg",
    help="Plate to the picture's horizontal, counter-clockwise [default: 0 deg +- 0.5 deg].",
)  # fmt: skip
@click.option(
    "--gyration", metavar='"4.7 mm +- 0.1 mm"',
    help="Radius of gyration about the axis seen along; else that of a prism.",
)  # fmt: skip
@click.option("--track", metavar="NAME", help="Which of several objects that rebound.")
@roi_option("Part of the picture to look at, in pixels.")
@click.option("--at", metavar="frame,x,y", help="Where the particle is in some frame.")
@figures_option("Put the diagnostic figure there.")
@into_options("restitution")
@quiet_option
@answers_options
def command(
    film: str, fps: float | None, scale: str | None, plane: str, gyration: str | None,
    track: str | None, roi: Box | None, at: str | None, out: Path | None, into: Into | None,
    quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Restitution of an irregular particle that falls on a plate and rebounds with rotation.

    FILM shows it from the side, in silhouette. Its centroid and orientation before and after the
    contact give the restitution at the point of contact, which is the contact's own, the ratio of
    the centroid's velocities, which is not, and where the energy went.

    For example: calibrate rebound particle.mp4 --fps 500 --out figures
    """
    from calibration.rebound.measure import measure_rebound
    from calibration.statistics.quantity import measured_quantity, metres_per_pixel
    from granulab.campaign.output.terminal import Progress

    angle = measured_quantity(plane, "rad", "--plane")
    if not abs(angle.value) < 1.0:
        raise InputError(
            f"--plane = {plane!r}: below 57 degrees; steeper plates let nothing rebound"
        )
    radius = None if gyration is None else measured_quantity(gyration, "m", "--gyration")
    if radius is not None and radius.value <= 0:
        raise InputError(f"--gyration = {gyration!r}: must be positive, such as '4.7 mm'")
    with Progress(Path(film).name, quiet) as progress:
        found = measure_rebound(
            film, fps=fps, scale=None if scale is None else metres_per_pixel(scale), plane=angle,
            gyration_radius=radius, track=track, roi=roi, hint=position(at),
            progress=progress.update,
        )  # fmt: skip
    finish(
        found, as_json=as_json, quiet=quiet, out=out, name=f"rebound-{found.path.stem}",
        into=into, measured=[film],
    )  # fmt: skip
