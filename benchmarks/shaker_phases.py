"""Phase from force and acceleration against that of the particles counted, on 300 small runs.

    python benchmarks/shaker_phases.py docs/results/calibration [--runs 300] [--draw 1] [--keep DIR]

Five beds of 38 to 150 spheres are shaken at frequencies and accelerations drawn by chance; each
run is exported as a shaker's record (`damper3d export --to shaker`), and `calibrate shaker
--against` compares. Writes shaker-phases.csv, a row a run, .txt and .png. 6 minutes of CPU.
"""

import argparse
import csv
import tempfile
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from calibration.shaker.against import Confusion, against
from damper3d.case.case import DamperCase
from damper3d.run.sweep import run_cases
from damper3d.view.export import export
from granulab.campaign.output.figure import write_figure
from granulab.campaign.sweeps.sweep import Labelled, over_seeds

# Diameter and height of the enclosure, spheres, their number: fill ratios of 0.32 to 0.47.
BEDS = (
    ("20 mm", "20 mm", "sphere:4mm", 75),
    ("20 mm", "25 mm", "sphere:4mm", 75),
    ("20 mm", "20 mm", "sphere:3mm", 150),
    ("20 mm", "20 mm", "sphere:5mm", 45),
    ("24 mm", "18 mm", "sphere:5mm", 40),
)
FREQUENCIES = 20.0, 320.0  # [Hz], drawn evenly in the logarithm
GAMMAS = 0.5, 80.0  # likewise
_FIXED = {
    "law.youngs_modulus": "0.3 GPa",  # with a step of 4 us a tenth of acrylic's work
    "run.time_step": "4 us",
    "fill.settle_time": "100 ms",
    "run.cycles": 25,
    "run.discard": 5,
    "output.frames": 10,
}


def cases(number: int, draw: int) -> list[Labelled]:
    """Runs at points drawn by chance, each bed as often."""
    random, found = np.random.default_rng(draw), []
    for k in range(number):
        diameter, height, shape, count = BEDS[k % len(BEDS)]
        frequency, gamma = (
            float(f"{np.exp(random.uniform(*np.log(ends))):.3g}") for ends in (FREQUENCIES, GAMMAS)
        )
        case = DamperCase.load("thesis", _FIXED | {
            "enclosure.diameter": diameter, "enclosure.height": height,
            "particles.shape": shape, "particles.count": count,
            "motion.frequency": frequency, "motion.gamma": gamma,
        })  # fmt: skip
        labels = {"bed": k % len(BEDS) + 1, "frequency_hz": frequency, "gamma": gamma}
        found += over_seeds(labels, case, [draw])
    return found


def runs(number: int, draw: int, folder: Path) -> list[Path]:
    """Folders of finished runs with their records; those that are there are not done again."""
    rows = run_cases(cases(number, draw), out=folder, workers=1, quiet=True)
    done = [Path(row["run_folder"]) for row in rows if row["state"] == "done"]
    for row in rows:
        if row["state"] != "done":
            print(f"bed {row['bed']}, {row['frequency_hz']} Hz, {row['gamma']}: {row['reason']}")
    for run in done:
        export(run, "shaker")
    return done


def write(found: Confusion, folder: Path, about: str) -> None:
    """Write shaker-phases.csv, .txt and .png."""
    rows = [
        {"frequency_hz": f"{run.frequency_hz:.4g}", "gamma": f"{run.gamma:.4g}",
         "counted": run.counted, "signals": run.signals.name,
         **{name: f"{value:.3g}" for name, value in run.signals._asdict().items()
            if name != "name"},
         "efficiency": f"{run.efficiency:.4g}", "of_run": f"{run.efficiency_of_run:.4g}"}
        for run in found.runs
    ]  # fmt: skip
    with (folder / "shaker-phases.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    text = f"# {about}\n\n{found.text()}\n"
    (folder / "shaker-phases.txt").write_text(text, encoding="utf-8", newline="\n")
    write_figure(folder / "shaker-phases.png", found.figure)
    print(text)


def main() -> None:
    """Run, compare, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--runs", type=int, default=300)
    parser.add_argument("--draw", type=int, default=1, help="Seed of the points and packings.")
    parser.add_argument("--keep", type=Path, help="Folder of the runs, which can go on there.")
    given = parser.parse_args()
    about = f"python benchmarks/shaker_phases.py {given.folder} --runs {given.runs}"
    with nullcontext(given.keep) if given.keep else tempfile.TemporaryDirectory() as folder:
        done = runs(given.runs, given.draw, Path(folder))
        write(against(done), given.folder, f"{about} --draw {given.draw}")


if __name__ == "__main__":
    main()
