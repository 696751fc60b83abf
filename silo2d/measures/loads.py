"""Loads on the silo by a run: pressures on the walls in pascals, their fluctuation, and the base.

A pressure is the force of the particles on a stretch of wall over its area, stretch times prism
length, in the mean over the samples of a stage (see basics/stages.py). It fluctuates, and the more,
the smaller the area and the shorter the time it is averaged over; both are stated:

    rms     standard deviation about the straight line in time, of single samples and of means over
            ten milliseconds
    peak    the largest of either

Forces are balanced with the weight in every stage (see basics/balance.py). The effective angle of
internal friction is that of the mean stress where the solid is sheared (see basics/friction.py).
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.output.figure import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION, headline
from granulab.campaign.runs.trajectory import stored_tables
from silo2d.measures.basics.balance import (
    PARTS,
    Balance,
    balance_at_rest,
    balance_between,
    balance_of_samples,
    part_of_wall,
)
from silo2d.measures.basics.coarse_graining import Floats, inside_edges, part_inside
from silo2d.measures.basics.contacts import FEWEST_OUT, read_moments, within
from silo2d.measures.basics.friction import Angle, effective_friction, shear_rate
from silo2d.measures.basics.particles import prism_length
from silo2d.measures.basics.stages import stage_samples, windows
from silo2d.measures.basics.walls import Samples, Tractions, on_walls, sides
from silo2d.measures.fields import dead_zones, field_of, flow_frames
from silo2d.measures.stress import contact_stress, kinetic_stress
from silo2d.view.scene import Scene, read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

AVERAGED = 0.01  # [s] over which fluctuations are averaged, besides those of single samples
_TWO_WIDTHS = 0.977  # part of a Gaussian on one side of a line two widths away
_SIDES = {-1: "left", 1: "right"}
COLOURS = {"filling": GREY, "at_rest": BLUE, "opening": VERMILION, "flow": ORANGE, "end": PURPLE}

_OF_PARTS = BLUE, GREEN, ORANGE, PURPLE, VERMILION, GREY


def measure(
    folder: Path, between: tuple[float, float] | None = None, stretch: float | None = None
) -> dict[str, Any]:
    """Pressures and forces in each stage that the run has.

    between: from and until [s], in place of the usual part of the flow; stretch: least length of
    the stretches of wall [m].

    largest_mean_pressure_pa    of all stretches and stages
    at_rest_closure             forces at rest over the weight, less 1
    effective_friction_deg, ..._low_deg, ..._high_deg   of the flow; None without one
    prism_length_m, averaged_s
    stages                      from_s, until_s, samples; balance: forces [N] upwards and their
                                shares of the weight; walls: name, part, side (None of inserts),
                                stretch_m, rise_m, area_m2, height_m and by height normal_pa,
                                shear_pa (down the wall), rms_pa, peak_pa of single samples,
                                averaged_rms_pa, averaged_peak_pa of means over averaged_s
    """
    scene, length = read_scene(folder), prism_length(folder)
    spans, settling = windows(scene, between), stored_tables(folder).get("settling")
    stages: dict[str, Any] = {}
    for name, samples in stage_samples(folder, scene, between).items():
        span, balance = spans.get(name), None
        if name == "at_rest":
            balance = balance_at_rest(scene, settling.columns if settling else None)
        elif span:
            balance = balance_between(scene, *span)
        else:
            frame = len(scene.time) - 1 if name == "end" else 0
            balance = balance_of_samples(scene, samples, frame)
        stages[name] = _stage(scene, samples, balance, length, stretch, span)
    angle = flow_friction(folder, scene, between)
    pressures = [max(wall["normal_pa"]) for one in stages.values() for wall in one["walls"]]
    return {
        "largest_mean_pressure_pa": max(pressures),
        "at_rest_closure": stages["at_rest"]["balance"]["closure"],
        **_in_degrees(angle),
        "prism_length_m": length,
        "averaged_s": AVERAGED,
        "stages": stages,
    }


def _stage(
    scene: Scene, samples: Samples, balance: Balance | None, length: float,
    stretch: float | None, span: tuple[float, float] | None,
) -> dict[str, Any]:  # fmt: skip
    walls = on_walls(scene, samples, stretch)
    parts, side = part_of_wall(scene), [_SIDES.get(int(k)) for k in sides(scene)]
    rise = np.abs(np.diff(scene.walls[:, :, 1])[:, 0])
    return {
        "from_s": span[0] if span else None,
        "until_s": span[1] if span else None,
        "samples": len(samples.time),
        "balance": None if balance is None else balance.numbers(),
        "walls": [
            _wall(wall, parts[k], samples.time, length)
            | {"side": side[k], "rise_m": float(rise[k]) / len(wall.height)}
            for k, wall in enumerate(walls)
        ],
    }


def _wall(wall: Tractions, part: str, time: Floats, length: float) -> dict[str, Any]:
    """Numbers of a wall, in pascals."""
    normal, shear = wall.normal / length, wall.shear / length
    over = in_blocks(time, normal)
    rows = {
        "height_m": wall.height,
        "normal_pa": normal.mean(axis=0),
        "shear_pa": shear.mean(axis=0),
        "rms_pa": about_line(time, normal),
        "peak_pa": normal.max(axis=0),
        "averaged_rms_pa": None if over is None else about_line(*over),
        "averaged_peak_pa": None if over is None else over[1].max(axis=0),
    }
    return {
        "name": wall.name,
        "part": part,
        "stretch_m": wall.length,
        "area_m2": wall.length * length,
        **{key: None if value is None else value.tolist() for key, value in rows.items()},
    }


def in_blocks(time: Floats, series: Floats) -> tuple[Floats, Floats] | None:
    """Means of samples (m, b) over AVERAGED, with their times; None of fewer than two a block."""
    number = np.floor((time - time[0]) / AVERAGED + 1e-9).astype(int)
    blocks, first, count = np.unique(number, return_index=True, return_counts=True)
    if len(blocks) > 1 and count[-1] < count[:-1].max() - 1:  # the last may be cut off
        series, blocks = series[: first[-1]], blocks[:-1]
        first, count = first[:-1], count[:-1]
    if len(time) < 2 * len(blocks):
        return None
    sums = np.add.reduceat(series, first, axis=0)
    return (blocks + 0.5) * AVERAGED + time[0], sums / count[:, None]


def about_line(time: Floats, series: Floats) -> Floats | None:
    """Standard deviation (b,) of series (m, b) about straight lines; None of three moments."""
    if len(time) < 4:
        return None
    lines = np.vander(time - time.mean(), 2)
    left = series - lines @ np.linalg.lstsq(lines, series, rcond=None)[0]
    return np.sqrt((left**2).sum(axis=0) / (len(time) - 2))


def flow_friction(folder: Path, scene: Scene, between: tuple[float, float] | None) -> Angle | None:
    """Effective angle of internal friction in the flow; None of a run without one."""
    if not between and scene.trajectory["n_out"][-1] < FEWEST_OUT:
        return None
    moments = within(read_moments(folder)[1:], between or windows(scene)["flow"])
    field = field_of(scene, flow_frames(scene, between))
    inside = part_inside(field.grid, inside_edges(scene)) > _TWO_WIDTHS
    zones, (left, right) = dead_zones(scene, field), scene.across
    rate = shear_rate(field.velocity, field.grid.x[1] - field.grid.x[0])
    sheared = zones.flowing & inside & (np.nan_to_num(rate) > zones.plug / (right - left))
    stresses = [
        contact_stress(m, field.grid) + kinetic_stress(scene, m.frame, field.grid) for m in moments
    ]
    return effective_friction(stresses, sheared)


def _in_degrees(angle: Angle | None) -> dict[str, float | None]:
    names = ("effective_friction_deg", "effective_friction_low_deg", "effective_friction_high_deg")
    values = (None, None, None) if angle is None else angle
    return {
        name: None if value is None else float(np.degrees(value))
        for name, value in zip(names, values, strict=True)
    }


def draw(folder: Path, between: tuple[float, float] | None = None) -> "Figure":
    """Pressure and friction on the walls by height, and what bears the weight, in each stage."""
    from matplotlib.figure import Figure

    found = measure(folder, between)
    figure = Figure(figsize=(12.5, 5), layout="constrained")
    headline(figure, read_scene(folder).headline)
    panels = figure.subplots(1, 3, width_ratios=[1, 1, 1.1])
    labels = {"normal_pa": "pressure on the walls [Pa]", "shear_pa": "friction down them [Pa]"}
    for axes, (key, label) in zip(panels, labels.items(), strict=False):
        for name, stage in found["stages"].items():
            height, value, rms = profile(stage, key)
            bars = rms if key == "normal_pa" else None
            axes.errorbar(value, height, xerr=bars, fmt="o-", ms=3, color=COLOURS[name],
                          elinewidth=0.6, label=name.replace("_", " "))  # fmt: skip
        axes.axvline(0, color=GREY, lw=0.6)
        axes.set(xlabel=label, ylabel="height over the outlet [m]")
    panels[0].legend(title=f"bars: rms over {1e3 * AVERAGED:g} ms", title_fontsize=8)
    draw_balance(panels[2], found["stages"])
    return figure


def profile(
    stage: dict[str, Any], key: str, of: str | None = None
) -> tuple[Floats, Floats, Floats | None]:
    """Height, mean over the two sides, and rms of means over AVERAGED, of walls not level.

    of: "left" or "right", the values of one side in place of the mean.
    Heights are the middles of the stretches of either side that both sides have a wall at; inserts
    are of no side.
    """
    walls = [wall for wall in stage["walls"] if wall["side"] and wall["part"] != "floor"]
    heights = np.unique(np.round([height for wall in walls for height in wall["height_m"]], 6))
    wanted = _SIDES.values() if of is None else [of]
    own = [[wall for wall in walls if wall["side"] == side] for side in wanted]
    value = np.mean([_at(heights, several, key) for several in own], axis=0)
    rms = np.mean([_at(heights, several, "averaged_rms_pa") for several in own], axis=0)
    both = np.isfinite(value)
    return heights[both], value[both], None if np.isnan(rms[both]).any() else rms[both]


def _at(heights: Floats, walls: list[dict[str, Any]], key: str) -> Floats:
    """Values of the stretches of walls that heights (h,) [m] lie in; NaN where none is."""
    found = np.full(len(heights), np.nan)
    for wall in walls:
        values = wall[key] or [np.nan] * len(wall["height_m"])
        for middle, value in zip(wall["height_m"], values, strict=True):
            found[np.abs(heights - middle) <= wall["rise_m"] / 2 + 1e-6] = value
    return found


def draw_balance(axes: "Axes", stages: dict[str, Any]) -> None:
    """Shares of the weight that walls and base bear in each stage."""
    known = {name: one["balance"] for name, one in stages.items() if one["balance"]}
    colours = dict(zip((*PARTS, "inertia"), _OF_PARTS, strict=True))
    words = {"walls": "friction at the walls", "inertia": "accelerates"}
    position = np.arange(len(known))
    left = np.zeros(len(known))
    for part, colour in colours.items():
        shares = np.array([one[f"{part}_share"] or 0.0 for one in known.values()])
        if np.abs(shares).max(initial=0.0) > 5e-4:
            axes.barh(position, shares, left=left, color=colour, label=words.get(part, part))
            left += shares
    axes.axvline(1, color=GREY, lw=0.8)
    names = [f"{name.replace('_', ' ')}\n{one['weight_n']:.3g} N" for name, one in known.items()]
    axes.set_yticks(position, names)
    axes.invert_yaxis()
    axes.set_xlabel("share of the weight")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, fontsize=8)
