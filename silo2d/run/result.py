"""The answers of a run: what stands in summary.json, and what describes its trajectory."""

import csv
import io
import json
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from granulab.campaign.runs.folder import RunFolder, write_atomic
from granulab.campaign.runs.result import Answers
from granulab.campaign.runs.trajectory import read_trajectory
from silo2d.baseline.discharge import Baseline
from silo2d.case.case import SiloCase
from silo2d.case.disorder import QUANTITIES, scores
from silo2d.engine.simulation import Simulation
from silo2d.measures.run_numbers import (
    MECHANISMS,
    discharge_measures,
    energy_closure,
    published_times,
)
from silo2d.run.discharge import Clock
from silo2d.run.packing import Packing


@dataclass(frozen=True)
class Result(Answers):
    """What a run found; SI, None for what does not exist."""

    silo: str
    seed: int
    engine: str
    outcome: Literal["empty", "dead_zones", "clogged", "clogged_at_opening", "time_limit"]
    n_particles: int
    n_out: int
    mass_kg: float
    mass_out_kg: float
    discharge_time_s: float | None  # None if clogged, or cut off by the time limit
    t90_s: float | None
    mean_rate_per_s: float | None
    mean_mass_flow_kg_per_s: float | None
    packing_fraction: float
    coordination: float
    time_step_s: float
    steps: int
    simulated_s: float
    cpu_us_per_step: float  # of the discharge
    cpu_s: float  # of filling, settling and discharge
    energy_closure: float | None  # unaccounted over dissipated, of the discharge; None: not known
    dissipated_j: dict[str, float | None]  # by mechanism and pair; None: the engine cannot tell
    restitution: dict[str, dict[str, float]]
    published: dict[str, Any]
    state_digest: str
    reused: bool
    run_folder: str


def summarise(
    folder: RunFolder,
    case: SiloCase,
    sim: Simulation | Baseline,
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
