"""What stands below a folder of runs, in words for a person; and new files for a person to edit."""

from pathlib import Path

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


def packings_and_runs(root: Path, answer: str) -> list[str]:
    """A line for each packing and run below a folder: where it is, its state and size.

    answer: the key of the summary that tells most of a finished run.
    """
    packings = sorted((root / "packings").glob("*/packing.h5"))
    runs = sorted(root.glob("*/case.toml"))
    return [
        *(f"packing    {path.parent}  {_size(path.parent)}" for path in packings),
        *(f"run        {p.parent}  {_state(p.parent, answer)}  {_size(p.parent)}" for p in runs),
    ]


def _state(folder: Path, answer: str) -> str:
    run = RunFolder(folder)
    if run.state != "finished":
        return "unfinished"
    try:
        return str(run.read_summary()[answer])
    except (FolderError, KeyError):
        return "damaged"


def _size(folder: Path) -> str:
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    return f"{size / 1e6:.1f} MB"
