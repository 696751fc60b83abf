"""Sizes of numbers that the thesis prints: fill of toroids, Rayleigh's step, impacts that yield."""

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

from damper3d.case.closed_forms import PACKINGS, bouncing_bed_onset, effective_clearance
from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import mean_sd, noise_of_difference
from granulab.contact.timestep import rayleigh_time_step

Row = dict[str, Any]

PRINTED = Quantities()

# Where the map has its fastest impacts: orientation, height [mm], frequency [Hz], Gamma.
FASTEST = (
    ("vertical", 40, 20.0, 40.0),
    ("vertical", 40, 20.0, 60.0),
    ("vertical", 40, 20.0, 100.0),
    ("vertical", 40, 40.0, 100.0),
    ("vertical", 55, 20.0, 100.0),
    ("horizontal", 40, 20.0, 100.0),
)
POINT = ("orientation", "height_mm", "frequency_hz", "gamma")
LAWS = {"constant": False, "yielding": True}  # restitution: [law] yielding

_COUNT, _RADIUS = 110, 3.5e-3  # toroids and their equal-volume radius [m] (sec. 8.3)
_DIAMETER = _LENGTH = 0.04  # [m] of the enclosure
# Table 6.2: Young's modulus [Pa], Poisson's ratio, density [kg/m3], and half of their last digit.
_ACRYLIC = ((3.3e9, 0.05e9), (0.37, 0.005), (1190.0, 5.0))


def points() -> list[Row]:
    """The labels of each point."""
    return [
        {"law": law, **dict(zip(POINT, point, strict=True))} for point in FASTEST for law in LAWS
    ]


def toroid_fill(count: float = _COUNT, radius: float = _RADIUS) -> float:
    """Fill ratio (eq. 6.1) of so many toroids of an equal-volume radius [m] in 40 mm x 40 mm."""
    return count * 4 / 3 * radius**3 / (0.25 * _DIAMETER**2 * _LENGTH)


@PRINTED.quantity
def fill_of_toroids(_rows: Sequence[Row]) -> list[Row]:
    """Fill ratio of 110 toroids, and what number and radius have the printed 0.38."""
    own = toroid_fill()
    return [{"value": own, "number": _COUNT * 0.38 / own,
             "radius_mm": 1e3 * _RADIUS * (0.38 / own) ** (1 / 3)}]  # fmt: skip


@PRINTED.quantity
def onset_of_fill(_rows: Sequence[Row], fill: float) -> list[Row]:
    """Gamma of eq. 6.11 with another fill ratio over that with the toroids' own, per packing."""
    items = []
    for name, packing in PACKINGS.items():
        onsets = [
            float(bouncing_bed_onset(40.0, effective_clearance(one, _LENGTH, packing)))
            for one in (fill, toroid_fill())
        ]
        items.append({"packing": name, "value": onsets[0] / onsets[1], "printed": onsets[0],
                      "own": onsets[1]})  # fmt: skip
    return items


@PRINTED.quantity
def rayleigh(_rows: Sequence[Row], radius_mm: float, rounding: float) -> list[Row]:
    """Rayleigh's step [us] (eq. 3.31), and between which it lies by the digits of Table 6.2.

    rounding    [us] half of the last digit of the printed step, for the width of its interval
    Also the modulus [GPa] and the density [kg/m3] that alone would have the printed 8.4 us.
    """
    radius = 1e-3 * radius_mm
    ends = [(value - half, value + half) for value, half in _ACRYLIC]
    steps = [1e6 * rayleigh_time_step(radius, d, e, nu) for e, nu, d in product(*ends)]
    (e, _), (nu, _), (d, _) = _ACRYLIC
    own = 1e6 * rayleigh_time_step(radius, d, e, nu)
    part = (8.4 / own) ** 2
    return [{"value": own, "low": min(steps), "high": max(steps), "their_low": 8.4 - rounding,
             "their_high": 8.4 + rounding, "modulus": e / part / 1e9,
             "density": d * part}]  # fmt: skip


@PRINTED.quantity
def share_of_rayleigh(_rows: Sequence[Row], radius_mm: float) -> list[Row]:
    """The thesis's step of 1 us over Rayleigh's."""
    (e, _), (nu, _), (d, _) = _ACRYLIC
    return [{"value": 1e-6 / rayleigh_time_step(1e-3 * radius_mm, d, e, nu)}]


@PRINTED.quantity
def fastest(rows: Sequence[Row], law: str) -> list[Row]:
    """Fastest particle-particle impact over the yield velocity of each point, of all packings.

    Also which part of the impacts lies beyond the yield velocity, in the mean.
    """
    items = []
    for point in FASTEST:
        own = _at(rows, point, law)
        if own:
            ratios = [row["max_impact_over_yield_velocity.particle_particle"] for row in own]
            beyond = mean_sd([row["impacts_beyond_yield.particle_particle"] for row in own]).mean
            items.append(dict(zip(POINT, point, strict=True))
                         | {"value": max(ratios), "beyond": beyond})  # fmt: skip
    return items


@PRINTED.quantity
def change_by_yielding(rows: Sequence[Row], column: str) -> list[Row]:
    """Relative change of a column where restitution falls above yield, with its noise."""
    items = []
    for point in FASTEST:
        constant, falling = (
            mean_sd([row[column] for row in _at(rows, point, law)]) for law in LAWS
        )
        if not constant.mean or falling.mean is None:
            continue
        noise = noise_of_difference(falling, constant)
        items.append(dict(zip(POINT, point, strict=True)) | {
            "constant": constant.mean, "yielding": falling.mean,
            "value": falling.mean / constant.mean - 1,
            "noise": math.nan if noise is None else noise / constant.mean,
        })  # fmt: skip
    return items


def _at(rows: Sequence[Row], point: tuple[str, int, float, float], law: str) -> list[Row]:
    labels = {"law": law, **dict(zip(POINT, point, strict=True))}
    return [row for row in done(rows) if labels.items() <= row.items()]
