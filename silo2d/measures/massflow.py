"""Mass flow index: velocity at the walls over velocity at the centre line, height by height.

    MFI = v_wall/v_centre           above 0.3 mass flow, below it funnel flow

Johanson and Jenike's index (Utah Engineering Experiment Station, Bulletin 116, 1962; Johanson, J.
Appl. Mech. 31 (1964) 499), made for the radial velocities in a converging hopper. Accordingly
v_wall is the mean velocity along the nearest wall, downwards, of particles whose centroids lie
within one particle size of it, and v_centre the mean downward velocity of those within one particle
size of the vertical through the middle of the outlet: in bands of height, over all frames of a time
window, the steady part of the discharge (see curve.py) unless given. Level floors and inserts are
no walls here.

The error is the standard error over five equal parts of the window.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import BLUE, GREEN, GREY, VERMILION, headline
from granulab.errors import InputError
from silo2d.measures.basics.particles import (
    FEWEST_OUT,
    Series,
    in_silo,
    leavers,
    numbers,
    outlet_centre,
)
from silo2d.measures.curve import steady_part
from silo2d.view.scene import Scene, read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LIMIT = 0.3
_PARTS, _FEWEST_PARTS, _BANDS = 5, 3, 10


def measure(
    folder: Path, band: float | None = None, between: tuple[float, float] | None = None
) -> dict[str, Any]:
    """The index with its error in bands of height [m], and the velocities [m/s] it is made of.

    band      height of a band [m]; a tenth of the fill level unless given
    between   from and until [s]; the steady part of the discharge, or all of it, unless given

    Without it this raises InputError where fewer than twenty particles left.
    """
    scene = read_scene(folder)
    band = band or float(scene.trajectory.attributes["level"]) / _BANDS
    start, end = between or _steady_window(scene)
    if not ((scene.time >= start) & (scene.time <= end)).any():
        raise InputError(
            f"between {start:g} s and {end:g} s: no frame; the run has them from 0 to "
            f"{scene.time[-1]:.3g} s"
        )
    edges: Series = np.arange(int(scene.window[3] / band) + 1.0) * band
    wall, centre = strip_velocities(scene, edges, start, end)
    index, error = index_and_error(wall, centre)
    v_wall, v_centre = (mean_velocity(sums.sum(axis=0)) for sums in (wall, centre))
    rows = [
        {"from_m": float(edges[k]), "until_m": float(edges[k + 1]), "index": i, "error": e,
         "wall_m_per_s": w, "centre_m_per_s": c, "flow": flow_by(i, e)}
        for k, (i, e, w, c) in enumerate(
            zip(*map(numbers, (index, error, v_wall, v_centre)), strict=True)
        )
    ]  # fmt: skip
    return {
        "window_from_s": start,
        "window_until_s": end,
        "strip_m": scene.particle_size,
        "lowest_index": min((r["index"] for r in rows if r["index"] is not None), default=None),
        "bands": rows,
    }


def lowest_over(each: Sequence[dict[str, Any]]) -> tuple[float, float] | None:
    """The lowest index of the bands' means over runs, and its standard error; None of no band.

    each: what `measure` gives of runs of one silo. Bands without an error in a run do not count.
    """
    found = []
    for rows in zip(*(one["bands"] for one in each), strict=False):
        known = [(r["index"], r["error"]) for r in rows
                 if r["index"] is not None and r["error"] is not None]  # fmt: skip
        if known:
            index, error = np.array(known).T
            found.append((float(index.mean()), float(np.hypot.reduce(error)) / len(known)))
    return min(found, default=None)


def flow_by(index: float | None, error: float | None) -> str | None:
    """Side of the limit that an index lies on by two errors, in words."""
    if index is None or error is None:
        return None
    if abs(index - LIMIT) <= 2 * error:
        return "undecided"
    return "mass flow" if index > LIMIT else "funnel flow"


def _steady_window(scene: Scene) -> tuple[float, float]:
    times, mass = leavers(scene, FEWEST_OUT, "a mass flow index")
    steady = steady_part(times, mass)
    return (steady.start, steady.end) if steady else (0.0, float(times[-1]))


def strip_velocities(
    scene: Scene, edges: Series, start: float, end: float
) -> tuple[Series, Series]:
    """Sums of velocity [m/s] and numbers of particles, (parts, 2, bands), at walls and centre."""
    size, inside = scene.particle_size, in_silo(scene)
    sums = np.zeros((2, _PARTS, 2, len(edges) - 1))
    frames = np.flatnonzero((scene.time >= start) & (scene.time <= end))
    for part, members in enumerate(np.array_split(frames, _PARTS)):
        for frame in members:
            x, y, vx, vy = (scene.trajectory[k][frame] for k in ("x", "y", "vx", "vy"))
            band = np.digitize(y, edges) - 1
            counted = inside[frame] & (band >= 0) & (band < len(edges) - 1)
            distance, along = nearest_wall(scene, x, y)
            for strip, which, speed in (
                (0, counted & (distance <= size), vx * along[:, 0] + vy * along[:, 1]),
                (1, counted & (np.abs(x - outlet_centre(scene)) <= size), -vy),
            ):
                for row, weight in enumerate((speed[which], np.ones(int(which.sum())))):
                    sums[strip, part, row] += np.bincount(
                        band[which], weight, minlength=len(edges) - 1
                    )
    return sums[0], sums[1]


def nearest_wall(scene: Scene, x: NDArray, y: NDArray) -> tuple[Series, Series]:
    """Distance (n,) [m] of points from the nearest wall that is not level, its direction (n, 2).

    The direction is a unit vector downwards along the wall.
    """
    ends = scene.walls[~scene.of_insert & (scene.walls[:, 0, 1] != scene.walls[:, 1, 1])]
    ends = np.where((ends[:, 0, 1] > ends[:, 1, 1])[:, None, None], ends, ends[:, ::-1])
    span = ends[:, 1] - ends[:, 0]
    length = np.hypot(*span.T)
    point = np.stack([x, y], axis=1)[:, None, :] - ends[None, :, 0]
    part = np.clip((point * span).sum(axis=2) / length**2, 0, 1)
    distance = np.hypot(*np.moveaxis(point - part[..., None] * span, 2, 0))
    nearest = distance.argmin(axis=1)
    return distance.min(axis=1), (span / length[:, None])[nearest]


def index_and_error(wall: Series, centre: Series) -> tuple[Series, Series]:
    """Index and standard error (bands,) from sums (parts, 2, bands); NaN where there is none."""
    index = _ratio(*(mean_velocity(sums.sum(axis=0)) for sums in (wall, centre)))
    parts = np.array(
        [_ratio(mean_velocity(w), mean_velocity(c)) for w, c in zip(wall, centre, strict=True)]
    )
    known = np.isfinite(parts)
    n = known.sum(axis=0)
    mean = np.nan_to_num(parts).sum(axis=0) / np.maximum(n, 1)
    variance = np.where(known, (np.nan_to_num(parts) - mean) ** 2, 0).sum(axis=0) / np.maximum(
        n - 1, 1
    )
    error = np.where(n >= _FEWEST_PARTS, np.sqrt(variance / np.maximum(n, 1)), np.nan)
    return index, error


def mean_velocity(sums: Series) -> Series:
    """Mean (bands,) [m/s] of sums and numbers (2, bands); NaN where there is no particle."""
    return _ratio(sums[0], sums[1])


def _ratio(over: Series, under: Series) -> Series:
    """NaN where there is nothing to divide by."""
    return np.divide(over, under, out=np.full(len(over), np.nan), where=under != 0)


def draw(folder: Path, between: tuple[float, float] | None = None) -> "Figure":
    """Velocities at walls and centre against height, and the index with its limit."""
    from matplotlib.figure import Figure

    scene, found = read_scene(folder), measure(folder, between=between)
    rows = [row for row in found["bands"] if row["index"] is not None]
    height = [500 * (row["from_m"] + row["until_m"]) for row in rows]
    figure = Figure(figsize=(8.2, 4.8), layout="constrained")
    headline(figure, scene.headline)
    speeds, index = figure.subplots(1, 2, sharey=True)
    speeds.plot([r["centre_m_per_s"] for r in rows], height, "o-", color=BLUE, label="centre line")
    speeds.plot([r["wall_m_per_s"] for r in rows], height, "o-", color=VERMILION, label="walls")
    speeds.set_xlabel("velocity towards the outlet [m/s]")
    speeds.set_ylabel("height above the outlet [mm]")
    speeds.legend()
    _draw_index(index, rows, height)
    index.set_title(f"{found['window_from_s']:.2f} to {found['window_until_s']:.2f} s", loc="left",
                    fontsize=9)  # fmt: skip
    for axes in (speeds, index):
        axes.set_xlim(left=min(0.0, axes.get_xlim()[0]))
        axes.set_ylim(bottom=0)
        axes.grid()
    return figure


def _draw_index(axes: "Axes", rows: list[dict], height: list[float]) -> None:
    errors = [2 * (row["error"] or 0.0) for row in rows]
    axes.errorbar([row["index"] for row in rows], height, xerr=errors, fmt="o-", color=GREEN,
                  ecolor=GREY, capsize=2, label="bars: two standard errors")  # fmt: skip
    axes.axvline(LIMIT, color=GREY, lw=0.9, ls=(0, (4, 2)),
                 label="0.3: mass flow right of it,\nfunnel flow left")  # fmt: skip
    axes.set_xlabel("mass flow index, walls over centre [-]")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1.05), fontsize=8)
