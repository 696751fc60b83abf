"""Ratio of tangential to normal stiffness from markers next to an interface, eq. 3.3.

kt/kn = (sigma_t/sigma_n) (dx_n/dx_t), of absolute values: the forces of eq. 3.2 act on the same
area of contact. A ratio of small displacements: where a reading's sigma (--reading dx_t=...) is a
good share of the displacement itself, the first-order sigma of a marker is a rough one.
"""

from collections.abc import Sequence
from pathlib import Path

from calibration.bench.measure import Quantity, measure
from calibration.bench.sections import Columns, Input, Request, need, rows
from calibration.statistics.uncertainty import Estimate
from granulab.errors import InputError

INPUTS = (
    Input("dx_t", "m", "displacement along the interface"),
    Input("dx_n", "m", "displacement across it"),
    Input("sigma_t", "Pa", "shear stress"),
    Input("sigma_n", "Pa", "normal stress"),
    Input("kn", "N/m", "normal stiffness, where kt is wanted; a constant, as a rule"),
)
_READ = [one.name for one in INPUTS[:4]]


def stiffness_ratio(files: Sequence[str | Path], what: Request) -> list[Quantity]:
    """kt/kn, one row a marker; and kt where kn is given."""
    sections, remarks = rows(files, INPUTS, what, [_READ])
    for section in sections:
        need(section, [_READ], INPUTS)

    def kt(columns: Columns) -> Estimate:
        return Estimate(_ratio(columns).value * float(columns["kn"][0]), None, 1)

    results = [measure(sections, _ratio, what, key="kt_over_kn", name="kt/kn", remarks=remarks)]
    if all("kn" in section.columns for section in sections):
        results.append(
            measure(
                sections, kt, what,
                key="kt_n_per_m", name="tangential stiffness kt", si="N/m", unit="N/mm",
            )
        )  # fmt: skip
    return results


def _ratio(columns: Columns) -> Estimate:
    dx_t, dx_n, sigma_t, sigma_n = (abs(float(columns[name][0])) for name in _READ)
    if dx_t == 0 or sigma_n == 0:
        raise InputError(f"dx_t = {dx_t:g} m, sigma_n = {sigma_n:g} Pa: neither may be 0")
    return Estimate(sigma_t / sigma_n * dx_n / dx_t, None, 1)
