"""A run folder made without a simulation: particles slide to the outlet on curves and fall."""

import json
from pathlib import Path

import numpy as np

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import TrajectoryWriter
from silo2d.case.outline import Outline, preset
from silo2d.case.shapefile import load_shapes
from silo2d.run.numbers import MECHANISMS, discharge_measures, published_times

GRAVITY = 9.81
LEAVING = 0.96  # of the time, from the first particle to the last


def write_fake_run(
    folder: Path,
    *,
    silo: Outline | None = None,
    n_frames: int = 106,
    spacing: float = 0.05,
    outcome: str = "empty",
    finished: bool = True,
) -> RunFolder:
    """Write a run of n_frames frames, 10 ms apart, of particles `spacing` [m] apart."""
    silo = silo or preset("A4")
    rng = np.random.default_rng(7)
    shapes = load_shapes("wood19").shapes
    start = _lattice(silo, spacing, rng)
    kind = rng.integers(len(shapes), size=len(start))
    mass = 54.0 * np.array([shape.area for shape in shapes])[kind]
    outlines = [shape.rounded_outline() for shape in shapes]
    walls = silo.walls()
    static = {
        "kind": kind,
        "mass": mass,
        "layer": (start[:, 1] // 0.045).astype(int),
        "shape_points": np.concatenate(outlines),
        "shape_start": np.cumsum([0, *map(len, outlines)]),
        "wall_segments": walls.segments,
    }
    attributes = {
        "silo": silo.name,
        "wall_names": json.dumps(walls.names),
        "lips": silo.lips,
        "level": start[:, 1].max(),
    }
    # Derivatives and rates need two frames; a run may have fewer.
    frames = _frames(silo, start, mass, len(walls.names), max(n_frames, 2), outcome, rng)
    writer = TrajectoryWriter(folder)
    writer.write_static(static, attributes)
    for k in range(n_frames):
        writer.append({key: array[k] for key, array in frames.items()})
        if k == n_frames // 2:
            writer.flush()
    writer.flush()
    run = RunFolder(folder)
    run.write_case(f'silo = "{silo.name}"\n')
    if finished:
        writer.finish(static, attributes)
        run.write_summary(_summary(silo, outcome, frames["out_time"][-1], mass))
    return run


def _lattice(silo: Outline, spacing: float, rng: np.random.Generator) -> np.ndarray:
    """Points (n, 2) [m] in the silo on rows that are shifted in turn, from the lowest up."""
    from shapely import Polygon, contains_xy

    left, right = silo.polygon[:, 0].min(), silo.polygon[:, 0].max()
    x, y = np.meshgrid(
        np.arange(left, right, spacing), np.arange(spacing, 0.95 * silo.height, 0.87 * spacing)
    )
    x[::2] += spacing / 2
    room = Polygon(silo.polygon).buffer(-0.6 * spacing)
    points = np.column_stack([x.ravel(), y.ravel()])[contains_xy(room, x.ravel(), y.ravel())]
    return points + rng.normal(scale=0.03 * spacing, size=points.shape)


def _frames(silo, start, mass, n_walls, n_frames, outcome, rng) -> dict[str, np.ndarray]:
    time = 0.01 * np.arange(n_frames)
    n = len(start)
    x, y, leaves = _paths(silo, start, time, rng, flows=0.3 if "clogged" in outcome else 1.0)
    inside = y > -0.1
    dropped = np.minimum.accumulate(inside, axis=0)
    x, y = np.where(dropped, x, x[-1]), np.where(dropped, y, -0.1)
    vx, vy = np.gradient(x, time, axis=0), np.gradient(y, time, axis=0)
    angle = rng.uniform(0, 6, n) + rng.normal(scale=0.4, size=n) * np.minimum(time[:, None], 1.0)
    kinetic = (0.5 * mass * (vx**2 + vy**2) * inside).sum(axis=1)
    potential = (mass * GRAVITY * y * inside).sum(axis=1)
    elastic = 1e-3 * potential
    gone = ~inside
    carried_out = (gone * mass * (GRAVITY * -0.1 + 2.0)).sum(axis=1)
    held = kinetic + potential + elastic
    lost = np.maximum.accumulate(np.maximum(held[0] - held - carried_out, 0))
    shares = np.array([0.22, 0.04, 0.4, 0.1, 0.02, 0.22])
    weight = mass @ inside.T * GRAVITY
    out_time = np.where(time[:, None] >= leaves, leaves, np.nan)
    single = {"x": x, "y": y, "angle": angle, "vx": vx, "vy": vy, "spin": 0 * x}
    return {
        **{key: array.astype(np.float32) for key, array in single.items()},
        "time": time,
        "inside": inside,
        "n_out": (~np.isnan(out_time)).sum(axis=1),
        "steps": 2000 * np.arange(n_frames),
        "kinetic": kinetic,
        "potential": potential,
        "elastic_normal": 0.9 * elastic,
        "elastic_tangential": 0.1 * elastic,
        "carried_out": held[0] - held - lost * (1 + 2e-5 * np.sin(9 * time)),
        **{name: share * lost for name, share in zip(MECHANISMS, shares, strict=True)},
        "wall_force": _wall_forces(silo, weight, n_walls, rng),
        "out_time": out_time,
    }


def _paths(silo, start, time, rng, flows: float):
    """Positions (F, n) and times at which particles leave (n,), of which a part `flows` does."""
    reach = np.hypot(start[:, 0] - silo.outlet_centre, 0.8 * start[:, 1])
    order = np.argsort(np.argsort(reach + rng.normal(scale=0.02, size=len(start))))
    leaves = LEAVING * time[-1] * (order + 1) / len(start)
    leaves = np.where(order < flows * len(start), leaves, np.inf)
    left = np.sqrt(np.clip(1 - time[:, None] / leaves, 0, 1))
    past = np.clip(time[:, None] - leaves, 0, None)
    target = silo.outlet_centre + 0.4 * silo.outlet * np.tanh(
        (start[:, 0] - silo.outlet_centre) / silo.outlet
    )
    x = target + (start[:, 0] - target) * left
    y = start[:, 1] * left - 0.5 * past - GRAVITY / 2 * past**2
    return x, y, leaves


def _wall_forces(silo, weight, n_walls, rng) -> np.ndarray:
    """Forces (F, w, 2) [N] that push each wall outwards and down, and the door at first."""
    along = silo.walls().segments[:, 1] - silo.walls().segments[:, 0]
    outwards = np.column_stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)[:, None]
    pushed = outwards + np.array([0.0, -0.4])
    noise = rng.lognormal(sigma=0.3, size=(len(weight), n_walls))
    force = weight[:, None, None] / n_walls * noise[:, :, None] * pushed
    force[1:, -1] = 0.0
    return force


def _summary(silo, outcome, out_time, mass) -> dict:
    measures = discharge_measures(out_time, mass)
    ended = outcome not in ("clogged", "clogged_at_opening", "time_limit")
    return {
        "silo": silo.name,
        "outcome": outcome,
        "n_particles": len(mass),
        "n_out": measures["n_out"],
        "discharge_time_s": measures["last_out_s"] if ended else None,
        "t90_s": measures["t90_s"] if ended else None,
        "mean_rate_per_s": measures["mean_rate_per_s"],
        "published": published_times(silo.name),
    }
