"""Quantities of the displacement profiles: how deep their V is, how they scatter, what is left."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.layout import done

if TYPE_CHECKING:
    from pandas import DataFrame

Row = dict[str, Any]

_NEAR, _AWAY = 0.1, 0.2  # [m] layers below count as near the exit, above as away from it

PROFILES = Quantities()


def profiles(rows: Sequence[Row]) -> "DataFrame":
    """The rows of runs that came to an end, with every column that any has."""
    from pandas import DataFrame

    known = done(rows)
    return DataFrame(known, columns=None if known else ["silo"])


def in_mm(values: Sequence[float]) -> str:
    """Mean and sample standard deviation of lengths [m], in mm; "-" of none."""
    if len(values) == 0:
        return "-"
    spread = f" +- {1e3 * np.std(values, ddof=1):.0f}" if len(values) > 1 else ""
    return f"{1e3 * np.mean(values):.0f}{spread}"


@PROFILES.quantity
def part_of_lines_deeper(found: "DataFrame") -> list[Row]:
    """Part of the lines of each silo that are deeper in the middle by more than half a particle.

    lines, deep: their numbers; higher: how many are higher there by as much.
    """
    items = []
    for silo, own in found.groupby("silo", sort=False):
        known = own[(own["time_s"] > 0) & own["depth_m"].notna()]
        if len(known):
            deep = int((known["depth_m"] > known["grain_size_m"] / 2).sum())
            higher = int((known["depth_m"] < -known["grain_size_m"] / 2).sum())
            items.append({"silo": silo, "value": deep / len(known), "lines": len(known),
                          "deep": deep, "higher": higher})  # fmt: skip
    return items


@PROFILES.quantity
def scatter_by_height(found: "DataFrame") -> list[Row]:
    """Mean scatter of displacements about the line, near the exit and away from it [m].

    near, away: both in mm, with their standard deviations over layers.
    """
    items = []
    for silo, own in found.groupby("silo", sort=False):
        moving = own[(own["time_s"] > 0) & own["scatter_m"].notna()]
        near = moving.loc[moving["level_m"] < _NEAR, "scatter_m"].tolist()
        away = moving.loc[moving["level_m"] > _AWAY, "scatter_m"].tolist()
        shown = {"silo": silo, "near": in_mm(near), "away": in_mm(away)}
        items += [
            shown | {"height": name, "value": np.mean(values)}
            for name, values in (("near", near), ("away", away))
            if values
        ]
    return items


@PROFILES.quantity
def particles_left(found: "DataFrame") -> list[Row]:
    """Particles that stay in the silo, of each run; particles: how many there are in the mean.

    empty: how many runs of the silo are empty.
    """
    items: list[Row] = []
    for silo, own in found.groupby("silo", sort=False):
        runs = own.drop_duplicates("seed", keep="last")
        left = (runs["n_particles"] - runs["n_out"]).tolist()
        shown = {"silo": silo, "particles": runs["n_particles"].mean(), "empty": left.count(0)}
        items += [shown | {"value": n} for n in left]
    return items


def deeper_in_second(first: "DataFrame", second: "DataFrame") -> np.ndarray:
    """Difference of the depths of the V [m] at each layer and time that both silos have one."""
    means = [one[one["time_s"] > 0].groupby(["time_s", "layer"])["depth_m"].mean()
             for one in (first, second)]  # fmt: skip
    differences: np.ndarray = (means[1] - means[0]).dropna().to_numpy()
    return differences
