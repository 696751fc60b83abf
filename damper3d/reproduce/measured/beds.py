"""Beds that others measured, as they are run: enclosure, particles, motion, grid of Gammas."""

import math
from dataclasses import dataclass
from typing import Any

from damper3d.case.closed_forms import PACKINGS, bouncing_bed_onset, effective_clearance

Row = dict[str, Any]

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
    "rolls": Bed(
        "cylinder 40 x 80 mm, spheres of 5 mm, 0.33 GPa, 30 Hz, vertical; 100 cycles",
        {"enclosure.height": "80 mm", "motion.frequency": 30.0} | _cycles(110, 10) | _SOFT,
        (0.9, 1.0, 1.2, 1.5, 2.0, 3.0), (358,),
    ),
    **{
        f"suspended, {frequency:g} Hz": Bed(
            f"cylinder 40 x 40 mm, spheres of 5 mm, {frequency:g} Hz, vertical",
            {"motion.frequency": frequency, "run.time_step": "2 us"} | _cycles(40, 20),
            (5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 16.0, 20.0), (358,),
        )
        for frequency in (80.0, 160.0)
    },
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
