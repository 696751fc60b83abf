"""Comparison of two runs, from their folders: outcomes, times, curves, cost; and a figure."""

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import BLUE, GREY, INK, headline, ruled
from granulab.campaign.runs.folder import RunFolder, resume_run
from granulab.campaign.runs.trajectory import Trajectory, read_trajectory
from granulab.contact.files.casefile import flat
from granulab.errors import FolderError
from silo2d.run.numbers import discharge_curve

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Times = NDArray[np.float64]
_KEPT = ["silo", "seed", "engine", "outcome", "n_particles", "n_out", "discharge_time_s", "t90_s"]
_KEPT += ["mean_rate_per_s", "mean_mass_flow_kg_per_s", "time_step_s", "steps", "cpu_us_per_step"]


def compare(first: str | Path, second: str | Path) -> dict[str, Any]:
    """Two finished runs: what each found and took, and how far their curves are apart.

    runs             of each: the results of the run that are kept here, what moved its particles
                     (label), the CPU time of its step loop (discharge_cpu_s), the wall time of
                     the whole run, the filling included where it filled (wall_s), and the keys of
                     its case that are not as the other's (differs)
    curve            see `curve_distance`; None where nothing left one of them
    start_offset_m   how far apart the same particle is at the opening, at most; None where the
                     particles are not the same

    Raises FolderError for a folder that is no finished run.
    """
    folders = [_finished(path) for path in (first, second)]
    frames = [read_trajectory(folder.path) for folder in folders]
    times = [discharge_curve(trajectory)[0] for trajectory in frames]
    rows = [_row(folder) for folder in folders]
    for row, differs in zip(rows, _differences(folders), strict=True):
        row["differs"] = differs
    return {
        "runs": rows,
        "curve": curve_distance(*times),
        "start_offset_m": _start_offset(*frames),
    }


def curve_distance(first: Times, second: Times) -> dict[str, float | int] | None:
    """Distance of two discharge curves; None where no particle left one of the silos.

    first, second    times (n,) [s] at which particles left, ascending

    With t(n) the time at which the n-th particle leaves, over the counts that both reach:

    counts           how many those are
    mean_s, max_s    mean and largest |t_2(n) - t_1(n)|
    later_s          mean of t_2(n) - t_1(n): by how much the second lags
    """
    counts = min(len(first), len(second))
    if not counts:
        return None
    lag = second[:counts] - first[:counts]
    return {
        "counts": counts,
        "mean_s": float(np.abs(lag).mean()),
        "max_s": float(np.abs(lag).max()),
        "later_s": float(lag.mean()),
    }


def _finished(path: str | Path) -> RunFolder:
    folder = resume_run(path)
    if folder.state != "finished":
        raise FolderError(
            f"{folder.path}: not finished; go on with: silo2d run --resume {folder.path}"
        )
    return folder


def _row(folder: RunFolder) -> dict[str, Any]:
    summary = folder.read_summary()
    try:
        row = {name: summary[name] for name in _KEPT}
        row["discharge_cpu_s"] = 1e-6 * row["cpu_us_per_step"] * row["steps"]
    except TypeError as error:
        raise FolderError(
            f"{folder.path / 'summary.json'}: damaged ({error}); use --again to compute the run "
            "again"
        ) from None
    row["wall_s"] = folder.read_provenance().get("wall_s")
    return {"label": _label(folder, row), **row, "run_folder": str(folder.path)}


def _label(folder: RunFolder, row: dict[str, Any]) -> str:
    """Label of what moved the particles: "dem, 5 us", "pymunk, 30 x 0.25 ms"."""
    if row["engine"] == "dem":
        return f"dem, {1e6 * row['time_step_s']:g} us"
    settings = tomllib.loads(folder.read_case()).get(row["engine"], {})
    return f"{row['engine']}, {settings.get('iterations')} x {1e3 * row['time_step_s']:g} ms"


def _differences(folders: Sequence[RunFolder]) -> list[dict[str, Any]]:
    """Keys of each of two cases whose values differ, but for their names, by "section.key"."""
    first, second = (flat(tomllib.loads(folder.read_case())) for folder in folders)
    keys = [key for key in first | second if "." in key and first.get(key) != second.get(key)]
    return [{key: one.get(key) for key in keys} for one in (first, second)]


def _start_offset(first: Trajectory, second: Trajectory) -> float | None:
    if not np.array_equal(first.static["kind"], second.static["kind"]):
        return None
    apart = [second[axis][0].astype(float) - first[axis][0] for axis in "xy"]
    return float(np.hypot(*apart).max())


def mean_distance(pairs: Sequence[dict[str, Any]]) -> dict[str, float] | None:
    """The means of the curve distances of several pairs; None where no pair has any."""
    curves = [pair["curve"] for pair in pairs if pair["curve"]]
    if not curves:
        return None
    return {name: float(np.mean([c[name] for c in curves])) for name in curves[0]}


def table(pairs: Sequence[dict[str, Any]]) -> str:
    """Pairs of runs for a person to read."""
    named: list[str] = []
    if len(pairs) == 1:
        named, rows = _named(pairs[0]), pairs[0]["runs"]
        rows = [row | {"label": f"{k} {row['label']}"} for k, row in enumerate(rows, 1)]
        pairs = [{**pairs[0], "runs": rows}]
    width = max(len(row["label"]) for pair in pairs for row in pair["runs"])
    heading = f"{'seed':>4}  {'outcome':18}  {'out':>7}  {'time':>8}  {'T90':>8}  {'rate':>8}"
    lines = [*named, f"{'':{width}}  {heading}  {'CPU':>8}  {'wall':>8}"]
    for pair in pairs:
        lines += [_line(row, width) for row in pair["runs"]]
        lines.append(f"{'':{width}}  {_distance(pair['curve'])}")
    mean = mean_distance(pairs)
    if mean and len(pairs) > 1:
        lines.append(f"{'mean':{width}}  {_distance(mean)}")
    return "\n".join(lines)


def _named(pair: dict[str, Any]) -> list[str]:
    """A line for each of two runs: its folder, and what its case has that the other has not."""
    return [
        f"{k} {Path(row['run_folder']).name}"
        + "".join(f"; {key} {'left out' if value is None else value}"
                  for key, value in row["differs"].items())
        for k, row in enumerate(pair["runs"], 1)
    ]  # fmt: skip


def _line(row: dict[str, Any], width: int) -> str:
    out = f"{row['n_out']}/{row['n_particles']}"
    cells = [f"{row['seed']:4}", f"{row['outcome']:18}", f"{out:>7}"]
    cells += [_number(row[name], ".3f", "s") for name in ("discharge_time_s", "t90_s")]
    cells.append(_number(row["mean_rate_per_s"], ".0f", "/s"))
    cells += [_number(row[name], ".1f", "s") for name in ("discharge_cpu_s", "wall_s")]
    return f"{row['label']:{width}}  {'  '.join(cells)}"


def _number(value: float | None, digits: str, unit: str) -> str:
    return f"{'none' if value is None else f'{value:{digits}} {unit}':>8}"


def _distance(curve: dict[str, float] | None) -> str:
    if curve is None:
        return "curves: none to compare"
    return (
        f"curves {curve['mean_s']:.3f} s apart in the mean, {curve['max_s']:.3f} s at most; the "
        f"second is {abs(curve['later_s']):.3f} s {'later' if curve['later_s'] > 0 else 'earlier'}"
        f" ({curve['counts']:.0f} counts)"
    )


def draw(pairs: Sequence[dict[str, Any]]) -> "Figure":
    """Both curves of every pair, and below them by how much the second lags at each count."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.5, 6.8), layout="constrained")
    curves, lags = figure.subplots(2, 1, height_ratios=[2, 1])
    labels = _legend_labels(pairs[0]["runs"])
    silos = dict.fromkeys(row["silo"] for pair in pairs for row in pair["runs"])
    title = f"Silo {', '.join(silos)}: {labels[0]} and {labels[1]}"
    title += f", {len(pairs)} seeds" if len(pairs) > 1 else ""
    headline(figure, title)
    for number, pair in enumerate(pairs):
        times = [discharge_curve(read_trajectory(row["run_folder"]))[0] for row in pair["runs"]]
        for label, colour, left in zip(labels, (INK, BLUE), times, strict=True):
            steps = [0.0, *left], range(len(left) + 1)
            named = label if number == 0 else None
            curves.step(*steps, where="post", color=colour, lw=1.2, label=named)
        both = min(map(len, times))
        lags.plot(range(1, both + 1), 1e3 * (times[1][:both] - times[0][:both]), color=BLUE, lw=1)
    curves.set(xlabel="time since the opening [s]", ylabel="particles out")
    curves.set_xlim(left=0)
    curves.set_ylim(bottom=0)
    curves.legend(loc="upper left")
    lags.axhline(0, color=GREY, lw=0.6)
    lags.set(xlabel="particles out", ylabel=f"{labels[1]}\nlater by [ms]")
    for axes in (curves, lags):
        ruled(axes)
    return figure


def _legend_labels(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Names that distinguish two runs: engine, else steps, else folder."""
    for name in ("engine", "label"):
        if rows[0][name] != rows[1][name]:
            return [row[name] for row in rows]
    return [Path(row["run_folder"]).name for row in rows]
