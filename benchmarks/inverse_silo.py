"""A known friction found again from a simulated discharge: its time and its curve.

    python benchmarks/inverse_silo.py runs docs/results/calibration

runs three discharges of a silo of 200 particles with a friction of 0.4 between them, takes their
mean time (+- 5 ms) and curve (+- 0.02) for measured, with that noise put on, and fits the friction
to it. The runs go to the first folder, report and figures as inverse-silo-* to the second.
"""

import shutil
import sys
from pathlib import Path

import numpy as np

from granulab.campaign.runs.trajectory import read_trajectory
from granulab.campaign.sweeps.sweep import over_seeds
from silo2d.case.case import SiloCase
from silo2d.run.sweep import run_cases

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "helpers"))
from small_silo import write_case

TRUTH = 0.4
TRIALS = 3
TIMES = np.array([0.1, 0.2, 0.3, 0.4])  # [s]
SIGMA_TIME, SIGMA_FRACTION = 5e-3, 0.02
LARGER = {
    "silo.width": "120 mm",
    "silo.height": "150 mm",
    "silo.outlet": "60 mm",
    "fill.level": "100 mm",
    "law.mu_wall": 0.3,
    "law.mu_particle": TRUTH,
}
FIT = """schema = 1
simulator = "silo2d"
case = "small.toml"
seeds = 3
runs = 36
[parameters]
law.mu_particle = { distribution = "uniform", min = 0.1, max = 0.8 }
[[observation]]
kind = "discharge_time"
"""


def measured(folder: Path) -> tuple[float, np.ndarray]:
    """Mean time [s] and fractions of discharges with seeds that the fit does not take."""
    case = SiloCase.load(write_case(folder, LARGER))
    seeds = [1001 + k for k in range(TRIALS)]
    rows = run_cases(over_seeds({}, case, seeds), out=folder / "truth", quiet=True)
    curves = []
    for row in rows:
        frames = read_trajectory(row["run_folder"])
        mass, out = frames.static["mass"], frames["out_time"][-1]
        curves.append((out[None] <= TIMES[:, None]) @ mass / mass[~np.isnan(out)].sum())
    print(*(f"seed {row['seed']}: {row['outcome']}, {row['discharge_time_s']} s" for row in rows),
          sep="\n")  # fmt: skip
    random = np.random.default_rng(1)
    time = np.mean([row["discharge_time_s"] for row in rows]) + SIGMA_TIME * random.normal()
    return time, np.mean(curves, axis=0) + SIGMA_FRACTION * random.normal(size=len(TIMES))


def main() -> None:
    """Make the measurement, fit it, and keep the answer."""
    from calibration.commands.main import main as calibrate

    folder, results = Path(sys.argv[1]), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    time, fractions = measured(folder)
    table = ["time [s],fraction", *(f"{t},{f:.4f}" for t, f in zip(TIMES, fractions, strict=True))]
    (folder / "curve.csv").write_text("\n".join(table) + "\n")
    (folder / "inverse-silo.toml").write_text(
        f'{FIT}value = "{time:.4f} s"\nsigma = "{SIGMA_TIME} s"\ntrials = {TRIALS}\n'
        f'[[observation]]\nkind = "curve"\nfile = "curve.csv"\nsigma = {SIGMA_FRACTION}\n'
        f"trials = {TRIALS}\n"
    )
    sys.argv[1:] = ["inverse", str(folder / "inverse-silo.toml"), "-o", str(folder)]
    calibrate()
    (kept,) = (folder / "inverse").glob("inverse-silo-*")
    results.mkdir(parents=True, exist_ok=True)
    for file in (kept / "report.txt", *kept.glob("figures/*.png")):
        shutil.copy(file, results / f"inverse-silo-{file.name}")


if __name__ == "__main__":  # the workers import this file
    main()
