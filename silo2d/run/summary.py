"""The summary of a run: numbers of its trajectory, what describes it, what was published."""

import csv
import io
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granulab.campaign.runs.folder import RunFolder, write_atomic
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.contact.files.datafile import data_file
from silo2d.case.case import SiloCase
from silo2d.case.disorder import QUANTITIES, scores
from silo2d.case.outline import PRESETS, preset_sizes
from silo2d.run.ending import Clock, Flow
from silo2d.run.packing import Packing

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


def summarise(
    folder: RunFolder,
    case: SiloCase,
    sim: Flow,
    packing: Packing,
    clock: Clock,
    outcome: str,
) -> dict[str, Any]:
    """The answers of a finished discharge, from its trajectory."""
    frames = read_trajectory(folder.path)
    mass, out_time = frames.static["mass"], frames["out_time"][-1]
    measures = discharge_measures(out_time, mass)
    # Where the flow was cut off, the times of those that left before mean nothing.
    cut_off = outcome not in ("empty", "dead_zones")
    by_mechanism = all(name in frames for name in MECHANISMS)
    return {
        "silo": case.label,
        "seed": case.settings.run.seed,
        "engine": case.settings.run.engine,
        "outcome": outcome,
        "n_particles": sim.n_grains,
        "n_out": sim.n_out,
        "mass_kg": float(mass.sum()),
        "mass_out_kg": float(mass[~np.isnan(out_time)].sum()),
        "discharge_time_s": None if cut_off else measures["last_out_s"],
        "t90_s": None if cut_off else measures["t90_s"],
        "mean_rate_per_s": None if cut_off else measures["mean_rate_per_s"],
        "mean_mass_flow_kg_per_s": None if cut_off else measures["mean_mass_flow_kg_per_s"],
        "packing_fraction": packing.fraction,
        "coordination": packing.coordination,
        "time_step_s": case.impulses.time_step if case.impulses else case.time_step,
        "steps": sim.steps,
        "simulated_s": sim.time,
        "cpu_us_per_step": 1e6 * clock.cpu_s / sim.steps,
        "cpu_s": clock.cpu_s + clock.filling_cpu_s,
        "energy_closure": energy_closure(frames)[1] if by_mechanism else None,
        "dissipated_j": {
            name: float(frames[name][-1]) if by_mechanism else None for name in MECHANISMS
        },
        "restitution": case.restitution(),
        "published": published_times(case.published_name or ""),
        "state_digest": sim.state_digest(),
    }


def describe(case: SiloCase, packing: Packing) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """What does not change from frame to frame, and the attributes, of a trajectory."""
    walls = case.outline.walls()
    outlines = [shape.rounded_outline() for shape in case.shapes.shapes]
    areas = np.array([shape.area for shape in case.shapes.shapes])
    layer = np.floor(packing.poses[:, 1] / case.settings.output.layer_height)
    static = {
        "kind": packing.kinds,
        "mass": case.surface_density * areas[packing.kinds],
        "layer": layer.astype(np.int64),
        "shape_points": np.concatenate(outlines),
        "shape_start": np.cumsum([0, *(len(outline) for outline in outlines)]),
        "wall_segments": walls.segments,
    }
    if case.settings.disorder.per == "particle":
        drawn = scores(case.settings.run.seed, len(packing.kinds))
        static |= {f"score_{name}": own for name, own in zip(QUANTITIES, drawn, strict=True)}
    attributes = {
        "silo": case.label,
        "wall_names": json.dumps(walls.names),
        "lips": np.array(case.outline.lips),
        "level": case.settings.fill.level,
    }
    if case.settings.run.door_speed is not None:
        attributes["door_speed"] = case.settings.run.door_speed
    return static, attributes


def write_records(folder: RunFolder) -> None:
    """records.csv: time, grains out, energies and wall forces, a line a frame."""
    frames = read_trajectory(folder.path)
    names = json.loads(frames.attributes["wall_names"])
    numbers = [k for k in frames if frames[k].ndim == 1]
    columns = {k: frames[k] for k in numbers}
    for w, name in enumerate(names):
        for axis, letter in enumerate("xy"):
            columns[f"force_{letter}_{name.replace(' ', '_')}"] = frames["wall_force"][:, w, axis]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
    write_atomic(folder.path / "records.csv", text.getvalue())


def discharge_measures(out_time: ArrayLike, mass: ArrayLike) -> dict[str, float | None]:
    """How the grains that leave do so; n of them.

    out_time    when each centroid passed y = 0 (n_grains,) [s]; NaN for those that stay
    mass        of each grain (n_grains,) [kg]

    n_out                      n
    t90_s                      when the ceil(0.9 n)-th leaves; t10 likewise; not interpolated
    mean_rate_per_s            0.8 n/(t90 - t10); mean_mass_flow_kg_per_s is this by mass
    last_out_s                 when the n-th leaves

    None stands for what does not exist: nothing leaves, or all at once. Whether the silo clogged
    is not asked here: a clogged run has no T90, though these grains have one.
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
    """Times [s] at which grains left, ascending, and how many had left at each, itself included."""
    times = trajectory["out_time"][-1]
    times = np.sort(times[~np.isnan(times)])
    return times, np.arange(1, len(times) + 1)


def dissipated(trajectory: Mapping[str, np.ndarray]) -> dict[str, Series]:
    """Energy [J] that each mechanism has taken since the first frame, (F,) each."""
    return {name: trajectory[name] - trajectory[name][0] for name in MECHANISMS}


def energy_closure(trajectory: Mapping[str, np.ndarray]) -> tuple[Series, float | None]:
    """Energy [J] that the books do not account for (F,), and its part of the dissipated energy.

    It is E(0) - E(t) - carried out - dissipated: positive where energy was lost. E is the
    kinetic, potential and elastic energy of the grains inside; what grains that were dropped
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
    """What was published for a silo: discharge times [s] of the experiment and of SPOLY.

    experiment_n             trials, of which experiment_clogged clogged
    experiment_mean_s        over the trials with a time; experiment_sd_s is their sample sd
    simulation_s             SPOLY's; simulation_clogged tells whether it clogged instead

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
    path = data_file("published", f"silo_discharge_{which}")
    if path is None or silo_name not in PRESETS:
        return []
    outlet_mm = round(1e3 * preset_sizes(silo_name)[1])
    lines = path.read_text(encoding="utf-8").splitlines()
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return [
        row["time_s"]
        for row in rows
        if row["silo"] == silo_name[0] and float(row["outlet_mm"]) == outlet_mm
    ]
