"""Quantities of shaken and dropped beds that others measured, with the intervals of ours."""

import csv
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from damper3d.case.closed_forms import (
    PACKINGS,
    bouncing_bed_onset,
    collect_and_collide,
    effective_clearance,
)
from damper3d.case.parts import GRAVITY
from damper3d.studies.field.fall import falls
from damper3d.studies.field.table import Field
from damper3d.studies.map.grid import MapResult
from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import mean_sd, quantile
from granulab.contact.files.datafile import data_file

Row = dict[str, Any]
Rows = Sequence[Row]

MEASURED = Quantities()

MOVES = 0.01  # efficiency (of the walls' work) from which a bed moves in its enclosure
UNLIKE = 0.1  # |b - a|/(b + a) of what successive cycles dissipate, from which they differ
STILL = 0.02  # height of a rebound over the drop, below which there is none
FAR = 1.5  # times clearance/pi, beyond which even one body takes less than 0.9 of the most
AT_REST = 0.5  # Gamma of a bed that rides along
_SOFT = {"law.youngs_modulus": "0.33 GPa", "run.time_step": "4 us"}


@dataclass(frozen=True)
class Bed:
    """A bed as it is run.

    words     dimensions, particles, motion
    changes   of the thesis's case
    at        Gammas; of a dropped one, its mass over e0 times that of the enclosure
    counts    numbers of particles
    dropped   e0 of a dropped enclosure, or None of a shaken one
    """

    words: str
    changes: Row
    at: tuple[float, ...]
    counts: tuple[int, ...]
    dropped: float | None = None


def _cycles(number: int, discard: int) -> Row:
    return {"run.cycles": number, "run.discard": discard}


_WEIGHTLESS_FILL = 60 * (4 / 3) * 2.5**3 / (10**2 * 45)  # of 60 spheres of 5 mm in 20 by 45 mm
_AMPLITUDES = (0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0, 1.1, 1.25, 1.5, 2.0, 3.0, 5.0)


def clearance_onset(packing: str) -> float:
    """Gamma of eq. 6.11 for the weightless bed, with the clearance of eq. 6.13."""
    clearance = effective_clearance(_WEIGHTLESS_FILL, 0.045, PACKINGS[packing])
    return float(bouncing_bed_onset(20.0, clearance))


def onset_of_mean() -> float:
    """The same with a clearance between those of both packings."""
    return math.sqrt(clearance_onset("loose") * clearance_onset("close"))


_NO_LID = (1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0, 28.0)
DROP = 0.1  # [m]
_BOX = {"enclosure.diameter": "30 mm", "enclosure.height": "100 mm", "run.time_step": "2 us"}

_TROUGH = "box 40 x 40 x 80 mm shaken along 80 mm, spheres of 5 mm, 0.33 GPa, 15 Hz"
_LYING = {
    "enclosure.shape": "box", "enclosure.width": "40 mm", "enclosure.depth": "40 mm",
    "enclosure.height": "80 mm", "motion.orientation": "horizontal", "motion.frequency": 15.0,
} | _cycles(13, 5) | _SOFT  # fmt: skip

BEDS: dict[str, Bed] = {
    "vertical": Bed(
        "cylinder 40 x 40 mm, spheres of 5 mm, 0.33 GPa, 15 Hz, vertical",
        {"motion.frequency": 15.0} | _cycles(13, 5) | _SOFT,
        (0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.15, 1.2, 1.3), (358,),
    ),
    "horizontal": Bed(
        f"{_TROUGH}, horizontal",
        _LYING, (0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.55, 0.6, 0.65, 0.7, 0.8, 0.9, 1.0), (358,),
    ),
    "horizontal, rolling": Bed(
        f"{_TROUGH}, horizontal; rolling resistance 0.3",
        _LYING | {"law.rolling_friction": 0.3, "law.rolling_stiffness": "1e4 N/m",
                  "law.rolling_damping": "0.01 N s/m"},
        (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0), (358,),
    ),
    "flying": Bed(
        "cylinder 40 x 80 mm, spheres of 5 mm, 20 Hz, vertical; no lid met",
        {"enclosure.height": "80 mm", "motion.frequency": 20.0, "run.time_step": "2 us"}
        | _cycles(22, 6),
        (2.5, 3.0, 3.3, 3.6, 3.8, 4.0, 4.2, 4.5, 5.0), (358,),
    ),
    "weightless": Bed(
        "cylinder 20 x 45 mm, spheres of 5 mm, 20 Hz, no gravity",
        {"enclosure.diameter": "20 mm", "enclosure.height": "45 mm", "motion.frequency": 20.0,
         "motion.orientation": "none", "run.time_step": "2 us"} | _cycles(40, 20),
        tuple(round(part * clearance_onset("close"), 3) for part in _AMPLITUDES), (60,),
    ),
    **{
        f"no lid, {frequency:g} Hz": Bed(
            f"cylinder 20 x 150 mm, spheres of 5 mm, {frequency:g} Hz, vertical; no lid met",
            {"enclosure.diameter": "20 mm", "enclosure.height": "150 mm",
             "motion.frequency": frequency, "run.time_step": "2 us"} | _cycles(40, 10),
            _NO_LID, (100,),
        )
        for frequency in (80.0, 160.0)
    },
    "thin": Bed(
        "cylinder 20 x 300 mm, spheres of 3 mm in 1 to 4 layers, 50 Hz, vertical",
        {"enclosure.diameter": "20 mm", "enclosure.height": "300 mm", "motion.frequency": 50.0,
         "particles.shape": "sphere:3mm", "run.time_step": "2 us"} | _cycles(80, 30),
        (AT_REST, 10.0, 13.0, 17.0, 22.0), (35, 70, 105, 140),
    ),
    **{
        f"dropped, e0 {e0:g}": Bed(
            f"cylinder 30 x 100 mm, spheres of 5 mm, dropped by 100 mm, empty with e0 = {e0:g}",
            _BOX, (0.25, 0.5, 0.75, 1.0, 1.5), (150,), dropped=e0,
        )
        for e0 in (0.5, 0.7, 0.9)
    },
}  # fmt: skip


def points() -> list[Row]:
    """The labels of each point."""
    return [
        {"bed": name, "count": count, "at": at}
        for name, bed in BEDS.items()
        for count in bed.counts
        for at in bed.at
    ]


@cache
def published() -> dict[str, tuple[float, float]]:
    """What others found: an interval by the name of a quantity."""
    path = data_file("published", "shaken_beds")
    assert path is not None  # shipped
    with path.open(encoding="utf-8", newline="") as file:
        table = csv.DictReader(line for line in file if not line.startswith("#"))
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
    items = []
    for name, beds, measure in _MEASURES:
        for bed in beds:
            if bed in found and (own := measure(found[bed])) is not None:
                value, low, high = own
                theirs = published()[name]
                items.append({"name": name, "bed": bed, "value": value, "low": low, "high": high,
                              "their_low": theirs[0], "their_high": theirs[1]})  # fmt: skip
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
    rows: Rows, passed: Callable[[Row], bool], still: float = math.inf
) -> Interval | None:
    """From where on every run of a packing passes: the middle, and what the packings enclose.

    Runs beyond `still` are not looked at. None where the first or the last point leaves it open.
    """
    ends = []
    for seed in sorted({row["seed"] for row in rows}):
        own = sorted((row for row in rows if row["seed"] == seed and row["at"] <= still),
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


def _transition(rows: Rows) -> Interval | None:
    """Amplitude over clearance/pi from which half of the most is dissipated."""
    found = _threshold(rows, lambda row: row["efficiency"] > 0.5, still=FAR * onset_of_mean())
    return None if found is None else _over_clearance(*found)


def _optimum(rows: Rows) -> Interval | None:
    """Amplitude of the largest mean efficiency over clearance/pi, in the bracket of its peak.

    The curve rises at once and falls slowly, so that the vertex of a parabola would lie too high.
    """
    result = MapResult.of(rows)
    peaks = result.peaks(float(result.frequency[0]))
    if not peaks:
        return None
    top = max(peaks, key=lambda peak: peak.efficiency).bracket
    return _over_clearance(float(result.gamma[np.argmax(result.efficiency)]), *top)


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
    """Logarithms of peak velocity, number and rise of the centre of mass of each run [SI]."""
    rest: dict[int, list[float]] = {}
    for row in rows:
        if row["at"] == AT_REST:
            rest.setdefault(row["count"], []).append(row["bed_height_m"])
    found = []
    for row in rows:
        if row["at"] > 1.0 and row["count"] in rest:
            still = mean_sd(rest[row["count"]]).mean or 0.0
            speed = row["gamma"] * GRAVITY / (2 * math.pi * row["frequency_hz"])
            found.append((math.log(speed), math.log(row["count"]),
                          math.log(row["bed_height_m"] - still)))  # fmt: skip
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
    ("transition", ("weightless",), _transition),
    ("optimum", ("weightless",), _optimum),
    ("in_phase", _SHAKEN_OPEN, _power("in_phase")),
    ("loss_factor", _SHAKEN_OPEN, _power("loss_factor")),
    ("rise_speed", ("thin",), _rise(0)),
    ("rise_number", ("thin",), _rise(1)),
    ("rebound", tuple(name for name, bed in BEDS.items() if bed.dropped), _no_rebound),
)
