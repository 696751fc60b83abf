"""Rows of the damper's tables, made up: shares, efficiencies and histories chosen by the test."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from damper3d.case.closed_forms import meeting_phase

Row = dict[str, Any]
G = 9.81  # m/s2


def done(labels: Row, **results: Any) -> Row:
    """A run that came to an end."""
    return {**labels, "seed": 1, "phase": "bouncing_bed", **results, "state": "done", "reason": ""}


def failed(labels: Row, reason: str) -> Row:
    """A run that did not."""
    return {**labels, "seed": 1, "state": "failed", "reason": reason}


def two_peaks(gamma: float, first: float = 3.0, second: float | None = 20.0) -> float:
    """An efficiency with parabolas in ln Gamma about a fluidisation and a bouncing-bed peak."""
    humps = [0.5 - 0.4 * math.log(gamma / first) ** 2]
    if second is not None:
        humps.append(0.8 - 0.4 * math.log(gamma / second) ** 2)
    return max(*humps, 0.05)


def shares(pair: float, friction: float, column: str = "shares", tangential: float = 0.05) -> Row:
    """Columns of a row whose particle-particle contacts have the part `pair` of everything.

    Friction is the same part of what either class dissipates.
    """
    found = {}
    for name, part in (("particle_particle", pair), ("particle_wall", 1 - pair)):
        own = {"friction": friction, "tangential_damping": tangential}
        own["normal_damping"] = 1 - friction - tangential
        found |= {f"{column}.{name}.{mechanism}": part * x for mechanism, x in own.items()}
    return found


def history(power: Callable[[np.ndarray], np.ndarray], bed: Callable[[np.ndarray], np.ndarray],
            speed: float, samples: int = 100) -> Row:  # fmt: skip
    """Columns of a row from functions of the part p, 0 to 2, of a pair of cycles.

    bed is over the peak speed of the enclosure [m/s].
    """
    part = np.linspace(0.0, 2.0, 2 * samples + 1)
    middle = (part[1:] + part[:-1]) / 2
    grown = np.concatenate([[0.0], np.cumsum(power(middle))])
    return {
        "cycle.dissipated": grown.tolist(),
        "cycle.bed_velocity": (speed * bed(part)).tolist(),
    }


def ideal_bouncing_bed(gamma: float, onset: float, width: float = 0.01) -> Row:
    """A row of the bed of theory.meeting_phase: it flies at V, meets a wall, goes with it.

    What each meeting dissipates is spread over a Gaussian of this width [cycles].
    """
    since = float(meeting_phase(gamma / onset)) / (2 * math.pi)

    def power(part: np.ndarray) -> np.ndarray:
        away = (part - since + 0.25) % 0.5 - 0.25
        return np.exp(-0.5 * (away / width) ** 2)

    def bed(part: np.ndarray) -> np.ndarray:
        sign = np.where(part % 1 < 0.5, 1.0, -1.0)
        flies = (part % 0.5) < since
        return np.where(flies, sign, np.cos(2 * np.pi * part))

    speed = gamma * G / (2 * math.pi * 40.0)
    labels = {"orientation": "vertical", "gamma": gamma}
    return done(labels, frequency_hz=40.0, mass_kg=0.028, **history(power, bed, speed))
