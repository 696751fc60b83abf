"""The folder of one run: its name, its state, its lock, its case, provenance and summary."""

import hashlib
import json
import shutil
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any, Literal

from granulab.campaign.output.files import SHOWN, below, in_shell, write_atomic, writing
from granulab.campaign.runs.seal import NotSealed, open_kept, opened_json, sealed_json, sha256_of
from granulab.errors import DamagedError, FolderError

SCHEMA = 1  # of the JSON files, trajectories and checkpoints; raise it when their keys change
RESULTS = ("records.csv", "trajectory.h5")  # of a finished run, besides its summary
_LOOK = 0.2  # [s] in which others that look at a lock (is_computed) have let go of it
_WRITTEN = 3600.0  # [s] in which a file is written
_SEALS = "sealed_files"  # in the provenance
_AGAIN = "use --again to compute the run again"
_RUN_ANEW = f"{_AGAIN}, and run a changed case as a new one"


class BusyError(FolderError):
    """A run that another process computes now."""


class Stored(dict[str, Any]):
    """Content of a file or table of a run, by name; DamagedError for what it does not hold."""

    def __init__(self, where: object, items: Mapping[str, Any]) -> None:
        super().__init__(items)
        self._where = where

    def __missing__(self, name: str) -> Any:
        raise DamagedError(f"{self._where}: damaged (no {name}); {_AGAIN}")


def digest(mapping: Mapping[str, Any]) -> str:
    """First 12 hex digits of the SHA-256 of a mapping, whatever the order of its keys.

    Floats enter with all their digits (repr), so the last bit counts.
    """
    canonical = json.dumps(mapping, sort_keys=True, separators=(",", ":"), default=plain)
    return hashlib.sha256(canonical.encode()).hexdigest()[:12]


def plain(value: Any) -> Any:
    """A numpy number or array as Python numbers, for json.dumps(default=plain)."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{value!r} cannot stand in a JSON file")


@dataclass(frozen=True)
class RunFolder:
    """One run on disk: case.toml, provenance.json, checkpoint.h5, summary.json, figures/."""

    path: Path

    @property
    def state(self) -> Literal["new", "unfinished", "finished"]:
        """State of the run, as the folder shows it now; finished where a summary stands."""
        if (self.path / "summary.json").exists():
            return "finished"
        return "unfinished" if (self.path / "case.toml").exists() else "new"

    @property
    def failure(self) -> str | None:
        """Reason why the run ended without a result when it was last tried; None where it did not.

        What has failed is unfinished: tried again, it goes on from its last checkpoint.
        """
        if self.state != "unfinished":
            return None
        try:
            return self.read_provenance().get("failed")
        except FolderError:
            return None

    @property
    def checkpoint(self) -> Path:
        """Path of the checkpoint."""
        return self.path / "checkpoint.h5"

    def go_on(self, command: str) -> str:
        """The line that goes on with this run, as one gives it to the shell."""
        return f"{command} run --resume {in_shell(str(self.path))}"

    @property
    def checkpoints(self) -> Path:
        """Folder of the checkpoints before it."""
        return self.path / "checkpoints"

    def drop_checkpoints(self) -> None:
        """Remove all checkpoints, the newest first: without it the others do not count."""
        self.checkpoint.unlink(missing_ok=True)
        if not self.checkpoints.is_symlink():
            shutil.rmtree(self.checkpoints, ignore_errors=True)

    @property
    def figures(self) -> Path:
        """Folder of the pictures; who draws the first one makes it."""
        return self.path / "figures"

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Keep every other process off this run; a killed holder leaves no lock behind.

        Raises BusyError when another one computes in this folder, FolderError when nobody can.
        """
        from filelock import FileLock, Timeout

        held = FileLock(self.path / ".lock")  # the system's own lock: it ends with its process
        with writing(self.path):
            try:
                held.acquire(timeout=_LOOK)
            except Timeout:
                raise BusyError(
                    f"{self.path}: another process computes this run now; wait for it, "
                    "or use --again to compute it in a folder of its own"
                ) from None
        try:
            with writing(self.path):
                self._clear_leftovers()
            yield
        finally:
            held.release()

    @property
    def is_computed(self) -> bool:
        """True where a process computes in this folder now."""
        from filelock import FileLock, Timeout

        if not (self.path / ".lock").exists():
            return False
        try:
            with FileLock(self.path / ".lock", timeout=0):
                return False
        except Timeout:
            return True
        except OSError:  # not ours to lock
            return False

    def _clear_leftovers(self) -> None:
        """Remove what killed writers left; who shows the run may be writing, and has no lock."""
        for path in below(self.path):
            if path.name.startswith(".") and path.suffix == ".tmp":
                with suppress(FileNotFoundError):
                    young = time.time() - path.lstat().st_mtime < _WRITTEN
                    if not (young and path.parent.name in SHOWN):
                        path.unlink()

    def write_case(self, text: str) -> None:
        """Keep the case as resolved (TOML); from here on the run counts as begun."""
        write_atomic(self.path / "case.toml", text)

    def read_case(self) -> str:
        """The case as resolved (TOML)."""
        return _read_text(self.path / "case.toml")

    @property
    def case_file(self) -> Path:
        """Path of the case as resolved, once it and the files beside it are found unchanged.

        Raises FolderError where they are not; a version before seals kept nothing to compare with.
        """
        seals = self.seals()
        there = {path.name for path in self.path.glob("*.toml")}
        for name in sorted((there | seals.keys()) - set(RESULTS)):
            self.check_seal(name, seals.get(name))
        return self.path / "case.toml"

    def seals(self) -> dict[str, str]:
        """SHA-256 of the files without a seal of their own, by name, as the provenance has them."""
        there = (self.path / "provenance.json").exists()
        return dict(self.read_provenance().get(_SEALS, {})) if there else {}

    def check_seal(self, name: str, seal: str | None) -> None:
        """Raise FolderError where a file cannot be read, or has another SHA-256 than a seal."""
        path = self.path / name
        try:
            found = sha256_of(path)
        except OSError as error:
            raise FolderError(f"{path}: cannot be read ({error.strerror}); {_RUN_ANEW}") from error
        if seal is not None and found != seal:
            raise DamagedError(f"{path}: changed since the run began, or damaged; {_RUN_ANEW}")

    def seal(self, *names: str) -> None:
        """Have the provenance seal those of the named files that are there."""
        self.write_provenance(self.with_seals(self.read_provenance(), names))

    def with_seals(self, provenance: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
        """A provenance that seals those of the named files that are there, besides others."""
        there = [name for name in names if (self.path / name).is_file()]
        seals = {name: sha256_of(self.path / name) for name in there}
        return {**provenance, _SEALS: {**provenance.get(_SEALS, {}), **seals}}

    def write_provenance(self, provenance: Mapping[str, Any]) -> None:
        """Keep where the numbers come from."""
        write_json(self.path / "provenance.json", {"schema": SCHEMA, **provenance})

    def read_provenance(self) -> dict[str, Any]:
        """Return the provenance; FolderError when missing, damaged or of another schema."""
        return _of_this_schema(self.path / "provenance.json")

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """Keep the results; from here on the run counts as finished.

        A value that does not exist is None; NaN and infinity are refused (ValueError).
        """
        write_json(self.path / "summary.json", {"schema": SCHEMA, **summary})

    def read_summary(self) -> dict[str, Any]:
        """Return the summary; FolderError when missing, damaged or of another schema."""
        path = self.path / "summary.json"
        return Stored(path, _of_this_schema(path))


def seals_of(texts: Mapping[str, str]) -> dict[str, Any]:
    """Entry of a provenance that seals texts which are about to be written, by name of the file."""
    return {
        _SEALS: {name: hashlib.sha256(text.encode()).hexdigest() for name, text in texts.items()}
    }


def open_run(root: str | Path, name: str, digest: str, again: bool = False) -> RunFolder:
    """The folder root/<name>-<digest> of a run (see find_run), made where it does not exist.

    Raises FolderError when no folder can be made there.
    """
    run = find_run(root, name, digest, again)
    with writing(run.path):
        run.path.mkdir(parents=True, exist_ok=True)
    return run


def find_run(root: str | Path, name: str, digest: str, again: bool = False) -> RunFolder:
    """The folder root/<name>-<digest> of a run; it may not exist yet.

    With `again` a run that was begun is left alone and -2, -3, ... is begun. Without, the
    newest finished one is given, else the newest unfinished one, else a new one.
    """
    if Path(name).name != name:
        raise FolderError(f"run name {name!r}: it names a folder; leave out the slashes")
    first = Path(root) / f"{name}-{digest}"
    begun: list[RunFolder] = []
    with writing(first):
        run = RunFolder(first)
        for k in count(2):
            if run.state == "new":
                break
            begun.append(run)
            run = RunFolder(first.with_name(f"{first.name}-{k}"))
        if begun and not again:
            run = next((r for r in reversed(begun) if r.state == "finished"), begun[-1])
    return run


def resume_run(path: str | Path) -> RunFolder:
    """The run folder at `path`, to go on with; FolderError when it is none."""
    run = RunFolder(Path(path))
    if not (run.path / "case.toml").is_file():
        raise FolderError(
            f"{path}: not a run folder (it has no case.toml); give the folder of a run"
        )
    return run


def write_json(path: Path, mapping: Mapping[str, Any]) -> None:
    """Write a JSON object with its seal; FolderError where it cannot be written, or holds NaN."""
    try:
        text = sealed_json(mapping, plain)
    except ValueError as error:
        raise FolderError(
            f"{path}: not written, a result is no number ({error}); {_AGAIN}"
        ) from None
    write_atomic(path, text)


def read_json(path: Path) -> tuple[dict[str, Any], bool]:
    """Read what write_json wrote, and whether it is sealed: versions before seals wrote none.

    FolderError where the file is missing or damaged.
    """
    text = _read_text(path)
    try:
        return opened_json(text)
    except NotSealed as error:
        raise DamagedError(f"{path}: {error}; {_AGAIN}") from error
    except (ValueError, RecursionError) as error:
        raise DamagedError(f"{path}: damaged, no JSON object with a schema; {_AGAIN}") from error


def _of_this_schema(path: Path) -> dict[str, Any]:
    mapping, _ = read_json(path)
    if "schema" not in mapping:
        raise DamagedError(f"{path}: damaged, no JSON object with a schema; {_AGAIN}")
    schema = mapping.pop("schema")
    if schema != SCHEMA:
        raise FolderError(
            f"{path}: schema {schema!r} of another version (this one reads {SCHEMA}); {_AGAIN}"
        )
    return mapping


def _read_text(path: Path) -> str:
    try:
        with open_kept(path) as file:
            return file.read().decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "damaged, not UTF-8 text"
        raise FolderError(f"{path}: cannot be read ({reason}); {_AGAIN}") from error
