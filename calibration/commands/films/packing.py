"""The command that measures a silo at rest, its packing height and layers: packing."""

from pathlib import Path

import click

from calibration.commands.options import Box, answers_options, figures_option, roi_option
from calibration.result import finish
from granulab.campaign.cli.commandline import quiet_option


@click.command(short_help="Packing height and layers of a silo at rest")
@click.argument("file")
@roi_option("The silo's inside, from the floor up to where nothing lies.")
@click.option("--width", metavar='"300 mm"', help="The silo's inner width: gives the scale.")
@click.option("--scale", metavar='"0.81 mm/px"', help="Length of a pixel.")
@click.option(
    "--columns", type=int, default=11, help="Across it, two particles wide each [default: 11]."
)
@click.option("--layers", type=int, metavar="N", help="Painted layers; refuse to see others.")
@figures_option("Draw the diagnostic figure there.")
@quiet_option
@answers_options
def command(
    file: str, roi: Box | None, width: str | None, scale: str | None, columns: int,
    layers: int | None, out: Path | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Packing height and layers of a silo at rest, from a film or one picture.

    Without --scale or --width lengths are in pixels.

    For example: calibrate packing filled.png --roi 40,60,420,500 --width "300 mm" --out figures
    """
    from calibration.flow.packing import measure_packing

    found = measure_packing(file, roi=roi, scale=scale, width=width, layers=layers,
                            columns=columns)  # fmt: skip
    finish(found, as_json=as_json, quiet=quiet, out=out, name=f"packing-{found.name}",
           measured=[file])  # fmt: skip
