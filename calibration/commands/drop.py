"""The command that reads restitution off a thing that falls and bounces: drop."""

import json
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import click

from calibration.commands.film_options import Box, fps_option, place, roi_option
from calibration.commands.options import into_options, sheets_option
from granulab.campaign.cli.commandline import json_option, quiet_option

if TYPE_CHECKING:
    from calibration.commands.options import Into
    from calibration.drop.measure import Drop
    from calibration.statistics.uncertainty import Estimate


@click.command(short_help="Restitution of a thing that falls and bounces")
@click.argument("file")
@fps_option
@click.option("--scale", metavar='"0.81 mm/px"', help="Length per unit of x and y.")
@click.option("--track", metavar="NAME", help="Which of several things that bounce.")
@click.option("--one-bounce", is_flag=True, help="Take a single bounce, unchecked by another.")
@roi_option("Part of the picture to look at, in pixels.")
@click.option("--at", metavar="frame,x,y", help="Where the thing is in some frame of a film.")
@sheets_option("Put sheet and annotated film there.")
@into_options("restitution")
@quiet_option
@json_option
def command(
    file: str, fps: float | None, scale: str | None, track: str | None, one_bounce: bool,
    roi: Box | None, at: str | None, out: Path | None, into: "Into | None", quiet: bool,
    as_json: bool,
) -> None:  # fmt: skip
    """Restitution of a thing that falls on a plate and bounces (eq. 3.5).

    FILE is a film (mp4, avi, mov, ..., a folder of pictures, 'im*.png'), in which the thing is
    found by itself, or a table of frame or time, x, y, as trackers write it. Free fall gives the
    scale where the rate is known, and the rate where the scale is; with both, g is a check.

    For example: calibrate drop marble.mp4 --fps 240 --out sheets
    """
    from calibration.drop.measure import measure_drop
    from granulab.campaign.cli.terminal import Progress

    with Progress(Path(file).name, quiet) as progress:
        drop = measure_drop(
            file, fps=fps, scale=scale, track=track, one_bounce=one_bounce, roi=roi,
            hint=place(at), progress=progress.update, out=out,
        )  # fmt: skip
    if into is not None:
        into.put("restitution", drop.restitution, method="drop test", files=[file])
    click.echo(json.dumps(drop.as_json(), indent=2) if as_json else _report(drop))


def _report(drop: "Drop") -> str:
    found = drop.bounces
    one = {
        True: f"one number describes the clip (p = {found.p or 0:.2g})",
        False: f"one number does not describe the clip (p = {found.p or 0:.2g})",
        None: "one value: nothing to compare it with",
    }[found.constant_within_noise]
    lines = [
        f"restitution {_with(drop.restitution, '')} from {found.method}; {one}",
        *_bounces(drop),
    ]
    if found.exponent is not None:
        lines.append(f"restitution ~ speed^n, n = {_with(found.exponent, '')}")
    a, sigma = found.flights.acceleration
    lines.append(f"acceleration {abs(a):.5g} +- {sigma:.2g} per frame^2, y counts "
                 f"{'downwards' if a > 0 else 'upwards'}")  # fmt: skip
    lines += [
        f"rate   {_with(drop.rate, 'frames/s')}",
        f"scale  {_with(drop.scale, 'm per unit of y')}",
        f"g      {_with(drop.gravity, 'm/s2')}",
        f"plate  moves by {_with(found.drift, '')} from the first contact to the last",
    ]
    lines += [f"time base: {remark}" for remark in drop.remarks]
    lines += [f"warning: {warning}" for warning in drop.warnings]
    if drop.sheet is not None:
        lines.append(f"sheet {drop.sheet}")
    if drop.film is not None:
        lines.append(f"annotated film {drop.film}")
    return "\n".join(lines)


def _bounces(drop: "Drop") -> list[str]:
    found = drop.bounces
    lines = [
        f"{'frame':>9} {'from times':>16} {'from velocities':>16} {'from heights':>16} "
        f"{'impact speed':>12}"
    ]
    for k, (clock, _) in enumerate(found.contacts):
        ways = [found.times[k], found.velocities[k], found.heights[k]]
        cells = [f"{e:.4f} +- {s:.1g}" if isfinite(e) else "-" for e, s in ways]
        speed = drop.speed(k)
        cells.append(f"{speed.value:.3f} m/s" if speed else "-")
        lines.append(
            f"{drop.frame(clock):9.2f} "
            + " ".join(f"{cell:>16}" for cell in cells[:3])
            + f" {cells[3]:>12}"
        )
    return lines


def _with(known: "Estimate | None", unit: str) -> str:
    """A value with its sigma and unit; "not known" for none."""
    if known is None:
        return "not known"
    sigma = f" +- {known.sigma:.2g}" if known.sigma else ""
    return f"{known.value:.5g}{sigma} {unit}".rstrip()
