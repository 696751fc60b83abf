"""The command that finds kt/kn from markers beside an interface: interface."""

from typing import TYPE_CHECKING

from calibration.bench.interface import INPUTS
from calibration.commands.bench_options import bench_command

if TYPE_CHECKING:
    from calibration.bench.measure import Result
    from calibration.bench.sections import Asked


@bench_command(INPUTS, {"kt": "kt_n_per_m"})
def command(files: tuple[str, ...], what: "Asked") -> "list[Result]":
    """kt/kn from displacements and stresses beside an interface.

    kt/kn = (sigma_t/sigma_n) (dx_n/dx_t), eq. 3.3; a row a marker.

    For example: calibrate interface markers.csv --group surface --reading "dx_t=0.003 mm"
    """
    from calibration.bench.interface import stiffness_ratio

    return stiffness_ratio(files, what)
