"""Scenes of starting: --help, a run up to its first step, and the first one, which compiles.

The bound of --help is a Python that does nothing, that of a run one that imports numba.
"""

import sys
import tempfile
from functools import partial
from pathlib import Path

from benchmarks.speed.timing import BOUND, HERE, Contest, Scene, child

COMMANDS = ("silo2d", "damper3d", "calibrate", "granulab")
# Runs whose packing is there; the first steps are those before the opening, and of the motion.
RUNS = {
    "silo2d": ("silo2d", "run", "A4", "--max-time", "0.02 s"),
    "damper3d": ("damper3d", "run", "--cycles", "2", "--discard", "1"),
}
_KEPT = {"PYTHONDONTWRITEBYTECODE": ""}  # modules are compiled once, as after an installation


def help_of(command: str) -> Contest:
    """--help of a command, compared with a Python that does nothing [ms]."""
    path = str(Path(sys.executable).with_name(command))
    return Contest({
        HERE: partial(cpu_ms, (path, "--help")), BOUND: partial(cpu_ms, (sys.executable, "-c", "")),
    })  # fmt: skip


def cpu_ms(command: tuple[str, ...]) -> float:
    """CPU time of a process [ms]."""
    return 1e3 * child(command, _KEPT).cpu_s


def to_first_step(package: str, out: str, kernels: dict[str, str]) -> float:
    """CPU time of a run up to its first step [s]."""
    command = (sys.executable, "-m", "benchmarks.speed.first_step", *RUNS[package])
    options = ("--again", "--no-figures", "--quiet", "--out", out)
    return child((*command, *options), {**_KEPT, **kernels}).cpu_s


def warm(package: str) -> Contest:
    """A run whose kernels are compiled and whose packing is there [s]."""
    folder = tempfile.TemporaryDirectory()
    command = Path(sys.executable).with_name(package)
    options = ("--no-figures", "--quiet", "--out", folder.name)
    child((str(command), *RUNS[package][1:], *options), _KEPT)
    return Contest(
        {
            HERE: partial(to_first_step, package, folder.name, {}),
            BOUND: lambda: child((sys.executable, "-c", "import numba"), _KEPT).cpu_s,
        },
        close=folder.cleanup,
    )


def cold(package: str) -> Contest:
    """A run that finds no compiled kernel, up to the first step of its filling [s]."""

    def here() -> float:
        with tempfile.TemporaryDirectory() as folder:
            kernels = {"NUMBA_CACHE_DIR": str(Path(folder) / "kernels")}
            return to_first_step(package, str(Path(folder) / "runs"), kernels)

    return Contest({HERE: here})


def scenes() -> list[Scene]:
    """Scenes of starting."""
    return [
        *(Scene(f"{one} --help", "ms", partial(help_of, one), 15) for one in COMMANDS),
        *(Scene(f"{one} run, first step", "s", partial(warm, one), 7) for one in RUNS),
        *(Scene(f"{one} run, compiling", "s", partial(cold, one), 1) for one in RUNS),
    ]
