"""Rows of a sweep of a made simulator: speed, a time that not all have, runs that get stuck."""

from typing import Any

from granulab.campaign.sweeps.report.axes import Varied
from granulab.campaign.sweeps.report.comparison import Comparison
from granulab.campaign.sweeps.report.quantities import Ending, Number, Quantities

SPEED = Number("speed", "speed", "m/s", "more", interval="speed_interval")
TIME = Number("time", "time", "s", "less", counts=lambda row: not row["stuck"])
STUCK = Ending("stuck", "stuck", lambda row: row["stuck"], named=True)
LATE = Ending("late", "late", lambda row: row.get("late", False))
MADE = Quantities((SPEED, TIME), (STUCK, LATE), ("stuck", "speed"))

A = Varied("a.width_m", "a.width", "mm", 1e-3)
B = Varied("b.count", "b.count")
CASE = Varied("case", "case")
DRAWN = Varied("c.mu", "c.mu", drawn=True)


def run(speed: float | None, seed: int = 1, **fields: Any) -> dict[str, Any]:
    """A run that came to an end; labels among the fields."""
    row = {"speed": speed, "time": None if speed is None else 1.0 / speed, "stuck": False}
    ends = {"run_folder": f"/runs/{seed}", "state": "done", "reason": "", "cpu_s": 2.0}
    return {**row, **ends, "seed": seed, **fields}


def lost(state: str = "failed", seed: int = 1, **labels: Any) -> dict[str, Any]:
    """A run that did not."""
    return {**labels, "seed": seed, "state": state, "reason": "why", "run_folder": "/runs/lost"}


def seeds(speeds: list[float | None], **labels: Any) -> list[dict[str, Any]]:
    """Runs of one combination."""
    return [run(speed, seed, **labels) for seed, speed in enumerate(speeds, 1)]


def compared(varied: list[Varied], rows: list[dict[str, Any]], quantities: Quantities = MADE):
    return Comparison.of("made", varied, quantities, rows)
