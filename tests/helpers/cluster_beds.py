"""Clusters of acrylic sub-spheres, alone and in small beds that start in vigorous motion."""

import dataclasses
import math

import numpy as np
from damper_beds import DENSITY, DOWN, NOWHERE, SHAKEN, STILL, acrylic

from damper3d.engine.enclosures import box, cylinder
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world
from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.particle import parse_particle
from granulab.contact.hertz import HertzLaw

SMALL = 2.2e-3  # equal-volume radius of the particles of beds [m]
ROOMS = {"cylinder": cylinder(0.0176, 0.0176), "box": box(0.0176, 0.0176, 0.0176)}


def particle(text: str = "prolate:1.5", radius: float = SMALL, **options) -> MultiSphere:
    """A shape by its name, of that equal-volume radius [m]."""
    return parse_particle(text, radius, **options)


def asymmetric(cluster: MultiSphere) -> MultiSphere:
    """The same spheres with three different moments of inertia."""
    return dataclasses.replace(cluster, inertia=cluster.inertia * np.array([1.0, 1.4, 0.9]))


def world_of(
    cluster: MultiSphere, positions, orientations=None, *, room=None, shaker=STILL, gravity=NOWHERE,
    pair_law: HertzLaw | None = None, wall_law: HertzLaw | None = None, time_step=1e-6,
    treatment="sum", direction=(0.0, 0.0, 1.0),
) -> Simulation:  # fmt: skip
    """Clusters at rest in a room of a metre, if no other is given."""
    law = acrylic()
    return Simulation(
        build_world(
            np.atleast_2d(positions), cluster,
            None if orientations is None else np.atleast_2d(orientations), density=DENSITY,
            enclosure=room or box(1.0, 1.0, 1.0), pair_law=pair_law or law,
            wall_law=wall_law or law, shaker=shaker, direction=np.array(direction),
            gravity=np.array(gravity, float), time_step=time_step, treatment=treatment,
        )
    )  # fmt: skip


def bed(shape="cylinder", cluster: MultiSphere | None = None, *, speed=0.5, shaker=SHAKEN,
        gravity=DOWN, steps_per_sample=1, **options) -> Simulation:  # fmt: skip
    """27 clusters on a grid, turned and moving at random [m/s]."""
    rng = np.random.default_rng(5)
    cluster = cluster or particle()
    pitch = 2.0 * max(cluster.bounding_radius, 2.9e-3)
    x, y, z = np.meshgrid(*[pitch * np.array([-1, 0, 1])] * 2, pitch * np.array([0.5, 1.5, 2.5]))
    places = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    edge = ROOMS[shape].cylinder_radius - cluster.bounding_radius
    if edge > 0.0:
        places = places[np.hypot(places[:, 0], places[:, 1]) < edge]
    turns = rng.normal(size=(len(places), 4))
    sim = world_of(
        cluster, places, turns / np.linalg.norm(turns, axis=1)[:, None], room=ROOMS[shape],
        shaker=shaker, gravity=gravity, **options,
    )  # fmt: skip
    sim.steps_per_sample = steps_per_sample
    velocity = speed * rng.uniform(-1.0, 1.0, (len(places), 3))
    sim.set_velocity(velocity, speed / SMALL * rng.uniform(-1.0, 1.0, (len(places), 3)))
    return sim


def touching(sim: Simulation) -> set[tuple[int, int, int, int]]:
    """All contacts now: particle and its sphere, then particle or wall and its sphere."""
    contacts = sim.contacts()
    (i, j), (p, q) = contacts["bodies"].T, contacts["spheres"].T
    found = list(zip(i.tolist(), p.tolist(), j.tolist(), q.tolist(), strict=True))
    assert len(found) == len(set(found)), "a contact is listed twice"
    return set(found)


def about(axis, angle) -> np.ndarray:
    """The quaternion of a turn by an angle [rad] about an axis (3,)."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    return np.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis)])


def rotation(q) -> np.ndarray:
    """The matrix (3, 3) of a unit quaternion, from the body to the laboratory."""
    w, x, y, z = q
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def spheres_of(sim: Simulation, cluster: MultiSphere) -> np.ndarray:
    """Centres of all spheres (n, k, 3) in the enclosure [m]."""
    frame = sim.frame()
    turned = [cluster.offsets @ rotation(q).T for q in frame["orientation"]]
    return frame["x"][:, None, :] + np.array(turned)
