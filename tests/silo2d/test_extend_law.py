"""A contact law from outside, in this one file: a spring that stiffens, f_n = k d^(3/2).

A process of its own runs it: the kernels of a law that is not the package's are kept apart.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

HERE = Path(__file__).parent


class Stiffening(NamedTuple):
    """Constants of the law."""

    k: float  # [N/m^1.5]
    kt: float  # tangential stiffness [N/m]
    mu: float  # [-]
    gamma_n: float  # [1/s]
    gamma_t: float  # [1/s]


def normal_force(law, m, overlap, overlap_rate):
    """Return the normal force and its dashpot's part [N]."""
    elastic = law.k * overlap * overlap**0.5
    damping = m * law.gamma_n * overlap_rate
    return elastic + damping, damping


def normal_energy(law, overlap):
    """Return (2/5) k d^(5/2) [J]."""
    return 0.4 * law.k * overlap**2 * overlap**0.5


def slip_limit(law, overlap):
    """Return the largest slip of the tangential spring [m]: mu k d^(3/2)/kt."""
    return law.mu * law.k * overlap * overlap**0.5 / law.kt


ELASTIC = Stiffening(k=1e9, kt=1e5, mu=0.0, gamma_n=0.0, gamma_t=0.0)
ROUGH = Stiffening(k=1e9, kt=1e6, mu=0.4, gamma_n=3000.0, gamma_t=30.0)
SPEED = 0.5  # [m/s]


def bounce() -> dict[str, float]:
    """Return mass, largest overlap and speed after an impact of a block's corner on a floor."""
    import scenes

    sim = scenes.corner_on_wall(ELASTIC, 1e-7)
    scenes.launch(sim, vy=-SPEED)
    start, deepest = scenes.position(sim)[1], 0.0
    while scenes.velocity(sim)[1] < 0 or scenes.position(sim)[1] < start:
        sim.run(1)
        deepest = max(deepest, start - scenes.position(sim)[1])
    energies = sim.energies()
    return {
        "mass": scenes.mass(sim),
        "deepest": float(deepest - scenes.HAIR),
        "speed": float(scenes.velocity(sim)[1]),
        "elastic": energies["elastic_normal"] + energies["elastic_tangential"],
    }


def discharge() -> dict[str, float]:
    """Return what a small silo dissipates until it is empty, and what its energies leave open."""
    import numpy as np
    import scenes

    from silo2d.case.outline import hopper
    from silo2d.engine.simulation import Simulation
    from silo2d.engine.world import build_world

    x, y = np.meshgrid([-18e-3, 0.0, 18e-3], [60e-3, 75e-3, 90e-3])
    poses = np.column_stack([x.ravel(), y.ravel(), np.linspace(0.1, 1.2, 9)])
    world = build_world(
        [scenes.block(9e-3, 6e-3)], np.zeros(9, int), poses,
        hopper(np.radians(50), 30e-3, 80e-3, 0.12).walls(),
        surface_density=54.0, particle_law=ROUGH, wall_law=ROUGH, gravity=9.81, time_step=2e-6,
    )  # fmt: skip
    sim = Simulation(world)
    sim.remove_wall(len(world.bodies.row) - len(poses) - 1)
    before = sum(sim.energies().values())
    while sim.n_out < 9 and sim.time < 1.0:
        sim.run(5000)
    after = sim.energies()
    lost = sum(value for name, value in after.items() if "damping" in name or "friction" in name)
    return {"out": sim.n_out, "lost": lost, "open": sum(after.values()) - before}


def run_both() -> None:
    """Register the law and print what it does."""
    import silo2d

    functions = {"normal_force": normal_force, "normal_energy": normal_energy}
    silo2d.register_law(Stiffening, slip_limit=slip_limit, **functions)
    print(json.dumps({"bounce": bounce(), "discharge": discharge()}))


@pytest.fixture(scope="module")
def found() -> dict[str, dict[str, float]]:
    """What a process that registers the law prints."""
    paths = [str(HERE), str(HERE.parent / "helpers")]
    code = f"import sys; sys.path[:0] = {paths!r}; import test_extend_law as t; t.run_both()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def test_impact_is_that_of_the_registered_spring(found):
    """m v^2/2 = (2/5) k d^(5/2) at the largest overlap. Tolerance: steps of 0.1 us of some 100."""
    bounce = found["bounce"]
    deepest = (5 * bounce["mass"] * SPEED**2 / (4 * ELASTIC.k)) ** 0.4
    assert bounce["deepest"] == pytest.approx(deepest, rel=1e-3)
    assert bounce["speed"] == pytest.approx(SPEED, rel=1e-3)
    assert bounce["elastic"] == 0.0


def test_silo_empties_and_its_energies_add_up(found):
    """Under the law with friction and damping; the balance is of second order in the step."""
    discharge = found["discharge"]
    assert discharge["out"] == 9
    assert discharge["lost"] > 0
    assert abs(discharge["open"]) < 1e-2 * discharge["lost"]


def test_wrong_functions_are_refused():
    """In words that name the function, before any kernel is compiled."""
    import silo2d

    with pytest.raises(TypeError, match="no function 'normal_power'; it has normal_force"):
        silo2d.register_law(Stiffening, normal_power=normal_energy)
    with pytest.raises(TypeError, match="slip_limit takes 2 arguments, the law first; not 4"):
        silo2d.register_law(Stiffening, slip_limit=normal_force)
