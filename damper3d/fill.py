"""Filling: a random start, and settling under gravity with the case's own law."""

import math
import time
from collections.abc import Callable

import numpy as np

from contact.quantity import InputError
from damper3d.case import GRAVITY, DamperCase
from damper3d.grow import grow
from damper3d.packing import Packing, lowest, packing_fraction
from damper3d.shaker import Sines
from damper3d.simulation import Simulation
from damper3d.world import build_world

_LOOK = 1e-3  # [s] of simulated time between reports

Report = Callable[[float, str], None]  # fraction done (0 to 1), words


def fill(case: DamperCase, report: Report) -> Packing:
    """Fill the enclosure of a case, from its seed, and let the particles settle.

    They settle for [fill] settle_time, under the gravity that they are shaken under, or 1 g along
    -z where they are shaken without. Raises InputError where they do not fit, SimulationError, and
    what `report` raises.
    """
    report(0.0, "filling")
    if len(case.particle.radii) > 1:
        raise InputError(
            f"{case.name}: [particles] shape = {case.particle.name!r}: cannot be run so far; "
            "spheres can, such as 'sphere:5mm'"
        )
    grow(case.enclosure, 1, case.particle.bounding_radius, np.random.default_rng(0))  # compiles
    begun = time.process_time()
    centres = random_start(case)
    growing = time.process_time() - begun
    sim = resting(case, centres)
    sim.compile()
    begun = time.process_time()
    n_steps = math.ceil(case.settings.fill.settle_time / case.steps.free)
    n_looks = math.ceil(case.settings.fill.settle_time / _LOOK)
    sim.steps_per_sample = math.ceil(n_steps / n_looks)
    for k in range(n_looks):
        sim.run(1)
        report((k + 1) / n_looks, f"settling, t = {sim.time:.3f} s")
    return packed(case, sim, growing + time.process_time() - begun)


def random_start(case: DamperCase) -> np.ndarray:
    """Centres (count, 3) [m] of particles, from the case's seed, that do not overlap.

    Raises InputError where there are too many.
    """
    rng = np.random.default_rng(case.settings.run.seed)
    radius = case.particle.bounding_radius
    centres, reached = grow(case.enclosure, case.count, radius, rng)
    if reached < 1.0:
        fit = max(math.floor(case.count * reached**3), 1)
        raise InputError(
            f"{case.name}: [particles] count = {case.count}: fill ratio {case.fill_ratio:.3f}; "
            f"random filling found room for particles of {reached:.3f} of their size, so for about "
            f"{fit}; give fewer, or a larger enclosure"
        )
    return centres


def resting(case: DamperCase, centres: np.ndarray) -> Simulation:
    """Particles at rest at some centres (count, 3) [m] in an enclosure that does not move."""
    still = Sines(np.zeros(1), np.zeros(1), np.zeros(1), 0.0)
    world = build_world(
        centres,
        np.full(len(centres), case.particle.radii[0]),
        density=case.density,
        enclosure=case.enclosure,
        pair_law=case.pair_law,
        wall_law=case.wall_law,
        shaker=still,
        direction=case.direction,
        gravity=case.settling_gravity,
        time_step=case.steps.free,
        curved_wall=case.settings.law.wall_curvature,
    )
    return Simulation(world)


def packed(case: DamperCase, sim: Simulation, cpu_s: float) -> Packing:
    """The packing that a simulation has come to."""
    frame, touching = sim.frame(), sim.contacts()["bodies"]
    up = -case.settling_gravity / GRAVITY
    ends = int(np.count_nonzero(touching < sim.n_bodies))
    return Packing(
        state=sim.save(),
        fraction=packing_fraction(frame["x"], case.particle.volume, case.enclosure, up),
        height=float((frame["x"] @ up).max())
        + case.particle.bounding_radius
        - lowest(case.enclosure, up),
        coordination=ends / sim.n_bodies,
        rms_speed=float(np.sqrt((frame["v"] ** 2).sum(axis=1).mean())),
        cpu_s=cpu_s,
    )
