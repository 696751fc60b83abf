"""Filling: a random start, and settling under gravity with the case's own law."""

import math
import time
from collections.abc import Callable

import numpy as np

from damper3d.case.case import GRAVITY, DamperCase
from damper3d.case.plan import expected_cpu_of_step
from damper3d.engine.growth.multisphere import grow_clusters, random_places
from damper3d.engine.growth.spheres import grow
from damper3d.engine.motions import at_rest
from damper3d.engine.simulation import Simulation
from damper3d.engine.state import World
from damper3d.engine.world import build_world
from damper3d.run.packing import Packing, packing_fraction
from granulab.campaign.runs.sharing import shared_by
from granulab.errors import InputError

_LOOK = 1e-3  # [s] of simulated time between reports
_LOOSE = 0.75  # cost of a step at the start of settling over the mean

Report = Callable[[str, float, str], None]  # stage, fraction done (0 to 1), words


def fill(case: DamperCase, report: Report) -> Packing:
    """Fill the enclosure of a case, from its seed, and let the particles settle.

    They settle for [fill] settle_time, with [fill] friction, under the gravity that they are shaken
    under, or 1 g along -z where they are shaken without. Raises InputError where they do not fit,
    SimulationError, and what `report` raises.
    """
    case = case.settling
    report("filling", 0.0, "random start")
    random_start(case, 1)  # compiles
    begun = time.process_time()

    def grown(part: float) -> None:
        report("filling", part, f"grown to {part:.0%}")

    sim = resting(case, *random_start(case, case.count, grown))
    growing = time.process_time() - begun
    sim.compile()
    begun = time.process_time()
    n_steps = math.ceil(case.settings.fill.settle_time / case.steps.free)
    n_looks = math.ceil(case.settings.fill.settle_time / _LOOK)
    sim.steps_per_sample = math.ceil(n_steps / n_looks)
    for k in range(n_looks):
        sim.run(1)
        report("settling", _part_settled((k + 1) / n_looks), f"t = {sim.time:.3f} s")
    return packed(case, sim, growing + time.process_time() - begun)


def _part_settled(part: float) -> float:
    """Part of the cost of settling that part of its time took: few touch at first, then most."""
    return part * (_LOOSE + part * (1.0 - _LOOSE))


def random_start(
    case: DamperCase, count: int, grown: Callable[[float], None] | None = None
) -> tuple[np.ndarray, np.ndarray | None]:
    """Centres (count, 3) [m] and orientations (count, 4) of particles, from the case's seed.

    They do not overlap. Orientations are unit quaternions, None of spheres. grown is called with
    the part (0 to 1) of their growth that is over. Raises InputError where there are too many.
    """
    rng = np.random.default_rng(case.settings.run.seed)
    orientations = None
    if case.of_spheres:
        radius = case.particle.bounding_radius if case.bed is None else case.radii[:count]
        centres, reached = grow(case.enclosure, count, radius, rng, grown)
    else:
        solids = case.solids(count)
        *places, first = random_places(case.enclosure, solids, count, rng)
        world = resting(case, *places).world
        reached = grow_clusters(world, solids, first, grown)
        centres, orientations = world.particles.position[:, :3], world.particles.orientation
    if reached < 1.0:
        fit = max(math.floor(count * reached**3), 1)
        raise InputError(
            f"{case.name}: [particles] count = {count}: fill ratio {case.fill_ratio:.3f}; "
            f"random filling found room for particles of {reached:.3f} of their size, so for about "
            f"{fit}; give fewer, or a larger enclosure"
        )
    return centres, orientations


def resting(
    case: DamperCase, centres: np.ndarray, orientations: np.ndarray | None = None
) -> Simulation:
    """Particles at rest in an enclosure that does not move; see world_of."""
    sim = Simulation(world_of(case, centres, orientations, rotating=not case.of_spheres))
    sim.share(shared_by(expected_cpu_of_step(case)))
    return sim


def world_of(
    case: DamperCase, centres: np.ndarray, orientations: np.ndarray | None, *, rotating: bool
) -> World:
    """The particles of a case at rest.

    centres (count, 3) [m]; orientations (count, 4) of multi-sphere particles, of no rotation if
    left out; rotating: whether they have an orientation, which a sphere needs not.
    """
    n = len(centres)
    pair_law, wall_law = case.laws(n)
    return build_world(
        centres,
        case.solids(n) if rotating else case.radii[:n],
        orientations,
        density=case.density if case.bed is None else case.bed.density[:n],
        enclosure=case.enclosure,
        pair_law=pair_law,
        wall_law=wall_law,
        shaker=at_rest(),
        direction=case.direction,
        gravity=case.settling_gravity,
        time_step=case.steps.free,
        curved_wall=case.settings.law.wall_curvature,
        treatment=case.settings.law.contact_treatment,
        yields=[math.nan if v is None else v for v in case.yield_velocity.values()],
    )


def packed(case: DamperCase, sim: Simulation, cpu_s: float) -> Packing:
    """The packing that a simulation has come to."""
    frame, touching = sim.frame(), np.unique(sim.contacts()["bodies"], axis=0)
    up = -case.settling_gravity / GRAVITY
    volumes = case.particle.volume if case.bed is None else case.bed.volume
    ends = int(np.count_nonzero(touching < sim.n_particles))
    return Packing(
        state=sim.save(),
        fraction=packing_fraction(frame["x"], volumes, case.enclosure, up),
        height=sim.top(up) - case.enclosure.lowest(up),
        coordination=ends / sim.n_particles,
        rms_speed=float(np.sqrt((frame["v"] ** 2).sum(axis=1).mean())),
        cpu_s=cpu_s,
    )
