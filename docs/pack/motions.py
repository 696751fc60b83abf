"""Cases of motion: on a plane, under gravity, between walls, and free rotation."""

import math
from collections.abc import Callable, Iterator
from functools import partial
from itertools import islice, pairwise
from typing import Any, NamedTuple

import numpy as np
from analytic import (
    angular_frequency,
    block_creeping_down,
    block_sliding_down,
    contact_time,
    damping_of_restitution,
)
from impacts import of_table, two
from record import MFIX, WOOD, Case, Row, hertz, linear, sphere, wall

from damper3d.studies.single_contact.particles.free_rotation import jacobi
from granulab.contact.reduced import sphere_mass
from silo2d.case.shape import shape_from_outline

G = 9.81
FLOOR = wall("floor", 0.0, 1)
_SPRINGS = """\
the springs that take up a load swing about it: each swing is worth acceleration over angular \
frequency, once to build up and once to die"""


def scene(step: float, duration: float, law, bodies, *, down=(0.0, -G), **more) -> dict[str, Any]:
    """A set-up under gravity, of which down are the components along x and z [m/s2]."""
    return {
        "time_step_s": step, "duration_s": duration, "gravity_m_s2": [down[0], 0.0, down[1]],
        "law": law, "wall": [FLOOR], "body": bodies, "variant": [], **more,
    }  # fmt: skip


def _solid(radius: float, density: float) -> dict[str, float]:
    mass = sphere_mass(radius, density)
    return {"mass_kg": mass, "moment_kg_m2": 0.4 * mass * radius**2}


def _sinks(acrylic, radius: float, weight: float) -> float:
    """Overlap [m] of a sphere that rests on a plane of its material, K d^1.5 = weight."""
    modulus, reduced, _ = two(acrylic, radius, acrylic)
    return (weight / (4 / 3 * modulus * math.sqrt(reduced))) ** (2 / 3)


def launched() -> Case:
    """A sphere launched without rotation, by Hertz's law."""
    acrylic, radius, u0, mu = of_table("acrylic"), 2.5e-3, 0.1, 0.3
    mass = sphere_mass(radius, acrylic["density_kg_m3"])
    height = radius - _sinks(acrylic, radius, mass * G)
    ends = 2 * u0 / (7 * mu * G)
    law = hertz(mu, 0.86)
    made = scene(1e-6, 2 * ends, law, [sphere(radius, height, (u0, 0.0), material=1)],
                 material=[acrylic])  # fmt: skip
    made["wall"] = [wall("floor", 0.0, 1, 1)]
    return Case("launched-sphere", "A sphere launched without rotation slides, then rolls",
                "closed form: u0 - mu g t and 2.5 mu g t/r until 2 u0/(7 mu g), then 5 u0/7",
                "a thousandth of the launching speed: the tangential spring rings for some "
                "periods of 0.1 ms where sliding ends, and the arm is shorter by 1e-5",
                made, tuple(_rolling(u0, mu, radius, ends, 1e-3 * u0)))  # fmt: skip


def mfix_launched() -> Case:
    """MFiX DEM04: the same with linear springs."""
    radius, density, k, mu, u0 = 0.5e-3, 1e4, 1e4, 0.2, 0.1
    own = _solid(radius, density)
    ends = 2 * u0 / (7 * mu * G)
    swing = mu * G / angular_frequency(k, own["mass_kg"] / 3.5)
    height = radius - own["mass_kg"] * G / k
    made = scene(2e-7, 2 * ends, linear(k, friction=mu), [sphere(radius, height, (u0, 0.0), **own)])
    return Case("launched-sphere-linear", "The same with linear springs",
                f"MFiX DEM04 (size, density, springs and friction; the speed is chosen here): "
                f"{MFIX}", _SPRINGS, made,
                tuple(_rolling(u0, mu, radius, ends, 2 * swing)))  # fmt: skip


def _rolling(u0, mu, radius, ends, near) -> list[Row]:
    rows = []
    for share in (0.25, 0.5, 0.75, 1.5, 2.0):
        t = share * ends
        u = max(u0 - mu * G * t, 5 / 7 * u0)
        w = min(2.5 * mu * G * t, 5 / 7 * u0) / radius
        rows += [Row("", "tangential velocity", u, near, 1, t),
                 Row("", "angular velocity", w, 2.5 * near / radius, 1, t)]  # fmt: skip
    return rows


def incline() -> Case:
    """A sphere on an incline, which rolls or slides as friction has it."""
    acrylic, radius, angle, end = of_table("acrylic"), 2.5e-3, math.radians(30.0), 0.02
    mass = sphere_mass(radius, acrylic["density_kg_m3"])
    down = G * math.sin(angle), -G * math.cos(angle)
    height, rows, variants = radius - _sinks(acrylic, radius, -mass * down[1]), [], []
    for mu in (0.3, 0.1):
        rolls = mu > 2 / 7 * math.tan(angle)
        label = f"friction {mu}"
        u = (5 / 7 * down[0] if rolls else block_sliding_down(angle, mu, G)) * end
        w = (u if rolls else -2.5 * mu * down[1] * end) / radius
        rows += [Row(label, "tangential velocity", u, 2e-3 * u, 1),
                 Row(label, "angular velocity", w, 2e-3 * w, 1)]  # fmt: skip
        variants.append({"name": label, "law.friction": mu})
    made = scene(1e-6, end, hertz(0.3, 0.86), [sphere(radius, height, material=1)], down=down,
                 material=[acrylic], variant=variants)  # fmt: skip
    made["wall"] = [wall("floor", 0.0, 1, 1)]
    return Case("sphere-on-incline", "A sphere on an incline of 30 degrees",
                "closed form: (5/7) g sin where mu > (2/7) tan, else g (sin - mu cos)",
                "it starts with its tangential spring relaxed and swings about the closed form by "
                "a thousandth of the speed; doubled for the end of a swing", made,
                tuple(rows))  # fmt: skip


def _block(law, angle: float, duration: float) -> tuple[dict[str, Any], float]:
    """A wooden block of 20 mm by 10 mm at rest on an incline, and its mass [kg]."""
    outline, corner, weight = [[0, 0], [20e-3, 0], [20e-3, 10e-3], [0, 10e-3]], 1e-3, 54.0
    shape = shape_from_outline("block", outline, corner, "block")
    mass = weight * shape.area
    overlap = mass * G * math.cos(angle) / (2 * law["stiffness_n_m"])
    body = {
        "shape": "spheropolygon", "outline_m": outline, "corner_radius_m": corner,
        "surface_density_kg_m2": weight, "position_m": [0.0, 0.0, 5e-3 - overlap],
        "velocity_m_s": [0.0, 0.0, 0.0], "angular_velocity_rad_s": [0.0, 0.0, 0.0],
    }  # fmt: skip
    down = G * math.sin(angle), -G * math.cos(angle)
    return scene(4e-6, duration, law, [body], down=down), mass


def block_slides() -> Case:
    """Coulomb's block."""
    angle, k, end, rows, variants = math.radians(22), 1e6, 0.1, [], []
    made, mass = _block(linear(k, 3000.0, 0.3), angle, end)
    swing = G * math.sin(angle) / angular_frequency(k, mass, 2)
    for share in (0.0, 0.5, 0.98, 1.02):
        label, mu = f"mu {share} tan", share * math.tan(angle)
        u = block_sliding_down(angle, mu, G) * end if share < 1 else 0.0
        rows.append(Row(label, "tangential velocity", u, 2 * swing, 1))
        variants.append({"name": label, "law.friction": mu})
    return Case("block-on-incline", "A block on an incline of 22 degrees rests or slides",
                "closed form (Coulomb): g (sin - mu cos) where tan > mu, else at rest",
                f"{_SPRINGS}; two vertex-edge contacts carry it", made | {"variant": variants},
                tuple(rows))  # fmt: skip


def block_creeps() -> Case:
    """The same held back by tangential dashpots, which gives the paper's friction test its form."""
    angle, k, mu, rows, variants = math.radians(25), 1e6, 0.38, [], []
    made, mass = _block(linear(k, 3000.0, mu), angle, 1 / 3)
    swing = G * math.sin(angle) / angular_frequency(k, mass, 2)
    for gamma in (3.0, 30.0):
        label = f"gamma_t {gamma:g} 1/s"
        variants.append({"name": label, "law.tangential_damping_1_s": gamma,
                         "duration_s": 1 / gamma})  # fmt: skip
        for t in (0.25 / gamma, 1 / gamma):
            u = block_creeping_down(angle, mu, G, gamma, 2, t)
            rows.append(Row(label, "tangential velocity", u, 2 * swing, 1, t))
    return Case("block-with-dashpots", "A block that tangential dashpots hold back",
                "Alonso-Marroquin et al. 2013, eq. 3.11, with a dashpot in each of two contacts",
                _SPRINGS, made | {"variant": variants}, tuple(rows), WOOD)  # fmt: skip


class Stretch(NamedTuple):
    """Flight or contact of a falling sphere: beginning and duration [s], and its path."""

    begins: float
    lasts: float
    at: Callable[[float], tuple[float, float]]  # height [m], velocity [m/s] so long after


def in_flight(y: float, v: float, t: float) -> tuple[float, float]:
    """Height and velocity under gravity."""
    return y + v * t - 0.5 * G * t**2, v - G * t


def on_spring(r: float, omega0: float, b: float, y: float, v: float, t: float):
    """Height and velocity of a sphere of radius r on a spring with a dashpot, gravity acting on.

    y'' = -g - 2 b y' - omega0^2 (y - r): a damped oscillation about r - g/omega0^2.
    """
    w, middle = math.sqrt(omega0**2 - b**2), r - G / omega0**2
    a, c, s, fall = y - middle, math.cos(w * t), math.sin(w * t), math.exp(-b * t)
    d = (v + b * a) / w
    return middle + fall * (a * c + d * s), fall * ((d * w - a * b) * c - (a * w + d * b) * s)


def stretches(height: float, r: float, omega0: float, gamma: float) -> Iterator[Stretch]:
    """Flights and contacts in turn of a sphere that is dropped; contacts end at zero overlap."""
    from scipy.optimize import brentq

    y, v, begins, w = height, 0.0, 0.0, math.sqrt(omega0**2 - gamma**2 / 4)
    while True:
        lasts = (v + math.sqrt(v**2 + 2 * G * (y - r))) / G
        yield Stretch(begins, lasts, partial(in_flight, y, v))
        begins, (y, v) = begins + lasts, in_flight(y, v, lasts)
        at = partial(on_spring, r, omega0, gamma / 2, y, v)
        # A half of the oscillation, and a little more for what gravity adds.
        lasts = float(brentq(lambda t, at=at: at(t)[0] - r, 0.5 * math.pi / w, 1.5 * math.pi / w,
                             xtol=1e-16))  # fmt: skip
        yield Stretch(begins, lasts, at)
        begins, (y, v) = begins + lasts, at(lasts)


def _dropped(k: float, e: float) -> tuple[dict[str, float], dict[str, Any], Iterator[Stretch]]:
    """MFiX DEM01's and DEM02's sphere: its mass, its variant and its path."""
    own = _solid(0.1, 2600.0)
    omega0 = angular_frequency(k, own["mass_kg"])
    gamma = damping_of_restitution(omega0, e) if e < 1 else 0.0
    variant = {"name": f"k {k:g} N/m, e {e}", "law.stiffness_n_m": k, "law.damping_1_s": gamma,
               "time_step_s": contact_time(omega0, gamma) / 2500}  # fmt: skip
    return own, variant, stretches(0.5, 0.1, omega0, gamma)


_JUMPS = """\
2500 steps to a contact; the dashpot's force begins and ends within one, gamma dt of the speed at \
either end, and gravity adds g dt"""


def _jumps(variant: dict[str, Any], speed: float) -> float:
    """What a dashpot's two jumps and gravity leave open in a bounce, as a part of the speed."""
    return 2 * (variant["law.damping_1_s"] + G / speed) * variant["time_step_s"]


def falling() -> Case:
    """MFiX DEM01: fall, contact and rebound."""
    rows, variants, speed = [], [], math.sqrt(2 * G * 0.4)
    for k in (5e4, 1e5):
        for e in (1.0, 0.9, 0.6):
            own, variant, path = _dropped(k, e)
            variants.append(variant)
            near = _jumps(variant, speed) + angular_frequency(k, own["mass_kg"]) * variant[
                "time_step_s"]  # fmt: skip
            for stretch, shares in zip(path, ((0.5,), (0.25, 0.5, 0.75), (0.1, 0.2)), strict=False):
                for t in (share * stretch.lasts for share in shares):
                    y, v = stretch.at(t)
                    rows += [Row(variant["name"], "height", y, near * 0.1, 1, stretch.begins + t),
                             Row(variant["name"], "normal velocity", v, near * speed, 1,
                                 stretch.begins + t)]  # fmt: skip
    made = scene(1e-4, 0.5, linear(5e4), [sphere(0.1, 0.5, **own)], variant=variants)
    return Case("falling-sphere", "A sphere falls on a spring and leaves it", f"MFiX DEM01: {MFIX}",
                f"{_JUMPS}; velocities by a step of the oscillation, heights by that of the radius",
                made, tuple(rows))  # fmt: skip


def bouncing() -> Case:
    """MFiX DEM02: heights of three bounces."""
    rows, variants, speed = [], [], math.sqrt(2 * G * 0.4)
    for k, e in ((0.5e5, 0.9), (0.5e5, 0.7), (5e5, 0.9)):
        own, variant, path = _dropped(k, e)
        variants.append(variant)
        flights = [one for n, one in enumerate(islice(path, 7)) if n % 2 == 0]
        for bounce, flight in enumerate(flights[1:], 1):
            up = flight.lasts / 2
            y = flight.at(up)[0]
            near = 2 * bounce * _jumps(variant, speed * e**bounce)
            rows.append(Row(variant["name"], "height", y, near * (y - 0.1), 1, flight.begins + up))
    made = scene(1e-4, 1.6, linear(0.5e5), [sphere(0.1, 0.5, **own)], variant=variants)
    return Case("bouncing-sphere", "Heights of three bounces", f"MFiX DEM02: {MFIX}; with gravity "
                "in the contact, so that a finite spring has its own height",
                f"{_JUMPS}; heights by twice that of the speed, for each bounce before", made,
                tuple(rows))  # fmt: skip


def stacked() -> Case:
    """MFiX DEM03: two spheres squeezed between two walls; linear equations, by their modes."""
    radius, k, gap, step, end = 0.5e-3, 1e3, 1.8e-3, 1e-7, 1e-3
    bodies = [_solid(radius, 2e4), _solid(radius, 1e4)]
    m1, m2 = (one["mass_kg"] for one in bodies)
    m12 = m1 * m2 / (m1 + m2)
    mass, start = np.diag([m1, m2]), np.array([gap / 4, 3 * gap / 4])
    stiff = np.array([[2 * k, -k], [-k, 2 * k]])
    load = np.array([-k * radius, k * (gap + radius)]) - G * np.array([m1, m2])
    rest = np.linalg.solve(stiff, load)
    rows, variants = [], []
    for gamma in (0.0, 2000.0):
        label = f"damping {gamma:g} 1/s"
        variants.append({"name": label, "law.damping_1_s": gamma})
        damp = gamma * np.array([[m1 + m12, -m12], [-m12, m2 + m12]])
        below = -np.linalg.solve(mass, np.hstack([stiff, damp]))
        value, vector = np.linalg.eig(np.vstack([np.eye(2, 4, 2), below]))
        part = np.linalg.solve(vector, np.concatenate([start - rest, [0, 0]]).astype(complex))
        omega = float(np.abs(value).max())
        off = (omega + gamma) * step + omega * end * (omega * step) ** 2 / 24
        near = off * float(np.abs(start - rest).max())
        for t in (0.25e-3, 0.5e-3, 1e-3):
            now = rest + (vector @ (part * np.exp(value * t)))[:2].real
            rows += [Row(label, "height", float(now[i]), near, i + 1, t) for i in (0, 1)]
    placed = [sphere(radius, float(z), **own) for z, own in zip(start, bodies, strict=True)]
    made = scene(step, end, linear(k), placed, variant=variants)
    made["wall"] = [FLOOR, wall("lid", gap, -1)]
    return Case("stacked-spheres", "Two spheres squeezed between floor and lid",
                f"MFiX DEM03 (sizes, densities, springs and walls; where they start and the damped "
                f"variant are chosen here): {MFIX}",
                "velocities and dashpots act half a step off at either end, (omega + gamma) dt, "
                "and the phase drifts by (omega dt)^2/24 of itself; of the largest displacement",
                made,
                tuple(rows))  # fmt: skip


def column() -> Case:
    """Three spheres at rest on each other: the weight goes to the floor, K d^1.5 by contact."""
    acrylic, radius = of_table("acrylic"), 2.5e-3
    weight = sphere_mass(radius, acrylic["density_kg_m3"]) * G
    modulus, reduced, _ = two(acrylic, radius, acrylic, radius)
    rows = [Row("", "force on the floor", 3 * weight, 1e-3 * weight)]
    for body, bears in ((1, 3), (2, 2), (3, 1)):
        deep = _sinks(acrylic, radius, bears * weight) if body == 1 else (
            bears * weight / (4 / 3 * modulus * math.sqrt(reduced))) ** (2 / 3)  # fmt: skip
        rows.append(Row("", "overlap below", deep, 1e-3 * deep, body))
    bodies = [sphere(radius, (2 * n + 1) * radius, material=1) for n in range(3)]
    made = scene(1e-6, 0.03, hertz(0.0, 0.3), bodies, material=[acrylic])
    made["wall"] = [wall("floor", 0.0, 1, 1)]
    return Case("column-at-rest", "Three spheres at rest on each other",
                "closed form: each contact bears what lies above it (Hertz)",
                "they start just in touch and swing until the dashpots have taken it, of which a "
                "thousandth of each overlap may be left", made,
                tuple(rows))  # fmt: skip


def rotation() -> Case:
    """Free rotation of an ellipsoid, and of one with two equal moments."""
    half, density, spin = (3e-3, 4e-3, 5e-3), 1190.0, np.array([60.0, 600.0, 120.0])
    end, step = 0.05, 2.5e-5
    mass = density * 4 / 3 * math.pi * math.prod(half)
    square = np.array(half) ** 2
    triaxial = mass / 5 * (square.sum() - square)[::-1]
    symmetric = triaxial[[0, 0, 2]]
    assert all(a < b for a, b in pairwise(triaxial))
    times = np.array([0.4, 1.0]) * end
    rate = (symmetric[2] / symmetric[0] - 1) * spin[2]
    turned = np.array([[math.cos(rate * t), math.sin(rate * t)] for t in times])
    round_axis = np.column_stack([
        spin[0] * turned[:, 0] - spin[1] * turned[:, 1],
        spin[0] * turned[:, 1] + spin[1] * turned[:, 0], np.full(2, spin[2]),
    ])  # fmt: skip
    paths = {"triaxial": jacobi(triaxial, spin, times), "symmetric": round_axis}
    # Phase error of a second-order scheme, (w dt)^2/12 of a phase w t, in both angles of rotation.
    near = 2 * float(spin.max()) ** 3 * step**2 / 12 * end * float(spin.max())
    rows = [Row(name, f"own angular velocity {axis}", float(path[i, k]), near, 1, float(t))
            for name, path in paths.items() for i, t in enumerate(times)
            for k, axis in enumerate("xyz")]  # fmt: skip
    body = {
        "shape": "rigid body", "mass_kg": mass, "principal_moments_kg_m2": triaxial.tolist(),
        "position_m": [0.0, 0.0, 0.0], "velocity_m_s": [0.0, 0.0, 0.0],
        "own_angular_velocity_rad_s": spin.tolist(),
    }  # fmt: skip
    made = {
        "time_step_s": step, "duration_s": end, "gravity_m_s2": [0.0, 0.0, 0.0], "body": [body],
        "variant": [{"name": "triaxial"},
                    {"name": "symmetric", "body.1.principal_moments_kg_m2": symmetric.tolist()}],
    }  # fmt: skip
    return Case("free-rotation", "A rigid body rotates freely",
                "Landau and Lifshitz, Mechanics, sec. 37: Jacobi's elliptic functions; about an "
                "axis of symmetry a precession",
                "a second-order scheme of 25 us: (w dt)^2/12 of the phase w t, twice", made,
                tuple(rows))  # fmt: skip


def cases() -> list[Case]:
    """All of this module."""
    return [launched(), mfix_launched(), incline(), block_slides(), block_creeps(), falling(),
            bouncing(), stacked(), column(), rotation()]  # fmt: skip
