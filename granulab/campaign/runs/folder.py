"""The folder of one run: its name, its state, its lock, and files that are written whole."""

import errno
import hashlib
import json
import os
import secrets
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any, Literal

SCHEMA = 1  # of the JSON files, trajectories and checkpoints; raise it when their keys change


class FolderError(ValueError):
    """A run folder or a file in it that cannot be used; one line that says what would do."""


@contextmanager
def writing(path: Path, option: str = "--out") -> Iterator[None]:
    """Turn an OSError of the enclosed lines into a FolderError about `path`.

    option: of the command line, which says where to write.
    """
    try:
        yield
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            cure = "make room there and start the run again: it goes on from its last checkpoint"
        else:
            cure = f"choose a folder you may write to with {option}"
        reason = error.strerror or type(error).__name__
        raise FolderError(f"{path}: cannot be written ({reason}); {cure}") from error


def refuse_unless_writable(folder: Path, option: str) -> None:
    """Raise FolderError where a folder cannot be made or written to; nothing is made.

    option: of the command line, which gave the folder.
    """
    with writing(folder, option):
        whole = folder.absolute()
        there = next(p for p in (whole, *whole.parents) if p.exists() or p.is_symlink())
        if not there.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
        if not os.access(there, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def write_atomic(path: str | Path, content: bytes | str) -> None:
    """Write a file so that at any moment, also after kill -9, it is the old or the new one whole.

    Raises FolderError when it cannot be written (no permission, disk full).
    """
    path = Path(path)
    # A name of its own: two processes may write the same file at once (a shared packing).
    part = path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp")
    with writing(path):
        try:
            with part.open("wb") as file:
                file.write(content.encode() if isinstance(content, str) else content)
                file.flush()
                os.fsync(file.fileno())
            part.replace(path)
        except BaseException:
            part.unlink(missing_ok=True)
            raise


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
    def checkpoint(self) -> Path:
        """Path of the checkpoint."""
        return self.path / "checkpoint.h5"

    @property
    def figures(self) -> Path:
        """Folder of the pictures; who draws the first one makes it."""
        return self.path / "figures"

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Keep every other process off this run; a killed holder leaves no lock behind.

        Raises FolderError when another one computes in this folder.
        """
        from filelock import FileLock, Timeout

        held = FileLock(self.path / ".lock")  # the system's own lock: it ends with its process
        with writing(self.path):
            try:
                held.acquire(blocking=False)
            except Timeout:
                raise FolderError(
                    f"{self.path}: another process computes this run now; wait for it, "
                    "or use --again to compute it in a folder of its own"
                ) from None
        try:
            with writing(self.path):
                for leftover in self.path.rglob(".*.tmp"):  # of a writer that was killed
                    leftover.unlink(missing_ok=True)
            yield
        finally:
            held.release()

    def write_case(self, text: str) -> None:
        """Keep the case as resolved (TOML); from here on the run counts as begun."""
        write_atomic(self.path / "case.toml", text)

    def read_case(self) -> str:
        """The case as resolved (TOML)."""
        return _read_text(self.path / "case.toml")

    def write_provenance(self, provenance: Mapping[str, Any]) -> None:
        """Keep where the numbers come from."""
        _write_json(self.path / "provenance.json", provenance)

    def read_provenance(self) -> dict[str, Any]:
        """Return the provenance; FolderError when missing, damaged or of another schema."""
        return _read_json(self.path / "provenance.json")

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """Keep the results; from here on the run counts as finished.

        A value that does not exist is None; NaN and infinity are refused (ValueError).
        """
        _write_json(self.path / "summary.json", summary)

    def read_summary(self) -> dict[str, Any]:
        """Return the summary; FolderError when missing, damaged or of another schema."""
        return _read_json(self.path / "summary.json")


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


def _write_json(path: Path, mapping: Mapping[str, Any]) -> None:
    text = json.dumps(
        {"schema": SCHEMA, **mapping}, indent=2, ensure_ascii=False, allow_nan=False, default=plain
    )
    write_atomic(path, text + "\n")


def _read_json(path: Path) -> dict[str, Any]:
    cure = "use --again to compute the run again"
    text = _read_text(path)
    try:
        mapping = json.loads(text)
        schema = mapping.pop("schema")
    except (ValueError, AttributeError, KeyError, TypeError) as error:
        raise FolderError(f"{path}: damaged, no JSON object with a schema; {cure}") from error
    if schema != SCHEMA:
        raise FolderError(
            f"{path}: schema {schema!r} of another version (this one reads {SCHEMA}); {cure}"
        )
    return mapping


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "damaged, not UTF-8 text"
        raise FolderError(
            f"{path}: cannot be read ({reason}); use --again to compute the run again"
        ) from error
