"""Discharge rate against outlet: Beverloo's law in the paper's silos and in a wide one.

The paper's silos A and D with outlets of 100 to 200 mm (6 to 13 particles) are outside the law's
range: 300 mm are less than 2.5 outlets and 30 particles, the filling ends before the flow is steady
for long, and A is no flat floor. The wide silo of small particles (data/cases/beverloo.toml) is in
it.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.output.figure import BLUE, GREEN, VERMILION
from silo2d.measures.basics.particles import leavers
from silo2d.measures.curve import Steady, part_between, steady_part
from silo2d.reproduce.quantities.beverloo_law import Fit, fit_law
from silo2d.view.scene import read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from silo2d.case.case import SiloCase

Row = dict[str, Any]

SEEDS = 3
COLUMNS = None
SILOS = "A", "D"
OUTLETS = 100, 110, 120, 130, 140, 150, 175, 200  # mm
_PRESETS = {100: "3", 150: "4"}  # outlets that the paper has too
# Outlets of the wide silo [mm], and when [s] some more than 30 % of its particles have left.
WIDE = {34: 2.0, 40: 1.5, 46: 1.2, 52: 1.0, 58: 0.9}
WIDE_PART = 0.1, 0.3  # of the particles out, between which the wide silo's rate is taken
_PER_PART = 10  # windows in it, for the Fano factor
_KEPT = ["state", "reason", "outcome", "n_particles", "n_out", "packing_fraction", "time_step_s",
         "cpu_s", "mean_mass_flow_kg_per_s"]  # fmt: skip


NAMES = {"A": "silo A, 60 deg", "D": "silo D, flat", "wide": "wide silo, 5 mm particles"}

_NOTE = """\
W = rho_b sqrt(g) C (D - k d)^1.5 (Beverloo 1961, for a slot); W is the mass flow of the steady part
of the discharge, +- its standard error; d is the diameter of the disc of the mean area, rho_b the
surface density of the packing; intervals of 95 % from a bootstrap about the fit.
Silos A and D are OUTSIDE the law's range (300 mm wide, 6 to 13 particles an outlet, no long steady
flow, A no flat floor): there the law is a way to interpolate, and C and k mean little. In the wide
silo (210 mm, 7 to 11 particles an outlet, rate between 10 and 30 % out) it should hold."""


def run(
    *, out: Path, seeds: Sequence[int], workers: int | None, quiet: bool, **engine: Any
) -> list[Row]:
    """A row a run: silo A, D or wide, outlet, seed, and the rate of its steady part."""
    from granulab.campaign.sweeps.sweep import is_elsewhere
    from silo2d.run.sweep import run_cases

    chosen = list(cases(seeds))
    runs = run_cases(chosen, out=out, workers=workers, quiet=quiet, **engine)
    return [
        one if is_elsewhere(one) else row_of(one, case)
        for one, (_, case) in zip(runs, chosen, strict=True)
    ]


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
    bulk_density_kg_per_m2    surface density of particles times the packing fraction: rho_b
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


def known(rows: Sequence[Row]) -> list[Row]:
    """The rows that have a rate."""
    return [row for row in rows if row["state"] == "done" and row["rate_kg_per_s"] is not None]


def fits(rows: Sequence[Row]) -> dict[str, Fit | None]:
    """The law fitted to each silo's runs; None where there are too few outlets."""
    found: dict[str, Fit | None] = {}
    for silo in dict.fromkeys(row["silo"] for row in rows):
        own = [row for row in known(rows) if row["silo"] == silo]
        found[silo] = _fit(own) if own else None
    return found


def _fit(rows: Sequence[Row]) -> Fit | None:
    columns = (
        np.array([row[key] for row in rows], dtype=float)
        for key in ("outlet_mm", "rate_kg_per_s", "bulk_density_kg_per_m2", "error_kg_per_s")
    )
    outlet, rate, density, error = columns
    return fit_law(1e-3 * outlet, rate, density, rows[0]["grain_diameter_m"], error)


def report(rows: list[Row]) -> str:
    """A block a silo: its runs by outlet, and its fit."""
    blocks = []
    for silo, fit in fits(rows).items():
        own = [row for row in rows if row["silo"] == silo]
        lines = [NAMES[silo], f"  {'outlet':>7}  {'D/d':>5}  {'runs':>4}  rate"]
        lines += [_line(outlet, own) for outlet in sorted({row["outlet_mm"] for row in own})]
        blocks.append("\n".join([*lines, f"  {_constants(fit)}"]))
    failed = [
        f"{row['state']}: {row['silo']} {row['outlet_mm']} mm, seed {row['seed']}: {row['reason']}"
        for row in rows
        if row["state"] != "done"
    ]
    return "\n\n".join(filter(None, [*blocks, _NOTE, "\n".join(failed)]))


def _line(outlet: int, rows: Sequence[Row]) -> str:
    at = [row for row in rows if row["outlet_mm"] == outlet and row["state"] == "done"]
    flowing = known(at)
    if not flowing:
        size = f"{1e-3 * outlet / at[0]['grain_diameter_m']:5.1f}" if at else "     "
        return f"  {outlet:4} mm  {size}  {len(at):4}  no steady flow{_clogged(at)}"
    flow = [row["rate_kg_per_s"] for row in flowing]
    particles = np.mean([row["rate_per_s"] for row in flowing])
    if len(flow) > 1:
        error = np.std(flow, ddof=1) / np.sqrt(len(flow))
    else:
        error = flowing[0]["error_kg_per_s"]
    size = 1e-3 * outlet / flowing[0]["grain_diameter_m"]
    return (
        f"  {outlet:4} mm  {size:5.1f}  {len(flow):4}  {np.mean(flow):.3f} +- {error:.3f} kg/s, "
        f"{particles:.0f} particles/s{_clogged(at)}"
    )


def _clogged(rows: Sequence[Row]) -> str:
    n = sum("clogged" in row["outcome"] for row in rows)
    return f"; {n} of {len(rows)} clogged" if n else ""


def _constants(fit: Fit | None) -> str:
    if fit is None:
        return "fewer than three outlets: no fit"
    low, high = fit.c_interval
    least, most = fit.k_interval
    return (
        f"C = {fit.c:.2f} [{low:.2f}, {high:.2f}], k = {fit.k:.2f} [{least:.2f}, {most:.2f}]; "
        f"d = {1e3 * fit.size:.1f} mm, rho_b = {fit.density:.1f} kg/m2; "
        f"rates scatter about it by {100 * fit.scatter:.1f} % (rms)"
    )


_COLOURS = {"A": BLUE, "D": VERMILION, "wide": GREEN}


def draw(rows: list[Row]) -> "Figure":
    """Rates with errors and the fitted laws with their bands: paper's silos left, wide right."""
    from matplotlib.figure import Figure

    found = fits(rows)
    figure = Figure(figsize=(9.6, 4.6), layout="constrained")
    narrow, wide = figure.subplots(1, 2)
    for silo, fit in found.items():
        axes = wide if silo == "wide" else narrow
        _draw(axes, silo, [row for row in known(rows) if row["silo"] == silo], fit)
        clogged = [r["outlet_mm"] for r in rows
                   if r["silo"] == silo and "clogged" in str(r["outcome"])]  # fmt: skip
        if clogged:
            axes.plot(clogged, [0] * len(clogged), "x", color=_COLOURS[silo], clip_on=False,
                      label=f"silo {silo}, clogged")  # fmt: skip
    narrow.set_title("paper's silos, outlets added: outside the law's range", fontsize=9,
                     loc="left")  # fmt: skip
    wide.set_title("wide silo of small particles: within it", fontsize=9, loc="left")
    for axes in (narrow, wide):
        axes.set_xlabel("outlet D [mm]")
        axes.set_ylabel("mass flow W [kg/s]")
        axes.set_xlim(left=0)
        axes.set_ylim(bottom=0)
        axes.grid()
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="upper left", fontsize=8)
    return figure


def _draw(axes: "Axes", silo: str, rows: Sequence[Row], fit: Fit | None) -> None:
    colour = _COLOURS[silo]
    outlet = np.array([row["outlet_mm"] for row in rows], dtype=float)
    rate, error = (
        np.array([row[key] for row in rows], dtype=float)
        for key in ("rate_kg_per_s", "error_kg_per_s")
    )
    axes.errorbar(outlet, rate, error, fmt="o", color=colour, ms=4, capsize=2)
    label = NAMES[silo]
    if fit is not None:
        width = np.linspace(fit.k * fit.size, 1.05e-3 * outlet.max(), 200)
        axes.fill_between(1e3 * width, *fit.band(width), color=colour, alpha=0.18, lw=0)
        axes.plot(1e3 * width, fit.rate(width), color=colour, lw=1.3,
                  label=f"{label}: C = {fit.c:.2f}, k = {fit.k:.2f}")  # fmt: skip
    else:
        axes.plot([], [], "o", color=colour, label=label)
