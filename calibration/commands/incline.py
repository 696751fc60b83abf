"""The command that measures friction by tilting: incline."""

from typing import TYPE_CHECKING

import click

from calibration.bench.incline import INPUTS
from calibration.commands.bench_options import bench_command

if TYPE_CHECKING:
    from calibration.bench.measure import Result
    from calibration.bench.sections import Asked


@bench_command(INPUTS, {"friction": "friction"})
@click.option(
    "--length-along", "along", type=click.Choice(["slope", "base"]), default="slope",
    help="Where L was measured [default: slope, sin(alpha) = |H1 - H2|/L].",
)  # fmt: skip
def command(files: tuple[str, ...], what: "Asked", along: str) -> "list[Result]":
    """Friction from the angle of first slip, mu = tan(alpha).

    A row a trial.

    For example: calibrate incline tilt.csv --group pairing --instrument "angle=0.2 deg"
    """
    from calibration.bench.incline import friction

    return friction(files, what, along=along)
