"""Effect of disorder: A4 and A3 with parameters that are all alike, or drawn from pair to pair.

The authors' open question (Granular Matter 15 (2013) 811, sec. 5): friction, stiffness and
restitution scatter from sample to sample, and the simulation has one value of each. The three
variants of a seed share its packing and its time step.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from silo2d.reproduce.runs import run_of_cases
from silo2d.reproduce.variants import draw_variants, report_variants

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Labelled
    from silo2d.reproduce import Row

SEEDS = 20
COLUMNS = ("silo", "disorder", "outcome", "discharge_time_s", "t90_s")

_SILOS = "A4", "A3"
_DISORDERS = "none", "particle", "pair"
_STEP = "3.5 us"  # stable for the stiffest pair that is drawn, up to 3.6 us


def cases(seeds: Sequence[int]) -> "list[Labelled]":
    """Both silos, without disorder, per particle and per pair, each with all seeds."""
    from granulab.campaign.sweeps.sweep import over_seeds
    from silo2d.case.case import SiloCase

    return [
        labelled
        for silo in _SILOS
        for per in _DISORDERS
        for labelled in over_seeds(
            {"silo": silo, "disorder": per},
            SiloCase.load(silo, {"disorder.per": per, "run.time_step": _STEP}),
            seeds,
        )
    ]


run = run_of_cases(cases)


def _variant(row: "Row") -> str:
    return {"none": "all alike"}.get(row["disorder"], f"per {row['disorder']}")


def report(rows: "list[Row]") -> str:
    """Times and counts of each variant, compared with those without disorder."""
    return report_variants(rows, _variant)


def draw(rows: "list[Row]") -> "Figure":
    """Times and shares of each variant."""
    return draw_variants(rows, _variant)
