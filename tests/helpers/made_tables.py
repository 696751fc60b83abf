"""Rows of damper3d's published tables as they come from run_cases, with optima at known places."""

import numpy as np

from damper3d.case.closed_forms import bouncing_bed_onset, effective_clearance

FILL = 358 * (5 / 40) ** 2 * 5 * 2 / 3  # times 1/height [mm]: eq. 6.1
FLUIDISED = 3.0  # Gamma at which the made bed fluidises best


def made_onset(labels, packing=0.64):
    """Gamma of eq. 6.11 for the damper of a row."""
    height = labels["height_mm"]
    clearance = effective_clearance(FILL / height, height / 1e3, packing)
    return float(bouncing_bed_onset(labels["frequency_hz"], clearance))


def made_table(
    packing=0.64, size_exponent=-0.2, ridge=0.38, scatter=0.01, tilt=0.0, lying=1.0, walls=None
):
    """In place of run_cases: a bouncing bed that peaks at eq. 6.11 for `packing`, times
    (d/5 mm)^size_exponent and a scatter from packing to packing; fluidisation of height `ridge`,
    times (f/40 Hz)^tilt, at a Gamma that goes with the inverse of that; `lying` times as high in
    the horizontal case; where `walls` is given, a function of the labels, the walls' work is
    that times what is dissipated, and so is either of a bed that is to be steady.
    """

    def run_cases(cases, *, out, **engine):
        how = packing, size_exponent, ridge, scatter, tilt, lying
        rows = [_row(labels, *how) for labels, _ in cases]
        if walls is not None:
            for row, (labels, case) in zip(rows, cases, strict=True):
                by_walls(row, walls(labels), steady=case.settings.run.steady)
        return rows

    return run_cases


def _row(labels, packing, size_exponent, ridge, scatter, tilt, lying):
    rng = np.random.default_rng(labels["seed"])
    place = made_onset(labels, packing) * (labels["diameter_mm"] / 5) ** size_exponent
    x = np.log(labels["gamma"] / (place * np.exp(rng.normal(scale=scatter))))
    bouncing = 0.85 * (np.exp(6 * x) if x < 0 else np.exp(-0.8 * x))
    shift = (labels["frequency_hz"] / 40) ** tilt
    fluidised = ridge * np.exp(-((np.log(labels["gamma"] * shift / FLUIDISED) / 0.45) ** 2))
    fluidised *= shift * (lying if labels["orientation"] == "horizontal" else 1.0)
    eta = 0.02 + max(bouncing, fluidised)
    return {
        "efficiency": eta,
        "efficiency_interval": [eta - 0.005, eta + 0.005],
        "fill_ratio": FILL / labels["height_mm"],
        "phase": "bouncing_bed" if x > 0 else None,
        "reused": False,
        "run_folder": "/somewhere",
        **labels,
        "state": "done",
        "reason": "",
    }


def by_walls(row, share, *, steady):
    """Give a row the walls' work; a steady bed has that as its efficiency too."""
    row["efficiency_wall_work"] = share * row["efficiency"]
    if steady:
        row["efficiency"] = row["efficiency_wall_work"]
        row |= {"efficiency_interval": None, "steady": True, "cycles": 24}
