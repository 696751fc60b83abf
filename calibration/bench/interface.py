"""Ratio of tangential to normal stiffness from markers beside an interface, eq. 3.3.

kt/kn = (sigma_t/sigma_n) (dx_n/dx_t), of absolute values: the forces of eq. 3.2 act on the same
area of contact. A ratio of small displacements: where a reading's sigma (--reading dx_t=...) is a
good share of the displacement itself, the first-order sigma of a marker is a rough one.
"""

from collections.abc import Sequence
from pathlib import Path

from calibration.bench.measure import Result, measure
from calibration.bench.sections import Asked, Columns, Input, need, rows
from calibration.uncertainty import Estimate
from contact.quantity import InputError

INPUTS = (
    Input("dx_t", "m", "displacement along the interface"),
    Input("dx_n", "m", "displacement across it"),
    Input("sigma_t", "Pa", "shear stress"),
    Input("sigma_n", "Pa", "normal stress"),
)


def stiffness_ratio(files: Sequence[str | Path], what: Asked) -> list[Result]:
    """kt/kn, one row a marker."""
    sections, remarks = rows(files, INPUTS, what)
    names = [one.name for one in INPUTS]
    for section in sections:
        need(section, [names], INPUTS)

    def evaluate(columns: Columns) -> Estimate:
        dx_t, dx_n, sigma_t, sigma_n = (abs(float(columns[name][0])) for name in names)
        if dx_t == 0 or sigma_n == 0:
            raise InputError(f"dx_t = {dx_t:g} m, sigma_n = {sigma_n:g} Pa: neither may be 0")
        return Estimate(sigma_t / sigma_n * dx_n / dx_t, None, 1)

    return [measure(sections, evaluate, what, key="kt_over_kn", name="kt/kn", remarks=remarks)]
