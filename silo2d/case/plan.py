"""Plan of a run before anything is filled: particles, steps, CPU time."""

import math
from typing import Any

from silo2d.case.case import SiloCase

# Costs and usual values that the plan is made with.
_SECONDS_PER_PARTICLE_STEP = 6e-8  # on one core of a current server
_SECONDS_PER_PARTICLE_IMPULSES = 6e-7, 4e-8  # of pymunk: a step, and an iteration in it
_USUAL_FRACTION = 0.88  # packing fraction
FILLING, DISCHARGE = 1.1, 1.5  # [s] of simulated time


def plan(case: SiloCase) -> dict[str, Any]:
    """Plan of a run of a case: particles, steps, CPU time [min]."""
    step = case.impulses.time_step if case.impulses else case.time_step
    return {
        "silo": case.silo_name or case.name,
        "seed": case.settings.run.seed,
        "engine": case.settings.run.engine,
        "n_particles": expected_particles(case),
        "time_step_s": step,
        "time_step_reason": "as given" if case.impulses else case.time_step_reason,
        "restitution": case.restitution(),
        "steps_at_most": math.ceil(case.settings.run.max_time / step),
        "expected_min": sum(expected_cpu_s(case)) / 60,
    }


def expected_particles(case: SiloCase) -> int:
    """About how many particles fill the silo to its level."""
    area = case.outline.area_below(case.settings.fill.level)
    return round(area * _USUAL_FRACTION / case.shapes.mean_area)


def expected_cpu_s(case: SiloCase) -> tuple[float, float]:
    """About what the filling and the discharge of a case cost [s of CPU]."""
    n, cost, step = expected_particles(case), _SECONDS_PER_PARTICLE_STEP, case.time_step
    filling = 1.5 * cost * FILLING / case.pour_time_step
    if case.impulses:
        a_step, an_iteration = _SECONDS_PER_PARTICLE_IMPULSES
        cost, step = a_step + an_iteration * case.impulses.iterations, case.impulses.time_step
    discharge = 0.5 * cost * DISCHARGE / step  # half of the particles, on average, are inside
    return n * filling, n * discharge
