"""Equal particles that do not meet over a wide flat floor without gravity, for studies to press."""

import math

import numpy as np

from damper3d.engine.enclosures import box
from damper3d.engine.motions import sine
from damper3d.engine.multisphere import (
    rotation,  # its kernels are called as Python here, uncompiled
)
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world
from damper3d.shapes.multisphere import MultiSphere
from granulab.contact.hertz import HertzLaw

_HELD = 1e-12  # [s] a step in which no force moves anything


AS_IT_IS = np.array([1.0, 0.0, 0.0, 0.0])  # the orientation of a particle in its own axes


def turn(axis: tuple[float, float, float], angle: float) -> np.ndarray:
    """The unit quaternion (w, x, y, z) of a turn by an angle [rad] about an axis of length 1."""
    return np.array([math.cos(angle / 2), *(math.sin(angle / 2) * np.array(axis))])


def combined(second: np.ndarray, first: np.ndarray) -> np.ndarray:
    """The quaternion of two rotations, one after the other."""
    return np.array(rotation.product.py_func(tuple(second), tuple(first)))


def matrix(q: np.ndarray) -> np.ndarray:
    """The rotation (3, 3) of a unit quaternion, from the body to the laboratory."""
    return np.array(rotation.axes_of.py_func(tuple(q))).T


def depth_of(particle: MultiSphere, orientation: np.ndarray) -> float:
    """Distance from its centroid down to its lowest point [m]."""
    heights = particle.offsets @ matrix(orientation)[2]
    return float((particle.radii - heights).max())


def over_floor(
    particle: MultiSphere, orientations: np.ndarray, gaps: np.ndarray, *, law: HertzLaw,
    treatment: str, density: float, time_step: float,
) -> Simulation:  # fmt: skip
    """Clusters at rest, each with its orientation (n, 4) and a gap (n,) above the floor z = 0 [m].

    A negative gap is an overlap. They stand too far from each other and from the sides to touch.
    """
    n, radius = len(gaps), particle.bounding_radius
    side = math.ceil(math.sqrt(n))
    pitch = 4.0 * radius
    row, column = np.divmod(np.arange(n), side)
    heights = [depth_of(particle, q) for q in orientations] + np.asarray(gaps)
    middle = 0.5 * (side - 1)
    positions = np.column_stack([pitch * (column - middle), pitch * (row - middle), heights])
    width = pitch * (side + 1)
    world = build_world(
        positions, particle, np.asarray(orientations), density=density,
        enclosure=box(width, width, 10.0 * radius), pair_law=law, wall_law=law,
        shaker=sine(0.0, 100.0, 9.81), direction=np.array([0.0, 0.0, 1.0]),
        gravity=np.zeros(3), time_step=time_step, treatment=treatment,
    )  # fmt: skip
    return Simulation(world)


def pressed(
    particle: MultiSphere,
    orientation: np.ndarray,
    overlaps: np.ndarray,
    law: HertzLaw,
    treatment: str,
) -> np.ndarray:
    """Normal forces (n,) [N] on a particle held at overlaps (n,) [m] of its lowest sub-sphere."""
    orientations = np.tile(orientation, (len(overlaps), 1))
    sim = over_floor(particle, orientations, -np.asarray(overlaps), law=law, treatment=treatment,
                     density=1.0, time_step=_HELD)  # fmt: skip
    sim.step(1)
    return sim.world.particles.force[:, 2].copy()


def sheared(
    particle: MultiSphere, orientation: np.ndarray, overlap: float, furthest: float, steps: int,
    law: HertzLaw, treatment: str,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Shifts along x (steps,) [m] up to about `furthest`, and the forces [N] against them.

    The particle is held at an overlap [m]. The forces of a leapfrog are those of the middle of its
    steps.
    """
    sim = over_floor(particle, orientation[None], np.array([-overlap]), law=law,
                     treatment=treatment, density=1.0, time_step=_HELD)  # fmt: skip
    stride = furthest / steps
    forces = np.empty(steps)
    for n in range(steps):
        sim.set_velocity(np.array([[stride / _HELD, 0.0, 0.0]]), np.zeros((1, 3)))
        sim.step(1)
        forces[n] = -sim.world.particles.force[0, 0]
    return stride * (np.arange(steps) + 0.5), forces
