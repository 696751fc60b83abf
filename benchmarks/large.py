"""Cost and memory of a particle in large beds, and of their checkpoints and frames.

    python benchmarks/large.py --write docs/results/large.txt

A bed of 20,048 spheres (7 by 8 settled ones of 358, without the walls between them) goes on until
it has settled, or bounced for a cycle and a half; larger beds are copies of it side by side, with
their contacts, and settle for a moment; the largest also begins without contacts, numbered at
random and as a filling numbers it. Polygons are copies of D4's bed. One thread; the least CPU
time of a few stretches counts. A checkpoint and a frame are written as a run writes them, and their
times are compared with that of the steps between two; memory is what the process takes beyond what
it had before the bed was made.
"""

import argparse
import math
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np

from benchmarks.speed import damper, silo
from benchmarks.speed.timing import cost_of
from damper3d.case.plan import checkpoint_interval
from damper3d.engine.growth.spheres import in_columns
from damper3d.engine.simulation import Simulation
from damper3d.run.fill import resting
from damper3d.run.vibration import frame_interval, tables_of
from granulab.campaign.output.files import write_atomic
from granulab.campaign.runs.checkpoint import save_checkpoint
from granulab.campaign.runs.provenance import cpu_model
from granulab.campaign.runs.trajectory import TrajectoryWriter
from silo2d.case.case import SiloCase
from silo2d.run.discharge import contacts_of, frame_of

_TILES = 8, 7  # beds of 358 in the one that larger ones are copies of
_COPIES = (1, 1), (5, 1), (10, 5)
_SILOS = 32, 154
_SETTLING, _AFTERWARDS, _MOMENT, _CYCLES = 10_000, 500, 20, 1.5
_ORDER = np.random.default_rng(1)
_WORK, _STRETCHES = 40_000_000, 3  # particles times steps of a stretch
_WRITTEN = 2  # times: the first may compile
_PROCESS = Path("/proc/self")  # Linux says, and forgets, how much memory a process took at most
_HEAD = """ns of CPU a particle and step (over that of the least bed); bytes a particle in arrays,
and in memory at most; time and size of a checkpoint and of a frame, and their part of the
time of the steps from one to the next"""


class Bed(NamedTuple):
    """A bed that goes on by steps, and what a run keeps of it."""

    name: str
    n_particles: int
    world: Any
    go: Callable[[int], Any]
    save: Callable[[], dict[str, np.ndarray]]
    frame: Callable[[TrajectoryWriter], None]
    intervals: tuple[int, int]  # steps from one checkpoint, and from one frame, to the next
    memory: int  # that the process took before the bed was made [bytes]
    warm_up: int  # steps before it is timed


def copies(case: Any, small: Simulation, n: int, m: int) -> tuple[Any, Simulation]:
    """The case of n x m copies of a bed side by side in one box, and they, as far as it is."""
    wide, centres = damper.in_one_box(_TILES[0] * n, _TILES[1] * m)
    sim = damper.sampled(wide, resting(wide, centres))
    sim.share(1)
    given = {name: getattr(small.world, name) for name in ("shaker", "gravity", "time_step")}
    sim.begin_phase(**given)
    sizes = np.array([case.enclosure.width, case.enclosure.depth])
    places = [(i - (n - 1) / 2, j - (m - 1) / 2) for i in range(n) for j in range(m)]
    saved, count = small.save(), case.count
    moving = {name: np.tile(saved[name], (n * m, 1)) for name in saved
              if saved[name].ndim == 2 and len(saved[name]) == count}  # fmt: skip
    moving["position"][:, :2] += np.repeat(places * sizes, count, axis=0)
    first = np.arange(n * m) * count
    on_floor = saved["wall_pairs"][:, 1] < 2  # the walls between them go
    of_walls = saved["wall_pairs"][on_floor].astype(np.int64)
    sim.restore({
        **saved, **moving, "heat": np.append(np.tile(saved["heat"][:-1], n * m), 0.0),
        "pairs": (saved["pairs"] + first[:, None, None]).reshape(-1, 2),
        "springs": np.tile(saved["springs"], n * m),
        "wall_pairs": np.concatenate([of_walls + np.array([k, 0]) for k in first]),
        "wall_springs": np.tile(saved["wall_springs"][:, on_floor], n * m),
    })  # fmt: skip
    return wide, sim


def numbered(order: Callable[[np.ndarray], np.ndarray]) -> tuple[Any, Simulation]:
    """The case and the bed of the most tiles, its centres (n, 3) in an order."""
    n, m = (a * b for a, b in zip(_TILES, _COPIES[-1], strict=True))
    wide, centres = damper.in_one_box(n, m)
    sim = damper.sampled(wide, resting(wide, order(centres)))
    sim.share(1)
    return wide, sim


def of_spheres(name: str, make: Callable[[], tuple[Any, Simulation]], warm_up: int) -> Bed:
    """A bed of spheres in one box."""
    memory = memory_now()
    case, sim = make()

    def frame(writer: TrajectoryWriter) -> None:
        writer.extend(sim.sample(), tables_of(sim))

    intervals = (checkpoint_interval(case), frame_interval(case))
    steps = tuple(interval * case.steps_per_sample for interval in intervals)
    own = (lambda: sim.world), sim.step, sim.save, frame, steps, memory, warm_up
    return Bed(name, case.count, *own)


def beds_of_spheres(largest: int) -> Iterator[Bed]:
    """Beds at rest, and then the same bouncing."""
    case, centres = damper.in_one_box(*_TILES)
    small = damper.sampled(case, resting(case, centres))
    small.share(1)
    small.step(_SETTLING)
    for name, cycles in (("spheres at rest", 0.0), ("spheres, 40 Hz, Gamma 20", _CYCLES)):
        if cycles:
            small.begin_phase(shaker=case.shaker, time_step=case.time_step)
            small.step(round(cycles * case.period / case.time_step))
        for n, m in _COPIES:
            if n * m * case.count <= largest:
                yield of_spheres(name, partial(copies, case, small, n, m), _AFTERWARDS)
    if math.prod(_COPIES[-1]) * case.count <= largest:
        columns = partial(in_columns, width=2.0 * case.particle.bounding_radius)
        for how, order in (("in columns", columns), ("at random", _ORDER.permutation)):
            yield of_spheres(f"spheres numbered {how}", partial(numbered, order), _MOMENT)


def of_polygons(n: int) -> Bed:
    """Copies of D4's bed in one silo, the door closed."""
    memory = memory_now()
    case, sim = SiloCase.load("D4"), silo.in_one_silo(n)
    sim.share(1)

    def frame(writer: TrajectoryWriter) -> None:
        writer.append(frame_of(sim, sim.wall_forces()), contacts_of(sim))

    of_many = case.settings.particles.scale / np.sqrt(n)  # a silo that has them has such frames
    intervals = SiloCase.load("D4", {"particles.scale": of_many}).intervals
    every = (case.settings.output.checkpoint_interval, intervals[0])
    steps = tuple(round(interval / sim.time_step) for interval in every)
    own = (lambda: sim.world), sim.run, sim.save, frame, steps, memory, _AFTERWARDS
    return Bed("polygons at rest", sim.n_particles, *own)


def beds_of_polygons(largest: int) -> Iterator[Bed]:
    """Beds at rest."""
    in_one = of_polygons(1)  # pours it, compiles
    in_one.go(1)
    for n in _SILOS:
        if n * in_one.n_particles <= largest:
            yield of_polygons(n)


def bytes_of(arrays: Any) -> int:
    """Bytes of all arrays in tuples of such."""
    if isinstance(arrays, tuple):
        return sum(map(bytes_of, arrays))
    return arrays.nbytes if isinstance(arrays, np.ndarray) else 0


def most_memory() -> int:
    """Bytes that the process took at most since memory_now; 0 where the system does not say."""
    if not _PROCESS.exists():
        return 0
    lines = (_PROCESS / "status").read_text().splitlines()
    return 1024 * int(next(line for line in lines if line.startswith("VmHWM")).split()[1])


def memory_now() -> int:
    """Bytes that the process takes now; the most is counted from here on."""
    if _PROCESS.exists():
        (_PROCESS / "clear_refs").write_text("5")
    return most_memory()


def kept(write: Callable[[Path], object]) -> tuple[float, float]:
    """Seconds that writing into a folder takes, and MB of what lies there then."""
    with tempfile.TemporaryDirectory(dir=".") as folder:
        began = time.perf_counter()
        write(Path(folder))
        took = time.perf_counter() - began
        return took, 1e-6 * sum(p.stat().st_size for p in Path(folder).rglob("*") if p.is_file())


def measured(bed: Bed) -> tuple[float, str]:
    """Its ns a particle and step, and the rest of its line."""
    steps, n = max(_WORK // bed.n_particles, 1), bed.n_particles
    bed.go(bed.warm_up)
    each = min(cost_of(lambda: bed.go(steps), steps) for _ in range(_STRETCHES))

    def frame(folder: Path) -> None:
        writer = TrajectoryWriter(folder)
        bed.frame(writer)
        writer.flush()

    writers = (lambda folder: save_checkpoint(folder / "checkpoint.h5", bed.save(), {}), frame)
    cells = []
    for write, interval in zip(writers, bed.intervals, strict=True):
        took, size = min(kept(write) for _ in range(_WRITTEN))
        part = took / (interval * each)
        cells.append(f"{took:6.2f} s {size:6.1f} MB {100 * part:5.2f} %")
    memory = f"{bytes_of(bed.world()) / n:5.0f} {(most_memory() - bed.memory) / n:5.0f}"
    return 1e9 * each / n, f"  {memory}  " + "  ".join(cells)


def lines(beds: Iterator[Bed]) -> Iterator[str]:
    """A line a bed."""
    least: dict[str, float] = {}
    for bed in beds:
        cost, rest = measured(bed)
        over = cost / least.setdefault(bed.name.partition(" numbered")[0], cost)
        yield f"{bed.n_particles:8} {bed.name:28} {cost:5.1f} ({over:.2f}){rest}"
        del bed  # before the next one is made


def main() -> None:
    """Print the table; write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--largest", type=int, default=1_100_000, help="particles at most")
    parser.add_argument("--write", type=Path, metavar="FILE", help="keep it")
    given = parser.parse_args()
    table = [f"python {' '.join(sys.argv)}", f"{cpu_model()}, one thread", "", _HEAD]
    print("\n".join(table), flush=True)
    for beds in (beds_of_polygons, beds_of_spheres):
        for line in lines(beds(given.largest)):
            table.append(line)
            print(line, flush=True)
    if given.write:
        write_atomic(given.write, "\n".join(table) + "\n")


if __name__ == "__main__":
    main()
