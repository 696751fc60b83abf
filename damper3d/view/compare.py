"""Two runs compared, from their folders: efficiency, shares, cost; and a figure."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.engine.records import CLASSES, MECHANISMS
from damper3d.run.folders import shaken
from damper3d.view.charts import dissipated, efficiency_of_cycles
from damper3d.view.scene import Scene, read_scene
from granulab.campaign.output.figure import BLUE, GREY, INK, headline, ruled
from granulab.campaign.runs.folder import RunFolder
from granulab.errors import FolderError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_KEPT = [
    "frequency_hz", "gamma", "orientation", "particles", "n_particles", "fill_ratio",
    "cycles", "discarded", "efficiency", "efficiency_interval", "efficiency_contact_count",
    "efficiency_wall_work", "shares", "law_term", "dissipated_power_w", "loss_factor",
    "peak_wall_force_n", "bed_height_m", "energy_closure", "phase", "time_step_s", "steps",
    "cpu_us_per_step", "cpu_s",
]  # fmt: skip
_LINES = (  # of the table: words, key and format
    ("efficiency", "efficiency", ".4f"),
    ("as the thesis counts", "efficiency_contact_count", ".4f"),
    ("from the wall work", "efficiency_wall_work", ".4f"),
    ("dissipated power [W]", "dissipated_power_w", ".4g"),
    ("loss factor", "loss_factor", ".4g"),
    ("peak wall force [N]", "peak_wall_force_n", ".4g"),
    ("height of the mass [m]", "bed_height_m", ".4g"),
    ("energy unaccounted for", "energy_closure", ".1e"),
    ("CPU time [s]", "cpu_s", ".2f"),
)
_OF_HOSTS = (  # of two runs on hosts, before the others
    ("amplitude over bare", "reduction", ".4f"),
    ("amplitude [m]", "amplitude_m", ".4g"),
    ("rms displacement [m]", "rms_m", ".4g"),
    ("added damping ratio", "added_damping_ratio", ".4g"),
)
_COLOURS = INK, BLUE


def compare(first: str | Path, second: str | Path) -> dict[str, Any]:
    """Two finished runs: what each found and took, and how far they are apart.

    runs          of each, the results that are kept here (see `damper3d run --json`), and its host
    difference    of the second from the first: efficiency, shares (as `shares` of a run), and
                  efficiency_over_interval, the difference of the efficiencies over the root of the
                  sum of the squared half widths of their intervals; None where one has none

    Raises FolderError for a folder that is no finished run.
    """
    one, other = (_row(shaken(path)) for path in (first, second))
    first_half, second_half = (_half_width(row["efficiency_interval"]) for row in (one, other))
    change = _minus(other["efficiency"], one["efficiency"])
    spread = None
    if first_half is not None and second_half is not None:
        spread = float(np.hypot(first_half, second_half))
    return {
        "runs": [one, other],
        "difference": {
            "efficiency": change,
            "efficiency_over_interval": None if change is None or not spread else change / spread,
            "shares": {
                c: {m: _minus(other["shares"][c][m], one["shares"][c][m]) for m in MECHANISMS}
                for c in CLASSES
            },
        },
    }


def _row(folder: RunFolder) -> dict[str, Any]:
    if folder.state != "finished":
        raise FolderError(
            f"{folder.path}: not finished; go on with: damper3d run --resume {folder.path}"
        )
    summary = folder.read_summary()
    if missing := [name for name in _KEPT if name not in summary]:
        raise FolderError(
            f"{folder.path / 'summary.json'}: damaged (no {missing[0]}); use --again to compute "
            "the run again"
        )
    found = {name: summary[name] for name in _KEPT}
    return {**found, "host": summary.get("host"), "run_folder": str(folder.path)}


def _half_width(interval: Sequence[float] | None) -> float | None:
    return None if interval is None else (interval[1] - interval[0]) / 2


def _minus(second: float | None, first: float | None) -> float | None:
    return None if second is None or first is None else second - first


def labels(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Names of two runs by where they differ: motion, particles or filling, else their folders."""
    words = {
        "frequency_hz": "{:g} Hz", "gamma": "\u0393 = {:g}", "orientation": "{}",
        "particles": "{}", "fill_ratio": "fill ratio {:.3f}",
        "time_step_s": "{:.3g} s a step",
    }  # fmt: skip
    differ = [name for name in words if rows[0][name] != rows[1][name]]
    if differ:
        return [", ".join(words[name].format(row[name]) for name in differ) for row in rows]
    return [Path(row["run_folder"]).name for row in rows]


def table(found: dict[str, Any]) -> str:
    """Two runs for a person to read."""
    rows = found["runs"]
    lines: list[tuple[str, list[Any], str | None]] = [("", labels(rows), None)]
    if all(row["host"] for row in rows):
        hosts = [row["host"] for row in rows]
        lines += [(name, [host[key] for host in hosts], digits) for name, key, digits in _OF_HOSTS]
    intervals = ("  its interval", [_interval(row["efficiency_interval"]) for row in rows], None)
    own = [(name, [row[key] for row in rows], digits) for name, key, digits in _LINES]
    lines += [own[0], intervals, *own[1:]]
    for c in CLASSES:
        for mechanism in MECHANISMS:
            name = f"{mechanism.replace('_', ' ')}, {c.replace('_', '-')}"
            lines.append((name, [row["shares"][c][mechanism] for row in rows], ".1%"))
    lines.append(("phase", [(row["phase"] or "none").replace("_", " ") for row in rows], None))
    texts = [[name, *(_cell(value, digits) for value in values)] for name, values, digits in lines]
    widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
    return "\n".join([*(_aligned(cells, widths) for cells in texts), _verdict(found["difference"])])


def _aligned(cells: list[str], widths: list[int]) -> str:
    """The first to the left, the others to the right."""
    numbers = (cell.rjust(width) for cell, width in zip(cells[1:], widths[1:], strict=True))
    return "  ".join([cells[0].ljust(widths[0]), *numbers])


def _interval(ends: Sequence[float] | None) -> str:
    return "none" if ends is None else f"{ends[0]:.4f} to {ends[1]:.4f}"


def _cell(value: Any, digits: str | None) -> str:
    if value is None:
        return "none"
    return f"{value:{digits}}" if digits else str(value)


def _verdict(difference: dict[str, Any]) -> str:
    if difference["efficiency"] is None:
        return "efficiency of the second: not compared, as a bed settles; see the wall work"
    words = f"efficiency of the second: {difference['efficiency']:+.4f}"
    over = difference["efficiency_over_interval"]
    if over is None:
        return words
    return f"{words}, {abs(over):.1f} of the half widths of both intervals (root of their squares)"


def draw(found: dict[str, Any]) -> "Figure":
    """Dissipation, velocity of the bed, efficiency of the cycles, shares: both runs in each.

    Raises FolderError for a run that kept its summary only.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    scenes = [read_scene(row["run_folder"]) for row in found["runs"]]
    named = labels(found["runs"])
    figure = Figure(figsize=(10.4, 7.6), layout="constrained")
    headline(figure, " and ".join(named))
    (loss, bed), (cycles, shares) = figure.subplots(2, 2)
    for scene, label, colour in zip(scenes, named, _COLOURS, strict=True):
        _histories(loss, bed, scene, label, colour)
        eta = efficiency_of_cycles(scene)
        cycles.plot(1 + np.arange(len(eta)), eta, "o-", ms=4, color=colour, lw=0.9, label=label)
    loss.set(ylabel="dissipated over 4 (\u0393g/\u03c9)\u00b2 M", xlabel="part of the cycle")
    loss.set_ylim(bottom=0)
    bed.set(ylabel="mean velocity of the bed\nover \u0393g/\u03c9", xlabel="part of the cycle")
    enclosure = scenes[0].by_cycle(scenes[0].trajectory["velocity"])[-1] / scenes[0].peak_speed
    bed.plot(scenes[0].phase, enclosure, color=GREY, lw=0.9, ls=(0, (4, 2)), label="enclosure")
    cycles.set(ylabel="efficiency", xlabel="cycle")
    cycles.set_ylim(bottom=min(0.0, cycles.get_ylim()[0]))
    cycles.xaxis.set_major_locator(MaxNLocator(integer=True))
    figure.legend(*bed.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    _shares(shares, found["runs"], named)
    for axes in (loss, bed, cycles):
        ruled(axes)
    return figure


def _histories(loss: "Axes", bed: "Axes", scene: Scene, label: str, colour: str) -> None:
    """Means over the cycles that count."""
    total = sum(series[scene.counted].mean(axis=0) for series in dissipated(scene).values())
    loss.plot(scene.phase, total / scene.full_energy, color=colour, label=label)
    velocity = scene.by_cycle(scene.along(scene.trajectory["mean_velocity"]))[scene.counted]
    bed.plot(scene.phase, velocity.mean(axis=0) / scene.peak_speed, color=colour, label=label)
    loss.set_xlim(0, 1)
    bed.set_xlim(0, 1)


def _shares(axes: "Axes", rows: Sequence[dict[str, Any]], named: Sequence[str]) -> None:
    """Parts of what is dissipated, a bar for each run."""
    kinds = [(c, mechanism) for c in CLASSES for mechanism in MECHANISMS]
    positions = np.arange(len(kinds))
    for k, (row, colour) in enumerate(zip(rows, _COLOURS, strict=True)):
        parts = [100 * (row["shares"][c][mechanism] or 0.0) for c, mechanism in kinds]
        axes.barh(positions - 0.2 + 0.4 * k, parts, 0.36, color=colour, label=named[k])
    axes.set_yticks(positions, [f"{m},\n{c}".replace("_", " ") for c, m in kinds])
    axes.invert_yaxis()
    axes.set_xlabel("part of what is dissipated [%]")
