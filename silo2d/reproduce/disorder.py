"""What disorder does: A4 and A3 with parameters that are all alike, or drawn from pair to pair.

The authors' open question (Granular Matter 15 (2013) 811, sec. 5): friction, stiffness and
restitution scatter from sample to sample, and the simulation has one value of each. The three arms
of a seed share its packing and its time step.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from silo2d.reproduce.variants import draw_arms, report_arms

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from silo2d.reproduce import Row

SEEDS = 20

_SILOS = "A4", "A3"
_ARMS = "none", "particle", "pair"
_STEP = "3.5 us"  # stable for the stiffest pair that is drawn, up to 3.6 us


def run(
    *, out: Path, seeds: Sequence[int], workers: int | None, quiet: bool, **engine: Any
) -> "list[Row]":
    """Both silos, without disorder, per particle and per pair, each with all seeds."""
    from granulab.campaign.sweeps.sweep import over_seeds
    from silo2d.case.case import SiloCase
    from silo2d.reproduce.runs import run_all

    cases = [
        labelled
        for silo in _SILOS
        for per in _ARMS
        for labelled in over_seeds(
            {"silo": silo, "disorder": per},
            SiloCase.load(silo, {"disorder.per": per, "run.time_step": _STEP}),
            seeds,
        )
    ]
    return run_all(cases, out=out, workers=workers, quiet=quiet, **engine)


def _arm(row: "Row") -> str:
    return {"none": "all alike"}.get(row["disorder"], f"per {row['disorder']}")


def report(rows: "list[Row]") -> str:
    """Times and counts of each arm beside those without disorder."""
    return report_arms(rows, _arm)


def draw(rows: "list[Row]") -> "Figure":
    """Times and shares of each arm."""
    return draw_arms(rows, _arm)
