"""Results of a map: its folder, the table of its points, a report in words."""

import math
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from damper3d.case.case import DamperCase
from damper3d.run.protocol import PACKAGES, run_digest
from damper3d.run.sources import SOURCES
from damper3d.run.sweep import DAMPER
from damper3d.studies.map.grid import Grid, MapResult, Rows, map_cases
from damper3d.studies.map.ridges import OnRidge
from damper3d.studies.predict.prediction import Prediction
from granulab.campaign.output import room
from granulab.campaign.output.files import writing
from granulab.campaign.output.table import write_table
from granulab.campaign.runs.folder import RunFolder, digest
from granulab.campaign.runs.provenance import provenance
from granulab.campaign.sweeps.overview import expected_cpu_s
from granulab.campaign.sweeps.report.axes import Varied
from granulab.campaign.sweeps.report.comparison import Comparison
from granulab.campaign.sweeps.report.quantities import Quantities
from granulab.campaign.sweeps.report.words import ranking_rows

_VARIED = (Varied("frequency_hz", "frequency", "Hz"), Varied("gamma", "Gamma", "g"))


def map_folder(name_or_path: str, changes: dict[str, Any], grid: Grid, out: Path) -> RunFolder:
    """out/maps/<name>-<digest>, named by the runs of the grid and how often it is refined."""
    cases = map_cases(name_or_path, changes, grid)
    runs = [[labels, run_digest(case)] for labels, case in cases]
    named = f"{cases[0][1].name}-{digest({'runs': runs, 'refine': grid.refine})}"
    return RunFolder(Path(out) / "maps" / named)


def planned(
    cases: Sequence[DamperCase], grid: Grid, folder: RunFolder, out: Path
) -> dict[str, Any]:  # fmt: skip
    """The runs of a grid and their cost, with the packings that are not there yet."""
    todo = [case for case in cases if DAMPER.run_folder(case, out).state != "finished"]
    packings, runs = expected_cpu_s(DAMPER, todo, out)
    to_fill = [seconds for file, seconds in packings.items() if not file.exists()]
    return {
        "case": cases[0].name,
        "folder": str(folder.path),
        "frequencies_hz": list(grid.frequencies),
        "gammas": list(grid.gammas),
        "packings": grid.packings,
        "runs": len(cases),
        "finished": len(cases) - len(todo),
        "packings_to_fill": len(to_fill),
        "expected_cpu_min": (runs + sum(to_fill)) / 60,
        "disk_bytes_at_most": DAMPER.disk_of(todo),
        "disk_free_bytes": room.free(out),
    }


def write_map(folder: RunFolder, result: MapResult, results: dict[str, Any]) -> None:
    """Write provenance.json, summary.json, table.csv and table.h5 (a row a point), runs/ (a run).

    Raises FolderError where they cannot be written.
    """
    runs = folder.path / "runs"
    with writing(runs):
        runs.mkdir(parents=True, exist_ok=True)
    seed = min((row["seed"] for row in result.rows), default=1)
    folder.write_provenance(
        provenance(command=sys.argv, seed=seed, packages=PACKAGES, sources=SOURCES.folders)
    )
    of_runs = [f"runs/{name}" for name in write_table(runs, result.rows)]
    folder.seal(*of_runs, *write_table(folder.path, points(result)))
    folder.write_summary(results)


def points(result: MapResult) -> Rows:
    """A row for each point: efficiency, its interval, phase, means of all columns of numbers."""
    columns = [name for name in result.columns if name not in ("frequency_hz", "gamma", "seed")]
    means = {name: result.mean(name) for name in columns}
    low, high = result.efficiency - result.half_width, result.efficiency + result.half_width
    return [
        {
            "frequency_hz": float(result.frequency[k]),
            "gamma": float(result.gamma[k]),
            "efficiency": _or_none(result.efficiency[k]),
            "efficiency_low": _or_none(low[k]),
            "efficiency_high": _or_none(high[k]),
            "packings": int(result.packings[k]),
            "phase": result.phases[k],
            **{name: _or_none(mean[k]) for name, mean in means.items() if name != "efficiency"},
        }
        for k in range(len(result.gamma))
    ]


def compared(name: str, result: MapResult, quantities: Quantities) -> Comparison:
    """The points of a map compared by quantities of their runs."""
    return Comparison.of(name, _VARIED, quantities, result.rows)


def summary(
    grid: Grid, result: MapResult, prediction: Prediction, on_ridges: list[OnRidge], folder: Path,
    comparison: Comparison | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Results of a map, for --json and summary.json; what does not exist is None."""
    states = Counter(row["state"] for row in result.rows)
    ranking = {} if comparison is None else {
        "ranked_by": list(comparison.quantities.order), "ranking": ranking_rows(comparison),
    }  # fmt: skip
    return {
        "case": prediction.name,
        "fill_ratio": prediction.fill_ratio,
        "orientation": prediction.orientation,
        "frequencies_hz": list(grid.frequencies),
        "gammas": list(grid.gammas),
        "packings": grid.packings,
        "refine": grid.refine,
        "points": len(result.gamma),
        "runs": len(result.rows),
        "done": states["done"],
        "reused": sum(bool(row.get("reused")) for row in result.rows),
        "failed": states["failed"],
        "interrupted": states["interrupted"],
        "settling": sum(bool(row.get("efficiency_note")) for row in result.rows),
        "failures": _failures(result.rows),
        "best": _best(result),
        "ridges": [_peak(item, prediction) for item in on_ridges],
        "folder": str(folder),
        "table": str(folder / "table.csv"),
        **ranking,
    }


def as_text(results: dict[str, Any]) -> str:
    """Report of a map: a line for each peak."""
    lines = [
        f"{results['case']}: fill ratio {results['fill_ratio']:.3f}, {results['orientation']}; "
        f"{results['points']} points of {_plural(results['packings'], 'packing')}",
        f"{'frequency':>12}  {'ridge':14}{'Gamma':>8}  {'between':16}{'eta':>6}  {'':10}"
        "predicted onset",
    ]
    lines += [_line(peak) for peak in results["ridges"]]
    if not results["ridges"]:
        lines.append("no peak along Gamma stands out of the noise")
    best = results["best"]
    if best:
        lines.append(
            f"best        {best['efficiency']:.3f} at {best['frequency_hz']:g} Hz, "
            f"Gamma {best['gamma']:g}"
        )
    counts = ", ".join(f"{results[name]} {name}" for name in ("done", "failed", "interrupted"))
    lines.append(f"runs        {counts} ({results['reused']} were there)")
    if results["settling"]:
        lines.append(
            f"settling    {results['settling']} runs have no efficiency, as their bed still "
            "settles; give more --cycles and --discard, or --steady"
        )
    lines += [f"failed: {line}" for line in results["failures"]]
    return "\n".join([*lines, f"table       {results['table']}"])


def _line(peak: dict[str, Any]) -> str:
    low, high = peak["gamma_bracket"]
    half = peak["efficiency_half_width"]
    noise = f"± {half:.3f}" if half else ""
    onsets = ", ".join(
        f"{name} {gamma:.3g}" for name, gamma in peak["predicted_gamma"].items() if gamma
    )
    return (
        f"{peak['frequency_hz']:9g} Hz  {peak['ridge'].replace('_', ' '):14}{peak['gamma']:8.3g}  "
        f"{f'{low:.3g} to {high:.3g}':16}{peak['efficiency']:6.3f}  {noise:10}"
        f"{onsets if peak['ridge'] == 'bouncing_bed' else ''}"
    ).rstrip()


def _peak(item: OnRidge, prediction: Prediction) -> dict[str, Any]:
    peak = item.peak
    return {
        "frequency_hz": item.frequency,
        "ridge": item.ridge,
        "gamma": peak.gamma,
        "gamma_interval": [peak.low, peak.high],
        "gamma_bracket": list(peak.bracket),
        "efficiency": peak.efficiency,
        "efficiency_half_width": peak.half_width,
        "prominence": peak.prominence,
        "predicted_gamma": {c.name: c.onset(item.frequency) for c in prediction.clearances},
    }


def _best(result: MapResult) -> dict[str, Any] | None:
    """The point of the greatest efficiency; None where no run is done."""
    done = [row for row in points(result) if row["efficiency"] is not None]
    if not done:
        return None
    best = max(done, key=lambda row: row["efficiency"])
    names = ("frequency_hz", "gamma", "efficiency", "efficiency_low", "efficiency_high", "phase")
    return {name: best[name] for name in names}


def _failures(rows: Rows) -> list[str]:
    """A line for each reason: how many runs it ended, and the first of them."""
    reasons: dict[str, Rows] = {}
    for row in rows:
        if row["state"] == "failed":
            reasons.setdefault(row["reason"], []).append(row)
    return [
        f"{_plural(len(of), 'run')} from {of[0]['frequency_hz']:g} Hz, Gamma {of[0]['gamma']:g}, "
        f"seed {of[0]['seed']} on: {reason}"
        for reason, of in reasons.items()
    ]


def _or_none(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _plural(n: int, word: str) -> str:
    return f"{n} {word}{'' if n == 1 else 's'}"
