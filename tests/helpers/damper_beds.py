"""Small beds of unequal acrylic spheres that start in vigorous motion, for tests of the engine."""

import numpy as np

from damper3d.engine.enclosures import Frustum, box, cylinder
from damper3d.engine.motions import Sines, sine
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world
from granulab.contact.files.datafile import data_file
from granulab.contact.files.table import load_table
from granulab.contact.hertz import HertzLaw
from granulab.contact.sphere_law import sphere_law

G = 9.81
DENSITY = 1190.0
LARGEST = 2.5e-3  # radius [m]
ROOMS = {
    "cylinder": cylinder(0.0204, 0.024),
    "box": box(0.0165, 0.0175, 0.024),
    "frustum": Frustum(0.0204, 0.0304, 0.024),
}
STILL = sine(0.0, 100.0, G)
SHAKEN = sine(50.0, 100.0, G)  # peak speed 0.78 m/s, as at 40 Hz and Gamma 20
DOWN, NOWHERE = (0.0, 0.0, -G), (0.0, 0.0, 0.0)


def acrylic(friction: float = 0.52, restitution: float = 0.86, **options) -> HertzLaw:
    """The thesis's law of acrylic."""
    material = load_table(data_file("materials", "acrylic")).materials["acrylic"]
    return sphere_law(material, material, friction=friction, restitution=restitution, **options)


def bed(shape: str = "cylinder", n: int = 36, *, shaker: Sines = SHAKEN, gravity=DOWN,
        pair_law: HertzLaw | None = None, wall_law: HertzLaw | None = None, time_step=1e-6,
        direction=(0.0, 0.0, 1.0), smallest=0.7, speed=0.5, steps_per_sample=1, turn=0.0,
        drift=NOWHERE) -> Simulation:  # fmt: skip
    """n spheres on a cubic grid with jitter, random velocities [m/s] and spins.

    Radii are between smallest and 1 times LARGEST; the whole bed is turned round the axis by turn
    [rad], and moves with the velocity drift [m/s].
    """
    rng = np.random.default_rng(5)
    room = ROOMS[shape]
    x, y, z = np.meshgrid(*[1.06 * LARGEST * np.array([-2, 0, 2])] * 2, 1.1 * LARGEST
                          * np.arange(1, 8, 2), indexing="ij")  # fmt: skip
    places = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    places = places[np.argsort(places[:, 2], kind="stable")][:n]
    places += rng.uniform(-0.05, 0.05, (n, 3)) * LARGEST
    radii = LARGEST * rng.uniform(smallest, 1.0, n)
    velocity = speed * rng.uniform(-1.0, 1.0, (n, 3))
    spin = speed / LARGEST * rng.uniform(-1.0, 1.0, (n, 3))
    about = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    law = acrylic()
    sim = Simulation(
        build_world(
            places @ about.T, radii, density=DENSITY, enclosure=room, pair_law=pair_law or law,
            wall_law=wall_law or law, shaker=shaker, direction=np.array(direction),
            gravity=np.array(gravity), time_step=time_step,
        ),
        steps_per_sample,
    )  # fmt: skip
    sim.set_velocity(velocity @ about.T + np.array(drift), spin @ about.T)
    return sim


def lone(law: HertzLaw, *, height: float, velocity=(0.0, 0.0, 0.0), gravity=DOWN,
         shaker: Sines = STILL, time_step=1e-6, steps_per_sample=1) -> Simulation:  # fmt: skip
    """One sphere of LARGEST in a room of a metre, its centre so high [m]."""
    sim = Simulation(
        build_world(
            np.array([[0.0, 0.0, height]]), np.array([LARGEST]), density=DENSITY,
            enclosure=box(1.0, 1.0, 1.0), pair_law=law, wall_law=law, shaker=shaker,
            direction=np.array([0.0, 0.0, 1.0]), gravity=np.array(gravity), time_step=time_step,
        ),
        steps_per_sample,
    )  # fmt: skip
    sim.set_velocity(np.array([velocity], float))
    return sim


def at_rest(law: HertzLaw, weight_per_mass: float = G) -> float:
    """Height of the centre of a sphere of LARGEST that rests on the floor: K d^1.5 = m g."""
    mass = DENSITY * 4 / 3 * np.pi * LARGEST**3
    return LARGEST - (mass * weight_per_mass / (law.hertz * np.sqrt(LARGEST))) ** (2 / 3)
