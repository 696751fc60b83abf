"""The six markers of the paper's Table 1 (journal): what it prints there, and what we read there.

A marker's kt/kn is eq. 3.3 of the stresses and displacements at it. Displacements count from the
resting platen: the paper does not say what they count from, but the markers of both blocks move
the same way.
"""

from dataclasses import dataclass

import numpy as np

from calibration.files.tables import Table, read_table
from calibration.stiffness_fe.blocks import Array
from calibration.stiffness_fe.protocol import Outcome
from granulab.contact.files.datafile import data_file


@dataclass(frozen=True)
class Printed:
    """Means over the six markers of one surface, in SI; kt_over_kn with its scatter."""

    across: float
    along: float
    sigma_n: float
    sigma_t: float
    kt_over_kn: float
    scatter: float


def printed(surface: str) -> Printed:
    """Means in Table 1 of the "flat" or the "rough" surface."""
    table = _table()
    rows = np.array([label == surface for label in table.labels("surface")])
    names = ("dx_n_mm", "dx_t_mm", "sigma_n_MPa", "sigma_t_MPa")
    across, along, sigma_n, sigma_t = (
        np.abs(table.column(name, "1")[rows]).mean() for name in names
    )
    ratios = table.column("kt_over_kn_printed", "1")[rows]
    return Printed(
        1e-3 * across, 1e-3 * along, 1e6 * sigma_n, 1e6 * sigma_t,
        float(ratios.mean()), float(ratios.std(ddof=1)),
    )  # fmt: skip


def positions() -> Array:
    """(6, 2) along and across the interface [m], from the middle between the two rows of markers.

    The interface runs in the mean direction of the rows, midway between them.
    """
    table = _table()
    flat = np.array([label == "flat" for label in table.labels("surface")])
    spots = 1e-3 * np.column_stack([table.column(name, "1")[flat] for name in ("x_mm", "y_mm")])
    rows = spots[:3], spots[3:]
    slope = float(np.mean([np.polyfit(row[:, 0], row[:, 1], 1)[0] for row in rows]))
    along = np.array([1.0, slope]) / np.hypot(1.0, slope)
    from_middle = spots - np.mean([row.mean(axis=0) for row in rows], axis=0)
    return from_middle @ np.array([along, [-along[1], along[0]]]).T


def read(outcome: Outcome) -> dict[str, Array] | None:
    """Displacements, stresses and kt/kn at the markers, (6,) each, SI; None if one is outside."""
    stack, state = outcome.stack, outcome.state
    spots = positions()
    middle = stack.lower.points[:, 0].mean()
    found: list[Array] = []
    for block, forces, rows, shift in (
        (stack.upper, state.upper, slice(0, 3), state.platen),
        (stack.lower, state.lower, slice(3, 6), np.zeros(2)),
    ):
        at = spots[rows] + [middle, block.points[:, 1].mean()]
        if not block.holds(at):
            return None
        moved = block.displacements(forces)
        shifted = block.at(block.by_point(moved), at) + shift[:, None]
        found.append(np.vstack([shifted, block.at(block.stress(moved)[1:], at)]))
    dx_t, dx_n, sigma_n, sigma_t = np.hstack(found)
    return {
        "dx_t_m": dx_t, "dx_n_m": dx_n, "sigma_t_pa": sigma_t, "sigma_n_pa": sigma_n,
        "kt_over_kn": np.abs(sigma_t / sigma_n * dx_n / dx_t),
    }  # fmt: skip


def _table() -> Table:
    path = data_file("published", "interface_markers")
    assert path is not None
    return read_table(path)
