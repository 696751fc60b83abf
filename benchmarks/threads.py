"""Speed-up of one run by threads: wall time of a step by one and by several.

    python benchmarks/threads.py --write docs/results/threads.txt

Stretches of one and of several threads take turns on the same bed, and the least of each counts: a
machine that others use too only ever adds. A step is compared on the same state, since the threads
leave the same bits.
"""

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np

from benchmarks.speed import damper, silo
from damper3d.run.fill import resting
from granulab.campaign.output.files import write_atomic
from granulab.campaign.runs.provenance import cpu_model
from granulab.campaign.runs.sharing import cores

_STRETCHES, _SETTLING = 5, 6000


class Bed(NamedTuple):
    """A bed that goes on by steps."""

    name: str
    n_particles: int
    share: Callable[[int], int]
    go: Callable[[int], Any]


def of_spheres(n: int, m: int) -> Iterator[Bed]:
    """n x m beds of 358 spheres in one box: at rest, and bouncing."""
    wide, centres = damper.in_one_box(n, m)
    sim = damper.sampled(wide, resting(wide, centres))
    sim.step(_SETTLING)
    yield Bed("spheres at rest", wide.count, sim.share, sim.step)
    sim.share(1)
    sim.begin_phase(shaker=wide.shaker, time_step=wide.time_step)
    sim.step(round(1.5 * wide.period / wide.time_step))
    yield Bed("spheres, 40 Hz, Gamma 20", wide.count, sim.share, sim.step)


def of_polygons(copies: int) -> Iterator[Bed]:
    """Copies of D4's bed in one silo, the door closed."""
    sim = silo.in_one_silo(copies)
    yield Bed("polygons at rest", sim.n_particles, sim.share, sim.run)


def step_us(bed: Bed, n_threads: int, steps: int) -> float:
    """Wall time of a step by so many threads [us]; inf where not so many can share it."""
    if bed.share(n_threads) < n_threads:
        return np.inf
    bed.go(10)
    began = time.perf_counter()
    bed.go(steps)
    return 1e6 * (time.perf_counter() - began) / steps


def line(bed: Bed, numbers: list[int]) -> str:
    """A bed's times and speed-ups."""
    steps = max(2_000_000 // bed.n_particles, 50)
    times = [[step_us(bed, n, steps) for n in numbers] for _ in range(_STRETCHES)]
    least = np.min(times, axis=0)
    cells = [f"{least[0]:7.1f}", *(f"{us:7.1f} ({least[0] / us:.2f})" for us in least[1:])]
    return f"{bed.n_particles:7} {bed.name:25}" + "  ".join(cells)


def main() -> None:
    """Print the table; write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--largest", type=int, default=25_000, help="particles at most")
    parser.add_argument("--write", type=Path, metavar="FILE", help="keep it")
    given = parser.parse_args()
    numbers = [n for n in (1, 2, 4, 8, 16) if n <= cores()]
    head = f"us of wall time a step by {', '.join(map(str, numbers))} threads (speed-up)"
    lines = [f"python {' '.join(sys.argv)}", f"{cpu_model()}, {cores()} cores", "", head]
    print("\n".join(lines), flush=True)
    wide = [of_spheres(*size) for size in ((2, 2), (4, 4), (8, 7))]
    for bed in (bed for beds in [*wide, *map(of_polygons, (2, 8, 32))] for bed in beds):
        if bed.n_particles <= given.largest:
            lines.append(line(bed, numbers))
            print(lines[-1], flush=True)
    if given.write:
        write_atomic(given.write, "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
