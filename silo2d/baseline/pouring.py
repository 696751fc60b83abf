"""Filling with pymunk: the rain of pour.py falls in an impulse engine, then rests under the law.

The impulses of a step are worked out by a few iterations, which do not carry the weight of a
whole heap: its particles sink into each other. So each falls with a skin round it, and the sinking
uses up the skin. What is left of it, and the overlaps that went through it, disappear when the
particles come to rest once more under the contact law of the filling.
"""

import math
import time
from typing import TYPE_CHECKING

import numpy as np

from granulab.errors import SimulationError
from silo2d.baseline.space import SMOOTH, add_particle, add_walls, empty_space, strays
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.outline import Outline
from silo2d.run.packing import Packing
from silo2d.run.pour import Report, down_at, level_off, packed, part_settled, pouring, rain, settle

if TYPE_CHECKING:
    import pymunk

# Lengths go with the spheroradius, as the deepest overlap that the law can undo does.
SKIN = 0.1  # of a falling particle, over the spheroradius
# Overlap that pymunk leaves alone, over the spheroradius: the skin at a wall, half of both skins
# between particles. A heap whose every overlap is pushed apart does not stop trembling.
SLOP = 0.1
# Part of the overlap beyond the slop that is pushed apart in a step: six times pymunk's usual, at
# which a heap of half a metre sinks through its skins and deeper all the time.
PUSH = 0.02
# Step over sqrt(spheroradius/g): 1/2000 s for 1 mm. A layer of the heap sinks by g step^2 in it.
STEP = 0.05
ITERATIONS = 10  # of the impulses, a step
# Normalised kinetic energy (as in pour.py) at which the law takes over. It needs no damping of the
# motion: the impacts are plastic, so that nothing bounces.
CALM = 1e-3
_STEPS = 10  # between looks at the kinetic energy
_PATIENCE = 6.0  # [s] of simulated time; a heap is calm long before
_WAY_OUT = "pour with [fill] pour_with = 'dem'"


def pour_with_pymunk(case: SiloCase, seed: int, report: Report) -> Packing:
    """Fill the silo with pymunk, and let the particles rest under the law of the filling.

    Raises SimulationError where particles are lost, too deep in each other, or do not come to rest.
    """
    kinds, poses, above = rain(case, np.random.default_rng(seed))
    outline = case.outline.raised(above)
    pouring(case, kinds, poses, outline).compile()
    begun = time.process_time()
    sim = pouring(case, kinds, fall(case, kinds, poses, outline, report), outline)
    settle(sim, case, report, "relaxing")
    kinds, poses = level_off(case, kinds, sim.poses())
    sim = pouring(case, kinds, poses, case.outline)
    settle(sim, case, report, "levelling")
    return packed(case, sim, kinds, "pymunk", time.process_time() - begun)


def fall(
    case: SiloCase, kinds: np.ndarray, poses: np.ndarray, outline: Outline, report: Report
) -> np.ndarray:
    """Poses (n, 3) [m, rad] of the rain once it has fallen to a calm heap behind the closed door.

    Raises SimulationError where a particle has passed through a wall, or the heap does not calm.
    """
    spheroradius = min(shape.spheroradius for shape in case.shapes.shapes)
    step = STEP * math.sqrt(spheroradius / GRAVITY)
    space = empty_space(ITERATIONS, SLOP * spheroradius)
    space.collision_bias = (1 - PUSH) ** (1 / step)  # what is left of an overlap after a second
    add_walls(space, outline.walls().segments, SMOOTH)
    shapes, density, skin = case.shapes.shapes, case.surface_density, SKIN * spheroradius
    particles = [
        add_particle(space, shapes[kind], density, pose, SMOOTH, skin).body
        for kind, pose in zip(kinds, poses.tolist(), strict=True)
    ]
    soonest = down_at(poses, case.settings.fill.level)
    now, start = 0.0, 0.0
    while True:
        for _ in range(_STEPS):
            space.step(step)
        now += _STEPS * step
        _check_inside(particles, outline)
        moving = _normalised_kinetic_energy(particles, case)
        start = max(start, moving)
        if moving < CALM and now >= soonest:
            return np.array([(*particle.position, particle.angle) for particle in particles])
        report("pouring", part_settled(start, moving, CALM), f"t = {now:.2f} s")
        if now > _PATIENCE:
            raise SimulationError(f"the heap did not calm within {_PATIENCE:g} s; {_WAY_OUT}")


def _normalised_kinetic_energy(particles: list["pymunk.Body"], case: SiloCase) -> float:
    """Kinetic energy over the energy that lifts each particle by the root of the mean area [-]."""
    # Not Body.kinetic_energy, which leaves out the factor 1/2.
    kinetic = 0.5 * sum(
        g.mass * g.velocity.length_squared + g.moment * g.angular_velocity**2 for g in particles
    )
    weight = GRAVITY * sum(g.mass for g in particles)
    return kinetic / (weight * math.sqrt(case.shapes.mean_area))


def _check_inside(particles: list["pymunk.Body"], outline: Outline) -> None:
    """Refuse to go on without a particle that has passed a wall: within one step a fast one can."""
    lost = strays(outline, np.array([particle.position for particle in particles]))
    if lost:
        raise SimulationError(f"pymunk lost {lost} of {len(particles)} particles; {_WAY_OUT}")
