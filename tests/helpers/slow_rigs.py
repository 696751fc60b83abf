"""Clusters between half containers: a few particles, for tests of the walls and of the servo."""

from typing import Any

import numpy as np
from cluster_beds import SMALL, particle
from damper_beds import DENSITY, DOWN, NOWHERE, STILL, acrylic

from damper3d.engine.world import build_world
from damper3d.studies.quasistatic.rig import Halves, RigSimulation

HALVES = Halves(diameter=0.0176, height=0.0088, gap=0.5e-3)
UP = np.array([0.0, 0.0, 1.0])


def rig(cluster, positions, orientations=None, *, gravity=NOWHERE, law=None, time_step=1e-6,
        treatment="sum", halves=HALVES, **options: Any) -> RigSimulation:  # fmt: skip
    """Clusters at rest between halves that rest, the table at the top."""
    law = law or acrylic()
    world = build_world(
        np.atleast_2d(positions), cluster,
        None if orientations is None else np.atleast_2d(orientations), density=DENSITY,
        enclosure=halves.enclosure, pair_law=law, wall_law=law, shaker=STILL, direction=UP,
        gravity=np.array(gravity, float), time_step=time_step, treatment=treatment,
    )  # fmt: skip
    sim = RigSimulation.between(halves.lines, world)
    sim.steps_per_sample = options.get("steps_per_sample", 1)
    return sim


def bed(treatment="sum", *, speed=0.5, **options: Any) -> RigSimulation:
    """12 spheroids on a grid, turned and moving at random [m/s], in halves that rest."""
    rng = np.random.default_rng(5)
    cluster = particle("prolate:1.5")
    pitch = 2.02 * cluster.bounding_radius
    x, y, z = np.meshgrid(*[0.5 * pitch * np.array([-1, 1])] * 2, pitch * np.array([0.5, 1.5, 2.5]))
    places = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    turns = rng.normal(size=(len(places), 4))
    sim = rig(cluster, places, turns / np.linalg.norm(turns, axis=1)[:, None], gravity=DOWN,
              treatment=treatment, **options)  # fmt: skip
    sim.set_velocity(
        speed * rng.uniform(-1.0, 1.0, places.shape),
        speed / SMALL * rng.uniform(-1.0, 1.0, places.shape),
    )
    return sim
