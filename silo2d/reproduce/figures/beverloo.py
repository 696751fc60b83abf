"""Rates against outlet as a figure, with the fitted laws and their bands."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.output.figure import BLUE, GREEN, VERMILION
from silo2d.reproduce.beverloo import NAMES, known
from silo2d.reproduce.quantities.beverloo_law import Fit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = dict[str, Any]

_COLOURS = {"A": BLUE, "D": VERMILION, "wide": GREEN}


def draw_rates(rows: Sequence[Row], found: Mapping[str, Fit | None]) -> "Figure":
    """The paper's silos on the left, labelled as outside the range; the wide one on the right."""
    from matplotlib.figure import Figure

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
    wide.set_title("wide silo of small grains: within it", fontsize=9, loc="left")
    for axes in (narrow, wide):
        axes.set_xlabel("outlet D [mm]")
        axes.set_ylabel("mass flow W [kg/s]")
        axes.set_xlim(left=0)
        axes.set_ylim(bottom=0)
        axes.grid(color="#e6e3dc", lw=0.7)
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
