"""Simulations compared with the closed forms: a few runs on either side of each predicted onset."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from damper3d.case import closed_forms
from damper3d.case.case import DamperCase
from damper3d.run.sweep import run_cases
from damper3d.studies.map.grid import Grid, map_cases
from damper3d.studies.map.peaks import DIGITS
from damper3d.studies.predict.prediction import Prediction

Rows = list[dict[str, Any]]

RATIOS = (0.5, 0.75, 0.9, 1.0, 1.25, 1.5, 2.0, 3.0)  # Gamma over the onset of the bouncing bed
GAMMAS = (1.5, 2.0, 2.5, 3.0, 3.5)  # where the fluidised bed is like a block without rebound
MOST = 100.0  # Gamma; the thesis goes no further, and impacts are then above the yield velocity
_TAKEN = ("efficiency", "efficiency_interval", "phase", "run_folder", "reused", "state", "reason")


def simulate(
    fills: Sequence[tuple[str, dict[str, Any]]],
    predictions: Sequence[Prediction],
    frequencies: Sequence[float],
    *,
    out: Path,
    **engine: Any,
) -> Rows:
    """A row a run: fill (its number), frequency_hz, gamma, both ideal efficiencies, ours.

    `fills` and `predictions` go together; a fill is what DamperCase.load takes. Ideal efficiencies
    that do not exist are None. `engine` is what run_cases takes; raises what it raises.
    """
    cases = []
    for k, ((name, changes), prediction) in enumerate(zip(fills, predictions, strict=True)):
        grid = Grid(seed=DamperCase.load(name, changes).settings.run.seed)
        points = [(f, gamma) for f in frequencies for gamma in gammas(prediction, f)]
        cases += [({"fill": k, **labels}, case)
                  for labels, case in map_cases(name, changes, grid, points)]  # fmt: skip
    rows = run_cases(cases, out=out, **engine)
    return [_compared(row, predictions[row["fill"]]) for row in rows]


def gammas(prediction: Prediction, frequency: float) -> list[float]:
    """Gammas to run, rising: about the onset, and where the bed is fluidised; up to MOST."""
    onset = prediction.best.onset(frequency)
    near = [] if onset is None else [_rounded_up(onset * ratio) for ratio in RATIOS]
    return sorted(gamma for gamma in {*near, *GAMMAS} if gamma <= MOST)


def _rounded_up(gamma: float) -> float:
    """Gamma to DIGITS digits, and not below: the onset itself has an ideal efficiency, of one."""
    return float(f"{gamma * (1 + 0.5 * 10.0 ** (1 - DIGITS)):.{DIGITS}g}")


def as_text(rows: Rows, predictions: Sequence[Prediction]) -> str:
    """The rows in words: a line for each run."""
    words = ("fill", "Hz", "Gamma", "over onset", "ideal bed", "ideal block", "simulated")
    wide = [max(len(word) + 2, 8) for word in words]
    lines = ["".join(word.rjust(w) for word, w in zip(words, wide, strict=True))]
    for row in rows:
        number = [
            predictions[row["fill"]].fill_ratio, row["frequency_hz"], row["gamma"],
            row["over_onset"], row["ideal_bouncing_bed"], row["ideal_block"], row["efficiency"],
        ]  # fmt: skip
        cells = ("-" if n is None else f"{n:.3g}" for n in number)
        lines.append("".join(cell.rjust(w) for cell, w in zip(cells, wide, strict=True)))
    return "\n".join(lines)


def _compared(row: dict[str, Any], prediction: Prediction) -> dict[str, Any]:
    gamma, onset = row["gamma"], prediction.best.onset(row["frequency_hz"])
    ratio = None if onset is None else gamma / onset
    bed = math.nan if ratio is None else float(closed_forms.collect_and_collide(ratio))
    vertical = prediction.orientation == "vertical"
    block = float(closed_forms.inelastic_block(gamma)) if vertical else math.nan
    labels = {name: row[name] for name in ("fill", "frequency_hz", "gamma", "seed")}
    return {
        **labels,
        "over_onset": ratio,
        "ideal_bouncing_bed": bed if math.isfinite(bed) else None,
        "ideal_block": block if math.isfinite(block) else None,
        **{name: row.get(name) for name in _TAKEN},
    }
