"""Results of a field and of responses: their folders, tables, and reports in words."""

import math
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.run.protocol import run_digest
from damper3d.studies.field.balance import Responses, respond, swept
from damper3d.studies.field.fall import as_rows, falls
from damper3d.studies.field.runs import Refinement, states, steady_changes, unlike
from damper3d.studies.field.structure import Structure
from damper3d.studies.field.table import Field
from damper3d.studies.map.grid import Grid, MapResult, map_cases
from granulab.campaign.output.files import write_atomic
from granulab.campaign.output.table import as_csv
from granulab.campaign.runs.folder import RunFolder, digest

Range = tuple[float, float]


def field_folder(
    name: str, changes: dict[str, Any], grid: Grid, refine: Refinement, out: Path
) -> RunFolder:
    """out/fields/<name>-<digest>, named by the runs of the grid and its refinement."""
    cases = map_cases(name, steady_changes(changes), grid)
    runs = [[labels, run_digest(case)] for labels, case in cases]
    more = [refine.most_runs, refine.tolerance] if refine.most_runs else []
    named = f"{cases[0][1].name}-{digest({'runs': runs, 'more': more})}"
    return RunFolder(Path(out) / "fields" / named)


def head(case: DamperCase) -> tuple[str, ...]:
    """Lines on where a field comes from: case, version and command."""
    size = f"{case.count} particles {case.particle.name}, {case.mass:.6g} kg"
    return (
        f"effective mass of {case.name}: {size}, fill ratio {case.fill_ratio:.3f}, {lid(case)}",
        f"granulab {version('granulab')}, {' '.join(['damper3d', *sys.argv[1:]])}",
        "m' - i m'' with F = omega^2 (m' - i m'') X of x = Re(X exp(i omega t)); half widths of "
        "95 % intervals over the packings",
    )


def lid(case: DamperCase) -> str:
    """The closed ends, in words, and the direction of the motion to gravity."""
    return f"with a lid, {1e3 * case.enclosure.height:g} mm high, {case.orientation}"


def summary(
    case: DamperCase, field: Field, result: MapResult, folder: Path, fitted: Range | None
) -> dict[str, Any]:
    """Results of a field, for --json and summary.json; what does not exist is None."""
    points = zip(result.frequency.tolist(), result.gamma.tolist(), strict=True)
    regimes = dict(zip(points, result.phases, strict=True))
    return {
        "case": case.name,
        "enclosure": lid(case),
        "bed_mass_kg": case.mass,
        "points": field.rows(),
        **states(result),
        "rides_at_least_gamma": field.rides_at_least if len(field.gamma) else None,
        "unlike_wall_work": unlike(result),
        "falls": as_rows(falls(field, fitted), regimes) if len(field.gamma) else [],
        "folder": str(folder),
        "table": str(folder / "field.csv"),
    }


def as_text(results: dict[str, Any]) -> str:
    """Report of a field: a line a point, masses over that of the bed."""
    mass = results["bed_mass_kg"]

    def part(value: float, half: float | None) -> str:
        return f"{value / mass:8.3f} {'' if half is None else f'± {half / mass:.3f}':8}"

    lines = [
        f"{results['case']}: effective mass over the bed's {1e3 * mass:.4g} g, "
        f"{results['enclosure']}",
        f"{'frequency':>12}{'Gamma':>8}{'amplitude':>13}{'in phase':>11}{'out of phase':>19}",
    ]
    lines += [
        f"{row['frequency_hz']:9g} Hz{row['gamma']:8.4g}{1e3 * row['amplitude_m']:10.3g} mm"
        f"{part(row['m_in_phase_kg'], row['m_in_phase_half_width_kg'])}"
        f"{part(row['m_out_of_phase_kg'], row['m_out_of_phase_half_width_kg'])}".rstrip()
        for row in results["points"]
    ]
    for fall in results["falls"]:
        what = {"in_phase": "in-phase mass", "loss_factor": "loss factor"}[fall["quantity"]]
        low, high = fall["gamma_range"]
        shown = ", ".join(fall["phases"]) or "phase not named"
        lines.append(
            f"fall        {what} at {fall['frequency_hz']:g} Hz as Gamma^({fall['exponent']:.2f} ± "
            f"{fall['half_width']:.2f}), Gamma {low:g} to {high:g} ({shown}); literature: "
            f"{fall['literature']}"
        )
    if results["unlike_wall_work"] is not None:
        lines.append(
            f"check       out of phase from forces and from work differ by at most "
            f"{100 * results['unlike_wall_work']:.2g} % of the bed's mass"
        )
    if results["rides_at_least_gamma"] is False:
        lines.append("below       the bed does not ride along at the least Gamma, and below it the "
                     "field holds what it has there: give lower --gammas")  # fmt: skip
    counted = ", ".join(f"{results[name]} {name}" for name in ("done", "failed", "interrupted"))
    lines.append(f"runs        {counted} ({results['reused']} were there)")
    if results["not_steady"]:
        lines.append(f"not steady  {results['not_steady']} runs ended at their most cycles; give "
                     "more --max-cycles")  # fmt: skip
    return "\n".join([*lines, f"table       {results['table']}"])


def of_response(structure: Structure, field: Field, responses: Responses) -> list[dict[str, Any]]:
    """Results of each level: largest response with its interval, reduction, jumps; for --json."""
    found = []
    corners = [
        respond(structure, field.shifted(a, b), responses.frequency, responses.levels)
        for a in (-1, 1) for b in (-1, 1)
    ]  # fmt: skip
    for k, level in enumerate(responses.levels.tolist()):
        peak, bare = responses.largest(k), float(responses.bare[k].max())
        edges = [corner.largest(k) for corner in corners]
        known = np.isfinite(field.in_phase_half_width).any() and None not in edges
        up, down = (swept(responses, k, down)[1] for down in (False, True))
        found.append(
            {
                "level": level,
                "peak_frequency_hz": peak and peak[0],
                "peak_amplitude_m": peak and peak[1],
                "peak_interval_m": [f(e[1] for e in edges if e) for f in (min, max)]
                if known else None,
                "bare_peak_amplitude_m": bare if math.isfinite(bare) else None,
                "reduction": peak[1] / bare if peak and math.isfinite(bare) else None,
                "most_solutions": int(responses.count[k].max()),
                "beyond_field_hz": _span(responses.frequency[responses.beyond[k]]),
                "jumps": [vars(jump) for jump in (*up, *down)],
            }
        )  # fmt: skip
    return found


def _span(frequency: Any) -> list[float] | None:
    """Least and greatest of some frequencies; None of none."""
    return [float(frequency.min()), float(frequency.max())] if len(frequency) else None


def in_words(levels: list[dict[str, Any]]) -> str:
    """Report of responses: a line a level, and its jumps."""
    lines = [f"{'level':>8}  {'bare peak':>12}{'with the bed':>14}  {'interval':20}{'at':>10}"
             f"{'reduction':>11}"]  # fmt: skip
    for one in levels:
        bare = _millimetres(one["bare_peak_amplitude_m"])
        start = f"{one['level']:8g}  {bare:>12}"
        if one["peak_amplitude_m"] is None:
            low, high = one["beyond_field_hz"]
            lines.append(f"{start}  beyond the field's greatest Gamma from {low:.4g} to {high:.4g} "
                         "Hz: compute it there (damper3d field --gammas)")  # fmt: skip
            continue
        interval = one["peak_interval_m"]
        between = " to ".join(_millimetres(edge) for edge in interval) if interval else ""
        reduction = "" if one["reduction"] is None else f"{one['reduction']:.3f}"
        lines.append(
            f"{start}{_millimetres(one['peak_amplitude_m']):>14}  {between:20}"
            f"{one['peak_frequency_hz']:7.4g} Hz{reduction:>11}"
        )
        lines += [
            f"{'':10}jump as the frequency goes {jump['direction']}: at {jump['frequency']:.4g} Hz "
            f"from {_millimetres(jump['before'])} to {_millimetres(jump['after'])}"
            for jump in one["jumps"]
        ]
    return "\n".join(lines)


def _millimetres(length: float | None) -> str:
    return "-" if length is None else f"{1e3 * length:.4g} mm"


def write_responses(path: Path, responses: Responses) -> Path:
    """Write a CSV, a line a level, frequency and solution; its path."""
    rows = []
    for k, level in enumerate(responses.levels.tolist()):
        for f, frequency in enumerate(responses.frequency.tolist()):
            about = {"level": level, "frequency_hz": frequency}
            bare = float(responses.bare[k, f])
            about["bare_amplitude_m"] = bare if math.isfinite(bare) else None
            found = responses.amplitude[k, f, : responses.count[k, f]].tolist()
            beyond = bool(responses.beyond[k, f])
            rows += [
                {**about, "amplitude_m": a, "stable": s % 2 == 0, "beyond_field": beyond}
                for s, a in enumerate(found or [None])
            ]
    write_atomic(path, as_csv(rows))
    return path
