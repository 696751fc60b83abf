"""What there is to run: presets, shipped files, packings and runs, in words for a person."""

import tomllib
from pathlib import Path

from campaign.folder import FolderError, RunFolder
from contact.datafile import data_file, data_names
from contact.quantity import InputError, nearest
from damper3d.case import PRESETS, DamperCase, shipped_cases


def write_new(path: Path, text: str) -> None:
    """Write a file that is not there yet; InputError where it is, or cannot be written."""
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise InputError(f"{path}: exists; give another name, nothing was written") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); give another") from None


def listing(root: Path) -> str:
    """Presets, cases, materials, and the packings and runs below a folder."""
    lines = [
        f"presets    {', '.join(PRESETS)}",
        f"cases      {', '.join(shipped_cases())}",
        f"materials  {', '.join(data_names('materials'))}",
    ]
    packings = sorted((root / "packings").glob("*/packing.h5"))
    runs = sorted(root.glob("*/case.toml"))
    lines += [f"packing    {path.parent}  {_size(path.parent)}" for path in packings]
    lines += [f"run        {p.parent}  {_state(p.parent)}  {_size(p.parent)}" for p in runs]
    return "\n".join(lines)


def _state(folder: Path) -> str:
    run = RunFolder(folder)
    if run.state != "finished":
        return "unfinished"
    try:
        return f"efficiency {float(run.read_summary()['efficiency']):.3f}"
    except (FolderError, KeyError, TypeError, ValueError):
        return "damaged"


def _size(folder: Path) -> str:
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    return f"{size / 1e6:.1f} MB"


def description(name: str) -> str:
    """A preset, case file, materials file or run folder in words and numbers."""
    path = Path(name)
    if path.is_dir():
        return _run(path)
    if name in PRESETS or name in shipped_cases():
        return _case(name)
    file = path if path.is_file() else data_file("materials", name)
    if file is None:
        known = [*PRESETS, *shipped_cases(), *data_names("materials")]
        raise InputError(f"{name!r}: no such preset, file or run; {nearest(name, known)}")
    try:
        document = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: cannot be read ({error}); give a TOML file") from None
    return _materials(str(file)) if "material" in document else _case(str(file))


def _case(name: str) -> str:
    from damper3d.report import echo

    return echo(DamperCase.load(name), dry_run=True)


def _run(folder: Path) -> str:
    from damper3d.report import report
    from damper3d.result import Result

    run = RunFolder(folder)
    if run.state == "new":
        raise InputError(f"{folder}: not a run folder (it has no case.toml); give one")
    if run.state == "unfinished":
        return f"{folder}: unfinished; go on with: damper3d run --resume {folder}"
    return report(Result.read(run, reused=False))


def _materials(name: str) -> str:
    from contact.table import load_table

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
