"""Prints the tables of docs/lammps-damper.md: `python tests/compare_damper_lammps.py`."""

import numpy as np
from damper_scenes import acrylic, bed_of, cycles_of, onto_wall, shaken, simulation, two_spheres
from lammps_damper import Bed, Lammps, Scene

from damper3d.enclosure import cylinder

LAWS = {
    "no damping": {"restitution": 1.0},
    "no damping, stored force": {"restitution": 1.0, "tangential": "force"},
    "ends at zero force, no tangential dashpot": {"end": "force", "dashpot": False},
    "ends at zero overlap, no tangential dashpot": {"dashpot": False},
    "ends at zero force": {"end": "force"},
    "the thesis's": {},
    "the thesis's, stored force": {"tangential": "force"},
}
POINTS = [(40, 20, False), (40, 20, True), (160, 3, False), (20, 5, False)]


def both(scene: Scene, steps: int) -> tuple[Bed, Bed]:
    """Here and in LAMMPS, after so many steps."""
    sim = simulation(scene)
    sim.step(steps)
    with Lammps(scene) as there:
        there.run(steps)
        return bed_of(sim), there.bed()


def print_impacts() -> None:
    """How far spins are apart after oblique impacts, as a part of their change [%]."""
    print("| law | pair | pair, 16 K | wall | wall, 16 K |\n|---|---|---|---|---|")
    for name, given in LAWS.items():
        parts = []
        for scene_of in (two_spheres, onto_wall):
            for stiffer in (1.0, 16.0):
                law = acrylic(**given)
                scene = scene_of(law._replace(hertz=stiffer * law.hertz), 5e-8)
                here, there = both(scene, 2400)
                change = np.abs(here.spin - scene.spin).max()
                parts.append(f"{100 * np.abs(here.spin - there.spin).max() / change:.2f}")
        print(f"| {name} | {' | '.join(parts)} |")


def print_steps() -> None:
    """Spin after the impact on a wall, against the time step."""
    print("\n| step [us] | spin here [rad/s] | spin in LAMMPS [rad/s] |\n|---|---|---|")
    for step in (1e-6, 5e-7, 2e-7, 1e-7, 5e-8, 2e-8, 1e-8):
        here, there = both(onto_wall(acrylic(), step), round(1.2e-4 / step))
        print(f"| {1e6 * step:g} | {here.spin[0, 1]:.2f} | {there.spin[0, 1]:.2f} |")


def print_efficiencies(n_packings: int = 3) -> None:
    """Eta by wall work, cycles 4-8, mean and deviation over packings of 358 spheres."""
    print("\n| f [Hz] | Gamma | gravity | law | here | LAMMPS |\n|---|---|---|---|---|---|")
    for frequency, gamma, horizontal in POINTS:
        for name in ("ends at zero force, no tangential dashpot", "the thesis's"):
            steps = round(1e6 / frequency)
            eta = []
            for seed in range(1, n_packings + 1):
                scene = shaken(358, cylinder(0.04, 0.04), acrylic(**LAWS[name]), seed=seed,
                               frequency=frequency, gamma=gamma, steps=steps,
                               horizontal=horizontal)  # fmt: skip
                work = [cycles_of(scene, 8, steps).wall_work]
                with Lammps(scene) as there:
                    there.start()
                    work.append(there.cycles(8, steps).wall_work)
                eta.append([scene.efficiency(part[3:].sum(), 5) for part in work])
            means, off = np.mean(eta, axis=0), np.std(eta, axis=0, ddof=1)
            columns = " | ".join(f"{m:.3f} ± {s:.3f}" for m, s in zip(means, off, strict=True))
            print(f"| {frequency} | {gamma} | {'across' if horizontal else 'along'} | {name} "
                  f"| {columns} |", flush=True)  # fmt: skip


if __name__ == "__main__":
    print_impacts()
    print_steps()
    print_efficiencies()
