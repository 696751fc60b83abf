"""The fall of the apparent mass with Gamma as a power: fitted exponents beside the literature's."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damper3d.studies.field.table import Field
from granulab.campaign.output.statistics import slope
from granulab.errors import InputError

FALLEN = 0.9  # of the bed's mass, below which m' no longer rides along
LEAST = 4  # points of a fit: two that a line takes, and two for its scatter
LITERATURE = {
    "in_phase": "-2 at moderate acceleration (Masmoudi et al. 2016), -1 in the quasi-static regime",
    "loss_factor": "-1 (Masmoudi et al. 2016)",
}


@dataclass(frozen=True)
class Fall:
    """A power of Gamma, fitted to a quantity of one frequency."""

    quantity: str  # "in_phase" (m'/M) or "loss_factor" (m''/M)
    frequency: float  # [Hz]
    gammas: tuple[float, float]  # the fitted range
    points: int
    exponent: float
    half_width: float  # of its 95 % interval, from the scatter about the line


def falls(field: Field, gammas: tuple[float, float] | None = None) -> list[Fall]:
    """Least-squares exponents of ln m'/M and ln m''/M against ln Gamma, at each frequency.

    gammas: the range to fit. Else m' is fitted from the first point below FALLEN of the bed's mass
    to the least one before it is no longer positive (a bed that meets the lid rises again), and
    the loss factor from its largest value on, likewise. A quantity with fewer than LEAST points
    there has none.
    """
    if gammas is not None and not 0 < gammas[0] < gammas[1] < math.inf:
        raise InputError(f"fit range {gammas[0]:g} to {gammas[1]:g}: give two rising Gammas")
    found = []
    for frequency in field.frequencies:
        own = field.frequency == frequency
        gamma = field.gamma[own]
        for quantity, values in (
            ("in_phase", field.in_phase[own] / field.bed_mass),
            ("loss_factor", field.out_of_phase[own] / field.bed_mass),
        ):
            if gammas is not None:
                chosen = (gammas[0] <= gamma) & (gamma <= gammas[1]) & (values > 0)
            else:
                chosen = _falling(values, quantity == "in_phase")
            line = slope(np.log(gamma[chosen]).tolist(), np.log(values[chosen]).tolist())
            if line is None or chosen.sum() < LEAST:
                continue
            ends = float(gamma[chosen][0]), float(gamma[chosen][-1])
            found.append(
                Fall(quantity, float(frequency), ends, int(chosen.sum()), line.value,
                     line.half_width)
            )  # fmt: skip
    return found


def _falling(values: NDArray[np.float64], rides: bool) -> NDArray[np.bool_]:
    """The points of the falling branch: to its least value before one that is not positive."""
    fallen = values < FALLEN if rides else np.arange(len(values)) >= np.argmax(values)
    first = int(np.argmax(fallen)) if fallen.any() else len(values)
    ended = np.flatnonzero(values[first:] <= 0)
    last = first + int(ended[0]) if ended.size else len(values)
    if last > first:
        last = first + int(np.argmin(values[first:last])) + 1
    at = np.arange(len(values))
    chosen: NDArray[np.bool_] = (first <= at) & (at < last)
    return chosen


def as_rows(found: list[Fall], regimes: dict[tuple[float, float], str | None]) -> list[Any]:
    """Falls for --json, with the phases that the runs of the range show.

    regimes: phase by frequency [Hz] and Gamma; None where it was not named.
    """
    return [
        {
            "quantity": fall.quantity,
            "frequency_hz": fall.frequency,
            "gamma_range": list(fall.gammas),
            "points": fall.points,
            "exponent": fall.exponent,
            "half_width": fall.half_width,
            "phases": sorted(
                {
                    phase
                    for (f, g), phase in regimes.items()
                    if phase and f == fall.frequency and fall.gammas[0] <= g <= fall.gammas[1]
                }
            ),
            "literature": LITERATURE[fall.quantity],
        }
        for fall in found
    ]
