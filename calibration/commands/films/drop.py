"""The command that reads restitution off an object that falls and bounces: drop."""

from pathlib import Path
from typing import Any

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
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@fps_option
@unit_option
@click.option("--scale", metavar='"0.81 mm/px"', help="Length per unit of x and y.")
@click.option("--track", metavar="NAME", help="Which of several objects that bounce.")
@click.option("--one-bounce", is_flag=True, help="Take a single bounce, unchecked by another.")
@click.option(
    "--terminal-speed", metavar='"45 m/s +- 10 %"',
    help="At which its fall in air would end, where that is known [default: as far as it shows].",
)  # fmt: skip
@roi_option("Part of the picture to look at, in pixels.")
@click.option("--at", metavar="frame,x,y", help="Where the object is in some frame of a film.")
@figures_option("Put diagnostic figure and annotated film there.")
@into_options("restitution")
@quiet_option
@answers_options
def command(
    files: tuple[str, ...], fps: float | None, units: dict[str, str], scale: str | None,
    track: str | None, one_bounce: bool, terminal_speed: str | None, roi: Box | None,
    at: str | None, out: Path | None, into: Into | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Restitution of an object that falls on a plate and bounces (eq. 3.5).

    FILE is a film (mp4, avi, mov, ..., a folder of pictures, 'im*.png'), in which the object is
    found by itself, or a table of frame or time, x, y, as trackers write it. Free fall gives the
    scale where the rate is known, and the rate where the scale is; with both, g is a check.

    Several files, or a folder of films, are trials of one test and are pooled. Folders name the
    particle and the height: drops/A/18.92mm/1.mp4.

    For example: calibrate drop marble.mp4 --fps 240 --out figures
    """
    from calibration.drop.pooled import is_folder_of_films
    from granulab.campaign.output.terminal import Progress

    how = {
        "fps": fps, "scale": scale, "track": track, "one_bounce": one_bounce,
        "terminal_speed": terminal_speed, "roi": roi, "hint": position(at), "units": units,
        "out": out,
    }  # fmt: skip
    several = len(files) > 1 or is_folder_of_films(Path(files[0]))
    with Progress(Path(files[0]).name, quiet) as progress:
        if several:
            _pooled(files, into, quiet, as_json, progress=progress.update, **how)
        else:
            _one(files[0], into, quiet, as_json, progress=progress.update, **how)


def _one(file: str, into: Into | None, quiet: bool, as_json: bool, **how: Any) -> None:
    from calibration.drop.measure import measure_drop

    drop = measure_drop(file, **how)
    finish(
        drop, as_json=as_json, quiet=quiet, into=into, measured=[file],
        files={"sheet": drop.sheet, "annotated_film": drop.film},
    )  # fmt: skip


def _pooled(
    files: tuple[str, ...], into: Into | None, quiet: bool, as_json: bool, **how: Any
) -> None:
    from calibration.drop.pooled import measure_drops

    found, measured = measure_drops(files, **how)
    finish(
        found, as_json=as_json, quiet=quiet, out=how["out"], name=f"drop-{Path(files[0]).stem}",
        into=into, measured=measured,
    )  # fmt: skip
