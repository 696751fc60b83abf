"""Provenance of a run: command, versions, sources, seed, machine, time."""

import hashlib
import os
import platform
import sys
from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from functools import cached_property
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

Warn = Callable[[str], None]


def source_digest(package_folders: Iterable[str | Path]) -> str:
    """First 12 hex digits of the SHA-256 over the .py files of packages, names and contents.

    Where the packages are installed and in which order they are named does not count.
    """
    total = hashlib.sha256()
    for folder in sorted(map(Path, package_folders), key=lambda path: path.name):
        for source in sorted(folder.rglob("*.py")):
            name = f"{folder.name}/{source.relative_to(folder).as_posix()}"
            content = hashlib.sha256(source.read_bytes()).hexdigest()
            total.update(f"{name} {content}\n".encode())
    return total.hexdigest()[:12]


def to_stderr(line: str) -> None:
    """A warning for a person."""
    print(f"warning: {line}", file=sys.stderr)


_OUTSIDE: dict[Path, list[Path]] = {}  # by folder of code, the files that extend it


def extend(folder: Path, *files: str | Path) -> None:
    """Let files from outside, such as that of a shape, count among the sources of a folder."""
    known = _OUTSIDE.setdefault(folder, [])
    known += [path for path in (Path(file).resolve() for file in files) if path not in known]


def _extensions(folder: Path) -> list[Path]:
    """The files that extend a folder; those that its kernels call are known where these are."""
    jit = sys.modules.get("granulab.contact.jit")  # not loaded: nothing extends a kernel yet
    return [*_OUTSIDE.get(folder, []), *(jit.extensions(folder) if jit else [])]


class Sources:
    """Folders of code that decide what is computed; runs, packings and results keep their digest."""

    def __init__(self, *folders: Path) -> None:
        self.folders = folders

    def plus(self, *folders: Path) -> "Sources":
        """These folders and others, such as that of a study or of a second engine."""
        return Sources(*self.folders, *folders)

    @property
    def digest(self) -> str:
        """Digest of the sources as they stood at first, and of what extends them from outside."""
        outside = [file for folder in self.folders for file in _extensions(folder)]
        if not outside:
            return self._own
        contents = [hashlib.sha256(file.read_bytes()).hexdigest() for file in sorted(outside)]
        return hashlib.sha256(" ".join([self._own, *contents]).encode()).hexdigest()[:12]

    @cached_property
    def _own(self) -> str:
        return source_digest(self.folders)

    def check(self, what: str, made: str | None, cure: str, warn: Warn) -> None:
        """Warn where `made`, a digest of sources, is not that of these."""
        if made != self.digest:
            warn(f"{what} by another version of the sources ({made}); {cure}")


def provenance(
    *, command: list[str], seed: int, packages: list[str], sources: Sources | Iterable[str | Path]
) -> dict[str, Any]:
    """Return the provenance of a run that starts now, as provenance.json keeps it.

    `packages` are distributions whose versions matter to the last bit; `sources` are those of the
    simulation, or their folders. A distribution that is not installed is None.
    """
    known = sources if isinstance(sources, Sources) else Sources(*map(Path, sources))
    return {
        "command": command,
        "granulab": _version("granulab"),
        "versions": {
            "python": platform.python_version(),
            **{package: _version(package) for package in packages},
        },
        "source_digest": known.digest,
        "seed": seed,
        "machine": {"platform": platform.platform(), "cpu": cpu_model(), "cores": os.cpu_count()},
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def cpu_model() -> str:
    """The processor's name; the bits of a run are promised for one type of it only."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:  # not Linux
        lines = []
    models = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(models, "") or platform.processor() or platform.machine()


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
