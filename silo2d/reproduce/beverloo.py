"""Discharge rate against outlet: Beverloo's law in the paper's silos and in a wide one.

The paper's silos A and D with outlets of 100 to 200 mm (6 to 13 grains) are outside the law's
range: 300 mm are less than 2.5 outlets and 30 grains, the filling ends before the flow is steady
for long, and A is no flat floor. The wide silo of small grains (data/cases/beverloo.toml) is in it.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from silo2d.measures.basics.particles import leavers
from silo2d.measures.curve import Steady, part_between, steady_part
from silo2d.view.scene import read_scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from silo2d.case.case import SiloCase

Row = dict[str, Any]

SEEDS = 1
SILOS = "A", "D"
OUTLETS = 100, 110, 120, 130, 140, 150, 175, 200  # mm
_PRESETS = {100: "3", 150: "4"}  # outlets that the paper has too
# Outlets of the wide silo [mm], and when [s] some more than 30 % of its grains have left.
WIDE = {34: 2.0, 40: 1.5, 46: 1.2, 52: 1.0, 58: 0.9}
WIDE_PART = 0.1, 0.3  # of the grains out, between which the wide silo's rate is taken
_PER_PART = 10  # windows in it, for the Fano factor
_KEPT = ["state", "reason", "outcome", "n_particles", "n_out", "packing_fraction", "time_step_s",
         "cpu_s", "mean_mass_flow_kg_per_s"]  # fmt: skip


def run(
    *, out: Path, seeds: Sequence[int], workers: int | None, quiet: bool, **engine: Any
) -> list[Row]:
    """A row a run: silo A, D or wide, outlet, seed, and the rate of its steady part."""
    from silo2d.run.sweep import run_cases

    chosen = list(cases(seeds))
    runs = run_cases(chosen, out=out, workers=workers, quiet=quiet, **engine)
    return [row_of(one, case) for one, (_, case) in zip(runs, chosen, strict=True)]


def cases(seeds: Sequence[int]) -> "Iterator[tuple[Row, SiloCase]]":
    """The cases with their labels: the paper's silos first, which are shorter."""
    from silo2d.case.case import SiloCase

    for seed in seeds:
        for silo in SILOS:
            for outlet in OUTLETS:
                # A preset's outlet is not given again, so that its runs are those of other tables.
                name = silo + _PRESETS.get(outlet, "4")
                changes: Row = {"run.seed": seed}
                if outlet not in _PRESETS:
                    changes["silo.outlet"] = f"{outlet} mm"
                labels = {"silo": silo, "outlet_mm": outlet, "seed": seed}
                yield labels, SiloCase.load(name, changes)
        for outlet, enough in WIDE.items():
            changes = {
                "run.seed": seed,
                "silo.outlet": f"{outlet} mm",
                "run.max_time": f"{enough} s",
            }
            yield (
                {"silo": "wide", "outlet_mm": outlet, "seed": seed},
                SiloCase.load("beverloo", changes),
            )


def row_of(one: Row, case: "SiloCase") -> Row:
    """The row of one run of a sweep, its case with it.

    grain_diameter_m          of the disc of the mean area of the shapes: d
    bulk_density_kg_per_m2    surface density of grains times the packing fraction: rho_b
    rate_kg_per_s             of the steady part, with its standard error; None where the silo
                              clogged or too few left
    """
    row = {key: one.get(key) for key in ("silo", "outlet_mm", "seed", *_KEPT)}
    if one["state"] != "done":
        return row
    row |= {
        "grain_diameter_m": float(np.sqrt(4 * case.shapes.mean_area / np.pi)),
        "bulk_density_kg_per_m2": case.surface_density * one["packing_fraction"],
        **dict.fromkeys(["from_s", "until_s", "rate_per_s", "rate_kg_per_s", "error_kg_per_s"]),
    }
    steady = _steady(one)
    if steady is not None and "clogged" not in one["outcome"]:
        row |= {
            "from_s": steady.start,
            "until_s": steady.end,
            "rate_per_s": steady.rate,
            "rate_kg_per_s": steady.mass_flow,
            "error_kg_per_s": steady.mass_flow * steady.relative_error,
        }
    return row


def _steady(one: Row) -> Steady | None:
    times, mass = leavers(read_scene(one["run_folder"]))
    if one["silo"] != "wide":
        return steady_part(times, mass)
    first, last = (int(share * one["n_particles"]) for share in WIDE_PART)
    if len(times) <= last:
        return None
    start, end = float(times[first]), float(times[last])
    return part_between(times, mass, start, end, (end - start) / _PER_PART)


def report(rows: list[Row]) -> str:
    """Rates against outlet, and the constants of the law with their intervals."""
    from silo2d.reproduce.beverloo_report import report

    return report(rows)


def draw(rows: list[Row]) -> "Figure":
    """Rates with errors and the fitted laws with their bands: paper's silos left, wide right."""
    from silo2d.reproduce.beverloo_report import sheet

    return sheet(rows)
