"""Displacement profiles of silos A4 and D4 every 0.25 s over seeds, and the paper's claims.

Granular Matter 15 (2013) 811, sec. 4.2.1 and Figs. 14 and 15: pictures of the painted layers and
three statements, no numbers. Line, depth, width and scatter are those of measures/profile.py.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.figure import BLUE, VERMILION, WALL
from granulab.campaign.output.layout import columns, paragraphs
from silo2d.case.outline import preset
from silo2d.measures.basics.particles import Series, numbers
from silo2d.measures.profile import layer_lines, profile_frames, v_shapes
from silo2d.reproduce.quantities.displacement import PROFILES, deeper_in_second, in_mm, profiles
from silo2d.view.scene import read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pandas import DataFrame

Row = dict[str, Any]

SEEDS = 5
COLUMNS = None
SILOS = "A4", "D4"
LAST = 1.25  # s, the last picture of the paper
_NOTE = """\
V depth / V width [mm], mean +- sample sd over the seeds that have one, (n) where not all do; layers
of 45 mm from the bottom up; "cut": the layer has no particles above the middle of the outlet but
some next to it; "-": fewer than two particles of it in any column."""
_ELSEWHERE = """\
Slip-stick motion at the walls is measured by `silo2d observe RUN stickslip`,
intermittent flow by `silo2d observe RUN curve`. The paper prints no depth or width."""
_KEPT = ["silo", "seed", "state", "reason", "outcome", "n_particles", "n_out", "discharge_time_s"]


def run(
    *, out: Path, seeds: Sequence[int], workers: int | None, quiet: bool, **engine: Any
) -> list[Row]:
    """A row a silo, seed, time and layer; one row for a run that failed."""
    from granulab.campaign.sweeps.sweep import is_elsewhere, over_seeds
    from silo2d.case.case import SiloCase
    from silo2d.reproduce.runs import run_all

    cases = [c for s in SILOS for c in over_seeds({"silo": s}, SiloCase.load(s), seeds)]
    runs = run_all(cases, out=out, workers=workers, quiet=quiet, **engine)
    kept = engine.get("known", ())
    return [
        row for one in runs for row in (_alike(one, kept) if is_elsewhere(one) else rows_of(one))
    ]


def _alike(one: Row, rows: Sequence[Row]) -> list[Row]:
    return [row for row in rows if all(row[key] == one[key] for key in ("silo", "seed"))]


def rows_of(one: Row) -> Iterator[Row]:
    """The rows of one run of a sweep, up to 1.25 s after the opening.

    grains            of the layer in the silo
    level_m           mean height of the layer's line
    depth_m, width_m  of its V; None where it has none; pierced: it is cut through
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
            "grain_size_m": round(scene.particle_size, 5),
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
    """Lengths to a hundredth of a millimetre, which is a thousandth of a particle."""
    return dict(zip(keys, numbers(np.round(values, 5)), strict=True))


def report(rows: list[Row]) -> str:
    """Tables of V depth and width, and the claims of the paper judged."""
    found = profiles(rows)
    judged = report_claims(PROFILES.judge(claims_of("silo_displacement"), found))
    failed = [
        f"{row['state']}: {row['silo']}, seed {row['seed']}: {row['reason']}"
        for row in rows
        if row["state"] != "done"
    ]
    return paragraphs(
        *(_table(silo, own) for silo, own in found.groupby("silo", sort=False)),
        _NOTE,
        "\n".join(failed),
        f"What the paper says (sec. 4.2.1, Figs. 12 to 15), and what these runs show:\n{judged}",
        _deeper(found),
        _ELSEWHERE,
    )


def _table(silo: str, own: "DataFrame") -> str:
    """Layers down, times across."""
    seeds = own["seed"].nunique()
    moved = own[own["time_s"] > 0]
    times = sorted(moved["time_s"].unique())
    lines = []
    for layer in sorted(own["layer"].unique(), reverse=True):
        at = {time: moved[(moved["layer"] == layer) & (moved["time_s"] == time)] for time in times}
        lines.append([f"layer {layer:.0f}", *(_cell(at[time], seeds) for time in times)])
    return columns([f"{silo}, {seeds} seeds", *(f"{time:.2f} s" for time in times)], lines)


def _cell(own: "DataFrame", seeds: int) -> str:
    depth, width = own["depth_m"].dropna().tolist(), own["width_m"].dropna().tolist()
    cut = int(own["pierced"].sum())
    if not depth:
        return f"cut ({cut})" if cut else "-"
    of = f" ({len(depth)})" if len(depth) < seeds else ""
    return f"{in_mm(depth)} / {in_mm(width)}{of}"


def _deeper(found: "DataFrame") -> str:
    """Not said by the paper: which V is deeper, layer by layer, where both silos have one."""
    first, second = (found[found["silo"] == silo] for silo in SILOS)
    if not len(first) or not len(second):
        return ""
    differ = deeper_in_second(first, second).tolist()
    return (
        f"Not said by the paper: at the same layer and time D4's V is deeper than A4's in\n"
        f"  {sum(d > 0 for d in differ)} of {len(differ)} cases, by {in_mm(differ)} mm (mean +- sd)"
    )


def draw(rows: list[Row]) -> "Figure":
    """The lines every 0.25 s, a row of panels a silo: thin for each seed, thick for their mean."""
    from matplotlib.figure import Figure

    found = profiles(rows)
    silos = list(dict.fromkeys(found["silo"]))
    times = sorted(set(found["time_s"])) if silos else []
    figure = Figure(figsize=(1.4 * max(len(times), 1) + 0.3, 2.6 * max(len(silos), 1)),
                    layout="constrained")  # fmt: skip
    panels = figure.subplots(max(len(silos), 1), max(len(times), 1), squeeze=False)
    for panel in panels.flat:
        panel.set_axis_off()
    for line, silo in zip(panels, silos, strict=False):  # none where all failed
        for panel, time in zip(line, times, strict=True):
            _panel(panel, silo, found[(found["silo"] == silo) & (found["time_s"] == time)])
            panel.set_title(f"{silo}, {time:.2f} s", fontsize=9)
    return figure


def _panel(panel: "Axes", silo: str, own: "DataFrame") -> None:
    from matplotlib.collections import LineCollection

    outline = preset(silo)
    panel.add_collection(LineCollection(list(outline.walls().segments[:-1]), colors=WALL, lw=1.6))
    left, right = outline.polygon[:, 0].min(), outline.polygon[:, 0].max()
    for layer, of_layer in own.groupby("layer"):
        colour = (BLUE, VERMILION)[int(layer) % 2]
        lines = of_layer.filter(regex=r"^y\d+_m$").to_numpy(float)
        x = left + (np.arange(lines.shape[1]) + 0.5) * (right - left) / lines.shape[1]
        panel.plot(x, lines.T, color=colour, lw=0.4, alpha=0.6)
        seen = np.isfinite(lines).sum(axis=0)
        mean = np.nansum(lines, axis=0) / np.maximum(seen, 1)
        panel.plot(x, np.where(2 * seen > len(lines), mean, np.nan), color=colour, lw=1.7)
    panel.set(xlim=(left - 0.004, right + 0.004), ylim=(-0.004, outline.height), aspect="equal")
