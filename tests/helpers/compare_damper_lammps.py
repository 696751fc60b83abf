"""Print the tables of docs/verification/lammps-damper.md; there are no arguments."""

import numpy as np
from damper_scenes import acrylic, bed_of, cycles_of, onto_wall, shaken, simulation, two_spheres
from lammps_damper import Bed, Lammps, Scene

from damper3d.engine.enclosures import cylinder

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


def efficiencies(scene: Scene, steps: int) -> list[float]:
    """Eta by wall work over cycles 4-8, here and in LAMMPS."""
    work = [cycles_of(scene, 8, steps).wall_work]
    with Lammps(scene) as there:
        there.start()
        work.append(there.cycles(8, steps).wall_work)
    return [scene.efficiency(part[3:].sum(), 5) for part in work]


def row(label: str, eta: list[list[float]]) -> None:
    """Mean and standard deviation over packings."""
    means, off = np.mean(eta, axis=0), np.std(eta, axis=0, ddof=1)
    columns = " | ".join(f"{m:.3f} ± {s:.3f}" for m, s in zip(means, off, strict=True))
    print(f"| {label} | {len(eta)} | {columns} |", flush=True)


def print_small_bed(n_packings: int = 4) -> None:
    """60 spheres in 22 mm x 24 mm at 40 Hz, Gamma 20, steps of 2 us."""
    print("\n| 60 spheres, law | packings | here | LAMMPS |\n|---|---|---|---|")
    for name in ("ends at zero force, no tangential dashpot", "the thesis's"):
        scenes = (
            shaken(60, cylinder(0.022, 0.024), acrylic(**LAWS[name]), frequency=40, gamma=20,
                   seed=seed, steps=12500)
            for seed in range(1, n_packings + 1)
        )  # fmt: skip
        row(name, [efficiencies(scene, 12500) for scene in scenes])


def print_thesis_damper(n_packings: int = 3) -> None:
    """358 spheres in 40 mm x 40 mm, steps of 1 us."""
    print("\n| f [Hz], Gamma, gravity, law | packings | here | LAMMPS |\n|---|---|---|---|")
    for frequency, gamma, horizontal in POINTS:
        for name in ("ends at zero force, no tangential dashpot", "the thesis's"):
            steps = round(1e6 / frequency)
            scenes = (
                shaken(358, cylinder(0.04, 0.04), acrylic(**LAWS[name]), frequency=frequency,
                       gamma=gamma, seed=seed, steps=steps, horizontal=horizontal)
                for seed in range(1, n_packings + 1)
            )  # fmt: skip
            label = f"{frequency}, {gamma}, {'across' if horizontal else 'along'}, {name}"
            row(label, [efficiencies(scene, steps) for scene in scenes])


if __name__ == "__main__":
    print_impacts()
    print_steps()
    print_small_bed()
    print_thesis_damper()
