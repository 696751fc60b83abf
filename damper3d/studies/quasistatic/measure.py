"""Results of a slow test: force over displacement, stiffness, balances of force and energy.

compress   z is how far the table came below where the pre-load held it, F_z the vertical force of
           the particles on the base, and F(z) is what the thesis draws in Figs 8.16 and 8.17
shear      x is how far the top half came, F_x the horizontal force of the particles on the bottom
           half, base and side, as in Figs 8.18 and 8.19

A row's force is a mean over the time since the row before, so its displacement is the mean of both.
The force at no displacement is the mean over the last rows of the pre-load.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from damper3d.measures.efficiency import closure, impact_ratios
from damper3d.run.packing import packing_fraction
from damper3d.studies.quasistatic.case import SlowTest
from damper3d.studies.quasistatic.course import WINDOW, Course, Samples
from damper3d.studies.quasistatic.rig import BASE, BOTTOM_SIDE, TABLE, TOP_SIDE, RigSimulation
from granulab.campaign.runs.result import Results

_UP = np.array([0.0, 0.0, 1.0])


def summary(test: SlowTest, course: Course, sim: RigSimulation) -> dict[str, Any]:
    """Results of a test that came to its end, as Result names them."""
    way, force = curve(test, course)
    table = course.test["wall_force"][1:, TABLE, 2]
    held = test.kind == "shear"
    closed, gained = closure(course.test)
    return {
        "test": test.kind,
        "particles": test.damper.particle.name,
        "n_particles": test.damper.count,
        "seed": test.settings.run.seed,
        "preload_n": test.preload,
        "preload_mean_n": float(table.mean()) if held else None,
        "preload_rms_deviation_n": _rms(table - test.preload) if held else None,
        "preload_displacement_m": course.touch - float(course.preload["place"][-1, TABLE, 2]),
        "bed_height_m": test.halves.enclosure.height + float(course.preload["place"][-1, TABLE, 2]),
        "packing_fraction": fraction(test, sim),
        "speed_m_per_s": test.speed,
        "distance_m": test.distance,
        "inertial_number": inertial_number(test, course),
        "at_m": test.at,
        "stiffness_n_per_m": stiffness(test.at, way, force),
        "force_start_n": float(force[0]),
        "force_end_n": float(force[-1]),
        "force_mean_n": mean_rise(way, force),
        "displacement_m": way.tolist(),
        "force_n": force.tolist(),
        "force_imbalance": imbalance(test, course.test, float(sim.mass.sum())),
        "energy_closure": closed,
        "law_term": gained,
        "max_impact_over_yield_velocity": impact_ratios(course.test, test.damper.yield_velocity),
    }


def curve(test: SlowTest, course: Course) -> tuple[np.ndarray, np.ndarray]:
    """Displacement (n,) [m] and force (n,) [N] of the test, from no displacement on."""
    if test.kind == "shear":
        position = course.test["place"][:, TOP_SIDE, 0]
    else:
        position = -course.test["place"][:, TABLE, 2]
    position = position - position[0]
    before = reaction(test, course.preload)[-WINDOW:].mean()
    return (
        np.append(0.0, 0.5 * (position[1:] + position[:-1])),
        np.append(before, reaction(test, course.test)[1:]),
    )


def reaction(test: SlowTest, rows: Samples) -> np.ndarray:
    """The force that is measured (n,) [N], positive against the displacement of the test."""
    force = rows["wall_force"]
    if test.kind == "shear":
        return force[:, BASE, 0] + force[:, BOTTOM_SIDE, 0]
    return -force[:, BASE, 2]


def stiffness(at: float, way: np.ndarray, force: np.ndarray) -> float:
    """Secant of the curve from no displacement to `at` [N/m]; at most to its last point."""
    end = min(at, way[-1])  # half a row before the whole distance
    return float((np.interp(end, way, force) - force[0]) / end)


def mean_rise(way: np.ndarray, force: np.ndarray) -> float:
    """Mean over the displacement of the force above that at its beginning [N]."""
    return float(np.trapezoid(force - force[0], way) / way[-1])


def inertial_number(test: SlowTest, course: Course) -> float:
    """Shear rate or rate of strain times d sqrt(rho/p), d the equal-volume diameter [-].

    Of shear, as if it were all across one diameter, the most it can be; quasi-static below 1e-3
    (GDR MiDi 2004, 10.1140/epje/i2003-10153-0).
    """
    time = math.sqrt(test.damper.density / test.pressure)
    if test.kind == "shear":
        return test.speed * time
    height = test.halves.enclosure.height + float(course.preload["place"][-1, TABLE, 2])
    return 2.0 * test.damper.particle.equal_volume_radius * test.speed / height * time


def fraction(test: SlowTest, sim: RigSimulation) -> float:
    """Volume of the particles over that of the space below 80 % of their centres [-], at the end.

    Of compression alone exact: where the top half was moved, as if it had not been.
    """
    particle = test.damper.particle
    return packing_fraction(sim.frame()["x"], particle.volume, test.halves.enclosure, _UP)


def imbalance(test: SlowTest, rows: Samples, mass: float) -> float:
    """Sum of all forces on the walls, the weight and the inertia, over the largest [-].

    Newton's third law, over the whole test: the particles push the walls with their weight less the
    rate of their momentum.
    """
    length = rows["time"][-1] - rows["time"][0]
    pushed = rows["wall_force"][1:].mean(axis=0)
    rate = (rows["mean_velocity"][-1] - rows["mean_velocity"][0]) / length
    left = pushed.sum(axis=0) - mass * (test.damper.settling_gravity - rate)
    return float(np.abs(left).max() / np.abs(pushed).max())


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


@dataclass(frozen=True)
class Result(Results):
    """Results of a test; SI, None for what does not exist."""

    test: str
    particles: str
    n_particles: int
    seed: int
    preload_n: float
    preload_mean_n: float | None  # on the table during the test; None where it is not held
    preload_rms_deviation_n: float | None
    preload_displacement_m: float  # of the table, from the top of the bed to where it rests
    bed_height_m: float  # under the pre-load
    packing_fraction: float
    speed_m_per_s: float
    distance_m: float
    inertial_number: float
    at_m: float
    stiffness_n_per_m: float  # secant to at_m
    force_start_n: float
    force_end_n: float
    force_mean_n: float  # above that at the start, mean over the distance
    displacement_m: list[float]
    force_n: list[float]
    force_imbalance: float
    energy_closure: float | None
    law_term: float | None
    max_impact_over_yield_velocity: dict[str, float | None]
    time_step_s: float
    steps: int
    cpu_us_per_step: float
    cpu_s: float
    state_digest: str
    reused: bool
    run_folder: str
