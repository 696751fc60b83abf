"""Readings of chapter 7: restitution from flights; collisions in force and acceleration."""

import math
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.case.case import GRAVITY
from damper3d.engine.records import cut
from damper3d.measures.counted import Cycles
from damper3d.measures.efficiency import efficiencies, reference_energy
from damper3d.measures.phases.bed_motion import contrast
from damper3d.measures.phases.criteria import STRUCK
from damper3d.view.shaker import signals
from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import mean_sd, noise_of_difference
from granulab.contact.files.datafile import shipped_rows
from granulab.contact.files.table import load_table

if TYPE_CHECKING:
    from pandas import DataFrame

Row = dict[str, Any]

SURFACES = {"smooth": 0.91, "printed": 0.83}  # restitution (Fig. 7.5)
FREQUENCY = 40.0  # [Hz] of Figs 7.12 to 7.16
POINT = ["surface", "frequency_hz", "gamma"]
SPEEDS = (0.2, 0.5, 1.0, 2.0)  # [m/s] of impacts of falls of 2 mm to 0.2 m; it yields at 7 m/s
DIAMETER = 5e-3  # [m]
# The spheres of a bed do not collide all at once: a shorter time is not told apart [cycles].
_SMOOTH = 0.05
_WINDOW = 5  # cycles that the thesis's simulations count

EXPERIMENTS = Quantities()


def signs_of(cycles: Cycles) -> Row:
    """Signs of a run's counted cycles in the force of its bed and its enclosure's acceleration.

    base_acceleration  size of the acceleration, over Gamma g, when the base is struck hardest
    base_force         force on the base then, over M g
    lid_...            likewise of the other end
    ends               how many ends reverse STRUCK of 2 M V a cycle
    unlike             |b - a|/(b + a) of the base's impulses in successive cycles
    count              efficiency as the thesis's simulations count it: eq. 6.7, five cycles
    """
    case, per = cycles.case, cycles.per_cycle
    _, acceleration, bed = signals(cycles)
    size = case.settings.motion.gamma * GRAVITY
    at = np.abs(acceleration.reshape(-1, per)) / size
    width = round(_SMOOTH * per)
    push = np.convolve(-bed, np.ones(width) / width, "same").reshape(-1, per)
    found: Row = {}
    for name, force in (("base", push), ("lid", -push)):
        hardest = force.argmax(axis=1)[:, None]
        found[f"{name}_acceleration"] = float(np.take_along_axis(at, hardest, 1).mean())
        found[f"{name}_force"] = float(force.max(axis=1).mean() / (case.mass * GRAVITY))
    impulse = np.stack([np.maximum(s * bed.reshape(-1, per), 0.0).mean(axis=1) for s in (-1, 1)])
    impulse *= case.period / (2.0 * case.mass * case.peak_speed)
    found["ends"] = int((impulse.mean(axis=1) >= STRUCK).sum())
    found["unlike"] = contrast(impulse[0])
    early = cut(cycles.counted, per, 0, min(_WINDOW, len(push)))
    etas = efficiencies(early, per, reference_energy(case.peak_speed, case.mass))
    return found | {"count": float(etas["contact_count"].mean())}


def readings(rows: Sequence[Row]) -> "DataFrame":
    """Means over the packings, a line a point: signs, efficiency_wall_work and its logs.

    Of a packing on which the walls do no work in the mean there is no logarithm.
    """
    from pandas import DataFrame

    several = [
        {key: value for key, value in row.items()
         if key in (*POINT, "efficiency_wall_work") or key.startswith("sign.")}
        for row in done(rows)
    ]  # fmt: skip
    if not several:
        return DataFrame(columns=POINT)
    groups = DataFrame(several).groupby(POINT, sort=False)
    logs = groups["efficiency_wall_work"].agg(
        lambda etas: [math.log(eta) for eta in etas if eta > 0]
    )
    return groups.mean().assign(logs=logs).reset_index()


@EXPERIMENTS.quantity
def sign(found: "DataFrame", name: str, relative: bool = False) -> "DataFrame":
    """One sign, or the efficiency, at each point that has it; over Gamma where `relative`."""
    column = name if name == "efficiency_wall_work" else f"sign.{name}"
    if column not in found:
        return found
    known = found[[*POINT, column]].rename(columns={column: "value"}).dropna()
    return known.assign(value=known["value"] / known["gamma"]) if relative else known


@EXPERIMENTS.quantity
def smooth_over_printed(found: "DataFrame") -> list[Row]:
    """Efficiency of smooth spheres over that of printed ones, at each point that has both.

    The geometric means over the packings, with the noise of their scatter (Welch).
    """
    if not len(found):
        return []
    known = {tuple(row[key] for key in POINT): mean_sd(row["logs"])
             for row in found.to_dict("records")}  # fmt: skip
    items = []
    for (surface, frequency, gamma), smooth in known.items():
        printed = known.get(("printed", frequency, gamma))
        if surface != "smooth" or printed is None:
            continue
        if smooth.mean is None or printed.mean is None:
            continue
        value, noise = math.exp(smooth.mean - printed.mean), noise_of_difference(smooth, printed)
        items.append({"frequency_hz": frequency, "gamma": gamma, "value": value,
                      "noise": math.nan if noise is None else value * noise})  # fmt: skip
    return items


@EXPERIMENTS.quantity
def share_of_smooth(found: "DataFrame") -> list[Row]:
    """Share of the points at which smooth spheres have the higher efficiency."""
    return _share_above_one(smooth_over_printed(found))


@EXPERIMENTS.quantity
def count_over_measured(found: "DataFrame") -> list[Row]:
    """Efficiency as simulations count it over that of the shaker's work, at each point."""
    measured = {tuple(row[key] for key in POINT): row["value"]
                for row in sign(found, "efficiency_wall_work").to_dict("records")}  # fmt: skip
    return [
        row | {"value": row["value"] / measured[tuple(row[key] for key in POINT)]}
        for row in sign(found, "count").to_dict("records")
    ]


@EXPERIMENTS.quantity
def share_overestimated(found: "DataFrame") -> list[Row]:
    """Share of the points at which the count is more than what a shaker measures."""
    return _share_above_one(count_over_measured(found))


def _share_above_one(items: list[Row]) -> list[Row]:
    above = sum(item["value"] > 1.0 for item in items)
    return [{"value": above / len(items), "above": above, "points": len(items)}] if items else []


@cache
def flights() -> list[Row]:
    """T_23/T_12 (eq. 7.5) of spheres that fall on a wall, at each speed of impact 2.

    Gaps are from touch to touch: a flight of 2 v/g and the contact before it.
    """
    from damper3d.studies.single_contact.spheres.impact import Impact, run

    acrylic = load_table("acrylic").material("acrylic")
    found = []
    for surface, e in SURFACES.items():
        for speed in SPEEDS:
            gaps = []
            for arriving in (speed / e, speed):
                one = run(Impact(acrylic, acrylic, radius=0.5 * DIAMETER, speed=arriving,
                                 restitution=e))  # fmt: skip
                leaving = one.normal_restitution * arriving
                gaps.append(one.contact_time_s + 2.0 * leaving / GRAVITY)
            found.append({"surface": surface, "speed": speed, "value": gaps[1] / gaps[0], "law": e})
    return found


@EXPERIMENTS.quantity
def bounce(_found: "DataFrame") -> list[Row]:
    """Restitution from flights; no run of the table is needed."""
    return flights()


@EXPERIMENTS.quantity
def of_simulations(_found: "DataFrame") -> list[Row]:
    """Restitution of acrylic on acrylic in the simulations."""
    pair = load_table("acrylic").pair("acrylic", "acrylic")
    assert pair.restitution is not None
    return [{"value": pair.restitution.value}]


@EXPERIMENTS.quantity
def roughness(_found: "DataFrame", over: float = 1e-6) -> list[Row]:
    """Mean roughness of each surface over a length [m], from Table 7.1."""
    table = shipped_rows("published", "surface_roughness")
    return [
        {"path": name, "value": 1e-6 * float(np.mean([float(row[name]) for row in table])) / over}
        for name in ("smooth", "perpendicular", "on_ridge")
    ]
