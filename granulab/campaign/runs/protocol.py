"""Steps that the run of any simulator goes through: folder begun or found, packing shared."""

import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol, TypeVar

from granulab.campaign.runs.lock import alone
from granulab.campaign.runs.folder import FolderError, RunFolder, write_atomic, writing
from granulab.campaign.runs.provenance import Sources, Warn, provenance
from granulab.errors import Stopped

Stop = Callable[[], bool]  # asked now and then: is the state to be kept, and the run to end?
Progress = Callable[[float, str], None]  # takes the fraction done (0 to 1), and words


class Made(Protocol):
    """A packing, as far as its sharing is concerned."""

    @property
    def sources(self) -> str: ...  # digest of the sources that made it


Packing = TypeVar("Packing", bound=Made)


def begin_or_check(
    folder: RunFolder,
    *,
    case: str,
    files: Mapping[str, str],
    run_digest: str,
    seed: int,
    packages: list[str],
    sources: Sources,
    warn: Warn,
) -> None:
    """Write what a new run's folder begins with; warn where a begun one is of other sources.

    case: as resolved (TOML); files: by name, those that it refers to. Raises FolderError.
    """
    if folder.state != "new":
        made = folder.read_provenance().get("source_digest")
        cure = "--again computes it anew beside it"
        sources.check(f"{folder.path} was begun", made, cure, warn)
        return
    for name, text in files.items():
        write_atomic(folder.path / name, text)
    origin = provenance(command=sys.argv, seed=seed, packages=packages, sources=sources.folders)
    folder.write_provenance({**origin, "run_digest": run_digest})
    folder.write_case(case)  # last: from here on the run counts as begun


def check_unchanged(folder: RunFolder, run_digest: str, files: str) -> None:
    """Raise FolderError where a begun run's case is no longer that of its digest.

    files: those that say the case, for the message.
    """
    if folder.read_provenance().get("run_digest") != run_digest:
        raise FolderError(
            f"{folder.path}: {files} were changed since the run began; run the changed case as a "
            "new one"
        )


def end(
    folder: RunFolder, summary: Mapping[str, Any], begun: float, measures: Sources | None = None
) -> None:
    """Keep the results, the wall time since `begun` (time.perf_counter) [s], and by which measures.

    measures: the rooms whose functions made the results from what the run stored.
    """
    origin = {**folder.read_provenance(), "wall_s": time.perf_counter() - begun}
    if measures:
        origin["measures_digest"] = measures.digest
    folder.write_provenance(origin)
    folder.write_summary(summary)


def is_measured_by(folder: RunFolder, measures: Sources) -> bool:
    """Return whether the results of a finished run were made by these measures."""
    return folder.read_provenance().get("measures_digest") == measures.digest


def measure_again(
    folder: RunFolder,
    measures: Sources,
    results: Callable[[Mapping[str, Any]], Mapping[str, Any] | None],
    warn: Warn,
) -> None:
    """Bring the results of a finished run up to date where other measures made them.

    results: the summary from what the run stored, given the one that stands there; None where too
    little was stored, of which `warn` is told.
    """
    origin = folder.read_provenance()
    made = origin.get("measures_digest")
    if made == measures.digest:
        return
    summary = results(folder.read_summary())
    if summary is None:
        cure = "--again computes the run again beside it"
        measures.check(f"the results of {folder.path} were measured", made, cure, warn)
        return
    folder.write_provenance({**origin, "measures_digest": measures.digest})
    folder.write_summary(summary)


def kept(
    folder: Path,
    *,
    load: Callable[[Path], Packing | None],
    make: Callable[[], Packing],
    cure: str,
    sources: Sources,
    stop: Stop,
    warn: Warn,
) -> Packing:
    """The packing in a folder; where there is none, one process makes it and others wait.

    load: gives None where there is none; make: makes and keeps it; cure: what to do about one
    that other sources made, of which `warn` is told. Raises FolderError where the folder cannot
    be written, Stopped where `stop` says so while waiting, and what `load` and `make` raise.
    """
    packing = load(folder)
    if packing is not None:
        sources.check(f"{folder} was filled", packing.sources, cure, warn)
        return packing
    with writing(folder):  # before the work of filling, not after it
        folder.mkdir(parents=True, exist_ok=True)
    with alone(folder, stop, Stopped("the same command goes on from there")):
        return load(folder) or make()


def packing_sources(load: Callable[[Path], Made | None], file: Path) -> str | None:
    """Digest of the sources that made the packing in a file; None where none can be read."""
    try:
        packing = load(file.parent)
    except FolderError:
        return None
    return packing.sources if packing else None
