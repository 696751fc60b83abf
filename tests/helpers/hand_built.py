"""Run folders of a few particles put together by hand, or with numbers of one's choice."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scenes

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import Trajectory, TrajectoryWriter
from granulab.contact.laws import LinearLaw
from silo2d.case.outline import Outline
from silo2d.case.shape import Shape
from silo2d.engine.simulation import Simulation
from silo2d.engine.world import build_world
from silo2d.measures.basics.contacts import Moment
from silo2d.run.discharge import contacts_of, frame_of
from silo2d.view.scene import Scene

GRAVITY = 9.81
TIME_STEP = 2e-6
# The wood's, with strong tangential dashpots, so that what is put down soon lies still.
STICKY = scenes.WOOD._replace(mu=0.5, gamma_t=5e3)


def static_of(shapes: Sequence[Shape], kinds, silo: Outline) -> tuple[dict, dict[str, Any]]:
    """What does not change from frame to frame, and the attributes, as a run keeps them."""
    outlines = [shape.rounded_outline() for shape in shapes]
    static = {
        "kind": np.asarray(kinds),
        "mass": scenes.SURFACE_DENSITY * np.array([shapes[k].area for k in kinds]),
        "layer": np.zeros(len(kinds), dtype=int),
        "shape_points": np.concatenate(outlines),
        "shape_start": np.cumsum([0, *map(len, outlines)]),
        "wall_segments": silo.walls().segments,
    }
    attributes = {
        "silo": silo.name,
        "wall_names": json.dumps(silo.walls().names),
        "lips": np.array(silo.lips),
        "level": silo.height,
    }
    return static, attributes


def simulation_in(
    silo: Outline, shapes: Sequence[Shape], poses, law: LinearLaw = STICKY, door: bool = False
) -> Simulation:
    """Particles, one of each shape, at rest in a silo whose door is away unless requested."""
    sim = Simulation(
        build_world(
            list(shapes), np.arange(len(shapes)), np.array(poses, dtype=float), silo.walls(),
            surface_density=scenes.SURFACE_DENSITY, particle_law=law, wall_law=law,
            gravity=GRAVITY, time_step=TIME_STEP,
        )
    )  # fmt: skip
    if not door:
        sim.remove_wall(len(silo.walls().names) - 1)
    return sim


def write_run(
    folder: Path, sim: Simulation, silo: Outline, shapes: Sequence[Shape], outcome: str
) -> Path:
    """Keep the present moment of a simulation as the last frame of a run that is over."""
    static = static_of(shapes, range(len(shapes)), silo)
    writer = TrajectoryWriter(folder)
    writer.append(frame_of(sim, sim.wall_forces()), contacts_of(sim))
    writer.finish(*static)
    run = RunFolder(folder)
    run.write_case(f'silo = "{silo.name}"\n')
    run.write_summary({"outcome": outcome, "discharge_time_s": None})
    return folder


def scene_of(shapes: Sequence[Shape], kinds, silo: Outline, x, y, vx=0.0, vy=0.0) -> Scene:
    """One frame of particles with positions and velocities (n,) of one's choice."""
    static, attributes = static_of(shapes, kinds, silo)
    n = len(static["kind"])
    columns = {"x": x, "y": y, "vx": vx, "vy": vy, "angle": 0.0}
    frames = {key: np.broadcast_to(value, (1, n)).copy() for key, value in columns.items()}
    frames |= {"time": np.zeros(1), "inside": np.ones((1, n), bool), "n_out": np.zeros(1, int),
               "out_time": np.full((1, n), np.nan)}  # fmt: skip
    return Scene(Trajectory(frames, static, attributes, [1]), {}, silo.walls().names)


def moment_of(scene: Scene, contacts: dict[str, Any]) -> Moment:
    """The contacts of the first frame of a scene: bodies, point and force, normal if needed."""
    count = len(contacts["bodies"])
    return Moment(
        scene=scene,
        frame=0,
        bodies=np.asarray(contacts["bodies"], dtype=np.int64),
        point=np.asarray(contacts["point"], dtype=float),
        force=np.asarray(contacts["force"], dtype=float),
        normal=np.asarray(contacts.get("normal", np.zeros((count, 2)))),
        overlap=np.asarray(contacts.get("overlap", np.zeros(count))),
        slides=np.asarray(contacts.get("slides", np.zeros(count, dtype=bool))),
    )


def moment_in(sim: Simulation, silo: Outline, shapes: Sequence[Shape]) -> Moment:
    """The present moment of a simulation, in double precision."""
    rows, kinds = sim.rows, range(len(shapes))
    scene = scene_of(shapes, kinds, silo, rows[:, 0], rows[:, 1], rows[:, 7], rows[:, 8])
    return moment_of(scene, sim.contacts())
