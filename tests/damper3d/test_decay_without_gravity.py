"""A structure that is let go without gravity loses what prescribed motion at its amplitude does.

Closed form (Sack et al. 2013, PRL 111, 018001; eq. 6.11 of the thesis is its optimum): a bed m that
moves as one body without restitution leaves a wall at V = A w, meets the other one, a clearance L
away, after the phase tau - sin tau = L/A at V (1 - cos tau), and takes m V^2 (1 - cos tau)^2 a
cycle for A from L/pi on, 4 m V^2 there. Of a heavy host M the amplitude then falls by
(m/M) A (1 - cos tau)^2 a cycle.
"""

import math
from functools import partial

import numpy as np
import pytest
from host_scenes import resolved, works

from damper3d.run import protocol
from damper3d.studies.predict.prediction import predict

FREQUENCY, RATIO, PACKINGS = 20.0, 150.0, 6  # Hz, host over bed
OMEGA = 2 * math.pi * FREQUENCY
AMPLITUDES = (0.4, 0.6, 1.0, 1.5)  # over the clearance
BED = {
    "enclosure": {"diameter": "20 mm", "height": "45 mm"},
    "particles": {"shape": "sphere:5mm", "count": 60},
    "fill": {"settle_time": "100 ms"},
}


def lost(a: float) -> float:
    """Energy of a cycle over m V^2 at the amplitude A/L = a; NaN below 1/pi."""
    from scipy.optimize import brentq

    if a * math.pi < 1:
        return math.nan
    return (1 - math.cos(brentq(lambda t: t - math.sin(t) - 1 / a, 1e-6, 4.0))) ** 2


def test_the_closed_form_has_its_optimum_and_a_straight_decay():
    """4 m V^2 at A = L/pi; the fall a cycle, A (1 - cos tau)^2, hardly varies above that."""
    assert lost(1 / math.pi + 1e-12) == pytest.approx(4.0, rel=1e-6)
    falls = [a * lost(a) for a in np.linspace(0.4, 1.5, 50)]
    assert max(falls) / min(falls) < 1.22


def taken(result, mass: float) -> tuple[np.ndarray, np.ndarray]:
    """Work on the bed over m V^2 of each cycle, and its amplitude [m]."""
    work, size = works(result, OMEGA)
    return work / (mass * (size * OMEGA) ** 2), size


def run(out, seed: int, cycles: int, motion: dict, **tables):
    case = resolved(
        **BED, motion={"orientation": "none", **motion},
        run={"seed": seed, "discard": 0, "cycles": cycles}, **tables,
    )  # fmt: skip
    return protocol.run(case, out=out)


@pytest.mark.validation
def test_without_gravity_a_decay_loses_what_a_shaker_gives_and_is_straight(tmp_path):
    """At four amplitudes, over six packings: within three standard errors, which are below 2 %.

    The bed meets a free host with the reduced mass m/(1 + m/M). At an amplitude the decay's value
    is that of the line through its cycles within 15 % of it. The amplitude's fall a cycle varies
    no more than in closed form.
    """
    case = resolved(**BED)
    clearance = float(np.mean([one.length for one in predict(case).clearances]))
    start, here = 1.9 * clearance, partial(run, tmp_path)
    host = {"mass": f"{RATIO * case.mass!r} kg", "frequency": FREQUENCY, "damping_ratio": 1e-4,
            "start_displacement": f"{start!r} m"}  # fmt: skip
    freed, driven = np.zeros((2, PACKINGS, len(AMPLITUDES)))
    for seed in range(PACKINGS):
        work, size = taken(here(seed + 1, 200, {}, host=host), case.mass)
        for k, a in enumerate(AMPLITUDES):
            off = np.log(size / (a * clearance))
            near = np.abs(off) < 0.15
            freed[seed, k] = np.polyfit(off[near], work[near], 1)[1] * (1 + 1 / RATIO)
            gamma = a * clearance * OMEGA**2 / 9.81
            shaken = here(seed + 1, 40, {"frequency": FREQUENCY, "gamma": gamma})
            driven[seed, k] = taken(shaken, case.mass)[0][10:].mean()
    error = np.sqrt((freed.var(axis=0, ddof=1) + driven.var(axis=0, ddof=1)) / PACKINGS)
    gap = freed.mean(axis=0) - driven.mean(axis=0)
    assert (error < 0.02 * driven.mean(axis=0)).all()
    assert (np.abs(gap) < 3 * error).all(), (gap, error)
    falls = freed.mean(axis=0) * AMPLITUDES
    assert falls.max() / falls.min() < 1.22 + 3 * error.max()
