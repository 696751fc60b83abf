"""Effect of the filling and of the door: A3 and B3 poured in three ways, opened in two.

The paper pours without friction, all at once, and takes the door away at once. Here also with the
friction of the discharge, and without friction in five layers of 95 mm; and with a door that is
drawn to the right at 0.5 m/s, which takes 0.2 s. Times count from the start of its motion.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from silo2d.reproduce.runs import run_of_cases
from silo2d.reproduce.variants import draw_variants, report_variants

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Labelled
    from silo2d.reproduce import Row

SEEDS = 20
COLUMNS = ("silo", "filling", "door", "packing_fraction", "outcome", "discharge_time_s", "t90_s")

_SILOS = "A3", "B3"
_FILLINGS: dict[str, dict[str, Any]] = {
    "frictionless": {},
    "friction": {"fill.friction": True},
    "layers": {"fill.layer": "95 mm"},
}
_DOORS: dict[str, dict[str, Any]] = {"at once": {}, "drawn": {"run.door_speed": "0.5 m/s"}}


def cases(seeds: Sequence[int]) -> "list[Labelled]":
    """Both silos, each filling with each door, each with all seeds."""
    from granulab.campaign.sweeps.sweep import over_seeds
    from silo2d.case.case import SiloCase

    return [
        labelled
        for silo in _SILOS
        for filling, poured in _FILLINGS.items()
        for door, opened in _DOORS.items()
        for labelled in over_seeds(
            {"silo": silo, "filling": filling, "door": door},
            SiloCase.load(silo, poured | opened),
            seeds,
        )
    ]


run = run_of_cases(cases)


def _variant(row: "Row") -> str:
    return f"{row['filling']}, door {row['door']}"


def report(rows: "list[Row]") -> str:
    """Times, counts and packing fractions of each variant, compared with the paper's way."""
    return f"{report_variants(rows, _variant)}\n\n{_packings(rows)}"


def _packings(rows: "list[Row]") -> str:
    """The packing fraction that each filling leaves, mean and standard deviation."""
    from granulab.campaign.output.layout import columns, done
    from granulab.campaign.output.statistics import mean_sd

    lines = []
    for silo in dict.fromkeys(row["silo"] for row in rows):
        for filling in _FILLINGS:
            own = {
                row["seed"]: row["packing_fraction"]
                for row in done(rows)
                if (row["silo"], row["filling"]) == (silo, filling)
            }
            found = mean_sd(list(own.values()))
            if found.mean is not None:
                spread = "" if found.sd is None else f" +- {found.sd:.4f}"
                lines.append([silo, filling, f"{found.mean:.4f}{spread} ({found.n})"])
    return columns(["silo", "filling", "packing fraction"], lines)


def draw(rows: "list[Row]") -> "Figure":
    """Times and shares of each variant."""
    return draw_variants(rows, _variant)
