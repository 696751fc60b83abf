"""Displacement profiles of silos A4 and D4 every 0.25 s over seeds, beside what the paper says.

Granular Matter 15 (2013) 811, sec. 4.2.1 and Figs. 14 and 15: pictures of the painted layers and
three statements, no numbers. Line, depth, width and scatter are those of measures/profile.py.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from silo2d.measures.basics.particles import Series, numbers, particle_size
from silo2d.measures.profile import layer_lines, profile_frames, v_shapes
from silo2d.view.scene import read_scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = dict[str, Any]

SEEDS = 5
SILOS = "A4", "D4"
LAST = 1.25  # s, the last picture of the paper
_KEPT = ["silo", "seed", "state", "reason", "outcome", "n_particles", "n_out", "discharge_time_s"]


def run(
    *, out: Path, seeds: Sequence[int], workers: int | None, quiet: bool, **engine: Any
) -> list[Row]:
    """A row a silo, seed, time and layer; one row for a run that failed."""
    from granulab.campaign.sweeps.sweep import over_seeds
    from silo2d.case.case import SiloCase
    from silo2d.reproduce.runs import run_all

    cases = [c for s in SILOS for c in over_seeds({"silo": s}, SiloCase.load(s), seeds)]
    runs = run_all(cases, out=out, workers=workers, quiet=quiet, **engine)
    return [row for one in runs for row in rows_of(one)]


def rows_of(one: Row) -> Iterator[Row]:
    """The rows of one run of a sweep, up to 1.25 s after the opening.

    grains            of the layer in the silo
    level_m           mean height of the layer's line
    depth_m, width_m  of its V; None where it has none; pierced tells that it is cut through
    scatter_m         of the displacements about the line
    y1_m, y2_m, ...   the line, column by column from the left
    """
    kept = {key: one.get(key) for key in _KEPT}
    if one["state"] != "done":
        yield kept
        return
    scene = read_scene(one["run_folder"])
    frames = [frame for frame in profile_frames(scene.time) if scene.time[frame] < LAST + 0.01]
    lines, counts, scatter = layer_lines(scene, frames)
    depth, width, pierced = v_shapes(scene, lines)
    for layer, f in np.ndindex(depth.shape):
        line = lines[layer, f]
        values = np.array([_mean(line), depth[layer, f], width[layer, f], scatter[layer, f]])
        yield {
            **kept,
            "grain_size_m": round(particle_size(scene), 5),
            "time_s": round(float(scene.time[frames[f]]), 6),
            "layer": layer + 1,
            "grains": int(counts[layer, f].sum()),
            "pierced": bool(pierced[layer, f]),
            **_rounded(["level_m", "depth_m", "width_m", "scatter_m"], values),
            **_rounded([f"y{k + 1}_m" for k in range(len(line))], line),
        }


def _mean(line: Series) -> float:
    known = line[np.isfinite(line)]
    return float(known.mean()) if len(known) else np.nan


def _rounded(keys: list[str], values: Series) -> dict[str, float | None]:
    """Lengths to a hundredth of a millimetre, which is a thousandth of a grain."""
    return dict(zip(keys, numbers(np.round(values, 5)), strict=True))


def report(rows: list[Row]) -> str:
    """Tables of V depth and width, and a word on each of the paper's statements."""
    from silo2d.reproduce.displacement_report import statements, tables

    return f"{tables(rows)}\n\n{statements(rows)}"


def draw(rows: list[Row]) -> "Figure":
    """The lines every 0.25 s, a row of panels a silo: thin for each seed, thick for their mean."""
    from silo2d.reproduce.displacement_report import sheet

    return sheet(rows)
