"""Displacement profiles over seeds as tables, checked statements and a picture."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.output.figure import BLUE, VERMILION, WALL
from silo2d.case.outline import preset
from silo2d.measures.basics.particles import Series

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = dict[str, Any]
_LOW, _HIGH = 0.1, 0.2  # m: layers below count as near the exit, above as away from it

_NOTE = """\
V depth / V width [mm], mean +- sample sd over the seeds that have one, (n) where not all do; layers
of 45 mm from the bottom up; "cut": the layer has no grains above the middle of the outlet but some
beside it; "-": fewer than two grains of it in any column."""


def done(rows: Sequence[Row]) -> list[Row]:
    """The rows of runs that came to an end."""
    return [row for row in rows if row["state"] == "done"]


def tables(rows: Sequence[Row]) -> str:
    """A table a silo: layers down, times across."""
    parts = [_table(silo, own) for silo, own in _by(done(rows), "silo").items()]
    failed = [
        f"{row['state']}: {row['silo']}, seed {row['seed']}: {row['reason']}"
        for row in rows
        if row["state"] != "done"
    ]
    return "\n\n".join(filter(None, [*parts, _NOTE, "\n".join(failed)]))


def _by(rows: Sequence[Row], key: str) -> dict[Any, list[Row]]:
    groups: dict[Any, list[Row]] = {}
    for row in rows:
        groups.setdefault(row[key], []).append(row)
    return groups


def _table(silo: str, rows: list[Row]) -> str:
    seeds = len({row["seed"] for row in rows})
    times = sorted({row["time_s"] for row in rows if row["time_s"] > 0})
    lines = [[f"{silo}, {seeds} seeds", *(f"{time:.2f} s" for time in times)]]
    for layer, own in sorted(_by(rows, "layer").items(), reverse=True):
        cells = _by(own, "time_s")
        lines.append([f"layer {layer}", *(_cell(cells.get(time, []), seeds) for time in times)])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(f"{c:{w}}" for c, w in zip(line, widths, strict=True)).rstrip() for line in lines
    )


def _cell(rows: list[Row], seeds: int) -> str:
    depth = [row["depth_m"] for row in rows if row["depth_m"] is not None]
    width = [row["width_m"] for row in rows if row["width_m"] is not None]
    cut = sum(row["pierced"] for row in rows)
    if not depth:
        return f"cut ({cut})" if cut else "-"
    of = f" ({len(depth)})" if len(depth) < seeds else ""
    return f"{_mm(depth)} / {_mm(width)}{of}"


def _mm(values: "Sequence[float] | Series") -> str:
    if len(values) == 0:
        return "-"
    spread = f" +- {1e3 * np.std(values, ddof=1):.0f}" if len(values) > 1 else ""
    return f"{1e3 * np.mean(values):.0f}{spread}"


def statements(rows: Sequence[Row]) -> str:
    """What the paper's text says of the profiles, each with what our runs say to it."""
    silos = _by(done(rows), "silo")
    lines = ["What the paper says (sec. 4.2.1, Figs. 12 to 15), and what these runs show:"]
    for silo, own in silos.items():
        lines += [_v_shape(silo, own), _mixing(silo, own), _rest(silo, own)]
    if {"A4", "D4"} <= set(silos):
        lines.append(_deeper(silos["A4"], silos["D4"]))
    lines.append(
        "Slip-stick motion at the walls is measured by `silo2d observe RUN stickslip`,\n"
        "intermittent flow by `silo2d observe RUN curve`. The paper prints no depth or width."
    )
    return "\n".join(lines)


def _v_shape(silo: str, rows: list[Row]) -> str:
    """ "A V-shape in the displacement profile is observed"."""
    known = [row for row in rows if row["depth_m"] is not None and row["time_s"] > 0]
    deep = [row for row in known if row["depth_m"] > row["grain_size_m"] / 2]
    upward = sum(row["depth_m"] < -row["grain_size_m"] / 2 for row in known)
    word = "agrees" if len(deep) > len(known) / 2 else "does not agree"
    return (
        f"- {silo}, V shape: {word}: of {len(known)} lines {len(deep)} are deeper in the middle by "
        f"more than half a grain,\n  {upward} are higher there by as much"
    )


def _mixing(silo: str, rows: list[Row]) -> str:
    """ "a certain mix of the layers near the exit"."""
    moving = [row for row in rows if row["time_s"] > 0 and row["scatter_m"] is not None]
    low = [row["scatter_m"] for row in moving if row["level_m"] < _LOW]
    high = [row["scatter_m"] for row in moving if row["level_m"] > _HIGH]
    if not low or not high:
        return f"- {silo}, mixing near the exit: nothing to compare"
    word = "agrees" if np.mean(low) > np.mean(high) else "does not agree"
    return (
        f"- {silo}, layers mix near the exit: {word}: displacements scatter about the line by "
        f"{_mm(low)} mm\n  below {1e3 * _LOW:.0f} mm and by {_mm(high)} mm above "
        f"{1e3 * _HIGH:.0f} mm (mean +- sd of layers)"
    )


def _rest(silo: str, rows: list[Row]) -> str:
    """A4 empties, D4 keeps grains beside the outlet (Figs. 12 and 13)."""
    runs = {row["seed"]: row for row in rows}.values()
    left = [row["n_particles"] - row["n_out"] for row in runs]
    empty = sum(n == 0 for n in left)
    expected = empty == 0 if silo.startswith("D") else empty == len(left)
    what = "grains stay beside the outlet" if silo.startswith("D") else "the silo empties"
    return (
        f"- {silo}, {what}: {'agrees' if expected else 'does not agree'}: {np.mean(left):.0f} of "
        f"{np.mean([row['n_particles'] for row in runs]):.0f} grains stay on average, "
        f"{empty} of {len(left)} runs empty"
    )


def _deeper(first: list[Row], second: list[Row]) -> str:
    """Not said by the paper: which V is deeper, layer by layer, where both silos have one."""
    means = [
        {
            key: np.mean([row["depth_m"] for row in own if row["depth_m"] is not None] or [np.nan])
            for key, own in _by_place(rows).items()
        }
        for rows in (first, second)
    ]
    both = [key for key in means[0] if key in means[1] and key[0] > 0]
    differ = np.array([means[1][key] - means[0][key] for key in both])
    differ = differ[np.isfinite(differ)]
    return (
        f"- not said by the paper: at the same layer and time D4's V is deeper than A4's in\n"
        f"  {int((differ > 0).sum())} of {len(differ)} cases, by {_mm(differ)} mm (mean +- sd)"
    )


def _by_place(rows: Sequence[Row]) -> dict[tuple[float, int], list[Row]]:
    groups: dict[tuple[float, int], list[Row]] = {}
    for row in rows:
        groups.setdefault((row["time_s"], row["layer"]), []).append(row)
    return groups


def sheet(rows: Sequence[Row]) -> "Figure":
    """A row of panels a silo, every 0.25 s: lines of each seed thin, their mean thick."""
    from matplotlib.figure import Figure

    silos = _by(done(rows), "silo")
    times = sorted({row["time_s"] for row in done(rows)})
    figure = Figure(figsize=(1.4 * max(len(times), 1) + 0.3, 2.6 * max(len(silos), 1)),
                    layout="constrained")  # fmt: skip
    panels = figure.subplots(max(len(silos), 1), max(len(times), 1), squeeze=False)
    for panel in panels.flat:
        panel.set_axis_off()
    for line, (silo, own) in zip(panels, silos.items(), strict=False):  # none where all failed
        at = _by(own, "time_s")
        for panel, time in zip(line, times, strict=True):
            _panel(panel, silo, at.get(time, []))
            panel.set_title(f"{silo}, {time:.2f} s", fontsize=9)
    return figure


def _panel(panel: "Axes", silo: str, rows: list[Row]) -> None:
    from matplotlib.collections import LineCollection

    outline = preset(silo)
    panel.add_collection(LineCollection(list(outline.walls().segments[:-1]), colors=WALL, lw=1.6))
    left, right = outline.polygon[:, 0].min(), outline.polygon[:, 0].max()
    for layer, own in _by(rows, "layer").items():
        colour = (BLUE, VERMILION)[layer % 2]
        lines = np.array([_line(row) for row in own])
        x = left + (np.arange(lines.shape[1]) + 0.5) * (right - left) / lines.shape[1]
        panel.plot(x, lines.T, color=colour, lw=0.4, alpha=0.6)
        seen = np.isfinite(lines).sum(axis=0)
        mean = np.nansum(lines, axis=0) / np.maximum(seen, 1)
        panel.plot(x, np.where(2 * seen > len(lines), mean, np.nan), color=colour, lw=1.7)
    panel.set(xlim=(left - 0.004, right + 0.004), ylim=(-0.004, outline.height), aspect="equal")


def _line(row: Row) -> list[float]:
    columns = [key for key in row if key.startswith("y") and key.endswith("_m")]
    return [np.nan if row[key] is None else row[key] for key in columns]
