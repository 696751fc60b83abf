"""Readings of the cycle: means over the packings of what a history of dissipation says."""

import dataclasses
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from damper3d.reproduce.quantities.cycle_steps import read
from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.layout import done

if TYPE_CHECKING:
    from pandas import DataFrame

Row = dict[str, Any]

FREQUENCY = 40.0  # [Hz]
POINT = ["orientation", "gamma"]

CYCLES = Quantities()


def readings(rows: Sequence[Row]) -> "DataFrame":
    """Mean readings over the packings, a line a point; columns of cycle_steps.Reading."""
    from pandas import DataFrame

    several = [
        {key: row[key] for key in POINT} | dataclasses.asdict(read(row))
        for row in done(rows)
        if row.get("cycle.dissipated")
    ]
    found = DataFrame(several, columns=None if several else POINT)
    return found.groupby(POINT, sort=False).mean().reset_index() if several else found


@CYCLES.quantity
def reading(found: "DataFrame", name: str) -> "DataFrame":
    """One number of cycle_steps.Reading at each point that has it."""
    known = found[[*POINT, name]] if name in found else found
    return known.rename(columns={name: "value"}).dropna()


def ideal_since(gamma: float) -> float | None:
    """Part of the cycle after which the ideal bouncing bed meets the other wall; None: never.

    With the onset of eqs 6.11 and 6.13 for the close packing.
    """
    from damper3d.case.case import DamperCase
    from damper3d.case.closed_forms import meeting_phase
    from damper3d.studies.predict.prediction import predict

    onset = predict(DamperCase.load("thesis")).clearances[1].onset(FREQUENCY)
    since = float(meeting_phase(gamma / onset)) / (2 * math.pi) if onset else math.nan
    return None if math.isnan(since) else since
