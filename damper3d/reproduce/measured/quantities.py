"""Quantities of shaken and dropped beds that others measured, with the intervals of ours."""

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np

from damper3d.case.closed_forms import collect_and_collide
from damper3d.case.parts import GRAVITY
from damper3d.measures.phases.particle_motion import SEEN
from damper3d.reproduce.measured.beds import (
    AT_REST,
    BEDS,
    clearance_onset,
    onset_of_mean,
)
from damper3d.studies.field.fall import falls
from damper3d.studies.field.table import Field
from damper3d.studies.map.grid import MapResult
from damper3d.studies.map.peaks import highest
from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import mean_sd, quantile
from granulab.contact.files.datafile import shipped_rows

Row = dict[str, Any]
Rows = Sequence[Row]

MEASURED = Quantities()

MOVES = 0.01  # efficiency (of the walls' work) from which a bed moves in its enclosure
UNLIKE = 0.1  # |b - a|/(b + a) of what successive cycles dissipate, from which they differ
STILL = 0.02  # height of a rebound over the drop, below which there is none
FAR = 1.5  # times clearance/pi, beyond which even one body takes less than 0.9 of the most
CONVECTING = ("leidenfrost", "buoyancy_convection", "convection")  # sec. 6.4.3.3, first to last


@cache
def published() -> dict[str, tuple[float, float]]:
    """Findings of others: an interval by the name of a quantity."""
    table = shipped_rows("published", "shaken_beds")
    return {row["quantity"]: (float(row["low"]), float(row["high"])) for row in table}


Found = dict[str, list[Row]]  # rows that are done, by the name of the bed


def found_in(rows: Rows) -> Found:
    """The rows that are done of each bed that has some."""
    found: Found = {}
    for row in done(rows):
        found.setdefault(row["bed"], []).append(row)
    return found


@MEASURED.quantity
def of_beds(found: Found) -> list[Row]:
    """Each quantity that can be had: name, value, low and high; also their_low and their_high."""
    return [item for item in sought(found) if "value" in item]


def sought(found: Found) -> list[Row]:
    """The same of all beds that were run, without value, low and high where the grid has none."""
    items = []
    for name, beds, measure in _MEASURES:
        theirs = dict(zip(("their_low", "their_high"), published()[name], strict=True))
        for bed in beds:
            if bed in found:
                own = dict(zip(("value", "low", "high"), measure(found[bed]) or (), strict=False))
                items.append({"name": name, "bed": bed, **own, **theirs})
    return items


@MEASURED.quantity
def rebounds(found: Found, at_least: float) -> list[Row]:
    """Rebound over the drop of each dropped enclosure with so much in it, the highest of all."""
    items = []
    for bed, own in found.items():
        heights = [row["rebound"] for row in own if row.get("rebound") is not None
                   and row["at"] >= at_least]  # fmt: skip
        if heights:
            items.append({"bed": bed, "value": max(heights)})
    return items


@MEASURED.quantity
def over_one_body(found: Found, amplitudes: Sequence[float]) -> list[Row]:
    """Efficiency without gravity over that of one body without rebound, by A over clearance/pi.

    The amplitude is over the mean of those for a loose and a close packing.
    """
    own = found.get("weightless")
    if not own:
        return []
    middle = onset_of_mean()
    result = MapResult.of(own)
    items = []
    for wanted in amplitudes:
        k = int(np.argmin(np.abs(np.log(result.gamma / (wanted * middle)))))
        part = float(result.gamma[k] / middle)
        ideal = float(collect_and_collide(part))
        items.append({"part": part, "value": float(result.efficiency[k]) / ideal})
    return items


Interval = tuple[float, float, float]  # value, low, high


def _threshold(
    rows: Rows, passed: Callable[[Row], bool], up_to: float = math.inf
) -> Interval | None:
    """From where on every run of a packing passes: the middle, and what the packings enclose.

    Runs above `up_to` are not looked at. None where the first or the last point leaves it open.
    """
    ends = []
    for seed in sorted({row["seed"] for row in rows}):
        own = sorted((row for row in rows if row["seed"] == seed and row["at"] <= up_to),
                     key=lambda row: row["at"])  # fmt: skip
        failed = [row["at"] for row in own if not passed(row)]
        beyond = [row["at"] for row in own if not failed or row["at"] > failed[-1]]
        if not failed or not beyond:
            return None
        ends.append((failed[-1], beyond[0]))
    low, high = min(low for low, _ in ends), max(high for _, high in ends)
    return 0.5 * (low + high), low, high


def _lift_off(rows: Rows) -> Interval | None:
    return _threshold(rows, lambda row: row["efficiency_wall_work"] > MOVES)


def unlike(row: Row) -> float:
    """|b - a|/(b + a) of what two successive counted cycles dissipate, in the mean."""
    each = row["efficiency_per_cycle"][row["discarded"] :]
    first, second = np.array(each[0::2]), np.array(each[1::2])
    return float(np.mean(np.abs(second - first) / (second + first)))


def _doubling(rows: Rows) -> Interval | None:
    return _threshold(rows, lambda row: unlike(row) > UNLIKE)


def convects(row: Row) -> bool:
    """True where the phase is one that the thesis calls convection-based."""
    return row["phase"] in CONVECTING


def _rolls(rows: Rows) -> Interval | None:
    return _threshold(rows, lambda row: row["phase_measures.circulation"] >= SEEN)


def _suspended(rows: Rows) -> Interval | None:
    return _threshold(rows, convects)


def _transition(rows: Rows) -> Interval | None:
    """Amplitude over clearance/pi from which half of the most is dissipated."""
    found = _threshold(rows, lambda row: row["efficiency"] > 0.5, up_to=FAR * onset_of_mean())
    return None if found is None else _over_clearance(*found)


def _optimum(rows: Rows) -> Interval | None:
    """Amplitude of the largest mean efficiency over clearance/pi, in the bracket of its peak.

    The curve rises at once and falls slowly, so that the vertex of a parabola would lie too high.
    """
    result = MapResult.of(rows)
    top = highest(result.peaks(float(result.frequency[0])))
    if top is None:
        return None
    return _over_clearance(float(result.gamma[np.argmax(result.efficiency)]), *top.bracket)


def _over_clearance(value: float, low: float, high: float) -> Interval:
    """Gammas over that of clearance/pi; the interval whichever packing the clearance has."""
    return value / onset_of_mean(), low / clearance_onset("close"), high / clearance_onset("loose")


def _power(quantity: str) -> Callable[[Rows], Interval | None]:
    """The power with which a part of the effective mass falls with Gamma."""

    def power(rows: Rows) -> Interval | None:
        result = MapResult.of(rows)
        in_phase, out_of_phase = (
            result.mean(f"effective_mass.{part}_kg") for part in ("in_phase", "out_of_phase")
        )
        field = Field.of(result.frequency, result.gamma, in_phase - 1j * out_of_phase,
                         rows[0]["mass_kg"])  # fmt: skip
        for fall in falls(field):
            if fall.quantity == quantity:
                return (fall.exponent, fall.exponent - fall.half_width,
                        fall.exponent + fall.half_width)  # fmt: skip
        return None

    return power


def rises(rows: Rows) -> list[tuple[float, float, float]]:
    """Logarithms of peak velocity, number and rise of the centre of mass of each run that rises."""
    rest: dict[int, list[float]] = {}
    for row in rows:
        if row["at"] == AT_REST:
            rest.setdefault(row["count"], []).append(row["bed_height_m"])
    found = []
    for row in rows:
        if row["at"] > 1.0 and row["count"] in rest:
            rise = row["bed_height_m"] - (mean_sd(rest[row["count"]]).mean or 0.0)
            speed = row["gamma"] * GRAVITY / (2 * math.pi * row["frequency_hz"])
            if rise > 0:
                found.append((math.log(speed), math.log(row["count"]), math.log(rise)))
    return found


def _rise(which: int) -> Callable[[Rows], Interval | None]:
    """Power of the rise with the velocity (0) or the number (1), by least squares of both."""

    def power(rows: Rows) -> Interval | None:
        table = np.array(rises(rows))
        freedom = len(table) - 3
        if freedom < 1:
            return None
        design = np.column_stack([table[:, :2], np.ones(len(table))])
        inverse = np.linalg.pinv(design.T @ design)
        powers = inverse @ design.T @ table[:, 2]
        scatter = float(np.sum((table[:, 2] - design @ powers) ** 2)) / freedom
        half = quantile(freedom) * math.sqrt(scatter * inverse[which, which])
        value = float(powers[which])
        return value, value - half, value + half

    return power


def _no_rebound(rows: Rows) -> Interval | None:
    return _threshold(rows, lambda row: row["rebound"] < STILL)


_SHAKEN_OPEN = ("no lid, 80 Hz", "no lid, 160 Hz")
_MEASURES: tuple[tuple[str, tuple[str, ...], Callable[[Rows], Interval | None]], ...] = (
    ("lift_off", ("vertical",), _lift_off),
    ("sliding", ("horizontal", "horizontal, rolling"), _lift_off),
    ("doubling", ("flying",), _doubling),
    ("convection", ("rolls",), _rolls),
    ("leidenfrost", ("suspended, 80 Hz", "suspended, 160 Hz"), _suspended),
    ("transition", ("weightless",), _transition),
    ("optimum", ("weightless",), _optimum),
    ("in_phase", _SHAKEN_OPEN, _power("in_phase")),
    ("loss_factor", _SHAKEN_OPEN, _power("loss_factor")),
    ("rise_speed", ("thin",), _rise(0)),
    ("rise_number", ("thin",), _rise(1)),
    ("rebound", tuple(name for name, bed in BEDS.items() if bed.dropped), _no_rebound),
)
