"""A fit of the small damper's friction to its efficiency, and runs of fits in this process."""

from pathlib import Path
from typing import Any

from small_damper import write_damper

from damper3d.case.case import DamperCase
from damper3d.run.protocol import run
from granulab.campaign.sweeps.sweep import Simulator, Task, run_labelled

# Of 25 cycles that count the efficiency scatters by 3 % from one packing to the next, and goes from
# 0.113 to 0.146 as the friction goes from 0.03 to 1.
BED = {"output.keep": "summary", "output.frames": 0, "run.cycles": 30, "run.discard": 5}
TRUTH, TRIALS = 0.3, 12
FIT = """
schema = 1
simulator = "damper3d"
case = "small.toml"
seeds = 2
runs = 24
[settings]
law.restitution = 0.6
[parameters]
law.friction = { distribution = "uniform", min = 0.02, max = 2.0 }
[[observation]]
kind = "eta"
file = "eta.csv"
trials = 12
"""


def run_here(simulator: Simulator, cases: Any, *, out: Path, **engine: Any) -> Any:
    """Runs in this process, which has the kernels: new workers would load them again."""
    for _, case in cases:
        if simulator.run_folder(case, out).state != "finished":
            simulator.work(Task(case, out, packing_only=False), lambda: False)
    return run_labelled(simulator, cases, out=out, quiet=True)


def write_fit(folder: Path) -> Path:
    """Fit file with the mean efficiency of packings of a known friction, sigma 0.5 %."""
    case = write_damper(folder, BED)
    changes = {"law.friction": TRUTH, "law.restitution": 0.6}
    found = [
        run(DamperCase.load(case, changes | {"run.seed": 1000 + k}), out=folder / "truth")
        for k in range(TRIALS)
    ]
    mean = sum(one.efficiency_wall_work for one in found) / TRIALS
    (folder / "eta.csv").write_text(
        f"frequency [Hz],gamma,eta,sigma\n80,10,{mean},{0.005 * mean}\n"
    )
    (folder / "fit.toml").write_text(FIT)
    return folder / "fit.toml"
