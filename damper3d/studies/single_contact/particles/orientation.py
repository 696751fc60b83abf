"""Rebound of particles from a smooth wall by orientation, against the rigid body's impulse.

Acrylic particles, three of chapter 8's sizes, fall on a flat wall without friction and without
spin. A rigid body that touches at the arm r from its centroid, with the wall's normal n, gets the
impulse J = (1 + e) v/(1/m + (r x n) . I^-1 (r x n)), by which its contact point leaves at e v (any
textbook of dynamics). What is measured is that point of the smooth body when the particle first
touches no more.

The law's dashpot goes by the whole mass m (eq. 5.32), and what hits the wall is
m_eff = 1/(1/m + ...): its damping ratio is larger by sqrt(m/m_eff), so that one contact alone
already gives less than e where it meets the body off its centroid.
"""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.engine.multisphere.particles import TREATMENTS
from damper3d.engine.simulation import Simulation
from damper3d.shapes import FAMILIES
from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.particle import parse_particle
from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.particles.held import combined, matrix, over_floor, turn
from damper3d.studies.single_contact.particles.shape_force import COLOURS
from granulab.campaign.output.figure import GREY, INK, headline
from granulab.contact.files.table import load_table
from granulab.contact.hertz import HertzLaw
from granulab.contact.restitution import restitution_of_ratio
from granulab.contact.sphere_law import sphere_law

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHAPES = ("prolate:1.5", "oblate:0.7", "toroid:0.2", "cylinder:1.5,0.2")
SPEED = 1.0  # of the impact; a vertical damper at 40 Hz and Gamma 20 reaches 0.78 [m/s]
N_TILTS = 61  # of the axis from the normal
_STEP, _LOOK, _LONGEST = 2e-7, 5, 2e-3  # [s], steps between two looks, [s]
_Y = (0.0, 1.0, 0.0)
_GOLDEN = math.pi * (3.0 - math.sqrt(5.0))  # rotations about the particle's axis, no two alike
_FLAT = 1e-9  # a cosine below which a face lies flat
_UP = np.array([0.0, 0.0, 1.0])


def compute() -> Found:
    """All shapes, multi-contact models and orientations."""
    acrylic = load_table("acrylic")
    solid, pair = acrylic.material("acrylic"), acrylic.pair("acrylic", "acrylic")
    e = pair.restitution.value if pair.restitution else 1.0
    law = sphere_law(solid, solid, friction=0.0, restitution=e)
    density = solid.density.value
    rows: list[dict[str, Any]] = []
    numbers: dict[str, Any] = {"restitution": e, "speed_m_s": SPEED}
    for shape in SHAPES:
        particle = parse_particle(shape, FAMILIES[shape.partition(":")[0]].radius)
        for treatment in TREATMENTS:
            mine = rebounds(particle, law, treatment, density, e)
            rows += [{"particle": shape, "treatment": treatment, **row} for row in mine]
            numbers[f"{shape}, {treatment}"] = _numbers(mine)
    remark = "means are over orientations at random; energies are the kinetic ones"
    return Found(numbers, rows, (remark,))


def tilts() -> np.ndarray:
    """Angles of the axis from the wall's normal (n,) [rad]."""
    return np.linspace(0.0, 0.5 * math.pi, N_TILTS)


def orientation(kind: str, tilt: float, about: float) -> np.ndarray:
    """A quaternion that tilts the particle's axis from the normal, after a turn about it [rad]."""
    if kind in ("toroid", "cylinder"):  # their axis is z
        return combined(turn(_Y, tilt), turn((0.0, 0.0, 1.0), about))
    return combined(turn(_Y, tilt - 0.5 * math.pi), turn((1.0, 0.0, 0.0), about))


def arm(particle: MultiSphere, rotation: np.ndarray) -> np.ndarray:
    """From the centroid to the smooth body's lowest point (3,) in the laboratory [m].

    rotation (3, 3) takes the body's axes to the laboratory's. Where a circle, a face or a line are
    lowest, their middle.
    """
    down = -rotation.T @ _UP
    down[np.abs(down) < _FLAT] = 0.0
    if particle.kind in ("toroid", "cylinder"):
        out, high, edge = _core(particle)
        aside = np.array([down[0], down[1], 0.0])
        size = float(np.linalg.norm(aside))
        middle = out / size * aside if size > 0.0 else aside
        return rotation @ (edge * down + middle + [0.0, 0.0, high * np.sign(down[2])])
    x, y, _ = particle.inertia
    square = np.array([2 * y - x, x, x]) * 2.5 / particle.volume  # of the half axes
    return rotation @ (square * down / math.sqrt(float(square @ down**2)))


def _core(particle: MultiSphere) -> tuple[float, float, float]:
    """Radius, half height and distance of all within which a toroid or cylinder lies [m]."""
    if particle.kind == "toroid":
        return float(np.linalg.norm(particle.offsets[0])), 0.0, float(particle.radii[0])
    out, _, high = particle.surface.vertices.max(axis=0)
    edge = float(particle.name.split(",")[1]) * out
    return out - edge, high - edge, edge


def rebounds(
    particle: MultiSphere, law: HertzLaw, treatment: str, density: float, restitution: float
) -> list[dict[str, float]]:
    """A row for each tilt: what the particle does, and the rigid body."""
    angles = tilts()
    orientations = np.array(
        [orientation(particle.kind, t, _GOLDEN * n) for n, t in enumerate(angles)]
    )
    gap = np.full(N_TILTS, 0.2 * _STEP * SPEED)
    sim = over_floor(particle, orientations, gap, law=law, treatment=treatment, density=density,
                     time_step=_STEP)  # fmt: skip
    sim.set_velocity(np.tile(-SPEED * _UP, (N_TILTS, 1)), np.zeros((N_TILTS, 3)))
    velocity, spin, last = _left(sim)
    mass, inertia = density * particle.volume, density * particle.inertia
    rows = []
    for n, q in enumerate(orientations):
        rotation = matrix(q)
        moment = rotation.T @ np.cross(arm(particle, rotation), _UP)
        yields = 1.0 / mass + float(moment @ (moment / inertia))
        impulse = (1.0 + restitution) * SPEED / yields
        own = rotation.T @ spin[n]  # it has rotated by 1e-3 rad: left out
        after = 0.5 * mass * float(velocity[n] @ velocity[n]) + 0.5 * float(inertia @ own**2)
        before = 0.5 * mass * SPEED**2
        rows.append(
            {
                "tilt_deg": math.degrees(angles[n]),
                "restitution": float(velocity[n, 2] + own @ moment) / SPEED,
                "one_contact_restitution": restitution_of_ratio(
                    law.damping * math.sqrt(yields * mass), "overlap"
                ),
                "rebound": float(velocity[n, 2]) / SPEED,
                "rigid_rebound": impulse / mass / SPEED - 1.0,
                "energy_lost": 1.0 - after / before,
                "rigid_energy_lost": (1.0 - restitution**2) / (yields * mass),
                "contact_time_s": float(last[n]),
            }
        )
    return rows


def _left(sim: Simulation) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Velocities (n, 3) [m/s], spins (n, 3) [rad/s] and times (n,) [s] of the first leaving."""
    n = sim.n_particles
    touched, left = np.zeros(n, bool), np.zeros(n, bool)
    velocity, spin, time = np.zeros((n, 3)), np.zeros((n, 3)), np.full(n, math.nan)
    while not left.all() and sim.time < _LONGEST:
        sim.step(_LOOK)
        touching = np.zeros(n, bool)
        touching[sim.contacts()["bodies"][:, 0]] = True
        now = touched & ~touching & ~left
        frame = sim.frame()
        velocity[now], spin[now], time[now] = frame["v"][now], frame["spin"][now], sim.time
        left |= now
        touched |= touching
    return velocity, spin, time


def _numbers(rows: list[dict[str, float]]) -> dict[str, float]:
    """Means over orientations at random, to which a tilt adds by its sine, and extremes."""
    e = np.array([row["restitution"] for row in rows])
    weights = np.sin(tilts())
    weights[-1] *= 0.5  # of the trapezoidal rule

    def mean(key: str) -> float:
        return float(np.average([row[key] for row in rows], weights=weights))

    return {
        "mean_restitution": mean("restitution"),
        "smallest_restitution": float(e.min()),
        "at_tilt_deg": rows[int(e.argmin())]["tilt_deg"],
        "largest_restitution": float(e.max()),
        "mean_one_contact_restitution": mean("one_contact_restitution"),
        "mean_rebound": mean("rebound"),
        "rigid_mean_rebound": mean("rigid_rebound"),
        "mean_energy_lost": mean("energy_lost"),
        "rigid_mean_energy_lost": mean("rigid_energy_lost"),
    }


def draw(found: Found) -> "Figure":
    """Restitution of the contact point, and rebound of the centroid, of each shape."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.5, 6.2), layout="constrained")
    panels = figure.subplots(2, len(SHAPES), sharex=True, sharey="row")
    for column, shape in enumerate(SHAPES):
        mine = [row for row in found.rows if row["particle"] == shape]
        tilt = [row["tilt_deg"] for row in mine if row["treatment"] == TREATMENTS[0]]
        top, bottom = panels[0][column], panels[1][column]
        top.axhline(found.numbers["restitution"], color=INK, ls="--", lw=1)
        top.plot(tilt, [row["one_contact_restitution"] for row in mine[: len(tilt)]], color=GREY,
                 lw=3, alpha=0.6)  # fmt: skip
        _curves(top, mine, "restitution")
        _curves(bottom, mine, "rebound")
        bottom.plot(tilt, [row["rigid_rebound"] for row in mine[: len(tilt)]], color=INK, ls="--",
                    lw=1, label="rigid body with that restitution")  # fmt: skip
        top.set_title(shape, fontsize=9, loc="left")
        bottom.set(xlabel="tilt of the axis from the normal [deg]", xlim=(0, 90))
        bottom.axhline(0, color=GREY, lw=0.5)
    bottom.plot([], [], color=GREY, lw=3, alpha=0.6, label="one contact damped by the whole mass")
    panels[0][0].set_ylabel("restitution of the contact point [-]")
    panels[1][0].set_ylabel("rebound of the centroid / speed [-]")
    figure.legend(*panels[1][-1].get_legend_handles_labels(), loc="outside lower center", ncols=5)
    headline(figure, f"Acrylic particles on a smooth wall at {SPEED:g} m/s, one impact")
    return figure


def _curves(axes: "Axes", rows: list[dict[str, Any]], key: str) -> None:
    for name, style in zip(TREATMENTS, ("-", "o", "-"), strict=True):
        mine = [row for row in rows if row["treatment"] == name]
        axes.plot([row["tilt_deg"] for row in mine], [row[key] for row in mine], style, ms=3,
                  mfc="none", color=COLOURS[name], label=name)  # fmt: skip
