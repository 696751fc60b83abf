"""The command that finds the roughness of a surface profile: roughness."""

from typing import TYPE_CHECKING

import click

from calibration.bench.roughness import FORMS, INPUTS
from calibration.commands.bench_options import bench_command, trial_option

if TYPE_CHECKING:
    from calibration.bench.measure import Result
    from calibration.bench.sections import Asked


@bench_command(INPUTS, {})
@trial_option
@click.option(
    "--form", type=click.Choice(FORMS), default="line",
    help="What is taken off the profile first, by least squares [default: line].",
)  # fmt: skip
def command(files: tuple[str, ...], what: "Asked", trial: str | None, form: str) -> "list[Result]":
    """Mean roughness Ra of profiles z(x).

    Ra = (1/L) integral |z| dx, thesis eq. 7.1; a path a trial.

    For example: calibrate roughness paths.csv --trial path --group particle --form circle
    """
    from calibration.bench.roughness import mean_roughness

    return mean_roughness(files, what, trial=trial, form=form)
