"""Dampers as strangers would describe them: is a short run's interval that of the steady bed?

    python tests/fuzz/own_dampers.py [--cases 40] [--first 0] [--workers 2] [--write FILE.csv]

Each design is drawn from its number alone: spheres or multi-sphere particles, fill, cylinder,
material, orientation, frequency and Gamma. It is run for 8 cycles of which 3 do not count (the
default), for 43, and for 243; the mean of the last 120 of these is taken as the steady answer, with
the interval of its blocks. A line a design says what each shorter run had, what it said of itself
(damper3d.run.steady.verdict), and whether the two intervals have a point in common.
"""

import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from own_silos import log_uniform, study

from damper3d.case.case import DamperCase
from damper3d.run.protocol import run
from damper3d.run.steady import block_interval
from granulab.errors import InputError, SimulationError

SHORT = (8, 43)  # cycles of the runs that are judged
LONG, LAST = 243, 120  # cycles of the run that answers, and those of them that count
FAR = 0.15  # of the steady answer: what an engineer would notice
MOST_WORK = 2e8  # spheres times steps of the long run: some twenty seconds of CPU


def drawn_design(number: int) -> dict[str, Any]:
    """The keys of the design of a number that differ from the thesis's case."""
    rng = np.random.default_rng([23, number])
    size = rng.uniform(3.0, 8.0)  # mm
    kind = rng.choice(["sphere", "prolate:1.5", "oblate:0.7", "toroid:0.2"], p=[0.7, 0.1, 0.1, 0.1])
    width = size * rng.uniform(4.0, 9.0)
    frequency = log_uniform(rng, 30.0, 800.0)
    particles: dict[str, Any] = {"particles.shape": f"sphere:{size:.2f}mm"}
    if kind != "sphere":
        particles = {
            "particles.shape": str(kind),
            "particles.equal_volume_radius": f"{size / 2:.2f} mm",
            "particles.sub_spheres": 13 if kind.startswith("prolate") else 12,  # a chain is odd
        }
    return particles | {
        "particles.fill_ratio": round(rng.uniform(0.15, 0.45), 3),
        "enclosure.diameter": f"{width:.1f} mm",
        "enclosure.height": f"{width * rng.uniform(0.7, 1.6):.1f} mm",
        "law.friction": round(rng.uniform(0.1, 0.8), 2),
        "law.restitution": round(rng.uniform(0.4, 0.92), 2),
        "motion.orientation": str(
            rng.choice(["vertical", "horizontal", "none"], p=[0.5, 0.4, 0.1])
        ),
        "motion.frequency": round(frequency, 1),
        "motion.gamma": round(log_uniform(rng, 1.0, 60.0), 2),
        "output.keep": "summary",
    }


def cases_of(number: int) -> dict[int, DamperCase]:
    """The case of a number by its cycles, with few enough particles for MOST_WORK.

    Raises InputError where the design is refused.
    """
    keys = drawn_design(number)
    while True:
        cases = {
            cycles: DamperCase.load("thesis", keys | {"run.cycles": cycles})
            for cycles in (*SHORT, LONG)
        }
        case = cases[LONG]
        spheres = case.count * len(case.particle.radii)
        work = spheres * LONG / case.settings.motion.frequency / case.time_step
        if work <= MOST_WORK or keys["particles.fill_ratio"] < 0.1:
            return cases
        keys |= {"particles.fill_ratio": round(0.7 * keys["particles.fill_ratio"], 3)}


def tried(number: int, folder: Path) -> dict[str, Any]:
    """The row of a design: refused, failed, or what its runs came to."""
    row: dict[str, Any] = {"design": f"own{number:03}"}
    try:
        cases = cases_of(number)
    except InputError as error:
        return {**row, "outcome": "refused", "said": str(error)}
    motion = cases[LONG].settings.motion
    row |= {
        "particles": cases[LONG].particle.name,
        "count": cases[LONG].count,
        "fill_ratio": cases[LONG].fill_ratio,
        "orientation": cases[LONG].orientation,
        "frequency_hz": motion.frequency,
        "gamma": motion.gamma,
    }
    try:
        found = {cycles: run(case, out=folder) for cycles, case in cases.items()}
    except SimulationError as error:
        return {**row, "outcome": "failed", "said": str(error)}
    last = np.array(found[LONG].efficiency_per_cycle)[-LAST:]
    low, high = block_interval(last)
    row |= {"outcome": "done", "steady": float(last.mean()), "steady_low": low, "steady_high": high}
    for cycles in SHORT:
        one = found[cycles]
        own = one.efficiency_interval or (math.nan, math.nan)
        row |= {
            f"eta_{cycles}": one.efficiency_with_settling,
            f"low_{cycles}": own[0],
            f"high_{cycles}": own[1],
            f"says_{cycles}": _says(one.steady, one.efficiency_note),
            f"holds_{cycles}": bool(own[0] <= high and low <= own[1]),
        }
    return row


def _says(steady: bool | None, settles: str | None) -> str:
    if settles is not None:
        return "settles"
    return {True: "steady", False: "not steady", None: "cannot say"}[steady]


def report(rows: list[dict[str, Any]]) -> str:
    """Counts of what short runs said of themselves, and of what was so."""
    ran = [row for row in rows if row["outcome"] == "done"]
    counts = Counter(row["outcome"] for row in rows)
    lines = [
        f"{len(rows)} dampers of strangers: {len(ran)} ran, {counts['refused']} refused, "
        f"{counts['failed']} failed; steady is the mean of the last {LAST} of {LONG} cycles"
    ]
    for cycles in SHORT:
        lines.append(f"of {cycles} cycles, that count from the 4th on:")
        for says in ("steady", "cannot say", "not steady", "settles"):
            own = [row for row in ran if row[f"says_{cycles}"] == says]
            hold = sum(row[f"holds_{cycles}"] for row in own)
            far = [
                row for row in own
                if not row[f"holds_{cycles}"]
                and abs(row[f"eta_{cycles}"] / row["steady"] - 1) > FAR
            ]  # fmt: skip
            names = f" ({', '.join(row['design'] for row in far)})" if far else ""
            lines.append(
                f"  says {says!r}: {len(own)}; the interval holds the steady answer in {hold}, "
                f"is off by more than {100 * FAR:g} % in {len(far)}{names}"
            )
    lines += [f"{row['design']} {row['outcome']}: {row['said']}" for row in rows if "said" in row]
    return "\n".join(lines)


if __name__ == "__main__":
    study(__doc__, 40, "own-dampers", tried, report)
