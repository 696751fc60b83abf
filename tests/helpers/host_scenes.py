"""A ball, or a small bed, in an enclosure on a host: what tests compare with closed forms."""

import math
from pathlib import Path
from typing import Any

import numpy as np
from damper_scenes import acrylic

from damper3d.case.case import DamperCase
from damper3d.case.host.host import Drive, host_of
from damper3d.case.host.modes import Modes
from damper3d.engine.enclosures import cylinder
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world
from damper3d.run.result import Result

UP, RADIUS = np.array([0.0, 0.0, 1.0]), 5e-3


def on_host(
    modes: Modes, drive: Drive, *, mass: float, gap: float, dt: float, restitution: float = 0.6,
    steps_per_sample: int = 1, off: float = 0.0,
) -> Simulation:  # fmt: skip
    """A ball of a mass in the middle of a cylinder that it has a gap in, or off it; SI."""
    law = acrylic(restitution, 0.0, dashpot=False)
    density = mass / (4 / 3 * math.pi * RADIUS**3)
    world = build_world(
        np.array([[0.0, 0.0, RADIUS + gap / 2 + off]]), np.array([RADIUS]), density=density,
        enclosure=cylinder(0.05, 2 * RADIUS + gap), pair_law=law, wall_law=law,
        shaker=host_of(modes, drive, dt, 0.0), direction=UP, gravity=np.zeros(3), time_step=dt,
    )  # fmt: skip
    sim = Simulation(world, steps_per_sample)
    start = float(sim.sample()["displacement"][0])
    sim.world.spheres.position[:1, 2] += start
    return sim


def resolved(**tables: dict[str, Any]) -> DamperCase:
    """A case of twenty balls of 5 mm, soft as in the small damper, with some tables changed."""
    document: dict[str, Any] = {
        "name": "small",
        "enclosure": {"diameter": "20 mm", "height": "25 mm"},
        "particles": {"shape": "sphere:5mm", "count": 20},
        "law": {"youngs_modulus": "0.1 GPa"},
        "fill": {"settle_time": "20 ms"},
        "run": {"cycles": 4, "discard": 2, "time_step": "5 us"},
        "output": {"samples": 50, "frames": 10},
    }  # fmt: skip
    for name, table in tables.items():
        document[name] = {**document.get(name, {}), **table}
    return DamperCase.resolve(document, "small", Path())


def works(result: Result, omega: float) -> tuple[np.ndarray, np.ndarray]:
    """Work on the bed [J] and the enclosure's amplitude [m] in each cycle of 50 samples."""
    from granulab.campaign.runs.trajectory import read_trajectory

    samples = read_trajectory(Path(result.run_folder))
    work = np.diff(samples["wall_work"][::50])
    turned = np.exp(-1j * omega * samples["time"][1:])
    size = np.abs(2 * (samples["displacement"][1:] * turned).reshape(-1, 50).mean(axis=1))
    return work, size
