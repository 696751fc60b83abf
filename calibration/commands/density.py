"""The command that weighs: density."""

from typing import TYPE_CHECKING

from calibration.bench.density import INPUTS
from calibration.commands.bench_options import bench_command

if TYPE_CHECKING:
    from calibration.bench.measure import Result
    from calibration.bench.sections import Asked


@bench_command(INPUTS, {"density": "density_kg_m3"})
def command(files: tuple[str, ...], what: "Asked") -> "list[Result]":
    """Density, mass over volume, from masses and sizes.

    A row a particle.

    For example: calibrate density weighed.csv --instrument "mass=0.01 g"
    """
    from calibration.bench.density import density

    return density(files, what)
