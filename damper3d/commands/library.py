"""Listing of presets, shipped files, packings and runs, in words for a person."""

from functools import partial
from pathlib import Path
from typing import Any

from damper3d.case.case import PRESETS, DamperCase
from damper3d.commands.options import EXAMPLES_OF_CASES
from damper3d.run.folders import is_slow_test
from granulab.campaign.cli.library import NewFile, packings_and_runs, read_shown, run_in_words
from granulab.campaign.runs.folder import resume_run
from granulab.contact.files.datafile import case_names, data_names


def new_files() -> dict[str, NewFile]:
    """Files that `init` writes besides studies."""

    def materials() -> str:
        from granulab.contact.files.needs import DAMPER
        from granulab.contact.files.reference import commented_materials
        from granulab.contact.files.table import load_table

        return commented_materials(DAMPER, "acrylic", "acrylic", load_table("acrylic"))

    def case() -> str:
        from damper3d.case.settings import commented_case

        return commented_case()

    def example(kind: str) -> str:
        from damper3d.case.settings import EXAMPLES, commented_case

        return commented_case(EXAMPLES[kind])

    def task() -> str:
        from damper3d.studies.design.spec import example

        return example()

    use, cases = "damper3d run {file}", partial(case_names, "enclosure")
    return {
        "case": NewFile(case, use, "cases", cases, "enclosure"),
        **{
            kind: NewFile(partial(example, kind), use, "cases", cases, "host")
            for kind in EXAMPLES_OF_CASES
        },
        "design": NewFile(task, "damper3d design {file}", "catalogues", lambda: (), "structure"),
        "materials": NewFile(
            materials,
            "damper3d run --material {file} --dry-run",
            "materials",
            lambda: data_names("materials"),
            "material",
        ),
    }


def preset_case(name: str) -> str | None:
    """The commented case of a preset; None for another name."""
    from damper3d.case.settings import commented_case

    return commented_case() if name in PRESETS else None


def listing(root: Path, every: bool) -> str:
    """Presets, cases, materials, and the packings and runs below a folder."""
    lines = [
        f"presets    {', '.join(PRESETS)}",
        f"cases      {', '.join(case_names('enclosure'))}",
        f"materials  {', '.join(data_names('materials'))}",
        *packings_and_runs(root, "enclosure", _result, every),
    ]
    return "\n".join(lines)


def _result(summary: dict[str, Any]) -> str:
    """Case of a finished run, and its efficiency, or stiffness."""
    if "test" in summary:
        return (
            f"{summary['n_particles']} of {summary['particles']}, {summary['test']}, pre-load "
            f"{float(summary['preload_n']):g} N: secant stiffness "
            f"{1e-3 * float(summary['stiffness_n_per_m']):.3g} N/mm"
        )
    from damper3d.measures.efficiency import in_words

    many = len(summary.get("dampers") or ())
    others = f"; and {many - 1} more dampers on its host" if many > 2 else ""
    excited = summary.get("excitation")  # gamma is then of the largest value, of a bare host
    moved = f"{float(summary['frequency_hz']):g} Hz, gamma {float(summary['gamma']):g}"
    return (
        f"{summary['n_particles']} of {summary['particles']}, {summary['orientation']}, "
        f"{excited['kind'] if excited else moved}: "
        f"{in_words(summary)}{'; and another damper on its host' if many == 2 else others}"
    )


def description(name: str) -> str:
    """A preset, case file, materials file or run folder in words and numbers."""
    path = Path(name)
    if path.is_dir():
        return _run(path)
    if name in PRESETS or name in case_names("enclosure"):
        return _case(name)
    known = [*PRESETS, *case_names("enclosure"), *data_names("materials")]
    file, document = read_shown(name, known)
    return _materials(file) if "material" in document else _case(file)


def _case(name: str | Path) -> str:
    from damper3d.view.report import echo

    return echo(DamperCase.load(name), dry_run=not isinstance(name, Path))


def _run(folder: Path) -> str:
    from damper3d.run.result import Result
    from damper3d.studies.quasistatic.report import finished_test
    from damper3d.view.report import report

    run = resume_run(folder)
    if not is_slow_test(run):
        return run_in_words(
            folder, "damper3d", _case, lambda run: report(Result.read(run, reused=False))
        )
    if run.state == "unfinished":
        return f"{run.path}: unfinished; the same damper3d shear or compress goes on with it"
    return finished_test(run)


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
