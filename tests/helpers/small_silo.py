"""A silo of seventy particles that fills and empties in a second, and the command to run it."""

import contextlib
import hashlib
import io
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

from granulab.campaign.runs.folder import RunFolder
from silo2d.commands.main import main

SHAPES = """
schema = 1
spheroradius = "0.5 mm"
unit = "mm"

[[shape]]
name = "square"
outline = [[0, 0], [7, 0], [7, 7], [0, 7]]

[[shape]]
name = "rectangle"
outline = [[0, 0], [10, 0], [10, 5], [0, 5]]

[[shape]]
name = "bevelled"
outline = [[0, 2], [2, 0], [9, 0], [9, 4], [7, 6], [0, 6]]
"""
DRY = ("--dry-run", "--no-figures")  # words that draw nothing, for what is said before a run
NARROWEST = 5e-3  # [m] the rectangle

# A tenth of the wood's stiffness, for a longer time step. The outlet is seven particles wide, and
# the friction low: seeds 1, 2 and 4 empty in 0.28 to 0.32 s, and seed 3 clogs with 12 of 67 out.
CASE: dict[str, Any] = {
    "silo.angle": "45 deg",
    "silo.outlet": "50 mm",
    "silo.width": "80 mm",
    "silo.height": "80 mm",
    "particles.shapes": "small_shapes.toml",
    "law.kn": "1.0e3 N/mm",
    "law.keep_ratios": True,
    "law.mu_particle": 0.2,
    "law.mu_wall": 0.2,
    "fill.level": "50 mm",
    "run.time_step": "10 us",
    "run.rest_time": "50 ms",
    "output.checkpoint_interval": "20 ms",
}
# More steps, and some thirty checkpoints: more time to be killed in.
SLOW = {
    "run.time_step": "6 us",
    "output.checkpoint_interval": "10 ms",
    "output.contact_interval": "20 ms",  # in one part of two, and after every checkpoint
}


class DischargeStop:
    """A stop that asks `decide` at each look, but only once the door is open."""

    def __init__(self, decide: Callable[[], bool]):
        self._decide = decide
        self._is_open = False

    def progress(self, fraction: float, text: str) -> None:
        """To be given as progress: its words name the phase."""
        self._is_open = " out" in text.partition(";")[0]

    def __call__(self) -> bool:
        return self._is_open and self._decide()


def write_case(folder: Path, changes: dict[str, Any] | None = None, name: str = "small") -> Path:
    """Write NAME.toml with its shapes file into a folder; a change to None takes a key out."""
    (folder / "small_shapes.toml").write_text(SHAPES, encoding="utf-8")
    return write_keys(folder / f"{name}.toml", CASE | (changes or {}))


def write_keys(path: Path, keys: dict[str, Any]) -> Path:
    """Write a case of keys such as "silo.angle"; one of None is left out."""
    tables: dict[str, dict[str, Any]] = {}
    for place, value in keys.items():
        table, _, key = place.rpartition(".")
        if value is not None:
            tables.setdefault(table, {})[key] = value
    lines = ["schema = 1"]
    for table, entries in sorted(tables.items()):  # "" first: keys of no table
        lines += [f"[{table}]"] if table else []
        # Texts, numbers, truth values and lists of numbers are written alike in TOML and JSON,
        # but for numbers that are none.
        lines += [
            f"{key} = {json.dumps(value).replace('NaN', 'nan').replace('Infinity', 'inf')}"
            for key, value in entries.items()
        ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@dataclass(frozen=True)
class Completed:
    """What the command gave back."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        """The one object on stdout."""
        assert self.code == 0, self.err
        return json.loads(self.out)


def run_command(name: str, main: Callable[[], None], *arguments: object) -> Completed:
    """Run a command in this process, which has the kernels; a traceback fails the test."""
    out, err = io.StringIO(), io.StringIO()
    code = 0
    with (
        mock.patch.object(sys, "argv", [name, *map(str, arguments)]),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as leave:
            code = int(leave.code or 0)
    return Completed(code, out.getvalue(), err.getvalue())


def silo2d(*arguments: object) -> Completed:
    """What the command gives back; see run_command."""
    return run_command("silo2d", main, *arguments)


def start(*arguments: object, before: str = "", package: str = "silo2d") -> subprocess.Popen[str]:
    """Start the command as a process of its own; `before` is Python that it runs first."""
    program = f"{before}\nfrom {package}.commands.main import main\nmain()"
    return subprocess.Popen(
        [sys.executable, "-c", program, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finish(process: subprocess.Popen[str]) -> Completed:
    """Wait for a process and give what it said."""
    out, err = process.communicate(timeout=100)
    return Completed(process.returncode, out, err)


def the_run(root: Path) -> RunFolder:
    """The only run folder below a root."""
    (case,) = root.glob("*/case.toml")
    return RunFolder(case.parent)


def contents(folder: Path) -> dict[str, str]:
    """SHA-256 of every file below a folder by its name; locks are left out."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != ".lock"
    }
