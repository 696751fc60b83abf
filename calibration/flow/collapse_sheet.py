"""Front and free surface of a column that spreads: a table and a picture."""

from pathlib import Path
from typing import TYPE_CHECKING

from calibration.flow.collapse import Collapse
from calibration.flow.report import write_rows
from granulab.campaign.output.figure import BLUE, GREEN, INK, VERMILION, headline, write_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_collapse(seen: Collapse, folder: Path, name: str) -> list[Path]:
    """collapse-NAME.csv and .png in a folder; their paths."""
    unit = seen.unit
    columns = {"time_s": seen.time} | {
        f"{what}_{unit}": series
        for what, series in (
            ("left", seen.left), ("right", seen.right), ("half_width", seen.half_width),
            ("surface", seen.surface),
        )
    }  # fmt: skip
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    table = write_rows(folder / f"collapse-{name}.csv", rows)
    return [table, write_figure(folder / f"collapse-{name}.png", lambda: _sheet(seen, name))]


def _sheet(seen: Collapse, name: str) -> "Figure":
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.2, 4.6), layout="constrained")
    headline(figure, f"{name}: front against time")
    ends, half = figure.subplots(1, 2)
    ends.plot(seen.time, seen.left, color=BLUE, label="left end")
    ends.plot(seen.time, seen.right, color=VERMILION, label="right end")
    ends.plot(seen.time, seen.surface, color=GREEN, lw=1, label="highest place, from the top")
    half.plot(seen.time, seen.half_width, ".-", color=INK, ms=3, lw=0.8)
    ends.set_ylabel(f"place in the picture [{seen.unit}]")
    half.set_ylabel(f"half of the width [{seen.unit}], +- {seen.sigma:.2g}")
    ends.legend(fontsize=8)
    for axes in (ends, half):
        axes.set_xlabel(f"time from the first frame [s], at {seen.rate:g} frames/s")
    return figure
