"""The summary of a run, the records of its frames, and what describes its trajectory."""

import csv
import io
import json
from typing import Any

import numpy as np

from granulab.campaign.runs.folder import RunFolder, write_atomic
from granulab.campaign.runs.trajectory import read_trajectory
from silo2d.case.case import SiloCase
from silo2d.case.disorder import QUANTITIES, scores
from silo2d.run.ending import Clock, Flow
from silo2d.run.numbers import MECHANISMS, discharge_measures, energy_closure, published_times
from silo2d.run.packing import Packing


def summarise(
    folder: RunFolder, case: SiloCase, sim: Flow, packing: Packing, clock: Clock, outcome: str
) -> dict[str, Any]:
    """The summary of a finished discharge, from its trajectory."""
    return {
        "silo": case.label,
        "seed": case.settings.run.seed,
        "engine": case.settings.run.engine,
        "outcome": outcome,
        "n_particles": sim.n_particles,
        "n_out": sim.n_out,
        "packing_fraction": packing.fraction,
        "coordination": packing.coordination,
        "time_step_s": case.impulses.time_step if case.impulses else case.time_step,
        "steps": sim.steps,
        "simulated_s": sim.time,
        "cpu_us_per_step": 1e6 * clock.cpu_s / sim.steps,
        "cpu_s": clock.cpu_s + clock.filling_cpu_s,
        "restitution": case.restitution(),
        "state_digest": sim.state_digest(),
        **measured(folder, case, outcome),
    }


def measured(folder: RunFolder, case: SiloCase, outcome: str) -> dict[str, Any]:
    """The part of the results that measures make from the stored frames."""
    frames = read_trajectory(folder.path)
    mass, out_time = frames.static["mass"], frames["out_time"][-1]
    measures = discharge_measures(out_time, mass)
    # Where the flow was cut off, the times of those that left before mean nothing.
    cut_off = outcome not in ("empty", "dead_zones")
    by_mechanism = all(name in frames for name in MECHANISMS)
    return {
        "mass_kg": float(mass.sum()),
        "mass_out_kg": float(mass[~np.isnan(out_time)].sum()),
        "discharge_time_s": None if cut_off else measures["last_out_s"],
        "t90_s": None if cut_off else measures["t90_s"],
        "mean_rate_per_s": None if cut_off else measures["mean_rate_per_s"],
        "mean_mass_flow_kg_per_s": None if cut_off else measures["mean_mass_flow_kg_per_s"],
        "energy_closure": energy_closure(frames)[1] if by_mechanism else None,
        "dissipated_j": {
            name: float(frames[name][-1]) if by_mechanism else None for name in MECHANISMS
        },
        "published": published_times(case.published_name or ""),
    }


def describe(case: SiloCase, packing: Packing) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Arrays of a trajectory that do not change from frame to frame, and its attributes."""
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
    """records.csv: time, particles out, energies and wall forces, a line a frame."""
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
