"""Listing of presets, shipped files, packings and runs, in words for a person."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from damper3d.case.case import PRESETS, DamperCase
from damper3d.run.folders import is_slow_test
from granulab.campaign.cli.library import packings_and_runs, run_in_words
from granulab.campaign.runs.folder import RunFolder, resume_run
from granulab.contact.files.datafile import case_names, data_file, data_names
from granulab.contact.files.units import nearest
from granulab.errors import InputError


def listing(root: Path) -> str:
    """Presets, cases, materials, and the packings and runs below a folder."""
    lines = [
        f"presets    {', '.join(PRESETS)}",
        f"cases      {', '.join(case_names('enclosure'))}",
        f"materials  {', '.join(data_names('materials'))}",
        *packings_and_runs(root, _answer),
    ]
    return "\n".join(lines)


def _answer(summary: dict[str, Any]) -> str:
    """Case of a finished run, and its efficiency, or stiffness."""
    if "test" in summary:
        return (
            f"{summary['n_particles']} of {summary['particles']}, {summary['test']}, pre-load "
            f"{float(summary['preload_n']):g} N: secant stiffness "
            f"{1e-3 * float(summary['stiffness_n_per_m']):.3g} N/mm"
        )
    return (
        f"{summary['n_particles']} of {summary['particles']}, {summary['orientation']}, "
        f"{float(summary['frequency_hz']):g} Hz, gamma {float(summary['gamma']):g}: efficiency "
        f"{float(summary['efficiency']):.3f}"
    )


def description(name: str, slow_test: Callable[[RunFolder], str]) -> str:
    """A preset, case file, materials file or run folder in words and numbers.

    slow_test: words for a finished run of `shear` or `compress`.
    """
    path = Path(name)
    if path.is_dir():
        return _run(path, slow_test)
    if name in PRESETS or name in case_names("enclosure"):
        return _case(name)
    file = path if path.is_file() else data_file("materials", name)
    if file is None:
        known = [*PRESETS, *case_names("enclosure"), *data_names("materials")]
        raise InputError(f"{name!r}: no such preset, file or run; {nearest(name, known)}")
    try:
        document = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: cannot be read ({error}); give a TOML file") from None
    return _materials(str(file)) if "material" in document else _case(str(file))


def _case(name: str) -> str:
    from damper3d.view.report import echo

    return echo(DamperCase.load(name), dry_run=True)


def _run(folder: Path, slow_test: Callable[[RunFolder], str]) -> str:
    from damper3d.run.result import Result
    from damper3d.view.report import report

    run = resume_run(folder)
    if not is_slow_test(run):
        return run_in_words(folder, "damper3d", lambda run: report(Result.read(run, reused=False)))
    if run.state == "unfinished":
        return f"{run.path}: unfinished; the same damper3d shear or compress goes on with it"
    return slow_test(run)


def _materials(name: str) -> str:
    from granulab.contact.files.table import load_table

    table = load_table(name)
    lines = [f"{table.path}"]
    for material in table.materials.values():
        parts = [f"density {material.density.value:g} kg/m3"]
        if material.youngs_modulus:
            parts.append(f"E {material.youngs_modulus.value:g} Pa")
        if material.poisson:
            parts.append(f"Poisson {material.poisson.value:g}")
        if material.yield_strength:
            parts.append(f"yield strength {material.yield_strength.value:g} Pa")
        lines.append(f"  {material.name}: {', '.join(parts)}")
    for pair in table.pairs.values():
        parts = [f"friction {pair.friction.value:g}"]
        if pair.restitution:
            parts.append(f"restitution {pair.restitution.value:g}")
        lines.append(f"  {pair.first}-{pair.second}: {', '.join(parts)}")
    return "\n".join(lines)
