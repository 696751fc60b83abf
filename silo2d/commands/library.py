"""Listing of what there is to run: presets, shipped files, packings and runs."""

from pathlib import Path

from granulab.campaign.cli.library import packings_and_runs, read_shown, run_in_words
from granulab.contact.files.datafile import case_names, data_names
from silo2d.case.outline import PRESETS


def listing(root: Path) -> str:
    """Presets, shapes, materials, and the packings and runs below a folder."""
    lines = [
        f"presets    {', '.join(PRESETS)}",
        f"cases      {', '.join(case_names('silo'))}",
        f"shapes     {', '.join(data_names('shapes'))}",
        f"materials  {', '.join(data_names('materials'))}",
        *packings_and_runs(root, lambda summary: str(summary["outcome"])),
    ]
    return "\n".join(lines)


def description(name: str) -> str:
    """A preset, case file, shape set, materials file or run folder in words and numbers."""
    path = Path(name)
    if path.is_dir():
        return _run(path)
    if name in PRESETS or name in case_names("silo"):
        return _case(name)
    if name in data_names("shapes"):
        return _shapes(name)
    shipped = (n for kind in ("shapes", "materials") for n in data_names(kind))
    file, document = read_shown(name, [*PRESETS, *case_names("silo"), *shipped])
    if "shape" in document:
        return _shapes(file)
    return _materials(file) if "material" in document else _case(file)


def _case(name: str) -> str:
    from silo2d.case.case import SiloCase
    from silo2d.view.report import echo

    return echo(SiloCase.load(name), dry_run=True)


def _run(folder: Path) -> str:
    from silo2d.run.result import Result
    from silo2d.view.report import report

    return run_in_words(folder, "silo2d", lambda run: report(Result.read(run, reused=False)))


def _shapes(name: str) -> str:
    from silo2d.case.shape import load_shapes

    shapes = load_shapes(name)
    lines = [
        f"{shapes.name}: {len(shapes.shapes)} shapes, mean area {shapes.mean_area * 1e6:.1f} mm2"
    ]
    for shape, share in zip(shapes.shapes, shapes.shares, strict=True):
        lines.append(
            f"  {shape.name:4} {len(shape.core)} vertices, area {shape.area * 1e6:6.1f} mm2, width "
            f"{shape.width * 1e3:5.2f} mm, share {share:.3f}"
        )
    return "\n".join(lines)


def _materials(name: str) -> str:
    from granulab.contact.files.table import load_table

    table = load_table(name)
    lines = [f"{table.path}"]
    lines += [f"  {m.name}: density {m.density.value:g} kg/m3" for m in table.materials.values()]
    for pair in table.pairs.values():
        parts = [f"friction {pair.friction.value:g}"]
        if pair.restitution:
            parts.append(f"restitution {pair.restitution.value:g}")
        if pair.linear:
            parts.append(f"kn {pair.linear.kn.value:g} N/m, kt {pair.linear.kt.value:g} N/m")
            parts.append(f"gamma_n {pair.linear.gamma_n.value:g} 1/s")
        lines.append(f"  {pair.first}-{pair.second}: {', '.join(parts)}")
    return "\n".join(lines)
