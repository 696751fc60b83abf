"""Results of a field and of responses: their folders, tables, and reports in words."""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.run.protocol import run_digest
from damper3d.studies.field.balance import Responses, swept_together, with_peaks
from damper3d.studies.field.fall import as_rows, falls
from damper3d.studies.field.origin import lid
from damper3d.studies.field.runs import Refinement, states, steady_changes, unlike
from damper3d.studies.field.several import respond_together
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
    edges = _with_edges([structure], [field], responses)
    return _levels([responses], edges, [field])[0]


def of_responses(
    structures: Mapping[str, Structure],
    fields: Sequence[Field],
    together: Sequence[Responses],
    shown: int = 0,
) -> list[dict[str, Any]]:
    """The same of several dampers, by the names of their places: those of the shown one, and all.

    Each level has a row for each damper under `dampers`.
    """
    levels = together[0].levels
    edges = _with_edges(list(structures.values()), fields, together[0])
    each = _levels(together, edges, fields)
    return [
        {
            **each[shown][k],
            "dampers": [
                {"at": name, **{key: value for key, value in one[k].items() if key != "level"}}
                for name, one in zip(structures, each, strict=True)
            ],
        }
        for k in range(len(levels))
    ]


def _with_edges(
    structures: Sequence[Structure], fields: Sequence[Field], like: Responses
) -> list[list[Responses]]:
    """Responses with the ends of the intervals, each with peaks of its own."""
    sharpest = float(structures[0].damping_ratio.min())
    return [
        with_peaks(partial(respond_together, structures, moved, levels=like.levels),
                   like.frequency, sharpest)
        for moved in _edges(fields)
    ]  # fmt: skip


def _edges(fields: Sequence[Field]) -> Iterator[list[Field]]:
    """The fields with m' and m'' of all points moved together to the ends of their intervals, and
    with those between two frequencies by amplitude."""
    for a in (-1, 1):
        for b in (-1, 1):
            yield [field.shifted(a, b) for field in fields]
    yield [field.by_amplitude() for field in fields]


def _levels(
    together: Sequence[Responses], edges: Sequence[Sequence[Responses]], fields: Sequence[Field]
) -> list[list[dict[str, Any]]]:
    """Results of each damper and level; edges: the responses with the ends of the intervals."""
    found: list[list[dict[str, Any]]] = [[] for _ in together]
    for k, level in enumerate(together[0].levels.tolist()):
        up, down = (swept_together(together, k, down)[1] for down in (False, True))
        for d, responses in enumerate(together):
            found[d].append(
                {
                    "level": level,
                    **_peaks(responses, k, fields[d]),
                    "peak_interval_m": _interval([together, *edges], fields, d, k),
                    "most_solutions": int(responses.count[k].max()),
                    "beyond_field_hz": _span(responses.frequency[responses.beyond[k]]),
                    "jumps": [vars(jump) for jump in (*up[d], *down[d])],
                }
            )
    return found


def _peaks(responses: Responses, level: int, field: Field) -> dict[str, Any]:
    """Largest responses of a level, with the bed and bare, and the one over the other.

    On a base that moves these are those of the transmissibility, amplitude over the base's, as the
    base's own may depend on the frequency.
    """
    peak, bare = responses.largest(level), responses.bare[level]
    size = responses.over_base(bare)
    top = int(np.argmax(size))
    known = peak is not None and math.isfinite(bare[top])
    own = responses.over_base(responses.largest_at_each(level)).max()
    ends = {"bed": peak is not None and responses.is_end(peak[0]),
            "bare": responses.is_end(float(responses.frequency[top]))}  # fmt: skip
    return {
        "peak_frequency_hz": peak and peak[0],
        "peak_amplitude_m": peak and peak[1],
        "bare_peak_amplitude_m": _finite(bare[top]),
        "reduction": float(own / size[top]) if known else None,
        "reduction_of": "amplitude" if responses.base is None else "transmissibility",
        "largest_at_end": [name for name, is_end in ends.items() if is_end],
        "between_hz": [float(responses.frequency[0]), float(responses.frequency[-1])],
        "field_between_hz": peak and field.far_between(*peak),
    }


def _interval(
    each: Sequence[Sequence[Responses]], fields: Sequence[Field], damper: int, level: int
) -> list[float] | None:
    """Least and greatest amplitude [m] of a damper's largest response at the ends of the intervals.

    each: the responses by the fields themselves, then with the ends. None where one is not known,
    or comes of a point of a field that has no interval.
    """
    sizes = []
    for together in each:
        found = together[damper].place(level)
        if found is None:
            return None
        frequency = float(together[damper].frequency[found[0]])
        for field, own in zip(fields, together, strict=True):
            if not field.has_interval(frequency, float(own.amplitude[level][found])):
                return None
        sizes.append(float(together[damper].amplitude[level][found]))
    return [min(sizes[1:]), max(sizes[1:])]


def _span(frequency: Any) -> list[float] | None:
    """Least and greatest of some frequencies; None of none."""
    return [float(frequency.min()), float(frequency.max())] if len(frequency) else None


def in_words(levels: list[dict[str, Any]]) -> str:
    """Report of responses: a line a level, and its jumps; of several dampers for each of them."""
    if "dampers" not in levels[0]:
        return "\n".join(_table(levels))
    lines: list[str] = []
    for d, first in enumerate(levels[0]["dampers"]):
        own = [{"level": one["level"], **one["dampers"][d]} for one in levels]
        lines += [f"at {first['at']}", *_table(own)]
    return "\n".join(lines)


def _table(levels: list[dict[str, Any]]) -> list[str]:
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
        lines += [*_at_ends(one), *_far_between(one)]
        lines += [
            f"{'':10}jump as the frequency goes {jump['direction']}: at {jump['frequency']:.4g} Hz "
            f"from {_millimetres(jump['before'])} to {_millimetres(jump['after'])}"
            for jump in one["jumps"]
        ]
    if levels[0]["reduction_of"] == "transmissibility":
        lines.append(f"{'':10}reduction: of the transmissibility, amplitude over that of the base")
    return lines


def _at_ends(one: dict[str, Any]) -> list[str]:
    """A warning where the largest responses of a level are at the ends of the frequencies."""
    if not one["largest_at_end"]:
        return []
    low, high = one["between_hz"]
    words = {"bed": "with the bed", "bare": "bare"}
    where = " and ".join(words[name] for name in one["largest_at_end"])
    return [
        f"{'':10}warning: largest response {where} at an end of {low:g} to {high:g} Hz, no peak: "
        "widen --between, or the field (damper3d field --frequencies)"
    ]


def _far_between(one: dict[str, Any]) -> list[str]:
    """A warning where a peak lies between frequencies of a field that are far apart."""
    if not one["field_between_hz"]:
        return []
    (low, high), peak = one["field_between_hz"], one["peak_frequency_hz"]
    return [
        f"{'':10}warning: the field has {low:g} and {high:g} Hz, and of a bed that leaves its "
        f"floor little is known between: compute it there (damper3d field --frequencies {peak:.3g})"
    ]


def _millimetres(length: float | None) -> str:
    return "-" if length is None else f"{1e3 * length:.4g} mm"


def write_responses(
    path: Path, together: Sequence[Responses], names: Sequence[str] = (), shown: int = 0
) -> Path:
    """Write a CSV, a line a level, frequency and solution; its path.

    names: of several dampers, each of which has amplitudes of its own besides the shown one's.
    """
    rows = []
    lead = together[shown]
    for k, level in enumerate(lead.levels.tolist()):
        for f, frequency in enumerate(lead.frequency.tolist()):
            about = {"level": level, "frequency_hz": frequency}
            bare = {"bare_amplitude_m": _finite(lead.bare[k, f])}
            more = {f"bare_amplitude_m_{name}": _finite(one.bare[k, f])
                    for name, one in zip(names, together, strict=bool(names))}  # fmt: skip
            beyond, stable = bool(lead.beyond[k, f]), lead.is_stable[k, f].tolist()
            for s in range(max(int(lead.count[k, f]), 1)):
                own = {f"amplitude_m_{name}": _finite(one.amplitude[k, f, s])
                       for name, one in zip(names, together, strict=bool(names))}  # fmt: skip
                rows.append(
                    {
                        **about, **bare, "amplitude_m": _finite(lead.amplitude[k, f, s]),
                        "stable": stable[s], "beyond_field": beyond, **more, **own,
                    }
                )  # fmt: skip
    write_atomic(path, as_csv(rows))
    return path


def _finite(value: Any) -> float | None:
    return float(value) if math.isfinite(value) else None
