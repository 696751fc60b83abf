"""Numbers of a trajectory: what left the silo when, where the energy went, what was published.

Nothing here needs the case or the engine: measures and pictures take them too.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granulab.contact.files.datafile import shipped_rows
from silo2d.case.outline import PRESETS, preset_sizes

Series = NDArray[np.float64]

MECHANISMS = [
    "normal_damping_grain_grain",
    "tangential_damping_grain_grain",
    "friction_grain_grain",
    "normal_damping_grain_wall",
    "tangential_damping_grain_wall",
    "friction_grain_wall",
]
_HELD = ["kinetic", "potential", "elastic_normal", "elastic_tangential"]


def discharge_measures(out_time: ArrayLike, mass: ArrayLike) -> dict[str, float | None]:
    """Numbers of the discharge of the n particles that leave.

    out_time    when each centroid passed y = 0 (n_particles,) [s]; NaN for those that stay
    mass        of each particle (n_particles,) [kg]

    n_out                      n
    t90_s                      when the ceil(0.9 n)-th leaves; t10 likewise; not interpolated
    mean_rate_per_s            0.8 n/(t90 - t10); mean_mass_flow_kg_per_s is this by mass
    last_out_s                 when the n-th leaves

    None stands for what does not exist: nothing leaves, or all at once. Whether the silo clogged
    does not count here: a clogged run has no T90, though these particles have one.
    """
    times, which = np.asarray(out_time, dtype=float), ~np.isnan(out_time)
    times, n = np.sort(times[which]), int(which.sum())
    measures: dict[str, float | None] = {
        "n_out": n,
        "t90_s": None,
        "mean_rate_per_s": None,
        "mean_mass_flow_kg_per_s": None,
        "last_out_s": None,
    }
    if n == 0:
        return measures
    # -(-a // b) rounds up in whole numbers: 0.9 n in floats may come out above 0.9 n.
    t10, t90 = times[-(-n // 10) - 1], times[-(-9 * n // 10) - 1]
    measures |= {"t90_s": float(t90), "last_out_s": float(times[-1])}
    if t90 > t10:
        mass_out = np.asarray(mass)[which].sum()
        measures["mean_rate_per_s"] = float(0.8 * n / (t90 - t10))
        measures["mean_mass_flow_kg_per_s"] = float(0.8 * mass_out / (t90 - t10))
    return measures


def discharge_curve(trajectory: Mapping[str, np.ndarray]) -> tuple[Series, NDArray[np.int64]]:
    """Times [s] at which particles left, ascending, and the number out at each, itself included."""
    times = trajectory["out_time"][-1]
    times = np.sort(times[~np.isnan(times)])
    return times, np.arange(1, len(times) + 1)


def dissipated(trajectory: Mapping[str, np.ndarray]) -> dict[str, Series]:
    """Energy [J] that each mechanism has taken since the first frame, (F,) each."""
    return {name: trajectory[name] - trajectory[name][0] for name in MECHANISMS}


def energy_closure(trajectory: Mapping[str, np.ndarray]) -> tuple[Series, float | None]:
    """Unaccounted energy [J] (F,), and its part of the dissipated energy at the end.

    It is E(0) - E(t) - carried out - dissipated: positive where energy was lost. E is the
    kinetic, potential and elastic energy of the particles inside; what particles that were dropped
    had of it is carried out, and so is what a moving door took. The second number is the last
    unaccounted energy over what was dissipated until then, None where nothing was.
    """
    energy = np.sum([trajectory[name] for name in _HELD], axis=0)
    carried_out = trajectory["carried_out"] - trajectory["carried_out"][0]
    if "given_to_door" in trajectory:  # older runs know no moving door
        carried_out = carried_out + trajectory["given_to_door"] - trajectory["given_to_door"][0]
    lost = np.sum(list(dissipated(trajectory).values()), axis=0)
    unaccounted = energy[0] - energy - carried_out - lost
    return unaccounted, float(unaccounted[-1] / lost[-1]) if lost[-1] > 0 else None


def published_times(silo_name: str) -> dict[str, float | bool | None]:
    """Published discharge times [s] of a silo, of the experiment and of SPOLY.

    experiment_n             trials, of which experiment_clogged clogged
    experiment_mean_s        over the trials with a time; experiment_sd_s is their sample sd
    simulation_s             SPOLY's; simulation_clogged: whether it clogged instead

    All values are None for silos other than the paper's sixteen, and where nothing was printed.
    Source: Granular Matter 15 (2013) 811, Tables 5 and 6.
    """
    trials, simulated = _printed("experiment", silo_name), _printed("simulation", silo_name)
    times = [float(t) for t in trials if t != "C"]
    known = {
        "experiment_mean_s": float(np.mean(times)) if times else None,
        "experiment_sd_s": float(np.std(times, ddof=1)) if len(times) > 1 else None,
        "experiment_n": len(trials) or None,
        "experiment_clogged": trials.count("C") if trials else None,
        "simulation_s": None,
        "simulation_clogged": None,
    }
    if simulated:
        clogged = simulated == ["C"]
        known |= {
            "simulation_s": None if clogged else float(simulated[0]),
            "simulation_clogged": clogged,
        }
    return known


def _printed(which: str, silo_name: str) -> list[str]:
    """The entries, a time in seconds or "C" for clogged, of a silo in a published table."""
    if silo_name not in PRESETS:
        return []
    outlet_mm = round(1e3 * preset_sizes(silo_name)[1])
    return [
        row["time_s"]
        for row in shipped_rows("published", f"silo_discharge_{which}")
        if row["silo"] == silo_name[0] and float(row["outlet_mm"]) == outlet_mm
    ]
