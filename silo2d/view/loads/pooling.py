"""Loads of several runs as one: means, half widths of their intervals, largest peaks."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from granulab.campaign.output.statistics import mean_sd, quantile
from silo2d.measures.loads import COLOURS

_OVER_SEEDS = ("normal_pa", "shear_pa")


def combined(each: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """One set of numbers of several runs: means, half widths of their intervals, largest peaks.

    A stage is of the runs that have it: one that clogs early has no flow.
    """
    stages = {name: _stage(of_stage(each, name)) for name in stages_of(each)}
    known = [one for one in each if one["effective_friction_deg"] is not None]
    angles = [one["effective_friction_deg"] for one in known]
    low, high = (
        known[0][f"effective_friction_{end}_deg"] if known else None for end in ("low", "high")
    )
    if len(angles) > 1:
        half = half_width(angles)
        low, high = float(np.mean(angles)) - half, float(np.mean(angles)) + half
    return {
        "effective_friction_deg": float(np.mean(angles)) if angles else None,
        "effective_friction_low_deg": low,
        "effective_friction_high_deg": high,
        "at_rest_closure": max((one["at_rest_closure"] for one in each), key=abs),
        "prism_length_m": each[0]["prism_length_m"],
        "averaged_s": each[0]["averaged_s"],
        "stages": stages,
    }


def stages_of(each: Sequence[Mapping[str, Any]]) -> list[str]:
    """Names of the stages that any of some runs has, in their order."""
    longest = sorted((list(one["stages"]) for one in each), key=len, reverse=True)
    known = dict.fromkeys(name for names in longest for name in names)
    return [name for name in COLOURS if name in known]


def of_stage(each: Sequence[Mapping[str, Any]], name: str) -> list[dict[str, Any]]:
    """A stage of the runs that have it."""
    return [one["stages"][name] for one in each if name in one["stages"]]


def half_width(values: Sequence[float]) -> float:
    """Half width of the interval of a mean of 95 %, by Student's t; 0 of one value."""
    sample = mean_sd(values)
    return (
        quantile(sample.n - 1) * sample.sd / math.sqrt(sample.n) if sample.sd is not None else 0.0
    )


def _stage(each: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    balances = [one["balance"] for one in each if one["balance"]]
    walls = []
    for several in zip(*(one["walls"] for one in each), strict=True):
        wall = dict(several[0])
        for key in _OVER_SEEDS:
            rows = np.array([one[key] for one in several])
            wall[key] = rows.mean(axis=0).tolist()
            wall[f"{key.removesuffix('_pa')}_half_width_pa"] = [
                half_width(values) for values in rows.T.tolist()
            ] if len(rows) > 1 else None  # fmt: skip
        for key in ("rms_pa", "averaged_rms_pa"):
            known = [one[key] for one in several if one[key] is not None]
            wall[key] = np.sqrt((np.array(known) ** 2).mean(axis=0)).tolist() if known else None
        for key in ("peak_pa", "averaged_peak_pa"):
            known = [one[key] for one in several if one[key] is not None]
            wall[key] = np.max(known, axis=0).tolist() if known else None
        walls.append(wall)
    numbers = {
        key: mean_of([one[key] for one in balances]) for key in (balances[0] if balances else ())
    }
    if balances:
        numbers["closure"] = max((one["closure"] or 0.0 for one in balances), key=abs)
    return {
        "from_s": mean_of([one["from_s"] for one in each]),
        "until_s": mean_of([one["until_s"] for one in each]),
        "samples": sum(one["samples"] for one in each),
        "runs": len(each),
        "balance": numbers or None,
        "walls": walls,
    }


def mean_of(values: Sequence[float | None]) -> float | None:
    """Mean of the values that exist; None of none."""
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None
