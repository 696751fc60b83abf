"""Every file below a folder of runs against its seal: which are whole, damaged, without one."""

from dataclasses import dataclass, field
from pathlib import Path

from granulab.campaign.output.files import below
from granulab.campaign.runs.folder import RESULTS, RunFolder, read_json
from granulab.campaign.runs.h5file import opened
from granulab.errors import FolderError

_JSON = ("summary.json", "provenance.json")
_HDF5 = ("trajectory.h5", "checkpoint.h5", "packing.h5")
_OF_CHECKPOINTS = ("checkpoint.h5", "packing.h5")
_NO_CONTENT = (".lock", ".tmp")  # endings of files that nobody reads back


@dataclass
class Verified:
    """Files below a folder, by what their seals say."""

    whole: list[Path] = field(default_factory=list)
    unsealed: list[Path] = field(default_factory=list)
    damaged: list[str] = field(default_factory=list)  # a line each: the file, what is wrong, a cure


def verify(root: Path) -> Verified:
    """Read every file below a folder and compare it with its seal.

    Sealed are those that runs, packings and tables are read back from. Pictures, films and exports
    are not, nor is what versions before seals wrote but for checkpoints and packings.
    """
    found = Verified()
    there = sorted(below(root))
    seals = {
        path.parent / name: seal
        for path in there
        if path.name == "provenance.json"
        for name, seal in _seals(path.parent).items()
    }
    for path in there:
        if (path.is_dir() and not path.is_symlink()) or path.name.endswith(_NO_CONTENT):
            continue
        try:
            sealed = _is_sealed(path, seals.get(path))
        except (FolderError, FileNotFoundError) as error:
            if not path.exists() and not path.is_symlink():
                continue  # of a run that goes on
            found.damaged.append(str(error))
        else:
            (found.whole if sealed else found.unsealed).append(path)
    found.damaged += [
        f"{path}: missing; use --again to compute the run again"
        for path in seals
        if not path.exists() and (path.name not in RESULTS or _finished(path.parent))
    ]
    return found


def _finished(folder: Path) -> bool:
    return RunFolder(folder).state == "finished"


def _seals(folder: Path) -> dict[str, str]:
    """Seals that a folder's provenance keeps; none where that is damaged."""
    try:
        return RunFolder(folder).seals()
    except FolderError:
        return {}


def _is_sealed(path: Path, seal: str | None) -> bool:
    """Return whether a file has a seal; FolderError where it does not hold.

    seal: of the whole file, which the provenance keeps; None where it keeps none.
    """
    RunFolder(path.parent).check_seal(path.name, seal)
    if path.name in _JSON:
        return read_json(path)[1]
    ours = path.parent.name in ("parts", "checkpoints") or path.name in _HDF5
    if path.suffix != ".h5" or not ours:
        return seal is not None
    of_checkpoint = path.name in _OF_CHECKPOINTS or path.parent.name == "checkpoints"
    with opened(path, "checkpoint" if of_checkpoint else "trajectory") as file:
        return file.userblock_size > 0
