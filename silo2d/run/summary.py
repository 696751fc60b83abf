"""The summary of a run, the records of its frames, and what describes its trajectory."""

import csv
import io
import json
from typing import Any

import h5py
import numpy as np

from granulab.campaign.output.files import write_atomic
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.contact.attraction import Attraction
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.disorder import QUANTITIES, scores
from silo2d.run.beds.acts import put_of_store
from silo2d.run.ending import Clock, Flow
from silo2d.run.numbers import (
    MECHANISMS,
    discharge_measures,
    energy_closure,
    published_times,
)
from silo2d.run.packing import Packing


def summarise(
    folder: RunFolder, case: SiloCase, sim: Flow, packing: Packing, clock: Clock, outcome: str
) -> dict[str, Any]:
    """The summary of a finished discharge, from its trajectory."""
    pulling = Attraction(*clock.attraction)
    return {
        "silo": case.label,
        "seed": case.settings.run.seed,
        "engine": case.settings.run.engine,
        "outcome": outcome,
        "n_particles": sim.n_particles - case.settings.flow.refill,
        "n_store": case.settings.flow.refill,
        "n_refilled": put_of_store(sim, case.settings.flow.refill),
        "n_out": sim.n_out,
        "packing_fraction": packing.fraction,
        "coordination": packing.coordination,
        "time_step_s": sim.time_step,
        "time_step_halvings": clock.halvings,
        "steps": sim.steps,
        "simulated_s": sim.time,
        "cpu_us_per_step": 1e6 * clock.cpu_s / sim.steps,
        "cpu_s": clock.cpu_s + clock.filling_cpu_s,
        "restitution": case.restitution(),
        "pulling": None if case.impulses else pulling.numbers(GRAVITY * case.mean_mass),
        "state_digest": sim.state_digest(),
        **measured(folder, case, outcome),
    }


def measured(folder: RunFolder, case: SiloCase, outcome: str) -> dict[str, Any]:
    """The part of the results that measures make from the stored frames."""
    frames = read_trajectory(folder.path, _numbers)
    mass, out_time = frames.static["mass"], frames["out_time"][-1]
    measures = discharge_measures(out_time, mass)
    # Where the flow was cut off, the times of those that left before mean nothing; its rate does.
    cut_off = outcome not in ("empty", "dead_zones")
    clogged = outcome.startswith("clogged")
    bed = len(mass) - case.settings.flow.refill
    # A bed that is shaken does not come to rest, by which a clog is known from a slow flow.
    unknown = outcome == "time_limit" and case.settings.flow.vibration_amplitude is not None
    by_mechanism = all(name in frames for name in MECHANISMS)
    return {
        "mass_kg": float(mass[:bed].sum()),
        "mass_store_kg": float(mass[bed:].sum()),
        "mass_out_kg": float(mass[~np.isnan(out_time)].sum()),
        "discharge_time_s": None if cut_off else measures["last_out_s"],
        "t90_s": None if cut_off else measures["t90_s"],
        "clogged": None if unknown else clogged,
        "clogged_after_s": (measures["last_out_s"] or 0.0) if clogged else None,
        "mean_rate_per_s": measures["mean_rate_per_s"],
        "mean_mass_flow_kg_per_s": measures["mean_mass_flow_kg_per_s"],
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
        "shape_part": np.unique(case.shapes.parts, return_inverse=True)[1],
        "wall_segments": walls.segments,
        **{f"filling_{name}": column for name, column in packing.at_walls.items()},
    }
    if case.settings.disorder.per == "particle":
        drawn = scores(case.settings.run.seed, len(packing.kinds))
        static |= {f"score_{name}": own for name, own in zip(QUANTITIES, drawn, strict=True)}
    attributes = {
        "silo": case.label,
        "wall_names": json.dumps(walls.names),
        "part_names": json.dumps(np.unique(case.shapes.parts).tolist()),
        "lips": np.array(case.outline.lips),
        "level": case.settings.fill.level,
    }
    if case.settings.flow.vibration_frequency is not None:
        attributes["vibration_frequency"] = case.settings.flow.vibration_frequency
    if case.settings.run.door_speed is not None:
        attributes["door_speed"] = case.settings.run.door_speed
    if case.settings.flow.gate_times:
        attributes["gate_times"] = np.array(case.settings.flow.gate)
    if case.settings.flow.feed_rate is not None:
        attributes["gate_times"] = np.array([0.0])
    return static, attributes


def write_records(folder: RunFolder) -> None:
    """records.csv: time, particles out, energies and wall forces, a line a frame.

    The names of its columns end with their unit, as those of the results do.
    """
    frames = read_trajectory(folder.path, _numbers)
    names = json.loads(frames.attributes["wall_names"])
    numbers = [k for k in frames if frames[k].ndim == 1]
    columns = {with_unit(k): frames[k] for k in numbers}
    for w, name in enumerate(names):
        for axis, letter in enumerate("xy"):
            key = f"force_{letter}_{name.replace(' ', '_')}_n"
            columns[key] = frames["wall_force"][:, w, axis]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
    write_atomic(folder.path / "records.csv", text.getvalue())


def _numbers(name: str, stored: h5py.Dataset) -> slice | None:
    """Rows of the frames that results are made of: numbers of all, and the last times of leaving.

    What a frame has of each particle is many times as much, and may not find room in memory.
    """
    if name == "out_time":
        return slice(-1, None)
    return slice(None) if stored.ndim == 1 or name == "wall_force" else None


def with_unit(series: str) -> str:
    """The name of a series of a trajectory, with its unit: of counts none, of energies J."""
    if series == "time":
        return "time_s"
    return series if series in ("steps", "n_out") else f"{series}_j"
