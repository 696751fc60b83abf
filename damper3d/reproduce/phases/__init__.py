"""Phases: what the thesis says of its phase maps (Figs 6.2, 6.3), judged by computed names."""

from typing import Any

from damper3d.reproduce.panels import run_of_panels
from damper3d.reproduce.phases.points import panels

Row = dict[str, Any]

SEEDS = 1
COLUMNS = (
    "orientation", "height_mm", "cycles", "frequency_hz", "gamma", "efficiency",
    "efficiency_wall_work", "energy_closure", "phase", "phase_measures.",
)  # fmt: skip

run = run_of_panels(panels)


def report(rows: list[Row]) -> str:
    return f"{len(rows)} rows"
