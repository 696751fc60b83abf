"""What a step of particles of sub-spheres costs: at rest and bouncing, against the number set.

Run as `python benchmarks/clusters.py`. User CPU time of one core, energy split on; medians of
stretches, with those of the thesis's spheres in between: on a machine that others use both are
slower, and their ratio holds. A mixture is named by the numbers of its kinds; the default ones are
90 spheroids of two kinds that are alike, and a mixture before each of its parts.
"""

import argparse
import statistics
from typing import Any

import numpy as np
from damper import BOUNCING, Run, quiet, sampled, steps_of, user_us

from damper3d.case.case import DamperCase
from damper3d.engine.simulation import Simulation
from damper3d.run.fill import fill, resting
from granulab.campaign.runs.provenance import cpu_model

TARGET = 50.0  # us a step, bouncing: 90 prolate spheroids of 51 sub-spheres
LAMMPS = 470.0  # us a step, of its rigid bodies on the same scene where the number was set
_STRETCH = 5000  # steps
_USUAL = ["prolate:1.5", "prolate:3", "toroid:0.2", "45 prolate:1.5 + 45 prolate:1.5",
          "60 sphere:5mm + 30 prolate:1.5", "60 sphere:5mm", "30 prolate:1.5"]  # fmt: skip


def shaken(case: DamperCase, state: dict[str, np.ndarray]) -> Simulation:
    """The settled bed of a case, in an enclosure that begins to move."""
    sim = resting(case, state["position"][:, :3])
    sim.restore(state)
    gravity = np.append(case.gravity, 0.0)
    sim.begin_phase(shaker=case.shaker, gravity=gravity, time_step=case.time_step)
    return sampled(case, sim)


def particles_of(text: str) -> dict[str, Any]:
    """Changes to a case for "prolate:1.5", "30 prolate:1.5" or "60 sphere:5mm + 30 prolate:1.5"."""
    kinds = [part.split() for part in text.split("+")]
    if len(kinds) > 1:
        return {"particles.kind": [{"shape": shape, "count": int(n)} for n, shape in kinds]}
    *count, shape = kinds[0]
    return {"particles.shape": shape, **({"particles.count": int(count[0])} if count else {})}


def bouncing(particles: str) -> tuple[DamperCase, Run, Run]:
    """The thesis's damper with such particles, at rest and after two cycles of its motion."""
    case = DamperCase.load("thesis", {**BOUNCING, **particles_of(particles)})
    state = fill(case, quiet).state
    still = resting(case, state["position"][:, :3])
    still.restore(state)
    moving = shaken(case, state)
    go = steps_of(moving)
    go(2 * round(case.period / case.time_step))
    return case, steps_of(sampled(case, still)), go


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=10, help="stretches of which the median is")
    parser.add_argument("particles", nargs="*", default=_USUAL)
    given = parser.parse_args()
    print(f"clusters: {cpu_model()}, one core, user CPU time [us a step]")
    _, _, spheres = bouncing("sphere:5mm")
    for particles in given.particles:
        case, rest, go = bouncing(particles)
        rows = [[user_us(run, _STRETCH) for run in (rest, go, spheres)]
                for _ in range(given.repeats)]  # fmt: skip
        at_rest, moving, ball = (statistics.median(column) for column in zip(*rows, strict=True))
        print(
            f"  {case.count:3}: {particles:31} at rest {at_rest:6.1f}   bouncing {moving:6.1f} "
            f"({TARGET:g}; LAMMPS {LAMMPS:g})   358 spheres {ball:5.1f}, ratio "
            f"{moving / ball:.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
