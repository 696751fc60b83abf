"""Filling with the contact law and with pymunk: what each costs, and how the silo empties after it.

`python benchmarks/filling.py [--out DIR]`, on a machine with nothing else to do; some minutes.
Runs that stand in DIR already are read, with the CPU time that their filling took then.
"""

import argparse
from pathlib import Path
from statistics import fmean

from silo2d import Result, SiloCase, run
from silo2d.run.packing import Packing, load_packing, packing_folder

SILOS = ("A4", "C4")
WAYS = ("dem", "pymunk")
SEEDS = (1, 2, 3)


def filled_and_emptied(silo: str, way: str, seed: int, out: Path) -> tuple[Packing, Result]:
    """The packing and the run that starts from it."""
    case = SiloCase.load(silo, {"fill.pour_with": way, "run.seed": seed})
    result = run(case, out=out)
    packing = load_packing(packing_folder(case, out))
    assert packing is not None  # the run has kept it
    return packing, result


def line(cells: list[object]) -> None:
    """A row of the table."""
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def seconds(time: float | None) -> str:
    """A time, or what stands for none."""
    return "none" if time is None else f"{time:.3f}"


def main() -> None:
    """Print the table, and what pymunk takes of the CPU time of the contact law."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("runs/filling"), help="folder of the runs")
    out = parser.parse_args().out
    small = {"silo.outlet": "100 mm", "fill.level": "50 mm"}
    run(SiloCase.load("A4", small | {"run.max_time": "10 ms"}), out=out)  # compiles
    line(["silo", "seed", "poured with", "filling [CPU s]", "particles", "packing fraction",
          "coordination", "outcome", "discharge time [s]", "T90 [s]"])  # fmt: skip
    line(["---"] * 10)
    for silo in SILOS:
        spent: dict[str, list[float]] = {way: [] for way in WAYS}
        for seed in SEEDS:
            for way in WAYS:
                packing, result = filled_and_emptied(silo, way, seed, out)
                spent[way].append(packing.cpu_s)
                line([silo, seed, way, f"{packing.cpu_s:.1f}", result.n_particles,
                      f"{packing.fraction:.3f}", f"{packing.coordination:.2f}", result.outcome,
                      seconds(result.discharge_time_s), seconds(result.t90_s)])  # fmt: skip
        ratio = fmean(spent["pymunk"]) / fmean(spent["dem"])
        line([silo, "mean", "pymunk / dem", f"{ratio:.2f}", *[""] * 6])


if __name__ == "__main__":
    main()
