"""Impacts and shaken beds of acrylic spheres of 5 mm, for this engine and for another one."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
from lammps_damper import Bed, Cycles, Scene

from damper3d.engine.enclosures import Enclosure, box, cylinder
from damper3d.engine.motions import Sines, Turning
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world
from granulab.contact.files.datafile import data_file
from granulab.contact.files.table import load_table
from granulab.contact.hertz import HertzLaw
from granulab.contact.sphere_law import sphere_law

GRAVITY = 9.81
RADIUS, DENSITY = 2.5e-3, 1190.0
SETTLING = 0.3  # [s], after which a poured bed is at rest
_PITCH = 2.15 * RADIUS  # of the grid that spheres fall from
_DOWN = (0.0, 0.0, -GRAVITY)


def acrylic(restitution: float = 0.86, friction: float = 0.52, *, end: str = "overlap",
            tangential: str = "displacement", dashpot: bool = True) -> HertzLaw:  # fmt: skip
    """The thesis's law; dashpot: the tangential one."""
    material = load_table(data_file("materials", "acrylic")).materials["acrylic"]
    return sphere_law(material, material, friction=friction, restitution=restitution, end=end,
                      tangential=tangential, tangential_damping=dashpot)  # fmt: skip


def simulation(scene: Scene, steps_per_sample: int = 1) -> Simulation:
    """The scene in this engine."""
    motion = np.array([scene.amplitude]), np.array([scene.omega]), np.zeros(1)
    sim = Simulation(
        build_world(
            scene.position, np.full(len(scene.position), scene.radius), density=scene.density,
            enclosure=scene.enclosure, pair_law=scene.pair_law, wall_law=scene.wall_law,
            shaker=Sines(*motion, 0.0), direction=np.array([0.0, 0.0, 1.0]),
            gravity=np.array(scene.gravity), time_step=scene.time_step, curved_wall=scene.curved,
        ),
        steps_per_sample,
    )  # fmt: skip
    if scene.velocity is not None:
        sim.set_velocity(scene.velocity, scene.spin)
    return sim


def bed_of(sim: Simulation) -> Bed:
    """Where the spheres are in this engine."""
    frame = sim.frame()
    return Bed(frame["x"], frame["v"], frame["spin"])


def cycles_of(scene: Scene, n_cycles: int, steps: int) -> Cycles:
    """Cycles of so many steps in this engine."""
    sim = simulation(scene, steps)
    rows = [sim.sample(), *(sim.run(1) for _ in range(n_cycles))]
    columns = (np.concatenate([row[name] for row in rows])
               for name in ("wall_work", "kinetic", "potential"))  # fmt: skip
    work, kinetic, potential = columns
    return Cycles(np.diff(work), kinetic, potential)


def two_spheres(law: HertzLaw, time_step: float) -> Scene:
    """A turning sphere that meets another one off-centre at some 1 m/s, 1 um away."""
    off = np.array([0.5, 0.2]) * RADIUS
    up = math.sqrt(4 * RADIUS**2 - off @ off) + 1e-6
    return Scene(
        np.array([[0, 0, 0.02], [*off, 0.02 + up]]), RADIUS, DENSITY, box(0.2, 0.2, 0.2),
        law, law, time_step, np.array([[0, 0, 0], [0.3, 0.5, -1.0]]),
        np.array([[10.0, -40, 60], [80, 20, -30]]), gravity=(0.0, 0.0, 0.0),
    )  # fmt: skip


def onto_wall(law: HertzLaw, time_step: float) -> Scene:
    """A turning sphere that meets the bottom obliquely at 1 m/s, 1 um away."""
    return Scene(
        np.array([[0, 0, RADIUS + 1e-6]]), RADIUS, DENSITY, box(0.2, 0.2, 0.2), law, law, time_step,
        np.array([[0.8, 0.4, -1.0]]), np.array([[50.0, -80, 30]]), gravity=(0.0, 0.0, 0.0),
    )  # fmt: skip


def onto_side(law: HertzLaw, time_step: float, curved: bool) -> Scene:
    """A sphere that meets the side of a cylinder of 40 mm head-on at 1 m/s."""
    return Scene(
        np.array([[0.02 - RADIUS, 0, 0.02]]), RADIUS, DENSITY, cylinder(0.04, 0.04), law, law,
        time_step, np.array([[1.0, 0, 0]]), gravity=(0.0, 0.0, 0.0), curved=curved,
    )  # fmt: skip


def pressed(law: HertzLaw, time_step: float, load: float, speed: float) -> Scene:
    """A sphere at rest on the bottom under so many g, with a little speed along it."""
    mass = DENSITY * 4 / 3 * math.pi * RADIUS**3
    overlap = (mass * load * GRAVITY / (law.hertz * math.sqrt(RADIUS))) ** (2 / 3)
    return Scene(
        np.array([[0, 0, RADIUS - overlap]]), RADIUS, DENSITY, box(0.2, 0.2, 0.2), law, law,
        time_step, np.array([[speed, 0, 0]]), gravity=(0.0, 0.0, -load * GRAVITY),
    )  # fmt: skip


def shaken(n: int, enclosure: Enclosure, law: HertzLaw, *, frequency: float, gamma: float,
           seed: int, steps: int, horizontal: bool = False) -> Scene:  # fmt: skip
    """A bed poured into the enclosure, which begins to move; so many steps a cycle."""
    omega = 2 * math.pi * frequency
    gravity = (-GRAVITY, 0.0, 0.0) if horizontal else _DOWN
    return Scene(
        poured(n, enclosure, seed, gravity), RADIUS, DENSITY, enclosure, law, law,
        1 / (frequency * steps), gravity=gravity, amplitude=gamma * GRAVITY / omega**2, omega=omega,
    )  # fmt: skip


@cache
def poured(
    n: int, enclosure: Enclosure, seed: int, gravity: tuple[float, ...] = _DOWN
) -> np.ndarray:
    """Positions (n, 3) of spheres that fell from a grid into the enclosure.

    Where gravity is not along the axis, they fall along it first, below a lid.
    """
    rng = np.random.default_rng(seed)
    position = _grid(n, enclosure) + rng.uniform(-0.05, 0.05, (n, 3)) * RADIUS
    velocity = rng.uniform(-0.3, 0.3, (n, 3))
    smooth = acrylic(friction=0.0)  # so that no arch stands
    tall = replace(enclosure, height=max(enclosure.height, position[:, 2].max() + 2 * RADIUS))
    for room, along in ((tall, _DOWN), (enclosure, gravity)):
        scene = Scene(position, RADIUS, DENSITY, room, smooth, smooth, 2e-6, velocity,
                      gravity=along)  # fmt: skip
        sim = simulation(scene)
        sim.step(round(SETTLING / scene.time_step))
        position, velocity = sim.frame()["x"], None
        if gravity == _DOWN:
            break
    if position[:, 2].max() > enclosure.height - 0.99 * RADIUS:  # a lid may be pressed a little
        raise ValueError(f"{n} spheres are higher than {enclosure.height:g} m")
    return position


def _grid(n: int, enclosure: Enclosure) -> np.ndarray:
    """The lowest n points of a cubic grid inside, whatever the height."""
    half = [int(size / (2 * _PITCH)) for size in (enclosure.width, enclosure.depth)]
    x, y = (np.arange(-k, k + 1) * _PITCH for k in half)
    layer = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    if enclosure.radius is not None:
        layer = layer[np.hypot(*layer.T) < enclosure.radius - 1.05 * RADIUS]
    else:
        half = np.array([enclosure.width, enclosure.depth]) / 2 - 1.05 * RADIUS
        layer = layer[(np.abs(layer) < half).all(axis=1)]
    floors = 1.1 * RADIUS + _PITCH * np.arange(math.ceil(n / len(layer)))
    points = [np.column_stack([layer, np.full(len(layer), z)]) for z in floors]
    return np.concatenate(points)[:n]


def ball_on_a_turning_floor(rate: float, off: float, time: float) -> tuple[np.ndarray, float]:
    """Velocity (3,) of a ball at rest off the axis [m] of a cylinder that spins at a rate [rad/s].

    After a time [s], beside the speed that sliding friction gives it by then, mu g t.
    """
    law, mass = acrylic(), 4.0 / 3.0 * math.pi * RADIUS**3 * DENSITY
    sunk = (mass * GRAVITY / (law.hertz * math.sqrt(RADIUS))) ** (2 / 3)
    slow = 1e-3  # [rad/s] of a sine whose rate stays the same meanwhile
    spin = Sines(np.array([rate / slow]), np.array([slow]), np.zeros(1), 0.0)
    sim = Simulation(
        build_world(
            np.array([[off, 0.0, RADIUS - sunk]]), np.array([RADIUS]), density=DENSITY,
            enclosure=cylinder(0.04, 0.02), pair_law=law, wall_law=law,
            shaker=Turning(spin, 1.0, np.zeros(1)), direction=np.array([0.0, 0.0, 1.0]),
            gravity=np.array(_DOWN), time_step=1e-6,
        ),
        1,
    )  # fmt: skip
    sim.run(round(time / 1e-6))
    return sim.frame()["v"][0], law.mu * GRAVITY * time
