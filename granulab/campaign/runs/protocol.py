"""Steps that the run of any simulator goes through: folder begun or found, packing shared."""

import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from granulab.campaign.output import terminal
from granulab.campaign.output.files import write_atomic, writing
from granulab.campaign.runs.folder import RESULTS, RunFolder, open_run, resume_run, seals_of
from granulab.campaign.runs.provenance import (
    Sources,
    Warn,
    check_arithmetic,
    check_versions,
    provenance,
    to_stderr,
)
from granulab.campaign.runs.sharing import alone, wanted
from granulab.campaign.runs.stages import Stages
from granulab.errors import DamagedError, FolderError, InputError, SimulationError, Stopped

if TYPE_CHECKING:
    from granulab.campaign.runs.result import Results

Stop = Callable[[], bool]  # called now and then: true where the run is to end, its state kept
Progress = Callable[[float, str], None]  # takes the fraction done (0 to 1), and words


class Made(Protocol):
    """A packing, as far as its sharing is concerned."""

    @property
    def sources(self) -> str: ...  # digest of the sources that made it


Packing = TypeVar("Packing", bound=Made)


Case = TypeVar("Case", bound="Runnable")
Found = TypeVar("Found", bound="Results")
Meta = TypeVar("Meta")


class Runnable(Protocol):
    """A case, as far as its run folder is concerned."""

    @property
    def name(self) -> str: ...
    @property
    def settings(self) -> Any: ...  # run.seed
    @property
    def files(self) -> Mapping[str, str]: ...  # texts by name, of the files that it refers to
    def to_toml(self) -> str: ...  # as resolved


@dataclass(frozen=True)
class Runs(Generic[Case, Found]):
    """Runs of one kind of case: begun or found, computed or gone on with, read back.

    result     type of the results
    digest     names a run: its case, seed and engine
    compute    results of a run that is not finished, from where it was left; it reports how far
               its stages are, and raises Stopped
    packages   distributions whose versions matter to the last bit
    sources    of a case: those that decide what its run computes
    load       the case of a case.toml; None: such runs are gone on with by their command alone
    described  files of a folder that say its case, for a message
    measures   those that make results from what a run stored; None: none are made again
    measured   results measured again, given those that stand there; None where too little is stored
    clear      removes what a finished run does not need
    find       the folder of a begun run at a path
    compiling  expected cost of a case's kernels [s], and about how many functions they are
    """

    result: type[Found]
    digest: Callable[[Case], str]
    compute: Callable[[RunFolder, Case, Stages, Stop, Warn], dict[str, Any]]
    packages: list[str]
    sources: Callable[[Case], Sources]
    load: Callable[[Path], Case] | None = None
    described: str = "case.toml"
    measures: Sources | None = None
    measured: Callable[[RunFolder, Case, Mapping[str, Any]], dict[str, Any] | None] | None = None
    clear: Callable[[RunFolder, Case], None] = lambda folder, case: None
    find: Callable[[str | Path], RunFolder] = resume_run
    compiling: Callable[[Case], tuple[float, int]] = lambda case: (30.0, 100)

    def run(
        self,
        case: Case,
        *,
        out: str | Path | None = None,
        progress: Progress | Stages | None = None,
        again: bool = False,
        stop: Stop | None = None,
        warn: Warn = to_stderr,
        threads: int | None = None,
    ) -> Found:
        """Run a case in a folder below `out` ("runs"), or read the result that stands there.

        An unfinished run goes on from its checkpoint.

        progress  takes the part of all that is done (0 to 1) and words; None: a line that changes
                  in place in a notebook, nothing in a script
        again     compute a finished run once more, in a new folder
        stop      called some times a second; when it is true, the state is kept and Stopped is
                  raised; None: Ctrl-C or the notebook's interrupt does so and raises
                  KeyboardInterrupt, and the same call goes on
        warn      called for what other sources made
        threads   share each step, and change no bit; None: as many as there are cores where the
                  bed is large enough

        Raises InputError where the particles do not fit, FolderError for folders that cannot be
        used and SimulationError where the simulation fails.
        """
        name = f"{case.name}-seed{case.settings.run.seed}"
        folder = open_run(Path(out or "runs"), name, self.digest(case), again)
        with wanted(threads):
            return self._run_in(folder, case, progress, stop, warn)

    def resume(
        self,
        path: str | Path,
        *,
        progress: Progress | Stages | None = None,
        stop: Stop | None = None,
        threads: int | None = None,
    ) -> Found:
        """Go on with the run in a folder; see `run`."""
        assert self.load
        folder = self.find(path)
        changed = FolderError(
            f"{folder.path}: {self.described} were changed since the run began, or damaged; run a "
            "changed case as a new one"
        )
        try:
            case = self.load(folder.case_file)
        except DamagedError as error:
            raise changed from error
        origin = folder.read_provenance()
        if origin.get("run_digest") != self.digest(case):
            if not folder.seals():  # of a version before seals: nobody knows
                raise changed
            raise FolderError(
                f"{folder.path}: begun by another version (granulab {origin.get('granulab')}, "
                f"sources {origin.get('source_digest')}), which made another run of this case; go "
                "on with that version, or run its case.toml as a new one"
            )
        with wanted(threads):
            return self._run_in(folder, case, progress, stop, to_stderr)

    def read_finished(self, folder: RunFolder, warn: Warn = to_stderr) -> Found:
        """The result of a finished run; measured again where the measures are others by now."""
        if not self._is_outdated(folder):  # without a lock: it may lie where nobody may write
            return self.result.read(folder, reused=True)
        with folder.lock():
            return self._read(folder, warn)

    def _run_in(
        self,
        folder: RunFolder,
        case: Case,
        progress: Progress | Stages | None,
        stop: Stop | None,
        warn: Warn,
    ) -> Found:
        kept = folder.state == "finished" and not self._is_outdated(folder)
        if kept and not os.access(folder.path, os.W_OK):  # nor can anybody change it
            self._begin_or_check(folder, case, warn)
            return self.result.read(folder, reused=True)
        with folder.lock():
            begun = time.perf_counter()
            self._begin_or_check(folder, case, warn)
            if folder.state == "finished":
                self._clear(folder, case)  # it may have been killed before it could
                return self._read(folder, warn)
            tried = folder.read_provenance()
            if tried.pop("failed", None):
                folder.write_provenance(tried)  # it goes on
            try:
                seeded = f"{case.name}, seed {case.settings.run.seed}"
                with attended(seeded, progress, stop) as (stages, ending):
                    stages.compiling = self.compiling(case)
                    with stages.watching():
                        summary = self.compute(folder, case, stages, ending, warn)
            except (InputError, SimulationError) as error:
                folder.write_provenance({**tried, "failed": str(error)})
                raise
            origin = {**folder.read_provenance(), "wall_s": time.perf_counter() - begun}
            if self.measures:
                origin["measures_digest"] = self.measures.digest
            folder.write_provenance(folder.with_seals(origin, RESULTS))
            folder.write_summary(summary)
            self._clear(folder, case)
            return self.result.read(folder, reused=False)

    def _begin_or_check(self, folder: RunFolder, case: Case, warn: Warn) -> None:
        """Write what a new run's folder begins with; warn where others began one that is there."""
        sources = self.sources(case)
        if folder.state != "new":
            what, origin = f"{folder.path} was begun", folder.read_provenance()
            cure = "--again computes it again in a new folder"
            sources.check(what, origin.get("source_digest"), cure, warn)
            check_arithmetic(what, origin, warn)
            check_versions(what, origin, warn)
            return
        for name, text in case.files.items():
            write_atomic(folder.path / name, text)
        seed, packages = case.settings.run.seed, self.packages
        origin = provenance(command=sys.argv, seed=seed, packages=packages, sources=sources)
        seals = seals_of({**case.files, "case.toml": case.to_toml()})
        folder.write_provenance({**origin, "run_digest": self.digest(case), **seals})
        folder.write_case(case.to_toml())  # last: from here on the run counts as begun

    def _clear(self, folder: RunFolder, case: Case) -> None:
        folder.drop_checkpoints()
        self.clear(folder, case)

    def _is_outdated(self, folder: RunFolder) -> bool:
        """True where the results of a finished run were made by other measures."""
        made = folder.read_provenance().get("measures_digest")
        return self.measures is not None and made != self.measures.digest

    def _read(self, folder: RunFolder, warn: Warn) -> Found:
        """The results of a finished run, brought up to date where other measures made them."""
        if self.measures and self.measured and self.load and self._is_outdated(folder):
            origin = folder.read_provenance()
            case = self.load(folder.case_file)
            summary = self.measured(folder, case, folder.read_summary())
            if summary is None:
                what = f"the results of {folder.path} were measured"
                made = origin.get("measures_digest")
                self.measures.check(what, made, "--again computes it again in a new folder", warn)
            else:
                folder.write_summary(summary)  # first: cut off here, it is measured again
                folder.write_provenance({**origin, "measures_digest": self.measures.digest})
        return self.result.read(folder, reused=True)


@contextmanager
def attended(
    title: str, progress: Progress | Stages | None, stop: Stop | None
) -> Iterator[tuple[Stages, Stop]]:
    """Stages and stop of a run; where none are given, those of a person at Python: see Runs.run."""
    with ExitStack() as surroundings:
        if progress is None and terminal.in_notebook():
            line = surroundings.enter_context(terminal.Progress(title, estimates=False))
            progress = line.update
        if stop is None:
            stop = surroundings.enter_context(terminal.interruptible())
        yield Stages.of(progress), stop


def restored(
    folder: RunFolder,
    restore: Callable[[dict[str, Any]], object],
    meta: type[Meta],
    start: str,
    warn: Warn,
    *,
    beside: Sequence[Path] = (),
) -> Meta | None:
    """Return the data of a checkpoint on the run (meta), once its arrays are restored.

    That is the newest one, or where a file is damaged the newest one that needs none of them;
    None where none is left. `warn` gets which file it is and what is computed again. start:
    where the run then begins; beside: folders of other trajectories that the checkpoint goes with,
    of as many parts. Raises FolderError where a checkpoint does not fit the case, and where a file
    cannot be read now: then none is removed.
    """
    # here, since h5py is slow to load
    from granulab.campaign.runs.checkpoint import checkpoints, go_back, load_checkpoint
    from granulab.campaign.runs.trajectory import part_file, whole_parts

    looked = [(*whole_parts(place), place) for place in (folder.path, *beside)]
    whole, _, wrong, place = min(looked, key=lambda one: one[0])
    there = max(one[1] for one in looked)
    for path in checkpoints(folder):
        try:
            saved, said = load_checkpoint(path)
        except DamagedError as error:
            wrong = wrong or str(error).partition(";")[0]
            continue
        try:
            if said.get("parts", 0) > whole:
                wrong = wrong or f"{part_file(place / 'parts', whole)}: missing"
                continue
            restore(saved)
            found = meta(**said)
        except (IndexError, KeyError, TypeError, ValueError) as error:
            raise FolderError(
                f"{folder.checkpoint}: does not fit this case ({error}); delete it and the run "
                f"starts from {start}"
            ) from None
        if path != folder.checkpoint:
            go_back(folder, path)
        if wrong:
            again = there - said.get("parts", 0)
            repeated = f" and computes {again} of its {there} parts again, to the same bits"
            warn(f"{wrong}; the run goes on from {path}{repeated if again else ''}")
        return found
    folder.drop_checkpoints()
    warn(f"{wrong}; no checkpoint before it is left, so that the run starts from {start}")
    return None


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
    that other sources made, passed to `warn`. Raises FolderError where the folder cannot
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


def loaded(
    folder: Path, packing: Callable[[dict[str, Any], dict[str, Any]], Packing], cure: str
) -> Packing | None:
    """The packing kept in a folder, None where there is none.

    Raises FolderError where it is damaged, or cannot be read now.

    packing: makes it of the arrays and the meta of its file.
    """
    from granulab.campaign.runs.checkpoint import load_checkpoint
    from granulab.campaign.runs.h5file import UnreadableError

    file = folder / "packing.h5"
    if not file.exists():
        return None
    try:
        return packing(*load_checkpoint(file))
    except UnreadableError:
        raise
    except (FolderError, KeyError, TypeError):
        raise damaged(folder, cure) from None


def damaged(folder: Path, cure: str) -> FolderError:
    """Error to raise for a packing that cannot be used; cure: what follows from deleting it."""
    return FolderError(
        f"{folder / 'packing.h5'}: damaged, or of another version; delete it and {cure}"
    )


def packing_sources(load: Callable[[Path], Made | None], file: Path) -> str | None:
    """Digest of the sources that made the packing in a file; None where none can be read."""
    try:
        packing = load(file.parent)
    except FolderError:
        return None
    return packing.sources if packing else None
