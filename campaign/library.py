"""What stands below a folder of runs, in words for a person; and new files for a person to edit."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from campaign.folder import FolderError, RunFolder


def write_new(path: Path, text: str) -> None:
    """Write a file that is not there yet; FolderError where it is, or cannot be written."""
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise FolderError(f"{path}: exists; give another name, nothing was written") from None
    except OSError as error:
        raise FolderError(f"{path}: cannot be written ({error.strerror}); give another") from None


def packings_and_runs(root: Path, answer: Callable[[dict[str, Any]], str]) -> list[str]:
    """A line for each packing and run below a folder: where it is, its state and size.

    answer: what to say of a finished run, from its summary; where it raises, that is damaged.
    """
    packings = sorted((root / "packings").glob("*/packing.h5"))
    runs = sorted(root.glob("*/case.toml"))
    return [
        *(f"packing    {path.parent}  {_size(path.parent)}" for path in packings),
        *(f"run        {p.parent}  {_state(p.parent, answer)}  {_size(p.parent)}" for p in runs),
    ]


def _state(folder: Path, answer: Callable[[dict[str, Any]], str]) -> str:
    run = RunFolder(folder)
    if run.state != "finished":
        return "unfinished"
    try:
        return answer(run.read_summary())
    except (FolderError, KeyError, TypeError, ValueError):
        return "damaged"


def _size(folder: Path) -> str:
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    return f"{size / 1e6:.1f} MB"
