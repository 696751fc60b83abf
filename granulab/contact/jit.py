"""The one decorator that compiles kernels: disk cache keyed by the sources, no fastmath.

numba notices that a kernel's own file changed, but not that a helper in another file did: it
would run the stale machine code. So the cache of a kernel lives in a folder named by a hash of all
that it can call: the contact laws, and the room that its module stands in. A room is the package
named `engine` that holds the module, with all below it; a kernel elsewhere stands alone and calls
only itself and the laws. An edit in a room compiles that room again; one in a case, a picture or a
command compiles nothing.

`error_model="numpy"` turns a division by zero into inf or NaN instead of an exception (a branch
in the inner loop); the step loop checks for non-finite states itself.
"""

import atexit
import hashlib
import os
import platform
import shutil
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding
import numba
from numba.core import event
from numba.core.cpu import CPUTargetOptions
from numba.core.options import TargetOptions
from numba.core.registry import cpu_target
from numba.extending import overload

from granulab.contact.compiled.kept import keep
from granulab.contact.compiled.linked import InnerCompiler

# numba knows this flag of its compiler but offers no option for it: arguments do not alias.
# LLVM then keeps values in registers across stores and vectorises; arrays that a kernel takes
# must not overlap.
CPUTargetOptions.noalias = TargetOptions.Mapping("noalias")

# Loading scattered rows one by one beats the gather instructions of current x86 processors
# (by 2.8 in the force pass of silo2d on a Skylake server, whose microcode slows gathers down).
if numba.config.CPU_FEATURES is None and platform.machine() in ("x86_64", "AMD64"):
    _host = llvmlite.binding.get_host_cpu_features().flatten()
    numba.config.CPU_FEATURES = f"{_host},+prefer-no-gather,-prefer-256-bit"
    if "_toplevel_target_context" in vars(cpu_target):  # made at the first use of numba.njit
        warnings.warn(
            "numba was used before GranuLab was imported, and GranuLab's kernels will be up to 3 "
            "times slower: import contact or silo2d.engine.simulation first",
            stacklevel=2,
        )

# Private options of numba, all in this file. They were tried on numba 0.68.0 and 0.68.1; pyproject
# states the newest version that may be installed.
_USUAL = {"error_model": "numpy", "nogil": True, "noalias": True, "no_cfunc_wrapper": True}
# Without counting references: numba counts who uses an array, at every call and every field of a
# tuple; in a loop over steps that takes thousands of arrays through a dozen functions this costs a
# third of the time.
_UNCOUNTED = {"_nrt": False}
# Code that shall stand where it is called: an array is seven numbers, and handing over a hundred
# of them costs as much as some contacts.
_INLINED = {"_nrt": False, "forceinline": True}
# Without a way in from Python: to unpack a hundred arrays takes longer to compile than most
# functions.
_INNER = {"no_cpython_wrapper": True, "pipeline_class": InnerCompiler}

_LAWS = Path(__file__).resolve().parent  # what every kernel may call
_COMPILED = "compiled"  # the one folder below that has kernels too; others have files and units
_KEPT_FOLDERS = 8  # older ones are pruned, but for those that somebody may be working with
_IN_USE = 7 * 24 * 3600.0  # [s] since a folder was last asked for

_DISPATCHERS: dict[Path, list[Any]] = {}  # room -> its kernels, so that their cache can be moved
_EXTENSIONS: dict[Path, dict[Path, str]] = {}  # room -> files whose functions it calls, modules
_HOSTS: dict[Path, Path] = {}  # such a file -> the room


def room_of(module: str, file: str | Path) -> Path:
    """The folder or file of all kernels that those of a module may call, the laws apart."""
    packages, path = module.split("."), Path(file).resolve()
    if "engine" not in packages:
        return path
    above = len(packages) - packages.index("engine") - 1
    if path.name == "__init__.py":
        above += 1
    return path.parents[above - 1] if above else path.parent


def extend(room: Path, module: str, *sources: str | Path) -> None:
    """Let the kernels of a room call functions of files outside it, and be kept by these too.

    module is the name of the one whose types the kernels take: numba keeps types by it, and it is
    "__main__" where the file is run as a script. The files' own kernels may call those of the room.
    Kernels that are compiled already stay as they are; what is compiled from now on is kept in
    another folder, which a process that does not know these files never opens.
    """
    known = _EXTENSIONS.setdefault(room, {})
    new = [path for path in (Path(source).resolve() for source in sources) if path not in known]
    if not new:
        return
    known.update(dict.fromkeys(new, module))
    _HOSTS.update(dict.fromkeys(new, room))
    cache_folder.cache_clear()
    for place in (room, *known):
        with _kept_in(place):
            for dispatcher in _DISPATCHERS.get(place, []):
                keep(dispatcher)


def extensions(room: Path) -> list[Path]:
    """Return the files from outside that extend a room, sorted."""
    return sorted(_EXTENSIONS.get(room, {}))


@cache
def cache_folder(room: Path = _LAWS) -> str:
    """Return where the compiled kernels of a room are kept: a folder or file, see room_of."""
    text = hashlib.sha256(numba.__version__.encode())
    room = _HOSTS.get(room, room)
    text.update(" ".join(sorted(_EXTENSIONS.get(room, {}).values())).encode())
    for place in (_LAWS, room, *extensions(room)):
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            if place != _LAWS or path.parent.name in (_LAWS.name, _COMPILED):
                text.update(path.read_bytes())
    kernels = _all_kernels()
    folder = kernels / text.hexdigest()[:16]
    with suppress(OSError):  # a full disk: kept.py says that nothing can be kept
        folder.mkdir(exist_ok=True)
        folder.touch()  # in use: the youngest are kept
        _prune(kernels, folder)
    return str(folder)


@cache
def _all_kernels() -> Path:
    """The folder of all caches; where none can be written, one for this process alone."""
    base = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    kernels = (Path(base) if base else Path.home() / ".cache") / "granulab-kernels"
    try:
        kernels.mkdir(parents=True, exist_ok=True)
        writable = os.access(kernels, os.W_OK)
    except OSError:
        writable = False
    if not writable:  # no home, or not ours
        with suppress(OSError):  # nor a temporary folder: kept.py says so
            kernels = Path(tempfile.mkdtemp(prefix="granulab-kernels-"))
            atexit.register(shutil.rmtree, kernels, ignore_errors=True)
    return kernels


def already_compiled(room: Path) -> bool:
    """Return whether kernels of a room are compiled already: then a start takes no time."""
    return any(Path(cache_folder(room)).glob("*/*.nbc"))


class _Compilation(event.Listener):
    """Counts functions as they are compiled; those that call others take these in."""

    def __init__(self, report: Callable[[bool], None]) -> None:
        self._report, self._depth = report, 0

    def on_start(self, event: Any) -> None:
        self._depth += 1
        if self._depth == 1:
            self._report(False)

    def on_end(self, event: Any) -> None:
        self._depth -= 1
        self._report(True)


@contextmanager
def watched_compilation(report: Callable[[bool], None]) -> Iterator[None]:
    """Call report(False) before, and report(True) after each function that is compiled within.

    What is compiled already is loaded without a word.
    """
    with event.install_listener("numba:compile", _Compilation(report)):
        yield


def _prune(kernels: Path, current: Path) -> None:
    others = [path for path in kernels.iterdir() if path != current]
    newest_first = sorted(others, key=lambda path: path.stat().st_mtime, reverse=True)
    for old in newest_first[_KEPT_FOLDERS:]:
        if time.time() - old.stat().st_mtime > _IN_USE:
            shutil.rmtree(old, ignore_errors=True)


@contextmanager
def _kept_in(room: Path) -> Iterator[None]:
    """Let numba keep what is decorated within in the folder of a room."""
    usual = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = cache_folder(room)  # read by numba when it decorates
    try:
        yield
    finally:
        numba.config.CACHE_DIR = usual


def njit(function, **options):
    """numba.njit with the project's cache folder and options."""
    room = room_of(function.__module__, function.__code__.co_filename)
    with _kept_in(room):
        dispatcher = numba.njit(**_USUAL, **options)(function)
        if dispatcher is not function:  # which it is where NUMBA_DISABLE_JIT is set
            keep(dispatcher)
    _DISPATCHERS.setdefault(room, []).append(dispatcher)
    return dispatcher


def uncounted(function):
    """njit for a function that makes no array and keeps none: without counting references."""
    return njit(function, **_UNCOUNTED)


def inlined(function):
    """uncounted, for a function whose code shall stand where it is called."""
    return njit(function, **_INLINED)


def inner(function):
    """uncounted, for a function that only kernels call: without a way into it from Python.

    Python that calls it jumps to nowhere, as it has no machine code of its own (see
    compiled/linked.py); it may not print, nor raise what it did not make beforehand.
    """
    return njit(function, **_UNCOUNTED, **_INNER)


def inlined_inner(function):
    """inlined, for a function that only kernels call; see inner."""
    return njit(function, **_INLINED, **_INNER)


def specialised(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorate what chooses the code of a function by the types of its arguments, when compiled.

    Such a choice may not be a function that is handed over, nor one made at run time: these break
    the cache on disk. The code is put in where it is called, by the compiler's back end.
    """
    return overload(function, jit_options={**_USUAL, **_INLINED, **_INNER})


def substituted(function: Callable[..., Any]) -> Callable[..., Any]:
    """specialised, put in by numba itself, before it knows types: for whole stages of a step.

    That loses stores to fields of tuples in loops, so that it does not serve what loops call.
    """
    return overload(function, inline="always", jit_options={**_USUAL, **_INNER})
