"""Rows of an efficiency map as they come from run_cases, made up: two ridges at known places."""

import numpy as np

from damper3d.case.closed_forms import bouncing_bed_onset, effective_clearance

CLEARANCE = effective_clearance(7 / 15, 0.04, 0.64)


def made_efficiency(frequency, gamma):
    """A bouncing bed that peaks at its onset, a fluidised bed that peaks at Gamma 3."""
    onset = float(bouncing_bed_onset(frequency, CLEARANCE))
    x = np.log(gamma / onset)
    bouncing = np.exp(12 * x) if x < 0 else np.exp(-0.8 * x)
    fluidised = 0.38 * np.exp(-((np.log(gamma / 3.0) / 0.45) ** 2))
    return 0.02 + max(0.85 * bouncing, fluidised)


def made_row(labels, noise=0.004, **fields):
    """A run that is done; its noise follows from its seed."""
    frequency, gamma, seed = labels["frequency_hz"], labels["gamma"], labels["seed"]
    rng = np.random.default_rng([int(1000 * frequency), int(1000 * gamma), seed])
    eta = made_efficiency(frequency, gamma) + rng.normal(scale=noise)
    return {
        "efficiency": eta,
        "efficiency_interval": [eta - 2 * noise, eta + 2 * noise],
        "orientation": "vertical",
        "law_term": 0.01 * gamma,
        "phase": None,
        "reused": False,
        "run_folder": "/somewhere",
        **fields,
        **labels,
        "state": "done",
        "reason": "",
    }


def made_runs(cases, *, out, **engine):
    """In place of run_cases."""
    return [made_row(labels) for labels, _ in cases]
