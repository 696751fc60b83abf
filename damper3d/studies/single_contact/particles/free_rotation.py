"""Free rotation of a particle against Jacobi's elliptic functions (triaxial) and a precession.

The moments are those of smooth shapes of 3.8 mm equal-volume radius; the triaxial one is the
ellipsoid 1 : 0.75 : 0.5. It begins near its middle axis, where a turn is the least even.
"""

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.engine.simulation import Simulation
from damper3d.shapes.multisphere import MultiSphere, sphere
from damper3d.shapes.particle import parse_particle
from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.particles.held import AS_IT_IS, matrix, over_floor
from granulab.campaign.output.figure import BLUE, GREEN, GREY, VERMILION, headline, ticked
from granulab.contact.files.table import load_table
from granulab.contact.sphere_law import sphere_law

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HALF_AXES = (1.0, 0.75, 0.5)
DENSITY = 1190.0  # of acrylic [kg/m3]; the motion does not depend on it
SPIN = (60.0, 600.0, 120.0)  # about the triaxial body's axes, moments rising [rad/s]
SPHEROID_SPIN = (300.0, -500.0, 600.0)
SECONDS = 0.05
STEPS = (4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5)  # [s]
_CURVE_STEP = 2.5e-5  # of the curves in the picture [s]
SPHEROIDS = ("prolate:1.5", "oblate:0.7")


def jacobi(inertia: np.ndarray, spin: np.ndarray, times: np.ndarray) -> np.ndarray:
    """w (n, 3) [rad/s] of a free body in its own axes at times (n,) [s].

    inertia: three moments, rising [kg m2]; spin (3,) at time 0 [rad/s], such that it turns about
    the axis of the largest moment (L^2 > 2 T I_2). With the kinetic energy T and the angular
    momentum L (Landau and Lifshitz, Mechanics, sec. 37), tau the time times a rate and k^2 the
    parameter, w = (w_1 cn, w_2 sn, w_3 dn)(tau + tau_0).
    """
    from scipy.special import ellipj, ellipkinc

    i1, i2, i3 = inertia
    twice, square = float(inertia @ spin**2), float((inertia**2) @ spin**2)
    low, high = square - twice * i1, twice * i3 - square
    k2 = (i2 - i1) * high / ((i3 - i2) * low)
    rate = math.sqrt((i3 - i2) * low / (i1 * i2 * i3))
    w1 = math.sqrt(high / (i1 * (i3 - i1)))
    w2 = math.sqrt(high / (i2 * (i3 - i2)))
    w3 = math.sqrt(low / (i3 * (i3 - i1)))
    # sn and cn at time 0 fix tau_0; the sense in which tau runs is that of Euler's equations,
    # I_3 w_3' = (I_1 - I_2) w_1 w_2, for w_3 of either sign.
    sense = math.copysign(1.0, spin[2])
    phase = math.atan2(spin[1] / w2, spin[0] / w1)
    sn, cn, dn, _ = ellipj(sense * rate * times + float(ellipkinc(phase, k2)), k2)
    return np.column_stack([w1 * cn, w2 * sn, math.copysign(w3, spin[2]) * dn])


def compute() -> Found:
    """Errors against the time step, and the rotation itself."""
    body = triaxial()
    exact = jacobi(moments(body), np.array(SPIN), np.array([SECONDS]))[0]
    errors, gains = [], []
    for step in STEPS:
        sim = turning(body, SPIN, step)
        energy = float(sim.sample()["kinetic"][0])
        sim.step(round(SECONDS / step))
        errors.append(float(np.abs(own_spin(sim) - exact).max() / np.abs(exact).max()))
        gains.append(abs(float(sim.sample()["kinetic"][0]) / energy - 1.0))
    numbers: dict[str, Any] = {
        "triaxial": {
            "time_steps_s": list(STEPS),
            "errors_of_spin": errors,
            "energy_changes": gains,
            "order_of_spin": _order(errors),
            "order_of_energy": _order(gains),
        }
    }
    for text in SPHEROIDS:
        numbers[text] = {"largest_error_of_axis": precession_error(text, STEPS[0])}
    rows = _curve(body)
    remark = (
        "errors over the largest angular velocity, after 0.05 s; of a spheroid's axis (length 1), "
        "at 0.4 ms"
    )
    return Found(numbers, rows, (remark,))


def triaxial() -> MultiSphere:
    """An ellipsoid 1 : 0.75 : 0.5, moments rising from x to z; its spheres play no part."""
    ball = sphere(3.8e-3)
    a = 3.8e-3 / np.prod(HALF_AXES) ** (1 / 3) * np.array(HALF_AXES)
    return dataclasses.replace(ball, inertia=ball.volume / 5.0 * (float(a @ a) - a**2))


def moments(body: MultiSphere) -> np.ndarray:
    """Principal moments (3,) [kg m2]."""
    return DENSITY * body.inertia


def turning(body: MultiSphere, spin: tuple[float, ...], time_step: float) -> Simulation:
    """One body far above the floor that begins to turn with a spin in its own axes [rad/s]."""
    acrylic = load_table("acrylic").material("acrylic")
    law = sphere_law(acrylic, acrylic, friction=0.0, restitution=1.0)
    sim = over_floor(body, AS_IT_IS[None], np.array([body.bounding_radius]), law=law,
                     treatment="sum", density=DENSITY, time_step=time_step)  # fmt: skip
    sim.set_velocity(np.zeros((1, 3)), np.array([spin]))
    return sim


def own_spin(sim: Simulation) -> np.ndarray:
    """w (3,) in the body's axes [rad/s]."""
    now = sim.frame()
    return matrix(now["orientation"][0]).T @ now["spin"][0]


def precession_error(text: str, step: float) -> float:
    """Largest deviation of a spheroid's axis from going round L at |L|/I_across [-]."""
    body = parse_particle(text, 3.8e-3, sub_spheres=21)
    momentum = moments(body) * np.array(SPHEROID_SPIN)
    along = momentum / np.linalg.norm(momentum)
    rate = float(np.linalg.norm(momentum)) / moments(body)[1]
    sim, first, most = turning(body, SPHEROID_SPIN, step), np.array([1.0, 0.0, 0.0]), 0.0
    level = (first @ along) * along
    for _ in range(round(SECONDS / step)):
        sim.step(1)
        angle = rate * sim.time
        wanted = (
            level + math.cos(angle) * (first - level) + math.sin(angle) * np.cross(along, first)
        )
        axis = matrix(sim.frame()["orientation"][0])[:, 0]
        most = max(most, float(np.abs(axis - wanted).max()))
    return most


def _order(errors: list[float]) -> float:
    """The slope of errors against time steps in logarithms [-]."""
    return float(np.polyfit(np.log(STEPS), np.log(errors), 1)[0])


def _curve(body: MultiSphere) -> list[dict[str, Any]]:
    sim, rows = turning(body, SPIN, _CURVE_STEP), []
    every = 10
    for _ in range(round(SECONDS / _CURVE_STEP / every)):
        sim.step(every)
        exact = jacobi(moments(body), np.array(SPIN), np.array([sim.time]))[0]
        found = own_spin(sim)
        rows.append(
            {"time_s": sim.time}
            | {f"spin_{n}_rad_s": float(found[k]) for k, n in enumerate("xyz")}
            | {f"jacobi_{n}_rad_s": float(exact[k]) for k, n in enumerate("xyz")}
        )
    return rows


def draw(found: Found) -> "Figure":
    """The rotation, and the errors."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 4.4), layout="constrained")
    curve, errors = figure.subplots(1, 2)
    time = [1e3 * row["time_s"] for row in found.rows]
    for name, colour in zip("xyz", (BLUE, VERMILION, GREEN), strict=True):
        curve.plot(time, [row[f"jacobi_{name}_rad_s"] for row in found.rows], color=colour,
                   label=f"about {name}")  # fmt: skip
        curve.plot(time[::5], [row[f"spin_{name}_rad_s"] for row in found.rows][::5], "o", ms=4,
                   mfc="none", color=colour)  # fmt: skip
    curve.plot([], [], "o", ms=4, mfc="none", color=GREY, label="the engine")
    curve.plot([], [], color=GREY, label="Jacobi's elliptic functions")
    curve.set(xlabel="time [ms]", ylabel="angular velocity in the body's axes [rad/s]")
    curve.legend(ncols=2, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, 1.16))
    mine = found.numbers["triaxial"]
    steps = 1e6 * np.array(mine["time_steps_s"])
    for key, colour, label in (("errors_of_spin", BLUE, "angular velocity, over the largest"),
                               ("energy_changes", VERMILION, "energy, over its own")):  # fmt: skip
        errors.loglog(steps, mine[key], "o-", color=colour, label=label)
    errors.loglog(steps, mine["errors_of_spin"][0] * (steps / steps[0]) ** 2, "--", color=GREY,
                  label="second order")  # fmt: skip
    errors.set(xlabel="time step [us]", ylabel="error after 50 ms [-]")
    ticked(errors, steps)
    errors.legend(fontsize=8)
    headline(figure, "Free rotation of an ellipsoid 1 : 0.75 : 0.5")
    return figure
