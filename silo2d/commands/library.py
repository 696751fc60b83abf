"""Listing of what there is to run: presets, shipped files, packings and runs."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from granulab.campaign.cli.library import NewFile, packings_and_runs, read_shown, run_in_words
from granulab.contact.files.datafile import case_names, data_names
from granulab.errors import InputError
from silo2d.case.outline import PRESETS

if TYPE_CHECKING:
    from granulab.campaign.runs.folder import RunFolder


def new_files() -> dict[str, NewFile]:
    """Files that `init` writes besides studies."""

    def materials() -> str:
        from granulab.contact.files.needs import SILO
        from granulab.contact.files.reference import commented_materials
        from granulab.contact.files.table import load_table

        return commented_materials(SILO, "wood", "methacrylate", load_table("wood"))

    def shapes() -> str:
        from silo2d.case.shapefile import EXAMPLE

        return EXAMPLE

    def case() -> str:
        from silo2d.case.settings import commented_case

        return commented_case()

    def loads() -> str:
        from silo2d.loads.spec import commented_spec

        return commented_spec()

    with_shapes = "silo2d run A4 --shapes {file} --dry-run"
    with_materials = "silo2d run A4 --materials {file} --dry-run"
    return {
        "case": NewFile(case, "silo2d run {file}", "cases", lambda: case_names("silo"), "silo"),
        "materials": NewFile(
            materials, with_materials, "materials", lambda: data_names("materials"), "material"
        ),
        "loads": NewFile(loads, "silo2d loads --silo {file}", "cases", lambda: (), "solid"),
        "shapes": NewFile(shapes, with_shapes, "shapes", lambda: data_names("shapes"), "shape"),
    }


def case_of(outline: str | None, unit: str | None, layer: str | None) -> str | None:
    """The commented case with the silo of a drawing; None where no drawing is given."""
    if outline is None:
        if unit or layer:
            raise InputError("--unit and --layer go with a drawing; give --outline FILE")
        return None
    from silo2d.drawings.outline import drawn_case

    return drawn_case(outline, unit, layer)


def preset_case(name: str) -> str | None:
    """The commented case of a preset; None for another name."""
    if name not in PRESETS:
        return None
    from granulab.contact.files.units import from_si
    from silo2d.case.outline import preset_sizes
    from silo2d.case.settings import commented_case

    angle, outlet = preset_sizes(name)
    sizes = {"silo.angle": from_si(angle, "deg"), "silo.outlet": from_si(outlet, "mm")}
    return commented_case(name, sizes)


def listing(root: Path, every: bool) -> str:
    """Presets, shapes, materials, and the packings and runs below a folder."""
    lines = [
        f"presets    {', '.join(PRESETS)}",
        f"cases      {', '.join(case_names('silo'))}",
        f"shapes     {', '.join(data_names('shapes'))}",
        f"materials  {', '.join(data_names('materials'))}",
        *packings_and_runs(root, "silo", _ended, every),
    ]
    return "\n".join(lines)


def _ended(summary: dict[str, Any]) -> str:
    """Outcome of a run in a word or two."""
    avalanches = summary.get("sizes")
    return str(summary["outcome"]) if avalanches is None else f"{len(avalanches)} avalanches"


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


def _case(name: str | Path) -> str:
    from silo2d.case.case import SiloCase
    from silo2d.view.report import echo

    return echo(SiloCase.load(name), dry_run=not isinstance(name, Path))


def _run(folder: Path) -> str:
    from silo2d.avalanches.result import Avalanches, in_words
    from silo2d.run.result import Result
    from silo2d.view.report import report

    def found(run: "RunFolder") -> str:
        if (folder / "avalanches.toml").is_file():
            return in_words(Avalanches.read(run, reused=False))
        return report(Result.read(run, reused=False))

    return run_in_words(folder, "silo2d", _case, found)


def _shapes(name: str) -> str:
    from silo2d.case.shapefile import load_shapes

    shapes = load_shapes(name)
    lines = [
        f"{shapes.name}: {len(shapes.shapes)} shapes, mean area {shapes.mean_area * 1e6:.1f} mm2"
    ]
    for shape, share in zip(shapes.shapes, shapes.shares, strict=True):
        corners = "disc" if shape.is_disc else f"{len(shape.core)} vertices"
        lines.append(
            f"  {shape.name:4} {corners}, area {shape.area * 1e6:6.1f} mm2, width "
            f"{shape.width * 1e3:5.2f} mm, share {share:.3f}"
        )
    return "\n".join(lines)


def _materials(name: str) -> str:
    from granulab.contact.files.table import load_table
    from granulab.contact.material import PROPERTIES

    table = load_table(name)
    lines = [f"{table.path}"]
    lines += [f"  {m.name}: density {m.density.value:g} kg/m3" for m in table.materials.values()]
    for pair in table.pairs.values():
        parts = [f"friction {pair.friction.value:g}"]
        if pair.restitution:
            parts.append(f"restitution {pair.restitution.value:g}")
        parts += [
            f"{name} {known.value:g} {PROPERTIES[name].unit}"
            for name in ("kn", "kt", "gamma_n", "gamma_t")
            if (known := getattr(pair.linear, name, None))
        ]
        lines.append(f"  {pair.first}-{pair.second}: {', '.join(parts)}")
    return "\n".join(lines)
