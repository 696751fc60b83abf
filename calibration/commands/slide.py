"""The command that measures tangential damping on a slope: slide."""

from typing import TYPE_CHECKING

import click

from calibration.bench.slide import INPUTS
from calibration.commands.bench_options import bench_command, trial_option

if TYPE_CHECKING:
    from calibration.bench.measure import Result
    from calibration.bench.sections import Asked


@bench_command(INPUTS, {"gamma_t": "gamma_t_per_s"})
@trial_option
@click.option(
    "--start", type=click.Choice(["rest", "any"]), default="rest",
    help="From rest at t = 0, eq. 3.11b, or at any velocity there [default: rest].",
)  # fmt: skip
def command(files: tuple[str, ...], what: "Asked", trial: str | None, start: str) -> "list[Result]":
    """Tangential damping gamma_t of a sliding block (eqs 3.11a-c).

    A curve v(t), or a row a trial.

    For example: calibrate slide run1.csv run2.csv --constant "incline=30 deg +- 0.5 deg"
    """
    from calibration.bench.slide import damping

    return damping(files, what, trial=trial, start=start)
