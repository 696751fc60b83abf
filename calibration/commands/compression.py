"""The command that measures stiffness by loading and unloading: compression."""

from typing import TYPE_CHECKING

import click

from calibration.bench.compression import INPUTS
from calibration.commands.bench_options import bench_command, trial_option

if TYPE_CHECKING:
    from calibration.bench.measure import Result
    from calibration.bench.sections import Asked


@bench_command(INPUTS, {"kn": "kn_n_per_m", "youngs_modulus": "youngs_modulus_pa"}, files=False)
@trial_option
@click.option(
    "--range",
    "share",
    nargs=2,
    type=float,
    default=(0.95, 0.5),
    metavar="UPPER LOWER",
    help="Shares of each fall of the load that the slope is fitted to [default: 0.95 0.5].",
)
@click.option(
    "--least-cycle", type=float, default=0.1, metavar="SHARE",
    help="A fall by less than this share of the range of the load is no cycle [default: 0.1].",
)  # fmt: skip
def command(
    files: tuple[str, ...], what: "Asked", trial: str | None, share: tuple[float, float],
    least_cycle: float,
) -> "list[Result]":  # fmt: skip
    """Unloading stiffness of each cycle, modulus, and kn = E A/L.

    A record a trial.

    For example: calibrate compression cube*.csv --constant "area=100 mm2" --constant "length=10 mm"

    Without a file: calibrate compression --constant "modulus=242 MPa +- 15 %" --constant
    "contact_area=1200 mm2" --constant "contact_length=20 mm"
    """
    from calibration.bench.compression import Branch, stiffness

    return stiffness(files, what, Branch(*share, least_cycle), trial=trial)
