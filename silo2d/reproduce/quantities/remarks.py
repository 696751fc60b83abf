"""Quantities of what the paper remarks: particles of arches, pauses of the flow, overlaps."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.layout import Row, done
from silo2d.case.case import GRAVITY

REMARKS = Quantities()


def pauses(out_times: Sequence[float] | np.ndarray, size: float) -> list[float]:
    """Times [s] between particles that leave, of those in which one falls farther than its size.

    out_times (n,) [s], ascending; size [m]. Shorter ones are the grain of a stream that goes on.
    Only those that begin and end between 10 and 90 % of the particles that leave count.
    """
    n = len(out_times)
    flow = out_times[-(-n // 10) - 1 : -(-9 * n // 10)] if n else ()
    longer = np.sqrt(2 * size / GRAVITY)
    return [later - time for time, later in pairwise(flow) if later - time > longer]


@REMARKS.quantity
def arch_particles(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Particles of the arch of each clogged run in which one was found."""
    return [
        {"silo": row["silo"], "outlet": row["outlet_mm"], "value": row["arch_particles"]}
        for row in done(rows)
        if row["arch_particles"] is not None
    ]


@REMARKS.quantity
def pauses_of_silo(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Pauses of all runs of a silo; runs: how many, with: in how many; longest [s], 0 of none."""
    items = []
    known = [row for row in done(rows) if row["pauses"] is not None]
    for silo in dict.fromkeys(row["silo"] for row in known):
        own = [row for row in known if row["silo"] == silo]
        items.append(
            {
                "silo": silo,
                "outlet": own[0]["outlet_mm"],
                "value": sum(row["pauses"] for row in own),
                "runs": len(own),
                "with": sum(row["pauses"] > 0 for row in own),
                "longest": max(row["longest_pause_s"] or 0.0 for row in own),
            }
        )
    return items


@REMARKS.quantity
def largest_overlap(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Largest overlap of all runs of a stiffness kn [N/mm], in mm."""
    known = [row for row in done(rows) if row["largest_overlap_m"] is not None]
    return [
        {"kn": kn, "value": 1e3 * max(r["largest_overlap_m"] for r in known if r["kn"] == kn)}
        for kn in dict.fromkeys(row["kn"] for row in known)
    ]
