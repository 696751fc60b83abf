"""Where the shipped data files are: in a checkout, or in an installed package."""

from pathlib import Path

_ROOT = Path(__file__).resolve().parent.parent


def data_root() -> Path:
    """The folder of the shipped tables, shapes, materials and cases."""
    installed = _ROOT / "granulab_data"  # the name in a wheel; a checkout has data/
    return installed if installed.is_dir() else _ROOT / "data"


def data_names(kind: str) -> list[str]:
    """Names of the shipped files of a kind: "materials", "shapes", "cases" or "published"."""
    return sorted(path.stem for path in (data_root() / kind).glob("*.*"))


def data_file(kind: str, name: str) -> Path | None:
    """Path of the shipped file `name` of a kind (without its ending), or None."""
    return next((p for p in sorted((data_root() / kind).glob("*.*")) if p.stem == name), None)
