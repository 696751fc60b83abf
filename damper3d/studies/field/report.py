"""Results of a field and of responses by it: folders, tables, words."""

import math
import sys
from collections import Counter
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.case.host import bare_amplitude
from damper3d.run.protocol import PACKAGES, run_digest
from damper3d.run.sources import SOURCES
from damper3d.studies.field.balance import Branch, jumps, solve
from damper3d.studies.field.runs import Points, Rows, field_cases, power_of
from damper3d.studies.field.table import Field, Floats
from damper3d.studies.map.grid import Grid
from granulab.campaign.output.files import write_atomic, writing
from granulab.campaign.output.table import write_table
from granulab.campaign.runs.folder import RunFolder, digest
from granulab.campaign.runs.provenance import provenance
from granulab.errors import InputError

_LITERATURE = "-2 at moderate Gamma (Masmoudi et al. 2016), -1 quasi-statically"


def write_field(
    name: str, changes: dict[str, Any], grid: Grid, rows: Rows, points: Points, out: Path
) -> RunFolder:
    """Write out/fields/<name>-<digest>: table.csv, table.h5, runs/, provenance.json."""
    cases = field_cases(name, changes, grid)
    runs = [[labels, run_digest(case)] for labels, case in cases]
    named = f"{cases[0][1].name}-{digest({'runs': runs, 'refine': grid.refine})}"
    folder = RunFolder(out / "fields" / named)
    with writing(folder.path / "runs"):
        (folder.path / "runs").mkdir(parents=True, exist_ok=True)
    folder.write_provenance(
        provenance(command=sys.argv, seed=grid.seed, packages=PACKAGES, sources=SOURCES.folders)
    )
    of_runs = [f"runs/{file}" for file in write_table(folder.path / "runs", rows)]
    folder.seal(*of_runs, *write_table(folder.path, points.rows()))
    return folder


def results_of(case: DamperCase, points: Points, rows: Rows, folder: Path) -> dict[str, Any]:
    """Results of a field, for --json."""
    powers = {}
    for frequency in np.unique(points.frequency).tolist():
        here = points.frequency == frequency
        found = power_of(points.gamma[here], points.mass[here].real, case.mass)
        powers[f"{frequency:g}"] = None if found is None else asdict(found)
    unsteady = sum(row.get("steady") is False for row in rows)
    return {
        "case": case.name,
        "orientation": case.orientation,
        "fill_ratio": case.fill_ratio,
        "mass_kg": case.mass,
        "points": points.rows(),
        "falls_as_power_of_gamma": powers,
        "runs": dict(Counter(row["state"] for row in rows)),
        "not_steady": unsteady,
        "table": str(folder / "table.csv"),
    }


def as_text(results: dict[str, Any]) -> str:
    """A field in words: its points, the powers with which the mass falls, and its table."""
    mass = results["mass_kg"]
    lines = [
        f"{results['case']}: effective mass of a bed of {mass:.4g} kg, {results['orientation']}, "
        f"in a closed enclosure, fill ratio {results['fill_ratio']:.3f}",
        "frequency   Gamma   in phase  out of phase   over the bed's mass (95 %)",
    ]
    for row in results["points"]:
        m, n = row["m_in_phase_kg"] / mass, row["m_out_of_phase_kg"] / mass
        a, b = row["m_in_phase_half_width_kg"], row["m_out_of_phase_half_width_kg"]
        lines.append(
            f"{row['frequency_hz']:7g} Hz {row['gamma']:7g} {m:9.3f}{_width(a, mass)} "
            f"{n:9.3f}{_width(b, mass)}"
        )
    for frequency, found in results["falls_as_power_of_gamma"].items():
        if found is not None:
            lines.append(
                f"{frequency} Hz: the mass in phase falls as Gamma^{found['exponent']:.2f} +- "
                f"{found['half_width']:.2f} from {found['low']:g} to {found['high']:g}; literature "
                f"{_LITERATURE}"
            )
    if results["not_steady"]:
        lines.append(f"{results['not_steady']} runs were not steady at their last cycle")
    return "\n".join([*lines, f"table       {results['table']}"])


def _width(half: float | None, mass: float) -> str:
    return "         " if half is None else f" +- {half / mass:.3f}"


@dataclass(frozen=True)
class Asked:
    """Responses that are wanted: levels of the excitation, and frequencies over the host's own."""

    levels: tuple[float, ...]
    span: tuple[float, ...]
    points: int


@dataclass(frozen=True, eq=False)
class Responses:
    """Responses of a host at several levels of what moves it."""

    names: list[str]
    frequency: Floats  # (f,) [Hz]
    bare: Floats  # (levels, f) amplitude without the damper [m]
    branch: Branch
    field: Field


def responses(case: DamperCase, field: Field, asked: Asked) -> Responses:
    """Responses of the host of a case; InputError where it has none, or the field is not enough."""
    if case.modes is None or case.drive is None or case.is_decay:
        raise InputError(
            f"{case.name}: a response is that of a host which a force or its base moves; give a "
            "[host] with force, base_displacement or base_acceleration"
        )
    if len(asked.span) != 2 or not 0 < asked.span[0] < asked.span[1]:
        raise InputError(f"--span {','.join(map(str, asked.span))}: give two that rise: 0.9,1.1")
    own = float(case.modes.omega[case.modes.nearest(2 * np.pi / case.period)])
    omega = np.linspace(asked.span[0] * own, asked.span[1] * own, asked.points)
    drives = [
        replace(case.drive, force=level * case.drive.force, base=level * case.drive.base)
        for level in asked.levels
    ]
    bare = np.array(
        [
            [abs(bare_amplitude(case.modes, replace(one, omega=w))) for w in omega.tolist()]
            for one in drives
        ]
    )
    branch = solve(field, [case.modes] * len(drives), drives, omega)
    names = [_named(one.force, one.base) for one in drives]
    return Responses(names, omega / (2 * np.pi), bare, branch, field)


def _named(force: float, base: float) -> str:
    return f"{force:.4g} N" if force else f"base {1e3 * base:.4g} mm"


def title(case: DamperCase) -> str:
    """Headline of a picture of responses."""
    return f"{case.name}: amplitude with the damper, by harmonic balance"


def write_responses(found: Responses, folder: Path) -> None:
    """Write response.csv into a folder: all solutions, a row each."""
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    lines = ["excitation,frequency_hz,amplitude_m,phase_rad,stable,bare_amplitude_m"]
    rows = zip(*(part.tolist() for part in found.branch), strict=True)
    for level, k, amplitude, stable, phase in rows:
        lines.append(
            f"{found.names[level]},{found.frequency[k]:.9g},{amplitude:.9g},{phase:.6g},"
            f"{int(stable)},{found.bare[level, k]:.9g}"
        )
    write_atomic(folder / "response.csv", ("\n".join(lines) + "\n").encode())


def response_results(case: DamperCase, found: Responses, folder: Path) -> dict[str, Any]:
    """Results of responses, for --json: peaks, jumps, and where the field ends."""
    levels, branch, f = [], found.branch, found.frequency
    for k, name in enumerate(found.names):
        here = branch.response == k
        known = np.unique(branch.frequency[here])
        top = int(np.argmax(np.where(here & branch.stable, branch.amplitude, -math.inf)))
        bare = float(found.bare[k].max())
        whole = bool(len(known) == len(f))
        levels.append(
            {
                "excitation": name,
                "peak_m": float(branch.amplitude[top]) if here.any() else None,
                "peak_frequency_hz": float(f[branch.frequency[top]]) if here.any() else None,
                "bare_peak_m": bare,
                "reduction": float(branch.amplitude[top]) / bare if here.any() else None,
                "jumps_up_hz": [float(f[j]) for j in jumps(branch, len(f), k, upwards=True)],
                "jumps_down_hz": [float(f[j]) for j in jumps(branch, len(f), k, upwards=False)],
                "within_field": whole,
            }
        )
    return {
        "case": case.name,
        "gammas": [float(found.field.gammas[0]), float(found.field.gammas[-1])],
        "levels": levels,
        "table": str(folder / "response.csv"),
    }


def in_words(results: dict[str, Any]) -> str:
    """Responses in words."""
    lines = [f"{results['case']}: response by harmonic balance"]
    for one in results["levels"]:
        if one["peak_m"] is None:
            lines.append(f"  {one['excitation']}: beyond the field at all frequencies")
            continue
        at = one["peak_frequency_hz"]
        words = (
            f"  {one['excitation']}: {1e3 * one['peak_m']:.4g} mm at {at:.4g} Hz, "
            f"{one['reduction']:.3g} of the bare peak, {1e3 * one['bare_peak_m']:.4g} mm"
        )
        for way in ("up", "down"):
            if one[f"jumps_{way}_hz"]:
                at = ", ".join(f"{x:.4g}" for x in one[f"jumps_{way}_hz"])
                words += f"; swept {way} it jumps at {at} Hz"
        if not one["within_field"]:
            words += (
                f"; at some frequencies beyond the field (Gamma {results['gammas'][0]:g} to "
                f"{results['gammas'][1]:g}), where nothing is known"
            )
        lines.append(words)
    return "\n".join([*lines, f"table       {results['table']}"])
