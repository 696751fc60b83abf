"""Runs of a field as they come from run_cases, made up: a bed that rides along, then falls off."""

import numpy as np

BED = 0.03  # kg
ONSET = 1.3  # Gamma at which it leaves the floor


def made_mass(frequency, gamma):
    """m' - i m'' [kg]: rides up to ONSET; beyond m' falls through zero and m'' has its maximum."""
    x = ONSET / gamma
    if x >= 1:
        return complex(BED)
    return BED * (1.3 * x**1.5 - 0.3 - 1j * 2.0 * x * (1 - x) * (1 + 0.001 * frequency))


def made_runs(cases, *, out, noise=0.0, **engine):
    """In place of run_cases; noise is of the bed's mass and follows from the seed."""
    return [_row(labels, noise) for labels, _ in cases]


def _row(labels, noise):
    frequency, gamma, seed = labels["frequency_hz"], labels["gamma"], labels["seed"]
    rng = np.random.default_rng([int(1000 * frequency), int(1000 * gamma), seed])
    mass = made_mass(frequency, gamma) + noise * BED * rng.normal()
    return {
        "effective_mass.in_phase_kg": mass.real,
        "effective_mass.out_of_phase_kg": -mass.imag,
        "mass_kg": BED,
        "efficiency": 0.1,
        "efficiency_wall_work": -mass.imag / BED * np.pi / 4,
        "phase": None,
        "steady": True,
        "reused": False,
        **labels,
        "state": "done",
        "reason": "",
    }
