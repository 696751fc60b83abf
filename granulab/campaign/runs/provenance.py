"""Provenance of a run: command, versions, sources, seed, arithmetic, machine, time."""

import hashlib
import os
import platform
import sys
from collections.abc import Callable, Iterable, Mapping
from datetime import UTC, datetime
from functools import cache, cached_property
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from granulab.campaign.output.terminal import say

Warn = Callable[[str], None]
_STORES = ("h5py",)  # every bit as it is, in any version


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
    say(f"warning: {line}")


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
    """Folders of code that decide what is computed; runs, packings, results keep their digest."""

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
        "versions": {name: _version(name) for name in ("python", *packages)},
        "source_digest": known.digest,
        "seed": seed,
        "arithmetic": arithmetic(),
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


def arithmetic() -> dict[str, Any]:
    """Libraries and processors that decide the last bits, besides versions and sources.

    blas     linear algebra that numpy and scipy call: name and version of each
    core     processor that numpy's OpenBLAS computes for, by itself or as OPENBLAS_CORETYPE says;
             None of another library
    kernels  processor that numba compiles for, and those of its features that are used; None
             where no kernel is loaded
    """
    return {"blas": _blas(), "core": _blas_core(), "kernels": _kernels()}


@cache
def _blas() -> dict[str, str]:
    import numpy
    import scipy

    found = {}
    for package in (numpy, scipy):
        built = package.show_config(mode="dicts")["Build Dependencies"]["blas"]
        found[package.__name__] = f"{built.get('name')} {built.get('version')}"
    return found


@cache
def _blas_core() -> str | None:
    from threadpoolctl import threadpool_info

    loaded = [one for one in threadpool_info() if one["internal_api"] == "openblas"]
    loaded.sort(key=lambda one: "numpy" not in one["filepath"])  # cv2 has one of its own
    return loaded[0]["architecture"] if loaded else None


def _kernels() -> dict[str, str] | None:
    if "granulab.contact.jit" not in sys.modules:  # which sets the features
        return None
    import numba
    from llvmlite import binding

    config: Any = numba.config
    features = config.CPU_FEATURES
    if features is None:
        features = binding.get_host_cpu_features().flatten()
    return {
        "cpu": binding.get_host_cpu_name() if config.CPU_NAME is None else config.CPU_NAME,
        "features": " ".join(sorted(one[1:] for one in features.split(",") if one[:1] == "+")),
    }


def in_words(made: Mapping[str, Any]) -> str:
    """An arithmetic in a line."""
    words = [f"{package} calls {library}" for package, library in made["blas"].items()]
    if made["core"]:
        words.append(f"core {made['core']}")
    if kernels := made["kernels"]:
        words.append(
            f"kernels for {kernels['cpu']} with {len(kernels['features'].split())} features"
        )
    return ", ".join(words)


def check_arithmetic(what: str, origin: Mapping[str, Any], warn: Warn) -> None:
    """Warn where the provenance of a run has another arithmetic than this process.

    Versions before the entry have none, and then nobody knows.
    """
    made, here = origin.get("arithmetic"), arithmetic()
    if made is None or made == here:
        return
    warn(
        f"{what} with another arithmetic ({in_words(made)}; here {in_words(here)}), whose "
        "roundings, and so its bits, do not come again here"
    )


def check_versions(what: str, origin: Mapping[str, Any], warn: Warn) -> None:
    """Warn where a run was begun with other versions of what computes than this process has.

    What was not installed computed nothing.
    """
    made = {name: v for name, v in origin.get("versions", {}).items() if v and name not in _STORES}
    here = {name: _version(name) for name in made}
    differ = [name for name in made if here[name] not in (None, made[name])]
    if differ:
        words = [", ".join(f"{name} {of[name]}" for name in differ) for of in (made, here)]
        warn(f"{what} with {words[0]} (here {words[1]}), so that its bits may not come again here")


def _version(package: str) -> str | None:
    if package == "python":
        return platform.python_version()
    try:
        return version(package)
    except PackageNotFoundError:
        return None
